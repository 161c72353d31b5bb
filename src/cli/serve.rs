//! The server as a command.

use std::path::PathBuf;

use clap::Args;
use tokio::net::TcpListener;
use toml::Value;

use crate::app;
use crate::config::Config;

use super::failure::Failure;
use super::output;

/// Options of `takt serve`.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Address and port to listen on [default: 127.0.0.1:8080]
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<String>,
    /// Directory of the database [default: takt-data]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Settings as TOML; see config.default.toml
    #[arg(long, value_name = "FILE", env = "TAKT_CONFIG")]
    config: Option<PathBuf>,
    /// Check the settings and end
    #[arg(long)]
    check_config: bool,
}

/// Serves until SIGTERM or Ctrl-C.
pub(super) async fn run(options: Options) -> Result<(), Failure> {
    let config = load(&options)?;
    if options.check_config {
        return output::print(&format!("{config:#?}\nthe settings are valid"));
    }
    app::start_log(config.log_format)
        .map_err(|error| Failure::system("cannot start the log", &error))?;
    let listener = TcpListener::bind(&config.listen)
        .await
        .map_err(|error| Failure::system(&format!("cannot listen on {}", config.listen), &error))?;
    let shutdown = app::shutdown_signal()
        .map_err(|error| Failure::system("cannot wait for signals", &error))?;
    let served = app::run(&config, listener, shutdown).await;
    served.map_err(|error| Failure::system("cannot serve", &error))
}

fn load(options: &Options) -> Result<Config, Failure> {
    let listen = options.listen.clone().map(|listen| ("listen", Value::String(listen)));
    let data = options
        .data
        .as_ref()
        .map(|data| ("data_dir", Value::String(data.to_string_lossy().into_owned())));
    // Variables that are not Unicode are none of ours.
    let environment = std::env::vars_os()
        .filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    Config::load(options.config.as_deref(), environment, listen.into_iter().chain(data))
        .map_err(|error| Failure::system("the settings cannot be used", &error))
}
