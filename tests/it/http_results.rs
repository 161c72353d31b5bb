//! The REST edge: what an ended job produced, in every form.

use serde_json::{Value, json};

use crate::support::*;

#[tokio::test]
async fn metrics_and_certificates_come_per_leg_of_a_program() {
    let server = Server::start().await;
    let single = server.succeeded(&quick_job()).await;
    let program = server.succeeded(&program_job()).await;
    let result = server.json(&format!("{single}/result")).await;
    let cycle = server.json(&format!("{program}/result")).await;
    for view in ["metrics", "certificate"] {
        assert_eq!(server.json(&format!("{single}/{view}")).await, result[view]);
        let all = server.json(&format!("{program}/{view}")).await;
        let legs = all["legs"].as_array().unwrap();
        let names: Vec<_> = legs.iter().map(|leg| leg["leg"].as_str().unwrap()).collect();
        assert_eq!(names, ["AB", "BC"]);
        let leg = server.json(&format!("{program}/{view}?leg=BC")).await;
        assert_eq!(leg, cycle["legs"][1]["result"][view]);
        for (address, leg) in [(&program, "XY"), (&single, "AB")] {
            let refused = server.get(&format!("{address}/{view}?leg={leg}")).await;
            let refused = problem(refused, 404, "not_found").await;
            assert!(refused["detail"].as_str().unwrap().contains(leg), "{refused}");
        }
    }
}

/// The fastest motion of all is served as any other.
#[tokio::test]
async fn the_fastest_motion_is_planned_drawn_and_told() {
    let server = Server::start().await;
    let mut job = quick_job();
    job["task"]["interpolation"] = json!("jerk_limited");
    let address = server.succeeded(&job).await;
    let result = server.json(&format!("{address}/result")).await;
    let quintic = server.succeeded(&quick_job()).await;
    let quintic = server.json(&format!("{quintic}/result")).await;
    let duration = |result: &Value| result["duration"].as_f64().unwrap();
    assert!(duration(&result) < duration(&quintic), "{}", result["duration"]);
    assert_eq!(
        (&result["interpolation"], &result["stop_reason"]),
        (&json!("jerk_limited"), &json!("converged"))
    );
    assert_eq!(result["certificate"]["lawful"], true);
    assert!(duration(&result) >= result["bound"]["lower"].as_f64().unwrap());
    let curve = server.json(&format!("{address}/convergence")).await;
    assert_eq!(curve["convergence"], result["convergence"]);
    for quantity in ["position", "velocity", "acceleration", "jerk"] {
        let plot = server.get(&format!("{address}/plot.svg?quantity={quantity}")).await;
        assert!(plot.text().await.unwrap().trim_end().ends_with("</svg>"), "{quantity}");
    }
    let offered = server.json("/v1/interpolations").await;
    let offered = offered["interpolations"].as_array().unwrap();
    let entry = offered.iter().find(|entry| entry["name"] == "jerk_limited").unwrap();
    assert_eq!((&entry["uses_optimizer"], &entry["max_segments"]), (&json!(false), &json!(1_999)));

    job["task"]["optimizer"] = json!({"name": "pso"});
    let refused = server.post("/v1/jobs", &job).await;
    let refused = problem(refused, 422, "invalid").await;
    assert!(refused["errors"][0]["detail"].as_str().unwrap().contains("leave out"), "{refused}");
}

/// A tolerance at waypoints goes in, what was missed comes out, and anyone can have it judged.
#[tokio::test]
async fn a_tolerance_at_waypoints_is_kept_and_judged() {
    let server = Server::start().await;
    let scenario = server.json("/v1/scenarios/mcb-ab-fastest/request").await;
    let mut job = scenario.clone();
    job["task"]["via_tolerance"] = json!(0.05);
    let address = server.succeeded(&job).await;
    let result = server.json(&format!("{address}/result")).await;
    let certificate = &result["certificate"];
    assert_eq!(certificate["lawful"], true, "{certificate}");
    assert_eq!(certificate["via_tolerance"], json!([0.05, 0.05, 0.05, 0.05, 0.05, 0.05]));
    let missed = certificate["waypoint_error"].as_f64().unwrap();
    assert!((0.04..=0.05).contains(&missed), "{missed}");
    let times = result["waypoint_times"].as_array().unwrap().iter();
    let due: Vec<Value> = times
        .zip(result["waypoints"].as_array().unwrap())
        .map(|(time, position)| json!({"time": time, "position": position}))
        .collect();
    for (tolerance, lawful) in [(json!(0.05), true), (json!([0, 0, 0, 0, 0, 0]), false)] {
        let request = json!({"robot": scenario["robot"], "limits": scenario["limits"],
            "trajectory": result["trajectory"], "waypoints": due, "via_tolerance": tolerance});
        let answer = server.post("/v1/verify", &request).await;
        let certificate: Value = answer.json().await.unwrap();
        assert_eq!(certificate["lawful"], lawful, "{certificate}");
    }
}

