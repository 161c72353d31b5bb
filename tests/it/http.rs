//! The REST edge: jobs, robots and operations, with their status codes and headers.

use reqwest::Method;
use serde_json::{Value, json};

use crate::support::*;

#[tokio::test]
async fn a_job_is_accepted_found_and_served() {
    let server = Server::start().await;
    let mut job = quick_job();
    job["labels"] = json!({"cell": "3"});
    job["priority"] = json!(70);
    let response = server.post("/v1/jobs", &job).await;
    assert_eq!(response.status(), 202);
    let address = header(&response, "location");
    let accepted: Value = response.json().await.unwrap();
    assert_eq!(address, format!("/v1/jobs/{}", accepted["id"].as_str().unwrap()));
    assert_eq!(accepted["labels"], json!({"cell": "3"}));
    assert_eq!((&accepted["robot"], &accepted["task"]), (&json!("pair"), &json!("waypoints")));
    let ended = server.ended(&address).await;
    assert_eq!(state(&ended), "succeeded", "{ended}");
    assert_eq!((&ended["attempt"], &ended["priority"]), (&json!(1), &json!(70)));
    let result = server.json(&format!("{address}/result")).await;
    assert_eq!(result["joint_names"], json!(["turn", "slide"]));
    assert_eq!(result["certificate"]["lawful"], true);
    let request = server.json(&format!("{address}/request")).await;
    assert_eq!(request["robot"]["name"], "pair");
    assert_eq!(request["task"]["waypoints"], json!([[0.0, 0.0], [0.5, 0.2], [1.0, 0.1]]));
}

#[tokio::test]
async fn a_client_may_prefer_to_wait_for_the_result() {
    let server = Server::start().await;
    let wait = |job: &Value, seconds: u32| {
        let request = server.request(Method::POST, "/v1/jobs").json(job);
        request.header("Prefer", format!("respond-async, wait={seconds}")).send()
    };
    let response = wait(&quick_job(), 100).await.unwrap();
    assert_eq!(response.status(), 200);
    assert_eq!(header(&response, "preference-applied"), "wait=60");
    let address = header(&response, "location");
    let result = response.text().await.unwrap();
    let stored = server.get(&format!("{address}/result")).await.text().await.unwrap();
    assert_eq!(result, stored);

    let response = wait(&endless_job(), 0).await.unwrap();
    assert_eq!(response.status(), 202);
    assert_eq!(header(&response, "preference-applied"), "wait=0");
    let job: Value = response.json().await.unwrap();
    assert!(["queued", "running"].contains(&state(&job)));
}

#[tokio::test]
async fn a_repeated_submission_makes_no_second_job() {
    let server = Server::start().await;
    let submit = |job: Value, key: &str| {
        let request = server.request(Method::POST, "/v1/jobs").json(&job);
        request.header("Idempotency-Key", key).send()
    };
    let first = submit(quick_job(), "order-1").await.unwrap();
    assert!(first.headers().get("idempotent-replayed").is_none());
    let again = submit(quick_job(), "order-1").await.unwrap();
    assert_eq!(again.status(), 202);
    assert_eq!(header(&again, "idempotent-replayed"), "true");
    assert_eq!(header(&first, "location"), header(&again, "location"));
    let other = submit(quick_job(), "order-2").await.unwrap();
    assert_ne!(header(&first, "location"), header(&other, "location"));
    let mut changed = quick_job();
    changed["seed"] = json!(9);
    problem(submit(changed, "order-1").await.unwrap(), 422, "idempotency_mismatch").await;
    let page = server.json("/v1/jobs").await;
    assert_eq!(page["jobs"].as_array().unwrap().len(), 2);
}

