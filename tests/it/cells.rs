//! What may be set in a scenario, on the command line and over REST.

use std::process::{Command, Output};

use serde_json::Value;

use crate::support::{Server, problem};

fn takt(arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_takt")).args(arguments.split(' ')).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn settings_select_what_is_planned() {
    let done = takt("plan mcb-assembly --set part=arc_chamber --set posture=2");
    assert!(done.status.success(), "{}", text(&done.stderr));
    let result: Value = serde_json::from_slice(&done.stdout).unwrap();
    let leg = |index: usize| (&result["legs"][index]["name"], &result["legs"][index]["note"]);
    assert_eq!(result["legs"].as_array().unwrap().len(), 2);
    assert_eq!(leg(0).0, "AB");
    assert_eq!(leg(1).0, "BE");
    let note = "pick, turn about Z on the way, place on the tray; \
                gripper 2 (16-22 mm) holds arc_chamber across 19 mm";
    assert_eq!(leg(1).1, note);
    assert!(text(&done.stderr).contains(note), "people see it too");
}

#[test]
fn settings_select_the_request_that_is_printed() {
    let done = takt("scenarios palletizing --set pack=25 --set layers=1 --set per_layer=1");
    assert!(done.status.success(), "{}", text(&done.stderr));
    let request: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(request["task"]["legs"].as_array().unwrap().len(), 3);
    let told = takt("scenarios mcb-assembly");
    let told = text(&told.stderr);
    for expected in ["--set NAME=VALUE", "part (default arc_chamber)", "upside down"] {
        assert!(told.contains(expected), "{told}");
    }
}

#[test]
fn a_scenario_may_be_a_file() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("cell.json");
    let text = include_str!("../../docs/SCENARIOS.md");
    let example = text.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
    std::fs::write(&path, example).unwrap();
    let plan = |set: &str| takt(&format!("plan {}{set}", path.display()));
    let done = plan(" --set bin=2");
    assert!(done.status.success(), "{}", self::text(&done.stderr));
    let result: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(result["legs"][1]["result"]["waypoints"][2][0], -1.5);
    let refused = plan(" --set bin=3");
    assert_eq!(refused.status.code(), Some(2));
    assert!(self::text(&refused.stderr).contains("bin: `3` is no whole number from 1 to 2"));

    std::fs::write(&path, example.replace("\"bolt\" }", "\"nut\" }")).unwrap();
    let refused = plan("");
    assert_eq!(refused.status.code(), Some(2));
    let told = self::text(&refused.stderr);
    assert!(told.contains("cell.json is no valid scenario"), "{told}");
    assert!(told.contains("/parameters/0/default: `bolt` is unknown; known: nut, plate"), "{told}");

    std::fs::write(&path, r#"{"robot": "ur5e"}"#).unwrap();
    let told = plan(" --set bin=1");
    let expected = "cell.json is a request, not a scenario: `bin` cannot be set";
    assert!(self::text(&told.stderr).contains(expected), "{}", self::text(&told.stderr));
}

#[test]
fn wrong_settings_are_bad_input_in_words() {
    for (arguments, expected) in [
        (
            "plan mcb-assembly --set part=magnetic_assembly --set posture=4",
            "error: mcb-assembly cannot be set up\n  part: no gripper opens to 24 mm, across which \
             magnetic_assembly is held on leg BC: gripper strokes are 11-17, 16-22, 3-9, 0-6 mm\n",
        ),
        (
            "submit mcb-assembly --set position=1",
            "error: mcb-assembly cannot be set up\n  position: no parameter is called `position`; \
             known: part, posture\n",
        ),
        ("scenarios --set part=yoke", "error: name the scenario in which to set `part`\n"),
    ] {
        let refused = takt(arguments);
        assert_eq!(refused.status.code(), Some(2), "{arguments}");
        assert_eq!(text(&refused.stderr), expected);
        assert!(refused.stdout.is_empty());
    }
    let refused = takt("plan wood --set part");
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("expected NAME=VALUE"));
}

#[tokio::test]
async fn settings_select_a_scenarios_request() {
    let server = Server::start().await;
    let scenario = server.json("/v1/scenarios/mcb-assembly").await;
    assert_eq!(scenario["parameters"][1]["name"], "posture");
    assert_eq!(scenario["parameters"][1]["values"]["choices"].as_array().unwrap().len(), 4);
    let address = "/v1/scenarios/mcb-assembly/request";
    assert_eq!(server.json(address).await, scenario["request"], "the defaults");

    let request = server.json(&format!("{address}?part=yoke&posture=1")).await;
    let address_of_job = server.succeeded(&request).await;
    let result = server.json(&format!("{address_of_job}/result")).await;
    let legs = result["legs"].as_array().unwrap();
    assert_eq!(legs.len(), 2);
    for (leg, asked) in legs.iter().zip(request["task"]["legs"].as_array().unwrap()) {
        assert_eq!(leg["name"], asked["name"]);
        assert_eq!(leg["note"], asked["note"], "notes reach whoever carries out the result");
    }
    assert!(
        legs[1]["note"].as_str().unwrap().ends_with("gripper 4 (0-6 mm) holds yoke across 1 mm")
    );

    let refused = server.get(&format!("{address}?part=magnetic_assembly&posture=4")).await;
    let refused = problem(refused, 422, "invalid").await;
    assert_eq!(refused["errors"][0]["parameter"], "part");
    let detail = refused["errors"][0]["detail"].as_str().unwrap();
    assert!(detail.starts_with("no gripper opens to 24 mm"), "{detail}");
    let refused = server.get(&format!("{address}?position=1&posture=5&part=yoke&part=x")).await;
    let refused = problem(refused, 422, "invalid").await;
    let at = |index: usize| &refused["errors"][index]["parameter"];
    assert_eq!([at(0), at(1), at(2)], ["position", "posture", "part"]);
}