/// A robot that moves is planned from its motion, and its result says so.
#[tokio::test]
async fn a_motion_goes_on_from_where_the_robot_is() {
    let server = Server::start().await;
    let mut job = quick_job();
    job["task"]["interpolation"] = json!("jerk_limited");
    let joints = job["task"]["waypoints"][0].as_array().unwrap().len();
    let mut velocity = vec![0.0; joints];
    velocity[0] = 0.1;
    job["task"]["start"] = json!({"velocity": velocity});
    let address = server.succeeded(&job).await;
    let result = server.json(&format!("{address}/result")).await;
    assert_eq!(result["certificate"]["lawful"], true);
    assert_eq!(result["certificate"]["starts_at_rest"], false);
    let slope = result["trajectory"]["pieces"][0][0][1].as_f64().unwrap();
    assert!((slope - 0.1).abs() <= 1e-9, "{slope}");
}

#[tokio::test]
async fn trajectories_come_as_polynomials_samples_csv_and_ros_messages() {
    let server = Server::start().await;
    let job = server.succeeded(&quick_job()).await;
    let result = server.json(&format!("{job}/result")).await;
    let duration = result["duration"].as_f64().unwrap();
    let polynomial = server.json(&format!("{job}/trajectory")).await;
    assert_eq!(polynomial["joint_names"], json!(["turn", "slide"]));
    assert_eq!(polynomial["joint_units"], json!(["rad", "m"]));
    assert_eq!(polynomial["breakpoints"], result["trajectory"]["breakpoints"]);
    assert_eq!(polynomial["pieces"], result["trajectory"]["pieces"]);

    let samples = server.json(&format!("{job}/trajectory?format=samples")).await;
    assert_eq!(samples["rate_hz"], 250.0);
    let times = samples["time"].as_array().unwrap();
    assert_eq!(times.len(), (duration * 250.0).ceil() as usize + 1);
    assert_eq!(times.last().unwrap().as_f64(), Some(duration));
    assert_eq!(samples["position"][0], json!([0.0, 0.0]));

    let csv = server.get(&format!("{job}/trajectory?format=csv&rate_hz=10")).await;
    assert!(header(&csv, "content-type").starts_with("text/csv"));
    assert!(header(&csv, "content-disposition").starts_with("attachment; filename=\"takt-"));
    let csv = csv.text().await.unwrap();
    assert_eq!(csv.lines().count(), (duration * 10.0).ceil() as usize + 2);
    assert!(csv.starts_with("t [s],turn position [rad],slide position [m]"), "{csv}");

    let ros = server.json(&format!("{job}/trajectory?format=joint_trajectory&rate_hz=10")).await;
    assert_eq!(ros["joint_names"], json!(["turn", "slide"]));
    let points = ros["points"].as_array().unwrap();
    assert_eq!(points.len(), (duration * 10.0).ceil() as usize + 1);
    assert!(points[1]["time_from_start"]["nanosec"].is_u64(), "{}", points[1]);
}

#[tokio::test]
async fn samples_run_through_all_legs_unless_one_is_named() {
    let server = Server::start().await;
    let job = server.succeeded(&program_job()).await;
    let result = server.json(&format!("{job}/result")).await;
    let cycle = result["duration"].as_f64().unwrap();
    let legs = server.json(&format!("{job}/trajectory")).await;
    assert_eq!(legs["legs"][0]["leg"], "AB");
    assert_eq!(legs["legs"][1]["start"], result["legs"][1]["start"]);
    assert_eq!(legs["legs"][1]["pieces"], result["legs"][1]["result"]["trajectory"]["pieces"]);
    let end = |samples: &Value| samples["time"].as_array().unwrap().last().unwrap().as_f64();
    let all = server.json(&format!("{job}/trajectory?format=samples")).await;
    assert!((end(&all).unwrap() - cycle).abs() < 1e-12);
    let one = server.json(&format!("{job}/trajectory?format=samples&leg=BC")).await;
    assert_eq!(end(&one), result["legs"][1]["result"]["duration"].as_f64());
}

#[tokio::test]
async fn convergence_and_motion_are_drawn() {
    let server = Server::start().await;
    let mut job = program_job();
    let optimizer = json!({"name": "pso", "iterations": 20});
    job["task"]["legs"][0]["task"]["optimizer"] = optimizer;
    let job = server.succeeded(&job).await;
    let curves = server.json(&format!("{job}/convergence")).await;
    let points = curves["legs"][0]["convergence"].as_array().unwrap();
    assert!(points.len() >= 2);
    let csv = server.get(&format!("{job}/convergence?format=csv")).await.text().await.unwrap();
    assert!(csv.starts_with("leg,iteration,evaluations,elapsed_s,best,mean\r\n\"AB\",0,"), "{csv}");
    let one = server.json(&format!("{job}/convergence?leg=AB")).await;
    assert_eq!(one["convergence"], curves["legs"][0]["convergence"]);
    for path in [
        "convergence?format=svg",
        "plot.svg",
        "plot.svg?quantity=position,velocity",
        "plot.svg?quantity=jerk&leg=BC",
    ] {
        let picture = server.get(&format!("{job}/{path}")).await;
        assert_eq!(header(&picture, "content-type"), "image/svg+xml", "{path}");
        let picture = picture.text().await.unwrap();
        assert!(picture.trim_end().ends_with("</svg>"), "{path}");
    }
}