#[tokio::test]
async fn jobs_are_listed_newest_first_by_state_and_label_in_pages() {
    let server = Server::start().await;
    let mut addresses = Vec::new();
    for cell in ["1", "2", "1"] {
        let mut job = quick_job();
        job["labels"] = json!({"cell": cell});
        addresses.push(server.succeeded(&job).await);
    }
    let ids = |page: &Value| -> Vec<String> {
        let jobs = page["jobs"].as_array().unwrap();
        jobs.iter().map(|job| format!("/v1/jobs/{}", job["id"].as_str().unwrap())).collect()
    };
    let newest_first: Vec<String> = addresses.iter().rev().cloned().collect();
    assert_eq!(ids(&server.json("/v1/jobs?state=succeeded").await), newest_first);
    assert!(ids(&server.json("/v1/jobs?state=failed").await).is_empty());
    let cell = server.json("/v1/jobs?label.cell=1").await;
    assert_eq!(ids(&cell), [addresses[2].clone(), addresses[0].clone()]);
    let page = server.json("/v1/jobs?page_size=2").await;
    assert_eq!(ids(&page), newest_first[..2]);
    let token = page["next_page_token"].as_str().unwrap();
    let last = server.json(&format!("/v1/jobs?page_size=2&page_token={token}")).await;
    assert_eq!(ids(&last), newest_first[2..]);
    assert_eq!(last["next_page_token"], Value::Null);
}

#[tokio::test]
async fn a_running_job_can_be_cancelled_and_only_then_deleted() {
    let server = Server::start().await;
    let address = server.submit(&endless_job()).await;
    server.runs(&address).await;
    let early = problem(server.get(&format!("{address}/result")).await, 409, "not_ended").await;
    assert!(early["detail"].as_str().unwrap().contains("running"), "{early}");
    problem(server.delete(&address).await, 409, "conflict").await;
    let cancel = format!("{address}/cancel");
    assert_eq!(server.request(Method::POST, &cancel).send().await.unwrap().status(), 200);
    assert_eq!(state(&server.ended(&address).await), "cancelled");
    let late = server.request(Method::POST, &cancel).send().await.unwrap();
    problem(late, 409, "conflict").await;
    let missing = problem(server.get(&format!("{address}/result")).await, 409, "no_result").await;
    assert!(missing["detail"].as_str().unwrap().contains("cancelled"), "{missing}");
    assert_eq!(server.delete(&address).await.status(), 204);
    problem(server.get(&address).await, 404, "not_found").await;
}

#[tokio::test]
async fn a_failed_jobs_result_is_refused_with_the_jobs_error() {
    let server = Server::start().await;
    let mut job = quick_job();
    job["task"]["duration"] = json!({"at_most": 0.01});
    let address = server.submit(&job).await;
    let job = server.ended(&address).await;
    assert_eq!(state(&job), "failed");
    assert_eq!(job["error"]["code"], "limits_unreachable");
    let refused = problem(server.get(&format!("{address}/result")).await, 409, "no_result").await;
    assert!(refused["detail"].as_str().unwrap().contains("limits_unreachable"), "{refused}");
}

#[tokio::test]
async fn a_full_queue_asks_to_try_again() {
    let server = Server::start_with(|config| {
        config.workers = 1;
        config.queue_capacity = 1;
    })
    .await;
    server.runs(&server.submit(&endless_job()).await).await;
    server.submit(&endless_job()).await;
    let response = server.post("/v1/jobs", &endless_job()).await;
    assert_eq!(header(&response, "retry-after"), "1");
    problem(response, 429, "queue_full").await;
    let metrics = server.get("/metrics").await.text().await.unwrap();
    assert!(metrics.contains("takt_rejections_total{code=\"queue_full\"} 1"), "{metrics}");
}

#[tokio::test]
async fn a_draining_server_says_so_lets_jobs_end_and_closes() {
    let mut server = Server::start_with(|config| config.drain_s = 60.0).await;
    let address = server.submit(&endless_job()).await;
    server.runs(&address).await;
    let events = server.get(&format!("{address}/events")).await;
    assert_eq!(server.get("/readyz").await.status(), 200);
    let stopping = tokio::spawn(server.take().stop());
    while server.get("/readyz").await.status() == 200 {
        tokio::task::yield_now().await;
    }
    let response = server.get("/readyz").await;
    assert_eq!(header(&response, "retry-after"), "5");
    problem(response, 503, "draining").await;
    problem(server.post("/v1/jobs", &quick_job()).await, 503, "draining").await;
    assert_eq!(server.get("/healthz").await.status(), 200);
    let cancel = format!("{address}/cancel");
    assert_eq!(server.request(Method::POST, &cancel).send().await.unwrap().status(), 200);
    assert!(events.text().await.unwrap().contains("event: finished"));
    stopping.await.unwrap().unwrap();
    assert!(server.request(Method::GET, "/healthz").send().await.is_err());
}

