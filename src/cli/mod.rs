//! The command line: reads arguments, calls the layers below, writes answers.
//!
//! Answers go to standard output, everything else to standard error, so that
//! output can be piped. The exit status is 0 if done, 1 if planning failed or a
//! trajectory is unlawful, 2 for bad input, 3 if no server answers.

mod catalogue;
mod client;
mod comparison;
mod demo;
mod failure;
mod family;
mod follow;
mod input;
mod jobs;
mod output;
mod planning;
mod progress;
mod reproduce;
mod serve;
mod table;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use failure::Failure;

/// Plans robot trajectories: as fast as the limits allow, certified over
/// continuous time, repeatable from a seed.
#[derive(Debug, Parser)]
#[command(name = "takt", version, arg_required_else_help = true)]
#[command(after_help = "Begin with `takt demo`, or `takt plan mcb-ab`. Exit status: 0 done, \
    1 planning failed or trajectory unlawful, 2 bad input, 3 server unreachable.")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show the whole story once: server, jobs, live progress, files, table
    Demo(demo::Options),
    /// Plan in this process: result as JSON, no server needed
    Plan(planning::PlanOptions),
    /// Certify a trajectory: yours, or a result of Takt
    Verify(planning::VerifyOptions),
    /// Run the server: REST and gRPC on one port
    Serve(serve::Options),
    /// Send a job to a server and print its id
    Submit(jobs::SubmitOptions),
    /// List a server's jobs, newest first
    Jobs(jobs::ListOptions),
    /// Follow a job until it ends
    Watch(jobs::WatchOptions),
    /// Cancel a job
    Cancel(jobs::CancelOptions),
    /// Print a job's result as JSON
    Result(jobs::ResultOptions),
    /// List the robots of the catalogue, or print one as JSON
    Robots(catalogue::RobotOptions),
    /// List the built-in requests, or print one as JSON
    Scenarios(catalogue::ScenarioOptions),
    /// List interpolations, optimizers and planners with their parameters
    Methods(catalogue::MethodOptions),
    /// Run the experiments of published papers again and report
    Reproduce(reproduce::Options),
    /// Ask a server whether it can take jobs
    Health(jobs::HealthOptions),
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version come this way too, with status 0.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let runtime = match tokio::runtime::Builder::new_multi_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return Failure::system("cannot start", &error).report(),
    };
    match runtime.block_on(arguments.command.run()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

impl Command {
    async fn run(self) -> Result<(), Failure> {
        match self {
            Self::Demo(options) => demo::run(options).await,
            Self::Plan(options) => planning::plan(options).await,
            Self::Verify(options) => planning::verify(options),
            Self::Serve(options) => serve::run(options).await,
            Self::Submit(options) => jobs::submit(options).await,
            Self::Jobs(options) => jobs::list(options).await,
            Self::Watch(options) => jobs::watch(options).await,
            Self::Cancel(options) => jobs::cancel(options).await,
            Self::Result(options) => jobs::result(options).await,
            Self::Robots(options) => catalogue::robots(options).await,
            Self::Scenarios(options) => catalogue::scenarios(options),
            Self::Methods(options) => catalogue::methods(options),
            Self::Reproduce(options) => reproduce::run(options).await,
            Self::Health(options) => jobs::health(options).await,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::Arguments;

    #[test]
    fn arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn every_command_says_what_it_does() {
        for command in Arguments::command().get_subcommands() {
            assert!(command.get_about().is_some(), "{}", command.get_name());
        }
    }
}