#[tokio::test]
async fn a_front_comes_with_the_result_and_is_drawn() {
    let server = Server::start().await;
    let mut request = quick_job();
    request["task"]["objective"] = json!({"time": 1, "energy": 0.2});
    request["task"]["pareto"] = json!({"objectives": ["time", "energy"], "points": 4});
    let job = server.succeeded(&request).await;
    let result = server.json(&format!("{job}/result")).await;
    let front = &result["pareto"];
    assert_eq!(front["objectives"][1], json!({"name": "energy", "unit": "(rad, m)²/s⁴"}));
    assert_eq!(front["points"].as_array().unwrap().len(), 4);
    let metrics = server.json(&format!("{job}/metrics")).await;
    assert_eq!(metrics["reference"]["time"], front["points"][0]["values"][0]);
    assert!(metrics["objective"]["energy"].as_f64() < metrics["reference"]["energy"].as_f64());
    let picture = server.get(&format!("{job}/pareto.svg")).await;
    assert_eq!(header(&picture, "content-type"), "image/svg+xml");
    assert!(picture.text().await.unwrap().contains("4 motions"));

    let plain = server.succeeded(&quick_job()).await;
    let refused = problem(server.get(&format!("{plain}/pareto.svg")).await, 404, "not_found").await;
    assert!(refused["detail"].as_str().unwrap().contains("`pareto`"), "{refused}");
}

#[tokio::test]
async fn what_is_left_of_a_cancelled_plan_is_served_on_demand() {
    let server = Server::start().await;
    let job = server.submit(&endless_job()).await;
    server.runs(&job).await;
    let cancel = server.request(reqwest::Method::POST, &format!("{job}/cancel"));
    assert_eq!(cancel.send().await.unwrap().status(), 200);
    server.ended(&job).await;
    problem(server.get(&format!("{job}/result")).await, 409, "no_result").await;
    let partial = server.get(&format!("{job}/result?partial=true")).await;
    // Whether there is anything depends on how far the search had come.
    assert!([200, 409].contains(&partial.status().as_u16()));
}

#[tokio::test]
async fn a_delivered_trajectory_is_certified_again_and_a_hasty_one_is_not() {
    let server = Server::start().await;
    let job = server.succeeded(&quick_job()).await;
    let result = server.json(&format!("{job}/result")).await;
    let verify = |trajectory: Value| {
        let request = json!({"robot": robot("pair"), "trajectory": trajectory});
        let server = &server;
        async move { server.post("/v1/verify", &request).await }
    };
    let response = verify(result["trajectory"].clone()).await;
    assert_eq!(response.status(), 200);
    let certificate: Value = response.json().await.unwrap();
    assert_eq!(certificate["lawful"], true);
    assert_eq!(certificate["sha256"], result["certificate"]["sha256"]);

    // One radian in half a second, at 2 rad/s where 1 is allowed.
    let hasty = json!({"breakpoints": [0, 0.5], "pieces": [[[0, 2], [0]]]});
    let certificate: Value = verify(hasty).await.json().await.unwrap();
    assert_eq!(certificate["lawful"], false);
    let violation = &certificate["violations"][0];
    assert_eq!((&violation["joint"], &violation["limit"]), (&json!("turn"), &json!("velocity")));
    assert_eq!((&violation["value"], &violation["limit_value"]), (&json!(2.0), &json!(1.0)));
}

/// An export is certified as it came, the interpolation added.
#[tokio::test]
async fn an_export_is_certified_as_it_will_be_driven() {
    let server = Server::start().await;
    let job = server.succeeded(&quick_job()).await;
    let planned = server.json(&format!("{job}/certificate")).await;
    for format in ["samples", "joint_trajectory"] {
        let mut samples = server.json(&format!("{job}/trajectory?format={format}")).await;
        for (interpolation, continuity) in [("linear", 0), ("cubic", 1), ("quintic", 2)] {
            samples["interpolation"] = json!(interpolation);
            let request = json!({"robot": robot("pair"), "samples": samples});
            let response = server.post("/v1/verify", &request).await;
            assert_eq!(response.status(), 200, "{format} {interpolation}");
            let driven: Value = response.json().await.unwrap();
            assert_eq!(driven["continuity"], continuity, "{format} {interpolation}");
            let peak = |certificate: &Value| certificate["joints"][0]["jerk"]["peak"].as_f64();
            if interpolation == "quintic" {
                let ratio = peak(&driven).unwrap() / peak(&planned).unwrap();
                assert!((ratio - 1.0).abs() < 1e-3, "{format}: {ratio}");
            } else {
                assert_eq!((&driven["lawful"], peak(&driven)), (&json!(false), None));
            }
        }
    }
}
