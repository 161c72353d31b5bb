//! The whole story once: a server of its own, three jobs over REST, their
//! convergence live over gRPC, what they produced over REST, and a table.

mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use toml::Value as Setting;

use crate::app::Running;
use crate::config::Config;
use crate::job::Job;
use crate::plan::ProgramResult;

use super::client::Client;
use super::failure::Failure;
use super::follow::{follow, outcome};
use super::output;
use super::progress::Display;

/// The program that is planned.
const SCENARIO: &str = "mcb-assembly";

/// Options of `takt demo`.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Directory for what the server delivers
    #[arg(long, value_name = "DIR", default_value = "takt-demo")]
    out: PathBuf,
}

/// A way to plan the program.
struct Method {
    /// Name of its directory.
    name: &'static str,
    title: &'static str,
    optimizer: &'static str,
    /// Interpolation of legs with three segments; others are `quintic`.
    three_segments: &'static str,
    clock: &'static str,
}

/// As published; the optimum of the published curves; the best curves here.
const METHODS: [Method; 3] = [
    Method {
        name: "as-published",
        title: "improved_pso, as published",
        optimizer: "improved_pso",
        three_segments: "quintic_han",
        clock: "per_joint",
    },
    Method {
        name: "same-curves",
        title: "exact, the published curves",
        optimizer: "exact",
        three_segments: "quintic_han",
        clock: "shared",
    },
    Method {
        name: "best",
        title: "exact, quintic",
        optimizer: "exact",
        three_segments: "quintic",
        clock: "shared",
    },
];

/// Runs the demonstration.
pub(super) async fn run(options: Options) -> Result<(), Failure> {
    let data = TemporaryDirectory::new()?;
    let server = start(&data.0).await?;
    let url = format!("http://{}", server.address());
    output::remark(&format!("a server of its own listens on {url}"));
    let told = tell(&url, &options.out).await;
    let stopped = server.stop().await;
    let text = told?;
    stopped.map_err(|error| Failure::system("the server did not end well", &error))?;
    output::print(&text)
}

/// Starts a server on a free port.
async fn start(data: &Path) -> Result<Running, Failure> {
    let failed = |error: &dyn std::error::Error| Failure::system("cannot start the server", error);
    let data = data.to_string_lossy().into_owned();
    let settings = [
        ("listen", Setting::String("127.0.0.1:0".to_owned())),
        ("data_dir", Setting::String(data)),
        // Nothing to wait for: every job has ended by then.
        ("drain_s", Setting::Float(1.0)),
    ];
    let config = Config::load(None, [], settings).map_err(|error| failed(&error))?;
    let listener = TcpListener::bind(&config.listen).await.map_err(|error| failed(&error))?;
    Running::start(&config, listener).await.map_err(|error| failed(&error))
}

/// Plans, fetches and compares; the answer is what the user reads at the end.
async fn tell(url: &str, out: &Path) -> Result<String, Failure> {
    let client = Client::new(url)?;
    let scenario: Value = client.get(&format!("/v1/scenarios/{SCENARIO}/request"), &[]).await?;
    let mut results = Vec::with_capacity(METHODS.len());
    for method in &METHODS {
        let request = request(&scenario, method);
        let job: Job = client.post("/v1/jobs", Some(&request)).await?;
        let id = job.id.to_string();
        let mut display = Display::new(format!("{:<28}", method.title));
        let finished = follow(&client, &id, &mut display).await?;
        display.finish(&format!("{:<28} {}", method.title, outcome(&finished)?));
        let directory = out.join(method.name);
        fetch(&client, &id, &directory, &request).await?;
        results.push(client.get(&format!("/v1/jobs/{id}/result"), &[]).await?);
    }
    let results: [ProgramResult; 3] =
        results.try_into().map_err(|_| Failure::planning("a result is missing"))?;
    Ok(report::report(&results, out))
}

/// The scenario's request, planned by `method`.
fn request(scenario: &Value, method: &Method) -> Value {
    let mut request = scenario.clone();
    let legs = request.pointer_mut("/task/legs").and_then(Value::as_array_mut);
    for task in legs.into_iter().flatten().filter_map(|leg| leg.get_mut("task")) {
        let waypoints = task.get("waypoints").and_then(Value::as_array).map_or(0, Vec::len);
        let interpolation = if waypoints == 4 { method.three_segments } else { "quintic" };
        if let Value::Object(task) = task {
            task.insert("interpolation".to_owned(), json!(interpolation));
            task.insert("optimizer".to_owned(), json!({"name": method.optimizer}));
            task.insert("clock".to_owned(), json!(method.clock));
        }
    }
    request
}

