//! Commands that list what there is: robots, scenarios, methods.

use clap::Args;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::optimize::{OPTIMIZERS, OptimizerEntry, OptimizerInfo, ParameterInfo};
use crate::plan::cell::{Choice, Parameter, Values};
use crate::plan::path::{SMOOTHINGS, SmoothingEntry, SmoothingInfo};
use crate::plan::scenarios::{self, Scenario};
use crate::planner::{PLANNERS, PlannerEntry, PlannerInfo};
use crate::robot::{Robot, catalogue};
use crate::trajectory::interpolation::{INTERPOLATIONS, Interpolation, InterpolationInfo};

use super::client::Client;
use super::failure::Failure;
use super::table::Table;
use super::{input, output};

/// Options of `takt robots`.
#[derive(Debug, Args)]
pub(super) struct RobotOptions {
    /// Print this robot as JSON
    name: Option<String>,
    /// Ask this server, which also knows registered robots, instead of the
    /// built-in catalogue
    #[arg(long, value_name = "URL")]
    server: Option<String>,
}

#[derive(Deserialize)]
struct RobotPage {
    robots: Vec<RobotLine>,
}

#[derive(Deserialize)]
struct RobotLine {
    name: String,
    description: Option<String>,
    dof: usize,
}

/// Lists robots, or prints one.
pub(super) async fn robots(options: RobotOptions) -> Result<(), Failure> {
    let client = options.server.as_deref().map(Client::new).transpose()?;
    match (options.name, client) {
        (None, None) => print_robots(catalogue::all().iter().map(|robot| line(robot)).collect()),
        (None, Some(client)) => {
            let page: RobotPage = client.get("/v1/robots", &[]).await?;
            print_robots(page.robots)
        }
        (Some(name), None) => {
            let robot = catalogue::get(&name);
            let robot = robot
                .ok_or_else(|| input::unknown("there is no robot", &name, catalogue::names()))?;
            output::print(&output::pretty(robot.description())?)
        }
        (Some(name), Some(client)) => {
            let robot: Value = client.get(&format!("/v1/robots/{name}"), &[]).await?;
            output::print(&output::pretty(&robot)?)
        }
    }
}

fn line(robot: &Robot) -> RobotLine {
    let description = robot.description().description.clone();
    RobotLine { name: robot.name().to_owned(), description, dof: robot.dof() }
}

fn print_robots(robots: Vec<RobotLine>) -> Result<(), Failure> {
    let mut table = Table::new(["name", ">joints", "description"]);
    for RobotLine { name, description, dof } in robots {
        table.row([name, dof.to_string(), description.unwrap_or_default()]);
    }
    output::print(&table.text())
}

/// Options of `takt scenarios`.
#[derive(Debug, Args)]
pub(super) struct ScenarioOptions {
    /// Print this scenario's request as JSON, ready to be changed and planned
    name: Option<String>,
    #[command(flatten)]
    set: input::SetOptions,
}

/// Lists scenarios, or prints one's request.
pub(super) fn scenarios(options: ScenarioOptions) -> Result<(), Failure> {
    let Some(name) = options.name else {
        if let Some((parameter, _)) = options.set.settings.first() {
            return Err(Failure::input(format!("name the scenario in which to set `{parameter}`")));
        }
        let mut table = Table::new(["name", "title"]);
        for scenario in scenarios::all() {
            table.row([scenario.name.clone(), scenario.title.clone()]);
        }
        return output::print(&table.text());
    };
    let names = || scenarios::all().iter().map(|scenario| scenario.name.as_str());
    let scenario = scenarios::get(&name);
    let scenario =
        scenario.ok_or_else(|| input::unknown("there is no scenario", &name, names()))?;
    output::remark(&format!("{}\n{}", scenario.description, scenario.source));
    if !scenario.parameters.is_empty() {
        output::remark(parameters(scenario).trim_end());
    }
    let request = input::select(scenario, &scenario.name, &options.set)?;
    output::print(&output::pretty(&request)?)
}

/// What may be set in a scenario.
fn parameters(scenario: &Scenario) -> String {
    let mut text = String::from("Set with --set NAME=VALUE:\n");
    for Parameter { name, description, default, values } in &scenario.parameters {
        text.push_str(&format!("  {name} (default {default}): {description}\n"));
        match values {
            Values::Range { min, max } => text.push_str(&format!("    {min} to {max}\n")),
            Values::Choices(choices) => {
                for Choice { value, description } in choices {
                    text.push_str(&format!("    {value}: {description}\n"));
                }
            }
        }
    }
    text
}

/// Options of `takt methods`.
#[derive(Debug, Args)]
pub(super) struct MethodOptions {
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

/// Lists interpolations, optimizers, planners and smoothings.
pub(super) fn methods(options: MethodOptions) -> Result<(), Failure> {
    let interpolations: Vec<InterpolationInfo> =
        INTERPOLATIONS.iter().map(Interpolation::info).collect();
    let optimizers: Vec<OptimizerInfo> = OPTIMIZERS.iter().map(OptimizerEntry::info).collect();
    let planners: Vec<PlannerInfo> = PLANNERS.iter().map(PlannerEntry::info).collect();
    let smoothings: Vec<SmoothingInfo> = SMOOTHINGS.iter().map(SmoothingEntry::info).collect();
    if options.json {
        let all = json!({"interpolations": interpolations, "optimizers": optimizers,
            "planners": planners, "smoothings": smoothings});
        return output::print(&output::pretty(&all)?);
    }
    let mut text = String::from("Interpolations\n");
    for entry in &interpolations {
        text.push_str(&method(entry.name, entry.title, entry.description, entry.source));
    }
    text.push_str("\nOptimizers\n");
    for entry in &optimizers {
        text.push_str(&method(entry.name, entry.title, entry.description, entry.source));
        for parameter in &entry.parameters {
            text.push_str(&parameter_line(parameter));
        }
    }
    text.push_str("\nPlanners\n");
    for entry in &planners {
        text.push_str(&method(entry.name, entry.title, entry.description, entry.source));
        entry.parameters.iter().for_each(|it| text.push_str(&parameter_line(it)));
    }
    text.push_str("\nSmoothings\n");
    for entry in &smoothings {
        text.push_str(&method(entry.name, entry.title, entry.description, entry.source));
        entry.parameters.iter().for_each(|it| text.push_str(&parameter_line(it)));
    }
    output::print(&text)
}

fn method(name: &str, title: &str, description: &str, source: &str) -> String {
    format!("\n  {name}: {title}\n    {description}\n    source: {source}\n")
}

fn parameter_line(parameter: &ParameterInfo) -> String {
    let default = match &parameter.default {
        Some(default) => format!("default {default}"),
        None => "off".to_owned(),
    };
    let (min, max) = (short(parameter.min), short(parameter.max));
    let ParameterInfo { name, description, .. } = parameter;
    format!("    - {name} ({default}; {min} to {max}): {description}\n")
}

/// A number without a row of zeros.
fn short(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs());
    if plain { format!("{value}") } else { format!("{value:e}") }
}