/// Number, name and data of each event.
fn parse_events(text: &str) -> Vec<(u64, String, Value)> {
    let field = |block: &str, name: &str| {
        let line = block.lines().find_map(|line| line.strip_prefix(name));
        line.map(|value| value.trim_start_matches(": ").to_owned())
    };
    let blocks = text.split("\n\n").filter(|block| block.contains("data"));
    blocks
        .map(|block| {
            let data = serde_json::from_str(&field(block, "data").unwrap()).unwrap();
            (field(block, "id").unwrap().parse().unwrap(), field(block, "event").unwrap(), data)
        })
        .collect()
}

#[tokio::test]
async fn watchers_see_the_same_events_and_resume_where_they_were() {
    let server = Server::start().await;
    let address = server.submit(&quick_job()).await;
    let events = format!("{address}/events");
    let live = server.get(&events).await;
    assert_eq!(header(&live, "content-type"), "text/event-stream");
    let live = parse_events(&live.text().await.unwrap());
    assert_eq!(live.iter().map(|event| event.0).collect::<Vec<_>>(), {
        let count = live.len() as u64;
        (1..=count).collect::<Vec<_>>()
    });
    assert_eq!((live[0].1.as_str(), &live[0].2["state"]), ("state", &json!("queued")));
    assert_eq!((live[1].1.as_str(), &live[1].2["state"]), ("state", &json!("running")));
    let (last, name, data) = live.last().unwrap();
    assert_eq!((name.as_str(), &data["state"]), ("finished", &json!("succeeded")));
    assert_eq!(data["summary"]["lawful"], true);
    assert_eq!(parse_events(&server.get(&events).await.text().await.unwrap()), live);

    let resume = |seq: u64| {
        server.request(Method::GET, &events).header("Last-Event-ID", seq.to_string()).send()
    };
    let rest = resume(2).await.unwrap().text().await.unwrap();
    assert_eq!(parse_events(&rest), live[2..]);
    let rest = server.get(&format!("{events}?after_seq=1")).await.text().await.unwrap();
    assert_eq!(parse_events(&rest), live[1..]);
    assert_eq!(resume(*last).await.unwrap().status(), 204);
}

#[tokio::test]
async fn robots_are_registered_used_replaced_and_deleted() {
    let server = Server::start().await;
    let put = |name: &str, robot: Value| {
        server.request(Method::PUT, &format!("/v1/robots/{name}")).json(&robot).send()
    };
    let mut unnamed = robot("pair");
    unnamed.as_object_mut().unwrap().remove("name");
    let created = put("pair", unnamed).await.unwrap();
    assert_eq!(created.status(), 201);
    assert_eq!(created.json::<Value>().await.unwrap()["name"], "pair");
    let mut job = quick_job();
    job["robot"] = json!("pair");
    let address = server.succeeded(&job).await;
    let mut slower = robot("pair");
    slower["joints"][0]["limits"]["velocity"] = json!(0.1);
    assert_eq!(put("pair", slower.clone()).await.unwrap().status(), 200);
    let kept = server.json("/v1/robots/pair").await;
    assert_eq!(kept["joints"][0]["limits"]["velocity"], 0.1);
    // What was accepted keeps the robot it came with.
    let request = server.json(&format!("{address}/request")).await;
    assert_eq!(request["robot"]["joints"][0]["limits"]["velocity"], 1.0);

    let list = server.json("/v1/robots").await;
    let origin = |name: &str| {
        let robots = list["robots"].as_array().unwrap();
        robots.iter().find(|robot| robot["name"] == name).unwrap()["origin"].clone()
    };
    assert_eq!((origin("ur5e"), origin("pair")), (json!("catalogue"), json!("registered")));
    problem(put("ur5e", robot("ur5e")).await.unwrap(), 409, "conflict").await;
    problem(server.delete("/v1/robots/ur5e").await, 409, "conflict").await;
    assert_eq!(server.delete("/v1/robots/pair").await.status(), 204);
    problem(server.get("/v1/robots/pair").await, 404, "not_found").await;
    problem(server.delete("/v1/robots/pair").await, 404, "not_found").await;
}