/// Fetches everything there is about a job into `directory`.
async fn fetch(
    client: &Client,
    id: &str,
    directory: &Path,
    request: &Value,
) -> Result<(), Failure> {
    let failed = |error| Failure::system(&format!("cannot make {}", directory.display()), &error);
    std::fs::create_dir_all(directory).map_err(failed)?;
    output::write(&directory.join("request.json"), output::pretty(request)?.as_bytes())?;
    let job = format!("/v1/jobs/{id}");
    let files = [
        ("result.json", "/result"),
        ("trajectory.json", "/trajectory"),
        ("trajectory.csv", "/trajectory?format=csv&rate_hz=250"),
        ("certificate.json", "/certificate"),
        ("metrics.json", "/metrics"),
        ("convergence.svg", "/convergence?format=svg"),
        ("plot.svg", "/plot.svg"),
    ];
    for (file, address) in files {
        let content = client.text(&format!("{job}{address}")).await?;
        output::write(&directory.join(file), content.as_bytes())?;
    }
    Ok(())
}

/// A directory that goes when it is dropped.
struct TemporaryDirectory(PathBuf);

impl TemporaryDirectory {
    fn new() -> Result<Self, Failure> {
        let name = format!("takt-demo-{}", uuid::Uuid::new_v4());
        let path = std::env::temp_dir().join(name);
        let failed = |error| Failure::system(&format!("cannot make {}", path.display()), &error);
        std::fs::create_dir(&path).map_err(failed)?;
        Ok(Self(path))
    }
}

impl Drop for TemporaryDirectory {
    fn drop(&mut self) {
        // What cannot be removed is left to the system's own cleaning.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_legs_of_three_segments_take_the_published_curves() {
        let leg = |name: &str, waypoints: usize| json!({"name": name, "task": {"type": "waypoints", "waypoints": vec![[0.0]; waypoints]}});
        let scenario = json!({"robot": "rokae_xb4", "task": {"type": "program",
            "legs": [leg("AB", 4), leg("BC", 6)]}});
        let request = request(&scenario, &METHODS[0]);
        let task = |leg: usize| &request["task"]["legs"][leg]["task"];
        assert_eq!(task(0)["interpolation"], "quintic_han");
        assert_eq!(task(1)["interpolation"], "quintic");
        for leg in 0..2 {
            assert_eq!(task(leg)["optimizer"]["name"], "improved_pso");
            assert_eq!(task(leg)["clock"], "per_joint");
            assert_eq!(task(leg)["type"], "waypoints");
        }
    }

    #[test]
    fn the_temporary_directory_goes() {
        let directory = TemporaryDirectory::new().unwrap();
        let path = directory.0.clone();
        assert!(path.is_dir());
        drop(directory);
        assert!(!path.exists());
    }

    /// The story has to go through as a newcomer sees it: server, REST, gRPC,
    /// files, table.
    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn tells_the_story_and_leaves_the_files() {
        let (data, out) = (TemporaryDirectory::new().unwrap(), TemporaryDirectory::new().unwrap());
        let server = start(&data.0).await.unwrap();
        let told = tell(&format!("http://{}", server.address()), &out.0).await;
        server.stop().await.unwrap();
        let report = told.unwrap();
        for text in ["AB        quintic_han", "7.89 s", "7.0255 s", "5.7568 s", "11.53 s *"] {
            assert!(report.contains(text), "{text} not in\n{report}");
        }
        for method in &METHODS {
            let file =
                |name: &str| std::fs::read_to_string(out.0.join(method.name).join(name)).unwrap();
            assert!(file("trajectory.csv").starts_with("t [s],joint_1 position [rad],"));
            let certificate: Value = serde_json::from_str(&file("certificate.json")).unwrap();
            assert_eq!(certificate["legs"].as_array().map(Vec::len), Some(4));
            for picture in ["plot.svg", "convergence.svg"] {
                assert!(file(picture).starts_with("<svg "), "{picture}");
            }
        }
    }
}
