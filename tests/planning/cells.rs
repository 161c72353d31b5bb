//! Scenarios and the cells behind them: every setting leads to a valid request
//! or to a fault in words, and arms stand where the papers put them.

use nalgebra::Vector3;
use serde_json::{Value, json};
use takt::budget::Budget;
use takt::fault::Faults;
use takt::geometry::Transform;
use takt::plan::cell::Cell;
use takt::plan::scenarios::{self, Scenario};
use takt::plan::{PlanRequest, PlanResult, ProgramResult, validate};
use takt::robot::catalogue;

use crate::support::timeless;

type Settings = Vec<(String, String)>;

fn settings(pairs: &[(&str, &str)]) -> Settings {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
}

fn get(name: &str) -> &'static Scenario {
    scenarios::get(name).unwrap()
}

/// Every combination of all parameters' values.
fn combinations(scenario: &Scenario) -> Vec<Settings> {
    scenario.parameters.iter().fold(vec![Settings::new()], |found, parameter| {
        let extend = |before: Settings| {
            let with =
                move |value| [before.clone(), vec![(parameter.name.clone(), value)]].concat();
            parameter.all().into_iter().map(with).collect::<Vec<_>>()
        };
        found.into_iter().flat_map(extend).collect()
    })
}

/// Number of settings that lead to a request, and to faults.
fn count(name: &str) -> [usize; 2] {
    let scenario = get(name);
    let mut counts = [0, 0];
    for given in combinations(scenario) {
        let Ok(request) = scenario.select(&given) else {
            counts[1] += 1;
            continue;
        };
        let request = PlanRequest::parse(request).unwrap_or_else(|it| panic!("{given:?}: {it}"));
        let checked = validate(&request, &catalogue::get);
        assert!(checked.is_ok(), "{name} {given:?}: {}", checked.err().unwrap());
        counts[0] += 1;
    }
    counts
}

#[test]
fn every_combination_of_settings_is_valid_or_refused() {
    // Nothing holds the magnetic assembly upside down.
    assert_eq!(count("mcb-assembly"), [19, 1]);
    assert_eq!(count("shu-cycle"), [19, 1]);
    // Five heights by five footprints: (1 + 2 + 3 + 4 + 5)² ways to stack.
    assert_eq!(count("palletizing"), [225, 625 - 225]);
    for scenario in scenarios::all().iter().filter(|scenario| scenario.parameters.is_empty()) {
        assert_eq!(count(&scenario.name), [1, 0], "{}", scenario.name);
    }
}

#[test]
fn every_scenario_tells_its_source_and_its_substitutes() {
    for scenario in scenarios::all() {
        for text in [&scenario.name, &scenario.title, &scenario.description, &scenario.source] {
            assert!(!text.is_empty(), "{}", scenario.name);
        }
        let published =
            ["mcb-ab", "mcb-ab-fastest", "mcb-ab-what-if", "wood"].contains(&&*scenario.name);
        assert_eq!(scenario.source.contains("substitute"), !published, "{}", scenario.name);
        // What is served can be read again as a scenario.
        let served = serde_json::to_value(scenario).unwrap();
        assert_eq!(&Scenario::parse(served).unwrap(), scenario);
    }
}

/// Names of the selected legs, and the gripper of each that holds something.
fn legs(scenario: &str, part: &str, posture: &str) -> Vec<String> {
    let request = get(scenario).select(&settings(&[("part", part), ("posture", posture)])).unwrap();
    let legs = request["task"]["legs"].as_array().unwrap();
    let leg = |leg: &Value| {
        let note = leg["note"].as_str().unwrap();
        let gripper = note.split("; gripper ").nth(1).map(|rest| &rest[..1]);
        format!("{} {}", leg["name"].as_str().unwrap(), gripper.unwrap_or("-"))
    };
    legs.iter().map(leg).collect()
}

