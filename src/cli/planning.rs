//! Commands that compute in this process: planning and certifying.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use clap::Args;
use serde_json::{Value, json};

use crate::budget::{Budget, CancelToken};
use crate::picture;
use crate::plan::verify::{VerifyRequest, verify as certify};
use crate::plan::{self, PlanError, PlanResult, PreparedPlan, Progress, TrajectoryResult};
use crate::robot::catalogue;
use crate::service::JobRequest;
use crate::trajectory::Certificate;

use super::failure::Failure;
use super::progress::{Display, Standing};
use super::{comparison, family, input, output};

/// Options of `takt plan`.
#[derive(Debug, Args)]
pub(super) struct PlanOptions {
    /// JSON file, name of a scenario, or - for standard input
    #[arg(value_name = "FILE|SCENARIO|-")]
    source: String,
    #[command(flatten)]
    set: input::SetOptions,
    /// Write the result here instead of to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also write a page that shows a family, comparison or benchmark, as HTML
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Also write which limit holds the motion back and when, as SVG; of a family
    /// that of its slowest member
    #[arg(long, value_name = "FILE")]
    timeline: Option<PathBuf>,
    /// Seed of the random streams, instead of the request's
    #[arg(long)]
    seed: Option<u64>,
}

/// Plans and prints the result as JSON. Ctrl-C ends the search.
pub(super) async fn plan(options: PlanOptions) -> Result<(), Failure> {
    let request = input::request(&options.source, &options.set)?;
    let invalid = |faults| Failure::faults(format!("{} cannot be planned", request.name), &faults);
    // What can be submitted can be planned here: the job's own settings are
    // read and have no effect.
    let mut job = JobRequest::parse(request.value).map_err(invalid)?;
    job.plan.seed = options.seed.unwrap_or(job.plan.seed);
    let prepared = plan::validate(&job.plan, &catalogue::get).map_err(invalid)?;
    let title = job.plan.task.name().to_owned();
    if options.page.is_some() && !matches!(title.as_str(), "family" | "comparison" | "benchmark") {
        let why = format!("--page shows a family, comparison or benchmark, not a {title} task");
        return Err(Failure::input(why));
    }
    if options.timeline.is_some() && matches!(title.as_str(), "path" | "comparison" | "benchmark") {
        let why = format!("--timeline shows a motion, and a {title} task has none");
        return Err(Failure::input(why));
    }
    let (result, partial) = run(prepared, title).await?;
    if let Some(result) = &result {
        output::deliver(&output::pretty(result)?, options.out.as_deref())?;
    }
    if let (Some(page), Some(path)) = (result.as_ref().and_then(picture::page::of), &options.page) {
        output::write(path, page.as_bytes())?;
    }
    if let (Some(result), Some(path)) = (&result, &options.timeline) {
        let sections = picture::Section::all(result);
        output::write(path, picture::timeline(&sections).as_bytes())?;
    }
    match partial {
        None => Ok(()),
        Some(failure) => Err(failure),
    }
}

/// Plans on a thread of its own. A failure may come with a part of the result.
async fn run(
    prepared: PreparedPlan,
    title: String,
) -> Result<(Option<PlanResult>, Option<Failure>), Failure> {
    let cancel = CancelToken::default();
    let budget = Budget::new(cancel.clone());
    let planned = tokio::task::spawn_blocking(move || {
        let display = Mutex::new(Display::new(title));
        let show = |progress: Progress| {
            display.lock().unwrap_or_else(PoisonError::into_inner).show(&standing(&progress));
        };
        let planned = prepared.run(&budget, &show);
        if let Ok(result) = &planned {
            let display = display.into_inner().unwrap_or_else(PoisonError::into_inner);
            display.finish(summary(result).trim_end());
        }
        planned
    });
    tokio::pin!(planned);
    let planned = tokio::select! {
        planned = &mut planned => planned,
        _ = tokio::signal::ctrl_c() => {
            cancel.cancel();
            planned.await
        }
    };
    match planned {
        Ok(Ok(result)) => Ok((Some(result), None)),
        Ok(Err(mut error)) => {
            let partial = error.partial.take().map(|partial| *partial);
            Ok((partial, Some(planning_failed(&error))))
        }
        Err(error) => {
            Err(Failure::planning(format!("planning ended with a fault of ours: {error}")))
        }
    }
}

fn standing(progress: &Progress) -> Standing<'_> {
    Standing {
        leg: progress.leg.as_deref(),
        method: progress.method.as_deref(),
        iteration: progress.iteration,
        evaluations: progress.evaluations,
        best: progress.best,
        lower_bound: progress.lower_bound,
        members: progress.members.as_ref().map(|it| [it.done, it.of]),
        slowest: progress.members.as_ref().and_then(|it| it.slowest),
    }
}

fn planning_failed(error: &PlanError) -> Failure {
    let details = error.details.as_object().into_iter().flatten();
    Failure::planning(format!("{} ({})", error.message, error.code.as_str()))
        .with_notes(details.map(|(name, value)| format!("{name}: {value}")))
}