#[tokio::test]
async fn forward_kinematics_place_the_tool() {
    let server = Server::start().await;
    let put = server.request(Method::PUT, "/v1/robots/pair").json(&robot("pair"));
    assert_eq!(put.send().await.unwrap().status(), 201);
    let quarter = std::f64::consts::FRAC_PI_2;
    let response = server.post("/v1/robots/pair/fk", &json!({"joints": [quarter, 0.25]})).await;
    assert_eq!(response.status(), 200);
    let frames: Value = response.json().await.unwrap();
    assert_eq!(frames["joint_names"], json!(["turn", "slide"]));
    let position: Vec<f64> = serde_json::from_value(frames["tool"]["position"].clone()).unwrap();
    for (found, expected) in position.iter().zip([0.0, 2.0, 0.75]) {
        assert!((found - expected).abs() < 1e-12, "{position:?}");
    }
    assert_eq!(frames["links"].as_array().unwrap().len(), 2);
    assert_eq!(frames["jacobian"].as_array().unwrap().len(), 6);
    // The tool moves towards -x as the joint turns on, and up as it slides.
    assert!((frames["jacobian"][0][0].as_f64().unwrap() + 2.0).abs() < 1e-12, "{frames}");
    assert!((frames["jacobian"][2][1].as_f64().unwrap() - 1.0).abs() < 1e-12, "{frames}");
}

#[tokio::test]
async fn inverse_kinematics_lead_back() {
    let server = Server::start().await;
    let joints = json!([0.3, -1.2, 1.4, -0.9, -1.5, 0.6]);
    let frames = server.post("/v1/robots/ur5e/fk", &json!({"joints": joints})).await;
    let pose = frames.json::<Value>().await.unwrap()["tool"].clone();
    let ask = async |name: &str, request: Value| -> Value {
        let response = server.post(&format!("/v1/robots/{name}/ik"), &request).await;
        assert_eq!(response.status(), 200, "{request}");
        response.json().await.unwrap()
    };
    let answer = ask("ur5e", json!({"pose": pose, "seed": joints})).await;
    assert_eq!(
        (&answer["method"], &answer["complete"]),
        (&json!("three_parallel_axes"), &json!(true))
    );
    let solutions = answer["solutions"].as_array().unwrap();
    assert_eq!((solutions.len(), &answer["failure"]), (8, &Value::Null));
    // The nearest comes first; joint 1 may also stand a whole turn back, the elbow not.
    for (found, expected) in
        solutions[0]["joints"].as_array().unwrap().iter().zip(joints.as_array().unwrap())
    {
        assert!((found.as_f64().unwrap() - expected.as_f64().unwrap()).abs() < 1e-9, "{answer}");
    }
    let equivalent = &solutions[0]["equivalent"];
    assert_eq!([0, 2].map(|joint: usize| equivalent[joint].as_array().unwrap().len()), [2, 1]);
    let nearest = ask("ur5e", json!({"pose": pose, "seed": joints, "solutions": "nearest"})).await;
    assert_eq!(nearest["solutions"].as_array().unwrap()[..], solutions[..1]);

    let far = ask("ur5e", json!({"pose": {"position": [2, 0, 0.3]}})).await;
    assert_eq!(
        (&far["solutions"], &far["failure"]["code"]),
        (&json!([]), &json!("ik_no_solution"))
    );
    assert!(far["failure"]["position_error"].as_f64().unwrap() > 1.0, "{far}");
    assert_eq!(far["failure"]["limit"], Value::Null);

    let put = server.request(Method::PUT, "/v1/robots/pair").json(&robot("pair"));
    assert_eq!(put.send().await.unwrap().status(), 201);
    let frames = server.post("/v1/robots/pair/fk", &json!({"joints": [0.5, 8.5]})).await;
    let high = frames.json::<Value>().await.unwrap()["tool"].clone();
    let answer = ask("pair", json!({"pose": high})).await;
    assert_eq!(answer["failure"]["limit"]["joint"], "slide", "{answer}");
}