#[test]
fn part_and_posture_select_legs_and_grippers() {
    // The example of Shu et al.: grippers 3 and 4 hold the arc chamber.
    assert_eq!(legs("shu-cycle", "arc_chamber", "3"), ["AB -", "BC 3", "CD -", "DE 4"]);
    // Han et al. number the same strokes the other way.
    assert_eq!(legs("mcb-assembly", "arc_chamber", "3"), ["AB -", "BC 1", "CD -", "DE 2"]);
    assert_eq!(legs("mcb-assembly", "arc_chamber", "1"), ["AB -", "BE 2"]);
    assert_eq!(legs("mcb-assembly", "arc_chamber", "2"), ["AB -", "BE 2"]);
    let twice = ["AB -", "BC 3", "CD -", "DC 3", "CD again -", "DE 3"];
    assert_eq!(legs("mcb-assembly", "handle", "4"), twice);
    // Widths of Han et al.: 1 and 1.2 mm take the finest gripper.
    assert_eq!(legs("mcb-assembly", "yoke", "1"), ["AB -", "BE 4"]);
    assert_eq!(legs("shu-cycle", "big_u_rod", "1"), ["AB -", "BE 1"]);
}

#[test]
fn turning_about_z_is_one_turn_of_the_flange() {
    let scenario = get("mcb-assembly");
    let Some(Cell::Assembly(cell)) = &scenario.cell else { panic!("no assembly") };
    let ends = ["BE", "BE_turned"].map(|path| cell.paths[path].last().unwrap());
    let [straight, turned] = ends.map(|end| tool("rokae_xb4", end, HAN));
    assert!((straight.origin - turned.origin).norm() < 1e-12, "at the same place");
    assert!(straight.x.dot(&turned.x).abs() < 1e-12, "a quarter turn");
    assert!((straight.z - turned.z).norm() < 1e-12);
    let reversed: Vec<_> = cell.paths["CD"].iter().rev().cloned().collect();
    assert_eq!(cell.paths["DC"], reversed);
}

/// Layers are filled from below, and every leg starts where the one before ended.
#[test]
fn a_pallet_is_filled_layer_by_layer() {
    let given = settings(&[("pack", "14"), ("layers", "2"), ("per_layer", "2")]);
    let request = get("palletizing").select(&given).unwrap();
    let legs = request["task"]["legs"].as_array().unwrap();
    let names: Vec<&str> = legs.iter().map(|leg| leg["name"].as_str().unwrap()).collect();
    let expected =
        "start,place 1.1,back 1.1,place 1.2,back 1.2,place 2.1,back 2.1,place 2.2,back 2.2";
    assert_eq!(names.join(","), expected);
    assert_eq!(legs[7]["note"], "pack of type 14 to layer 2, place 2: x 620, y -620, top 350 mm");
    let home = &legs[0]["task"]["waypoints"][0];
    assert_eq!(&legs[8]["task"]["waypoints"][2], home, "the arm ends where it began");
}

#[test]
fn faults_of_settings_in_words() {
    let found = |scenario: &str, given: &[(&str, &str)]| {
        get(scenario).select(&settings(given)).unwrap_err().0
    };
    let faults = [
        found("mcb-assembly", &[("part", "magnetic_assembly"), ("posture", "4")]),
        found("mcb-assembly", &[("part", "arc_chmber"), ("position", "4"), ("posture", "5")]),
        found("mcb-assembly", &[("part", "yoke"), ("part", "handle")]),
        found("palletizing", &[("pack", "25"), ("layers", "2"), ("per_layer", "2")]),
        found("palletizing", &[("pack", "26"), ("layers", "0"), ("per_layer", "many")]),
        found("wood", &[("part", "yoke")]),
    ];
    insta::assert_json_snapshot!(faults);
}

/// The example of docs/SCENARIOS.md.
fn example() -> Value {
    let text = include_str!("../../docs/SCENARIOS.md");
    let example = text.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
    serde_json::from_str(example).unwrap()
}

#[test]
fn the_documented_example_plans() {
    let scenario = Scenario::parse(example()).unwrap();
    let request = scenario.select(&settings(&[("part", "plate"), ("bin", "2")])).unwrap();
    let result = plan(request);
    assert!(result.lawful);
    let notes: Vec<_> = result.legs.iter().map(|leg| leg.note.clone().unwrap()).collect();
    assert_eq!(notes, ["empty", "gripper wide (40-60 mm) holds plate across 50 mm"]);
    assert_eq!(result.legs[1].result.waypoints[2], [-1.5, 0.0]);
}

