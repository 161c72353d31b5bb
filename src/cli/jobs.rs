//! Commands that talk to a server about jobs.

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;

use crate::job::{Job, JobPage, JobState};

use super::client::{Client, Server};
use super::failure::Failure;
use super::follow::{follow, outcome};
use super::progress::Display;
use super::table::Table;
use super::{input, output};

/// Options of `takt submit`.
#[derive(Debug, Args)]
pub(super) struct SubmitOptions {
    /// JSON file, name of a scenario, or - for standard input
    #[arg(value_name = "FILE|SCENARIO|-")]
    source: String,
    #[command(flatten)]
    set: input::SetOptions,
    /// Seed of the random streams, instead of the request's
    #[arg(long)]
    seed: Option<u64>,
    /// Follow the job until it ends
    #[arg(long)]
    watch: bool,
    #[command(flatten)]
    server: Server,
}

/// Sends a job and prints its id.
pub(super) async fn submit(options: SubmitOptions) -> Result<(), Failure> {
    let mut request = input::request(&options.source, &options.set)?.value;
    if let (Some(seed), Value::Object(members)) = (options.seed, &mut request) {
        members.insert("seed".to_owned(), seed.into());
    }
    let client = Client::new(&options.server.url)?;
    let job: Job = client.post("/v1/jobs", Some(&request)).await?;
    output::print(&job.id.to_string())?;
    if options.watch { show(&client, &job.id.to_string()).await } else { Ok(()) }
}

/// Options of `takt watch`.
#[derive(Debug, Args)]
pub(super) struct WatchOptions {
    /// The job's id
    id: String,
    #[command(flatten)]
    server: Server,
}

/// Follows a job until it ends; fails if the job does.
pub(super) async fn watch(options: WatchOptions) -> Result<(), Failure> {
    show(&Client::new(&options.server.url)?, &options.id).await
}

async fn show(client: &Client, id: &str) -> Result<(), Failure> {
    let mut display = Display::new(short(id));
    let finished = follow(client, id, &mut display).await?;
    display.finish(&outcome(&finished)?);
    Ok(())
}

/// The random end of an id: its beginning is the time and alike for many.
fn short(id: &str) -> &str {
    id.rsplit('-').next().unwrap_or(id)
}

/// Options of `takt jobs`.
#[derive(Debug, Args)]
pub(super) struct ListOptions {
    /// Only jobs in this state: queued, running, succeeded, failed, cancelled or expired
    #[arg(long)]
    state: Option<JobState>,
    /// Only jobs with this label; may be given several times
    #[arg(long = "label", value_name = "KEY=VALUE", value_parser = input::pair)]
    labels: Vec<(String, String)>,
    /// At most this many jobs, 1 to 500
    #[arg(long, default_value_t = 50)]
    limit: u32,
    /// Print the server's answer as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    server: Server,
}

/// Lists jobs, newest first.
pub(super) async fn list(options: ListOptions) -> Result<(), Failure> {
    let mut query = vec![("page_size".to_owned(), options.limit.to_string())];
    query.extend(options.state.map(|state| ("state".to_owned(), state.to_string())));
    query.extend(options.labels.into_iter().map(|(key, value)| (format!("label.{key}"), value)));
    let page: JobPage = Client::new(&options.server.url)?.get("/v1/jobs", &query).await?;
    if options.json {
        return output::print(&output::pretty(&page)?);
    }
    let mut table =
        Table::new(["id", "state", "task", "method", "robot", "accepted", ">best [s]", "error"]);
    for job in &page.jobs {
        table.row(row(job));
    }
    output::print(&table.text())?;
    if page.next_page_token.is_some() {
        output::remark("there are more; see --limit, --state and --label");
    }
    Ok(())
}

fn row(job: &Job) -> [String; 8] {
    let best = job.progress.as_ref().and_then(|progress| progress.best);
    [
        job.id.to_string(),
        job.state.to_string(),
        job.task.clone(),
        job.method.clone(),
        job.robot.clone(),
        format!("{:.0}", job.created_at),
        best.map(|best| format!("{best:.4}")).unwrap_or_default(),
        job.error.as_ref().map(|error| error.code.clone()).unwrap_or_default(),
    ]
}

/// Options of `takt cancel`.
#[derive(Debug, Args)]
pub(super) struct CancelOptions {
    /// The job's id
    id: String,
    #[command(flatten)]
    server: Server,
}

/// Cancels a job.
pub(super) async fn cancel(options: CancelOptions) -> Result<(), Failure> {
    let client = Client::new(&options.server.url)?;
    let job: Job = client.post(&format!("/v1/jobs/{}/cancel", options.id), None).await?;
    let state = match job.state {
        JobState::Running => "will end within moments".to_owned(),
        state => state.to_string(),
    };
    output::print(&format!("{} {state}", job.id))
}

/// Options of `takt result`.
#[derive(Debug, Args)]
pub(super) struct ResultOptions {
    /// The job's id
    id: String,
    /// Write the result here instead of to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    server: Server,
}

/// Prints a job's result, byte for byte as the server keeps it.
pub(super) async fn result(options: ResultOptions) -> Result<(), Failure> {
    let client = Client::new(&options.server.url)?;
    let text = client.text(&format!("/v1/jobs/{}/result", options.id)).await?;
    output::deliver(&text, options.out.as_deref())
}

/// Options of `takt health`.
#[derive(Debug, Args)]
pub(super) struct HealthOptions {
    #[command(flatten)]
    server: Server,
}

/// Asks whether a server can take jobs; made for health checks of containers.
pub(super) async fn health(options: HealthOptions) -> Result<(), Failure> {
    output::print(&Client::new(&options.server.url)?.text("/readyz").await?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_split_at_the_first_equals_sign() {
        assert_eq!(input::pair("cell=A=3").unwrap(), ("cell".into(), "A=3".into()));
        assert!(input::pair("cell").is_err());
    }

    #[test]
    fn short_ids_are_the_random_part() {
        assert_eq!(short("019aa7c1-5d2e-7000-8000-0123456789ab"), "0123456789ab");
    }
}