/// A slide and an arm on it.
const URDF: &str = r#"<robot name="crane">
<link name="floor"/><link name="trolley"/><link name="arm"/><link name="hook"/>
<joint name="run" type="prismatic"><parent link="floor"/><child link="trolley"/><axis xyz="1 0 0"/>
<limit lower="0" upper="2" velocity="1" effort="0"/></joint>
<joint name="swing" type="continuous"><parent link="trolley"/><child link="arm"/><axis xyz="0 1 0"/>
<limit velocity="2" effort="10"/></joint>
<joint name="end" type="fixed"><parent link="arm"/><child link="hook"/><origin xyz="0 0 -0.5"/></joint>
</robot>"#;

#[tokio::test]
async fn a_urdf_becomes_a_robot_that_plans() {
    let server = Server::start().await;
    let described = json!({
        "joints": [{"name": "run", "type": "prismatic", "limits": {"acceleration": 3, "jerk": 30}}],
        "kinematics": {"urdf": URDF, "tip": "hook", "joint_limits": "joint_limits: {swing: {max_acceleration: 6, max_jerk: 60}}"},
    });
    let put =
        server.request(Method::PUT, "/v1/robots/crane").json(&described).send().await.unwrap();
    assert_eq!(put.status(), 201);
    let kept: Value = put.json().await.unwrap();
    assert_eq!(kept["joints"][0]["limits"]["velocity"], 1.0);
    assert_eq!(kept["joints"][0]["limits"]["jerk"], 30.0);
    assert_eq!(kept["joints"][1]["limits"]["acceleration"], 6.0);
    assert_eq!(kept["kinematics"]["links"][1]["axis"], json!([0.0, 1.0, 0.0]));
    let frames = server.post("/v1/robots/crane/fk", &json!({"joints": [0.5, 0.0]})).await;
    let frames: Value = frames.json().await.unwrap();
    assert_eq!(frames["tool"]["position"], json!([0.5, 0.0, -0.5]));
    let job = json!({"robot": "crane", "task": {"type": "waypoints", "waypoints": [[0, 0], [1.5, 1]],
        "interpolation": "jerk_limited"}});
    let response = server.request(Method::POST, "/v1/jobs").json(&job).header("Prefer", "wait=60");
    let done: Value = response.send().await.unwrap().json().await.unwrap();
    assert_eq!(done["certificate"]["lawful"], true, "{done}");

    let broken = json!({"kinematics": {"urdf": URDF.replace("</robot>", ""), "tip": "hook"}});
    let put = server.request(Method::PUT, "/v1/robots/broken").json(&broken).send().await.unwrap();
    problem(put, 422, "invalid").await;
}

#[tokio::test]
async fn registries_and_operations_answer() {
    let server = Server::start().await;
    for (path, list) in [
        ("/v1/optimizers", "optimizers"),
        ("/v1/interpolations", "interpolations"),
        ("/v1/planners", "planners"),
        ("/v1/planners", "smoothings"),
        ("/v1/scenarios", "scenarios"),
    ] {
        let found = server.json(path).await;
        let found = found[list].as_array().unwrap();
        assert!(!found.is_empty(), "{path}");
        assert!(found.iter().all(|entry| entry["name"].is_string()), "{path}");
    }
    let scenario = server.json("/v1/scenarios/wood").await;
    let request = server.json("/v1/scenarios/wood/request").await;
    assert_eq!(scenario["request"], request);
    server.succeeded(&request).await;
    assert_eq!(server.json("/healthz").await["status"], "ok");
    assert_eq!(server.json("/readyz").await["status"], "ready");
    let metrics = server.get("/metrics").await;
    assert!(header(&metrics, "content-type").starts_with("text/plain; version=0.0.4"));
    assert!(metrics.text().await.unwrap().contains("takt_queue_depth 0"));
    let index = server.get("/").await.text().await.unwrap();
    assert!(index.contains("href=\"/docs\""));
    let docs = server.get("/docs/").await;
    assert!(header(&docs, "content-type").starts_with("text/html"));
    assert!(docs.text().await.unwrap().contains("swagger"));
    for kind in takt::http::PROBLEM_TYPES {
        let page = server.get(&kind.path()).await;
        assert_eq!(page.status(), 200, "{}", kind.code);
        assert!(page.text().await.unwrap().contains(kind.title));
    }
}