#[test]
fn faults_of_a_scenario_in_words() {
    let faults = |change: &dyn Fn(&mut Value)| -> Faults {
        let mut scenario = example();
        change(&mut scenario);
        Scenario::parse(scenario).unwrap_err()
    };
    let found = [
        faults(&|it| {
            let cell = &mut it["cell"]["assembly"];
            cell["grippers"][0]["stroke_mm"] = json!([10, 0]);
            cell["parts"][0] = json!({ "name": "nut", "grasps_mm": {} });
            cell["legs"][1] = json!({ "name": "place", "path": "to nowhere", "grasp": "along",
                "when": { "bin": ["3"], "size": ["1"] } });
        }),
        faults(&|it| {
            it["parameters"][0]["default"] = json!("screw");
            it["parameters"][1]["values"]["range"]["max"] = json!(4_000_000);
        }),
        faults(&|it| it["parameters"][1]["name"] = json!("part")),
        faults(&|it| it["parameters"] = json!([])),
        faults(&|it| drop(it.as_object_mut().unwrap().remove("cell"))),
        faults(&|it| it["request"] = json!("wood")),
        faults(&|it| it["cell"] = json!({ "assembly": { "legs": 7, "colour": "red" } })),
        faults(&|it| it["cell"] = json!({ "conveyor": {} })),
    ];
    insta::assert_json_snapshot!(found.map(|faults| faults.0));
}

/// Signs by which joints counted as Han et al. do become the kinematics'.
const HAN: [f64; 6] = [1.0, -1.0, -1.0, 1.0, -1.0, 1.0];

/// The robot's own sense.
const OWN: [f64; 6] = [1.0; 6];

/// Pose of the tool; lengths in m.
fn tool(robot: &str, configuration: &[f64], signs: [f64; 6]) -> Transform {
    let robot = catalogue::get(robot).unwrap();
    let kinematics = robot.kinematics().unwrap();
    let counted: Vec<f64> = configuration.iter().zip(signs).map(|(q, sign)| q * sign).collect();
    Transform::from(&kinematics.tool_pose(&counted))
}

/// Checks that the tool points down, and stands `at` mm.
fn assert_stands(configuration: &[f64], at: [f64; 3], tolerance_mm: f64) {
    let tool = tool("fanuc_m10ia", configuration, OWN);
    let apart = (tool.origin * 1e3 - Vector3::from(at)).norm();
    assert!(apart < tolerance_mm, "{apart} mm from {at:?}");
    assert!((tool.z + Vector3::z()).norm() < 1e-4, "{}", tool.z);
    assert!((tool.x - Vector3::x()).norm() < 1e-4, "{}", tool.x);
}

/// Lin and Yang, Table 3, in the robot's own sense of rotation. The substitutes
/// are known to 0.001 deg, which is 0.02 mm per joint at this reach.
#[test]
fn the_palletizing_arm_stands_at_the_published_points() {
    let published = [
        [1143.6, 378.2, 273.7],
        [1022.3, -16.3, -136.8],
        [990.1, -405.2, 897.1],
        [876.2, -782.7, 893.0],
        [790.3, -1029.0, 720.9],
    ];
    let waypoints = get("palletizing-points").request["task"]["waypoints"].clone();
    let waypoints: Vec<Vec<f64>> = serde_json::from_value(waypoints).unwrap();
    assert_eq!(waypoints.len(), published.len());
    for (waypoint, point) in waypoints.iter().zip(published) {
        assert_stands(waypoint, point, 0.03);
    }
    let Some(Cell::Pallet(pallet)) = &get("palletizing").cell else { panic!("no pallet") };
    assert_eq!([&pallet.home, &pallet.pick], [&waypoints[0], &waypoints[1]]);
}

