//! Robots kept as files, registered when the server starts.

use std::path::{Path, PathBuf};

use crate::service::{Service, ServiceError};

/// Why a robot file stops the server from starting.
#[derive(Debug, thiserror::Error)]
pub enum RobotFileError {
    /// The directory or the file cannot be read.
    #[error("cannot read {}", .path.display())]
    Read {
        /// The directory or file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is not JSON.
    #[error("{}: not JSON", .path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Where and what.
        source: serde_json::Error,
    },
    /// The robot is refused.
    #[error("{}: {}{faults}", .path.display(), .source.message)]
    Refused {
        /// The file.
        path: PathBuf,
        /// The faults with their places, in words.
        faults: String,
        /// The refusal.
        source: ServiceError,
    },
}

/// Registers every `*.json` of `directory` under its file's name, in order of
/// the names; a robot of that name is replaced.
///
/// # Errors
///
/// The first file that is no robot: better no start than a missing robot.
pub async fn register(service: &Service, directory: &Path) -> Result<usize, RobotFileError> {
    let unreadable = |path: &Path| {
        let path = path.to_owned();
        move |source| RobotFileError::Read { path, source }
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(unreadable(directory))? {
        let path = entry.map_err(unreadable(directory))?.path();
        if path.extension().is_some_and(|extension| extension == "json") {
            files.push(path);
        }
    }
    files.sort();
    for path in &files {
        let text = std::fs::read_to_string(path).map_err(unreadable(path))?;
        let value = serde_json::from_str(&text)
            .map_err(|source| RobotFileError::Json { path: path.clone(), source })?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if let Err(source) = service.put_robot(&name, value).await {
            let fault =
                |fault: &crate::fault::Fault| format!("; {}: {}", fault.pointer, fault.detail);
            let faults = source.faults.iter().map(fault).collect();
            return Err(RobotFileError::Refused { path: path.clone(), faults, source });
        }
    }
    Ok(files.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::Running;
    use crate::config::Config;

    async fn start(data: &Path, robots: &Path) -> Result<Running, crate::app::AppError> {
        let mut config = Config::load(None, [], []).unwrap();
        config.data_dir = data.to_owned();
        config.robots_dir = Some(robots.to_owned());
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        Running::start(&config, listener).await
    }

    #[tokio::test]
    async fn robots_of_the_directory_are_known_from_the_start() {
        let (data, robots) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let axis =
            r#"{ "joints": [{ "name": "x", "type": "prismatic", "limits": { "velocity": 1 } }] }"#;
        std::fs::write(robots.path().join("axis.json"), axis).unwrap();
        std::fs::write(robots.path().join("notes.txt"), "not a robot").unwrap();
        let server = start(data.path(), robots.path()).await.unwrap();
        let robot = server.service().robot("axis").await.unwrap();
        assert_eq!(robot.joints()[0].limits.velocity, Some(1.0));
        server.stop().await.unwrap();
    }

    #[tokio::test]
    async fn a_file_that_is_no_robot_stops_the_start_and_is_named() {
        let (data, robots) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::fs::write(robots.path().join("bad.json"), r#"{ "joints": [] }"#).unwrap();
        let error = start(data.path(), robots.path()).await.err().unwrap().to_string();
        assert!(error.contains("bad.json") && error.contains("/joints"), "{error}");
    }
}
