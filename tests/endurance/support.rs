//! A real server process, and jobs of every length.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

/// `takt serve` as a process of its own, killed when dropped.
pub struct Process {
    child: Child,
    pub base: String,
}

impl Process {
    /// Starts a server over `data` on a free port.
    pub fn start(data: &Path) -> Self {
        Self::start_with(data, &[])
    }

    /// Starts a server with environment variables of its own.
    pub fn start_with(data: &Path, environment: &[(&str, &str)]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_takt"))
            .args(["serve", "--listen", "127.0.0.1:0", "--data"])
            .arg(data)
            .env("TAKT_LOG_FORMAT", "json")
            .env("RUST_LOG", "info")
            .envs(environment.iter().copied())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap()).lines();
        let address = loop {
            let line = log.next().unwrap().unwrap();
            let entry: Value = serde_json::from_str(&line).unwrap_or(Value::Null);
            if let Some(address) = entry["address"].as_str() {
                break address.to_owned();
            }
        };
        // Keep reading, or the server would wait for its log to be read.
        std::thread::spawn(move || log.for_each(drop));
        Self { child, base: format!("http://{address}") }
    }

    /// SIGKILL: no farewell.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// SIGTERM, then waits for the orderly end.
    pub fn terminate(mut self) -> bool {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        self.child.wait().unwrap().success()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Already gone where a test ended it itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A job that ends in milliseconds.
pub fn short(seed: u64) -> Value {
    let joint = |name: &str| {
        json!({ "name": name, "type": "revolute",
            "limits": { "velocity": 1.5, "acceleration": 4.0, "jerk": 30.0 } })
    };
    json!({ "robot": { "name": "pair", "joints": [joint("a"), joint("b")] }, "seed": seed,
        "task": { "type": "waypoints", "waypoints": [[0, 0], [0.7, 0.2], [0.9, -0.4], [0.1, -0.5]],
            "optimizer": { "name": "improved_pso", "population": 20, "iterations": 15 } } })
}

/// A job that would run for hours.
pub fn endless() -> Value {
    let mut job = short(0);
    job["task"]["optimizer"]["iterations"] = json!(1_000_000_000u64);
    job
}

/// A result without the fields that tell how long planning took.
pub fn timeless(mut result: Value) -> String {
    if let Some(members) = result.as_object_mut() {
        members.remove("planning_s");
    }
    for point in result["convergence"].as_array_mut().into_iter().flatten() {
        point.as_object_mut().map(|members| members.remove("elapsed_s"));
    }
    result.to_string()
}