#[tokio::test]
async fn the_api_description_is_complete() {
    let server = Server::start().await;
    let api = server.json("/openapi.json").await;
    for (path, method) in [
        ("/v1/jobs", "post"),
        ("/v1/jobs", "get"),
        ("/v1/jobs/{id}", "get"),
        ("/v1/jobs/{id}", "delete"),
        ("/v1/jobs/{id}/cancel", "post"),
        ("/v1/jobs/{id}/result", "get"),
        ("/v1/jobs/{id}/metrics", "get"),
        ("/v1/jobs/{id}/certificate", "get"),
        ("/v1/jobs/{id}/trajectory", "get"),
        ("/v1/jobs/{id}/convergence", "get"),
        ("/v1/jobs/{id}/plot.svg", "get"),
        ("/v1/jobs/{id}/page", "get"),
        ("/v1/jobs/{id}/pareto.svg", "get"),
        ("/v1/jobs/{id}/events", "get"),
        ("/v1/verify", "post"),
        ("/v1/robots", "get"),
        ("/v1/robots/{name}", "put"),
        ("/v1/robots/{name}/fk", "post"),
        ("/v1/robots/{name}/ik", "post"),
        ("/v1/optimizers", "get"),
        ("/v1/planners", "get"),
    ] {
        assert!(api["paths"][path][method]["summary"].is_string(), "{method} {path}");
    }
    // Every schema that is referred to is there.
    let text = api.to_string();
    let references = text.split("\"#/components/schemas/").skip(1);
    for name in references.filter_map(|rest| rest.split('"').next()) {
        assert!(api["components"]["schemas"][name].is_object(), "{name} is not described");
    }
    // Two types of one name would hide each other.
    let schemas = &api["components"]["schemas"];
    let samples = schemas["Samples"].to_string();
    assert!(
        samples.contains("interpolation") && samples.contains("schemas/SampleForm"),
        "{samples}"
    );
    assert!(schemas["SampledTrajectory"]["properties"]["rate_hz"].is_object());
    let job = api["components"]["schemas"]["JobRequest"].to_string();
    assert!(job.contains("priority") && job.contains("PlanRequest"), "{job}");
    // A task's `type` stands beside its members, which must not forbid it.
    for composed in ["WaypointsTask", "BenchmarkTask", "Trajectory", "SampleLists"] {
        assert_eq!(schemas[composed]["additionalProperties"], Value::Null, "{composed}");
    }
    assert_eq!(schemas["Joint"]["additionalProperties"], false);
    let velocity = schemas["LimitOverrides"]["properties"]["velocity"].to_string();
    assert!(velocity.contains("schemas/LimitValues") && velocity.contains("null"), "{velocity}");
    assert!(!velocity.contains("default"), "a limit left out is not a limit removed: {velocity}");
}

#[tokio::test]
async fn the_examples_in_the_api_description_work() {
    let server = Server::start().await;
    let api = server.json("/openapi.json").await;
    for (method, path, name, count) in [
        (Method::POST, "/v1/jobs", "", 8),
        (Method::PUT, "/v1/robots/{name}", "gantry", 1),
        (Method::POST, "/v1/robots/{name}/fk", "ur5e", 1),
        (Method::POST, "/v1/robots/{name}/ik", "ur5e", 1),
        (Method::POST, "/v1/verify", "", 1),
    ] {
        let operation = &api["paths"][path][method.as_str().to_lowercase()];
        if !name.is_empty() {
            assert_eq!(operation["parameters"][0]["example"], name, "{path}");
        }
        let body = &operation["requestBody"]["content"]["application/json"];
        let named = body["examples"].as_object().into_iter().flatten();
        let examples = named.map(|(_, example)| &example["value"]).chain(body.get("example"));
        let examples: Vec<_> = examples.collect();
        assert_eq!(examples.len(), count, "{path}");
        for example in examples {
            let address = path.replace("{name}", name);
            let request = server.request(method.clone(), &address).json(example);
            let response = request.header("Prefer", "wait=60").send().await.unwrap();
            let expected = if method == Method::PUT { 201 } else { 200 };
            assert_eq!(response.status(), expected, "{path}: {example}");
            let answer: Value = response.json().await.unwrap();
            assert_ne!(answer["lawful"], false, "{path}");
        }
    }
}