#[test]
fn packs_stand_where_their_places_say() {
    let Some(Cell::Pallet(pallet)) = &get("palletizing").cell else { panic!("no pallet") };
    let mut checked = 0;
    for pack in &pallet.packs {
        let height = pack.size_mm[2];
        for place in &pack.places {
            let [x, y] = place.at_mm;
            assert_stands(&place.above, [x, y, 500.0], 0.005);
            for (layer, configuration) in place.layers.iter().enumerate() {
                let top = pallet.deck_mm + (layer + 1) as f64 * height;
                assert_stands(configuration, [x, y, top], 0.005);
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 225);
}

/// Packs of a layer do not overlap, nor hang over the pallet of 500 x 600 mm.
#[test]
fn packs_fit_beside_each_other() {
    let Some(Cell::Pallet(pallet)) = &get("palletizing").cell else { panic!("no pallet") };
    for pack in &pallet.packs {
        let [length, width, _] = pack.size_mm;
        for (index, place) in pack.places.iter().enumerate() {
            let [x, y] = [place.at_mm[0] - 620.0, place.at_mm[1] + 620.0];
            assert!(x.abs() + length / 2.0 <= 250.0 && y.abs() + width / 2.0 <= 300.0);
            let apart = |other: &takt::plan::cell::Place| {
                let [dx, dy] = [0, 1].map(|i| (other.at_mm[i] - place.at_mm[i]).abs());
                dx >= length || dy >= width
            };
            assert!(pack.places[..index].iter().all(apart), "pack {}", pack.name);
        }
    }
}

/// Shu et al. on the C4 in its own sense of rotation, Han et al. on the XB4 in
/// theirs: nodes from and to resting places are reached with the tool straight
/// down, and joint 4 rests in AB and DE.
#[test]
fn the_assembly_arms_pick_and_place_from_above() {
    for (scenario, robot, signs) in
        [("mcb-assembly", "rokae_xb4", HAN), ("shu-cycle", "epson_c4_a601s", OWN)]
    {
        let Some(Cell::Assembly(cell)) = &get(scenario).cell else { panic!("no assembly") };
        for path in ["AB", "DE", "BE", "BE_turned"] {
            for node in &cell.paths[path] {
                let z = tool(robot, node, signs).z;
                assert!((z + Vector3::z()).norm() < 2e-3, "{scenario} {path}: {z}");
                assert_eq!(node[3], 0.0);
            }
        }
        let counts = ["AB", "BC", "CD", "DE"].map(|path| cell.paths[path].len());
        assert_eq!(counts, [4, 6, 5, 5], "as Shu et al. tell");
    }
    let Some(Cell::Assembly(cell)) = &get("shu-cycle").cell else { panic!("no assembly") };
    for stage in ["AB", "BC", "CD", "DE"] {
        let request = &get(&format!("shu-{}", stage.to_lowercase())).request;
        assert_eq!(request["task"]["waypoints"], json!(cell.paths[stage]));
    }
}

fn plan(request: Value) -> ProgramResult {
    let request = PlanRequest::parse(request).unwrap();
    let prepared = validate(&request, &catalogue::get).unwrap_or_else(|it| panic!("{it}"));
    match prepared.run(&Budget::default(), &|_| {}).unwrap() {
        PlanResult::Program(result) => result,
        _ => panic!("not a program"),
    }
}

/// A leg that starts from the one before is never slower than planned alone,
/// and the program repeats to the byte.
#[test]
fn warm_starts_only_add_to_the_search() {
    let given = settings(&[("pack", "3"), ("layers", "2"), ("per_layer", "3")]);
    let request = get("palletizing").select(&given).unwrap();
    let [first, again] = [request.clone(), request.clone()].map(plan);
    assert_eq!(first.legs.len(), 13);
    for (leg, repeated) in first.legs.iter().zip(&again.legs) {
        assert_eq!(timeless(&leg.result), timeless(&repeated.result));
        let mut alone = request.clone();
        alone["task"] = json!({ "type": "waypoints", "interpolation": "cubic",
            "waypoints": leg.result.waypoints });
        let alone = crate::support::plan(alone);
        assert!(leg.result.duration <= alone.duration, "leg {}", leg.name);
        // The last leg has fewer segments than the one before, the first none before it.
        let warm = !["start", "place 1.1", "back 2.3"].contains(&&*leg.name);
        assert_eq!(leg.result.evaluations > alone.evaluations, warm, "leg {}", leg.name);
    }
}

#[test]
fn notes_are_limited_and_kept() {
    let leg = |note: &str| {
        json!({ "robot": "woodworking_pprr", "task": { "type": "program", "legs": [
            { "name": "AB", "note": note, "task": { "type": "waypoints",
                "waypoints": [[0.5, 0.5, 0, 0], [0.6, 0.5, 0, 0]] } }] } })
    };
    let longest = "ä".repeat(200);
    assert_eq!(plan(leg(&longest)).legs[0].note.as_deref(), Some(longest.as_str()));
    let found = crate::support::faults(leg(&format!("{longest}x")));
    assert_eq!(found.0[0].pointer, "/task/legs/0/note");
    assert_eq!(found.0[0].detail, "201 characters; a note has at most 200");
}
