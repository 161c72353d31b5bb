//! The settings: defaults, a file, the environment, the command line.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Table, Value};

/// The defaults with their explanations; the reference of all settings.
pub const DEFAULTS: &str = include_str!("../config.default.toml");

const PREFIX: &str = "TAKT_";

/// Variables of our prefix that other parts of the program read.
const OTHER_VARIABLES: &[&str] = &["TAKT_CONFIG", "TAKT_SERVER"];

/// What a server needs to know. `config.default.toml` explains each setting.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Address and port to listen on.
    pub listen: String,
    /// Directory of the database.
    pub data_dir: PathBuf,
    /// Directory of robot files to register at the start; none if empty.
    #[serde(deserialize_with = "unless_empty")]
    pub robots_dir: Option<PathBuf>,
    /// Threads that plan; 0 takes the machine's cores less one.
    pub workers: usize,
    /// Jobs that may wait.
    pub queue_capacity: usize,
    /// Largest body after decompression, bytes.
    pub max_body_bytes: usize,
    /// Seconds for running jobs to end when the server stops.
    pub drain_s: f64,
    /// Days that ended jobs are kept; 0 keeps them for ever.
    pub retention_days: u32,
    /// How log lines look.
    pub log_format: LogFormat,
}

/// TOML has no null: an empty path stands for none.
fn unless_empty<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<PathBuf>, D::Error> {
    let path = PathBuf::deserialize(from)?;
    Ok(Some(path).filter(|path| !path.as_os_str().is_empty()))
}

/// How log lines look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

/// Why there is no configuration.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("{origin}: {message}")]
    Parse {
        /// The file or `config.default.toml`.
        origin: String,
        /// Where and what.
        message: String,
    },
    /// There is no such setting.
    #[error("{origin}: unknown setting `{key}`; known: {known}")]
    UnknownKey {
        /// Where it was given.
        origin: String,
        /// The key.
        key: String,
        /// All settings.
        known: String,
    },
    /// The value does not fit the setting.
    #[error("{0}")]
    Value(String),
    /// Values that make no sense.
    #[error("{}", .0.join("; "))]
    Invalid(Vec<String>),
}

