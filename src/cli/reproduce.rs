//! Published experiments, run again.

use std::path::PathBuf;

use clap::Args;

use crate::reproduce::{self, DEFAULT_RUNS, PAPERS, Paper};

use super::failure::Failure;
use super::{input, output};

/// Options of `takt reproduce`.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// A paper: chen, han, shu, lin_yang or zhang; default all
    #[arg(value_name = "PAPER")]
    paper: Option<String>,
    /// Runs of every method that has seeds
    #[arg(long, default_value_t = DEFAULT_RUNS, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Directory for report.md and report.html
    #[arg(long, value_name = "DIR", default_value = "takt-reproduce")]
    out: PathBuf,
}

/// Runs the experiments and writes the report.
pub(super) async fn run(options: Options) -> Result<(), Failure> {
    let papers = papers(options.paper.as_deref())?;
    let runs = options.runs;
    let failed = |error| Failure::system("cannot make the directory of the report", &error);
    std::fs::create_dir_all(&options.out).map_err(failed)?;
    let work = move || reproduce::reproduce(&papers, runs, &output::remark);
    let report = tokio::task::spawn_blocking(work)
        .await
        .map_err(|error| Failure::planning(format!("ended with a fault of ours: {error}")))?
        .map_err(|error| Failure::planning(error.to_string()))?;
    output::write(&options.out.join("report.md"), report.markdown().as_bytes())?;
    output::write(&options.out.join("report.html"), report.html().as_bytes())?;
    output::print(&format!(
        "{}\n{} and report.md beside it",
        report.headline.join("\n"),
        options.out.join("report.html").display()
    ))
}

fn papers(name: Option<&str>) -> Result<Vec<&'static Paper>, Failure> {
    let Some(name) = name else { return Ok(PAPERS.iter().collect()) };
    let known = PAPERS.iter().map(|paper| paper.name);
    let unknown = || input::unknown("there is no paper", name, known);
    Ok(vec![reproduce::paper(name).ok_or_else(unknown)?])
}