#[tokio::test]
async fn requests_have_ids_the_clients_or_new_ones() {
    let server = Server::start().await;
    let send = |id: &str| server.request(Method::GET, "/nowhere").header("x-request-id", id).send();
    let response = send("cell-3/order-7").await.unwrap();
    assert_eq!(header(&response, "x-request-id"), "cell-3/order-7");
    assert_eq!(problem(response, 404, "not_found").await["request_id"], "cell-3/order-7");
    let replaced = header(&send("not one word").await.unwrap(), "x-request-id");
    assert_eq!(replaced.len(), 36, "{replaced}");
    let new = header(&server.get("/healthz").await, "x-request-id");
    assert_eq!(new.len(), 36, "{new}");
}

#[tokio::test]
async fn answers_are_compressed_for_those_who_ask() {
    let server = Server::start().await;
    let ask =
        |path: &str| server.request(Method::GET, path).header("Accept-Encoding", "gzip").send();
    let response = ask("/v1/robots").await.unwrap();
    assert_eq!(header(&response, "content-encoding"), "gzip");
    assert_eq!(response.bytes().await.unwrap()[..2], [0x1f, 0x8b]);
    assert!(server.get("/v1/robots").await.headers().get("content-encoding").is_none());
    let address = server.succeeded(&quick_job()).await;
    let events = ask(&format!("{address}/events")).await.unwrap();
    assert!(events.headers().get("content-encoding").is_none());
}

#[tokio::test]
async fn bodies_may_come_compressed_and_are_measured_unpacked() {
    let server = Server::start().await;
    let send = |body: Vec<u8>, encoding: &str| {
        let request = server.request(Method::POST, "/v1/jobs").body(body);
        request
            .header("Content-Type", "application/json")
            .header("Content-Encoding", encoding)
            .send()
    };
    let job = quick_job().to_string();
    let response = send(gzip::stored(job.as_bytes()), "gzip").await.unwrap();
    assert_eq!(response.status(), 202);
    let spaces = gzip::spaces(5 << 20);
    assert!(spaces.len() < 64 << 10);
    problem(send(spaces, "gzip").await.unwrap(), 413, "too_large").await;
    problem(send(b"no gzip".to_vec(), "gzip").await.unwrap(), 400, "unreadable").await;
    let encoding = send(job.into_bytes(), "br").await.unwrap();
    problem(encoding, 415, "unsupported_media_type").await;
}

/// Just enough of RFC 1951 and 1952 to send compressed bodies.
mod gzip {
    const HEADER: [u8; 10] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255];

    /// `data` as it is, in one block of at most 64 KiB.
    pub fn stored(data: &[u8]) -> Vec<u8> {
        let length = u16::try_from(data.len()).unwrap();
        let mut out = HEADER.to_vec();
        out.push(1);
        out.extend(length.to_le_bytes());
        out.extend((!length).to_le_bytes());
        out.extend(data);
        finish(out, data)
    }

    /// `count` spaces as repetitions of the first, 258 at a time.
    pub fn spaces(count: usize) -> Vec<u8> {
        let mut bits = Bits { out: HEADER.to_vec(), next: 0 };
        // The last block, with the fixed code.
        bits.push(&[1, 1, 0]);
        let space: [u8; 8] = [0, 1, 0, 1, 0, 0, 0, 0];
        let repeat_258: [u8; 13] = [1, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0];
        bits.push(&space);
        let repeats = (count - 1) / 258;
        (0..repeats).for_each(|_| bits.push(&repeat_258));
        bits.push(&[0; 7]);
        finish(bits.out, &vec![b' '; 1 + 258 * repeats])
    }

    fn finish(mut out: Vec<u8>, data: &[u8]) -> Vec<u8> {
        out.extend(crc32(data).to_le_bytes());
        out.extend((data.len() as u32).to_le_bytes());
        out
    }

    fn crc32(data: &[u8]) -> u32 {
        let step = |crc: u32, byte: &u8| {
            let shift = |crc: u32, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
            (0..8).fold(crc ^ u32::from(*byte), shift)
        };
        !data.iter().fold(!0, step)
    }

    struct Bits {
        out: Vec<u8>,
        next: u8,
    }

    impl Bits {
        fn push(&mut self, bits: &[u8]) {
            for bit in bits {
                if self.next == 0 {
                    self.out.push(0);
                }
                *self.out.last_mut().unwrap() |= bit << self.next;
                self.next = (self.next + 1) % 8;
            }
        }
    }
}