impl Config {
    /// Puts the settings together, the later over the earlier: the defaults,
    /// `file`, `environment` (names and values, all of the process's), and
    /// `options` of the command line.
    ///
    /// # Errors
    ///
    /// See [`ConfigError`]; all values are checked.
    pub fn load(
        file: Option<&Path>,
        environment: impl IntoIterator<Item = (String, String)>,
        options: impl IntoIterator<Item = (&'static str, Value)>,
    ) -> Result<Self, ConfigError> {
        let mut settings = parse("config.default.toml", DEFAULTS)?;
        if let Some(path) = file {
            let text = std::fs::read_to_string(path)
                .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
            let origin = path.display().to_string();
            let given = parse(&origin, &text)?;
            overlay(&mut settings, &origin, given)?;
        }
        let variables = variables(&settings, environment)?;
        overlay(&mut settings, "the environment", variables)?;
        let options = options.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        overlay(&mut settings, "the command line", options)?;
        let config: Self =
            settings.try_into().map_err(|error| ConfigError::Value(one_line(&error)))?;
        config.check()?;
        Ok(config)
    }

    /// Checks that the values make sense.
    ///
    /// # Errors
    ///
    /// [`ConfigError::Invalid`] with everything that is wrong.
    pub fn check(&self) -> Result<(), ConfigError> {
        let mut faults = Vec::new();
        let mut demand = |holds: bool, fault: String| {
            if !holds {
                faults.push(fault);
            }
        };
        let port = self.listen.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
        demand(
            matches!(port, Some(Ok(_))),
            format!(
                "listen: `{}` is not an address and a port, such as 127.0.0.1:8080",
                self.listen
            ),
        );
        demand(!self.data_dir.as_os_str().is_empty(), "data_dir: is empty".to_owned());
        demand(self.workers <= 1024, format!("workers: {} are more than 1024", self.workers));
        demand(self.queue_capacity > 0, "queue_capacity: 0 would refuse every job".to_owned());
        demand(
            (1024..=1 << 30).contains(&self.max_body_bytes),
            format!("max_body_bytes: {} is not within 1024 and 1 GiB", self.max_body_bytes),
        );
        demand(
            (0.0..=3600.0).contains(&self.drain_s),
            format!("drain_s: {} is not within 0 and 3600", self.drain_s),
        );
        if faults.is_empty() { Ok(()) } else { Err(ConfigError::Invalid(faults)) }
    }
}

fn parse(origin: &str, text: &str) -> Result<Table, ConfigError> {
    text.parse().map_err(|error: toml::de::Error| ConfigError::Parse {
        origin: origin.to_owned(),
        message: one_line(&error),
    })
}

fn one_line(error: &toml::de::Error) -> String {
    error.to_string().lines().map(str::trim).collect::<Vec<_>>().join(" ")
}

/// Replaces settings by those `given`.
fn overlay(settings: &mut Table, origin: &str, given: Table) -> Result<(), ConfigError> {
    for (key, value) in given {
        let Some(setting) = settings.get_mut(&key) else {
            let known = settings.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(ConfigError::UnknownKey { origin: origin.to_owned(), key, known });
        };
        *setting = match (&*setting, value) {
            // 25 is as good as 25.0.
            (Value::Float(_), Value::Integer(number)) => Value::Float(number as f64),
            (old, new) if old.same_type(&new) => new,
            (old, new) => {
                let (old, new) = (old.type_str(), new.type_str());
                return Err(ConfigError::Value(format!(
                    "{origin}: {key} is of type {new}, not {old}"
                )));
            }
        };
    }
    Ok(())
}

/// The settings among the environment's variables, read as what they replace.
fn variables(
    settings: &Table,
    environment: impl IntoIterator<Item = (String, String)>,
) -> Result<Table, ConfigError> {
    let mut given = Table::new();
    for (name, text) in environment {
        let Some(key) = name.strip_prefix(PREFIX).map(str::to_lowercase) else { continue };
        if OTHER_VARIABLES.contains(&name.as_str()) || set_by_kubernetes(&name) {
            continue;
        }
        let number = |error: &dyn std::fmt::Display| {
            ConfigError::Value(format!("{name}: `{text}` is not a number: {error}"))
        };
        let value = match settings.get(&key) {
            Some(Value::Integer(_)) => Value::Integer(text.parse().map_err(|e| number(&e))?),
            Some(Value::Float(_)) => Value::Float(text.parse().map_err(|e| number(&e))?),
            _ => Value::String(text),
        };
        given.insert(key, value);
    }
    Ok(given)
}

/// Kubernetes tells every container of a service named `takt` in such
/// variables; they are not meant as settings.
fn set_by_kubernetes(name: &str) -> bool {
    name.starts_with("TAKT_SERVICE_") || name.starts_with("TAKT_PORT")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(
        file: Option<&str>,
        environment: &[(&str, &str)],
        options: Vec<(&'static str, Value)>,
    ) -> Result<Config, String> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("takt.toml");
        std::fs::write(&path, file.unwrap_or_default()).unwrap();
        let environment = environment.iter().map(|(name, value)| ((*name).into(), (*value).into()));
        Config::load(file.map(|_| &*path), environment, options).map_err(|error| error.to_string())
    }

    #[test]
    fn the_defaults_are_complete_and_valid() {
        let config = load(None, &[("PATH", "/bin")], vec![]).unwrap();
        assert_eq!(config.listen, "127.0.0.1:8080");
        assert_eq!(config.drain_s, 25.0);
        assert_eq!(config.log_format, LogFormat::Text);
    }

    #[test]
    fn later_sources_win() {
        let file = Some("workers = 2\nqueue_capacity = 5\ndrain_s = 3");
        let environment = [("TAKT_WORKERS", "3"), ("TAKT_LOG_FORMAT", "json")];
        let config = load(file, &environment, vec![("workers", Value::Integer(4))]).unwrap();
        assert_eq!((config.workers, config.queue_capacity, config.drain_s), (4, 5, 3.0));
        assert_eq!(config.log_format, LogFormat::Json);
    }

    #[test]
    fn variables_that_are_not_ours_to_read_are_left_alone() {
        let environment = [("TAKT_SERVER", "http://x"), ("TAKT_PORT_8080_TCP", "tcp://10.0.0.1")];
        assert!(load(None, &environment, vec![]).is_ok());
    }

    #[test]
    fn faults_name_the_place() {
        for (file, environment, expected) in [
            (Some("worker = 2"), None, "unknown setting `worker`; known: "),
            (Some("workers = \"2\""), None, "workers is of type string, not integer"),
            (Some("workers = -1"), None, "workers"),
            (Some("workers = "), None, "takt.toml: TOML parse error at line 1"),
            (None, Some(("TAKT_WORKRES", "2")), "the environment: unknown setting `workres`"),
            (None, Some(("TAKT_WORKERS", "two")), "TAKT_WORKERS: `two` is not a number"),
            (None, Some(("TAKT_DRAIN_S", "nan")), "drain_s: NaN is not within"),
            (Some("queue_capacity = 0\nlisten = \"here\""), None, "queue_capacity: 0"),
            (Some("queue_capacity = 0\nlisten = \"here\""), None, "listen: `here`"),
            (Some("log_format = \"xml\""), None, "xml"),
        ] {
            let fault = load(file, &environment.into_iter().collect::<Vec<_>>(), vec![]);
            let fault = fault.unwrap_err();
            assert!(fault.contains(expected), "{expected} not in: {fault}");
        }
    }
}