/// A line per trajectory.
fn summary(result: &PlanResult) -> String {
    match result {
        PlanResult::Trajectory(result) => line(&result.robot, result),
        PlanResult::Program(program) => {
            let legs = program.legs.iter().map(|leg| {
                let note = leg.note.iter().map(|note| format!("  {note}\n"));
                line(&leg.name, &leg.result) + &note.collect::<String>()
            });
            format!("{}together {:.4} s\n", legs.collect::<String>(), program.duration)
        }
        PlanResult::Path(path) => format!("{}\n", path.verdict()),
        PlanResult::Family(family) => family::summary(family),
        PlanResult::Comparison(comparison) => comparison::summary(comparison),
    }
}

fn line(name: &str, result: &TrajectoryResult) -> String {
    let bound = result
        .bound
        .as_ref()
        .map(|bound| format!(", at most {:.1} % above the fastest possible", 100.0 * bound.gap));
    let without = result.metrics.without_tcp_limit;
    let without = without.map(|without| format!(", {without:.4} s without the tcp limit"));
    format!(
        "{name}: {:.4} s, {}{}{} ({}, {}; {} evaluations, {:.1} ms)\n",
        result.duration,
        lawfulness(&result.certificate),
        without.unwrap_or_default(),
        bound.unwrap_or_default(),
        result.interpolation,
        result.optimizer,
        result.evaluations,
        1e3 * result.planning_s,
    )
}

fn lawfulness(certificate: &Certificate) -> String {
    let verdict = if certificate.lawful { "lawful" } else { "NOT LAWFUL" };
    let tcp = certificate.tcp_speed.as_ref().and_then(|it| it.peak.zip(it.limit));
    let tcp = tcp.map(|(peak, limit)| format!(", tcp up to {peak:.4} of {limit} m/s"));
    format!(
        "{verdict}, largest peak {:.2} % of its limit{}",
        100.0 * certificate.worst_ratio,
        tcp.unwrap_or_default()
    )
}

/// Options of `takt verify`.
#[derive(Debug, Args)]
pub(super) struct VerifyOptions {
    /// JSON file, or - for standard input: a request of POST /v1/verify, or a
    /// result of Takt
    #[arg(value_name = "FILE|-")]
    source: String,
    /// Write the certificate here instead of to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Certifies a trajectory; fails if it is unlawful.
pub(super) fn verify(options: VerifyOptions) -> Result<(), Failure> {
    let document = input::document(&options.source)?;
    let mut certificates = Vec::new();
    for request in verify_requests(document.value) {
        let invalid =
            |faults| Failure::faults(format!("{} cannot be verified", document.name), &faults);
        let request = VerifyRequest::parse(request).map_err(invalid)?;
        certificates.push(certify(&request, &catalogue::get).map_err(invalid)?);
    }
    let text = match &certificates[..] {
        [one] => output::pretty(one)?,
        several => output::pretty(&several)?,
    };
    output::deliver(&text, options.out.as_deref())?;
    for certificate in &certificates {
        output::remark(&lawfulness(certificate));
    }
    let violations: Vec<String> = certificates
        .iter()
        .flat_map(|certificate| &certificate.violations)
        .map(|violation| violation.detail.clone())
        .collect();
    if certificates.iter().all(|certificate| certificate.lawful) {
        return Ok(());
    }
    Err(Failure::planning("limits are exceeded").with_notes(violations))
}

/// The requests in a document: a result holds one per trajectory, with the
/// limits of its certificate; anything else is a request already.
fn verify_requests(document: Value) -> Vec<Value> {
    match serde_json::from_value::<PlanResult>(document.clone()) {
        Ok(PlanResult::Trajectory(result)) => vec![verify_request(&result)],
        Ok(PlanResult::Program(program)) => {
            program.legs.iter().map(|leg| verify_request(&leg.result)).collect()
        }
        Ok(PlanResult::Family(family)) => vec![verify_request(&family.worst_case)],
        Ok(PlanResult::Path(_) | PlanResult::Comparison(_)) | Err(_) => vec![document],
    }
}

/// Asks for a certificate of a result within the limits it was planned for. A result holds no kinematics, which
/// the limit of the tool's speed needs: the catalogue may know them.
fn verify_request(result: &TrajectoryResult) -> Value {
    let joints: Vec<Value> = result
        .certificate
        .joints
        .iter()
        .zip(&result.joint_units)
        .map(|(joint, unit)| {
            json!({
                "name": joint.name,
                "type": if unit == "m" { "prismatic" } else { "revolute" },
                "limits": {
                    "lower": joint.position.lower,
                    "upper": joint.position.upper,
                    "velocity": joint.velocity.limit,
                    "acceleration": joint.acceleration.limit,
                    "jerk": joint.jerk.limit,
                },
            })
        })
        .collect();
    let due = result.waypoint_times.iter().zip(&result.waypoints);
    let due = due.map(|(time, position)| json!({"time": time, "position": position}));
    let mut request = json!({
        "robot": {"name": result.robot, "joints": joints},
        "trajectory": result.trajectory,
        "waypoints": due.collect::<Vec<_>>(),
    });
    if let Some(tolerance) = &result.certificate.via_tolerance {
        request["via_tolerance"] = json!(tolerance);
    }
    if let Some(tcp) = &result.certificate.tcp_speed {
        let known = catalogue::get(&result.robot);
        let kinematics = known.and_then(|robot| robot.description().kinematics.clone());
        request["robot"]["kinematics"] = json!(kinematics);
        request["limits"] = json!({ "tcp_speed": tcp.limit });
    }
    request
}
