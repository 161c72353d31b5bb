//! A long list of bad requests: each has to be refused with the right status
//! and a message that names the fault, and none may panic.

use std::sync::atomic::{AtomicUsize, Ordering};

use reqwest::Method;
use serde_json::{Value, json};

use crate::support::*;

/// What is sent, the status expected and the words that name the fault.
struct Case {
    method: Method,
    path: String,
    content_type: Option<&'static str>,
    body: Option<Vec<u8>>,
    status: u16,
    names: &'static [&'static str],
}

fn case(method: Method, path: &str, body: Option<Vec<u8>>, status: u16) -> Case {
    let content_type = body.as_ref().map(|_| "application/json");
    Case { method, path: path.to_owned(), content_type, body, status, names: &[] }
}

/// A job whose value at `pointer` is replaced, or added where there is none.
fn job_with(pointer: &str, value: Value) -> Value {
    with(quick_job(), pointer, value)
}

fn with(mut document: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(members) => drop(members.insert(key.to_owned(), value)),
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{pointer} has no place"),
    }
    document
}

fn raw(body: &str, names: &'static [&'static str]) -> Case {
    Case { names, ..case(Method::POST, "/v1/jobs", Some(body.into()), 400) }
}

fn invalid(path: &str, body: Value, names: &'static [&'static str]) -> Case {
    Case { names, ..case(Method::POST, path, Some(body.to_string().into()), 422) }
}

fn job(pointer: &str, value: Value, names: &'static [&'static str]) -> Case {
    invalid("/v1/jobs", job_with(pointer, value), names)
}

fn put_robot(pointer: &str, value: Value, names: &'static [&'static str]) -> Case {
    let body = with(robot("mine"), pointer, value);
    Case { method: Method::PUT, ..invalid("/v1/robots/mine", body, names) }
}

fn verify(pointer: &str, value: Value, names: &'static [&'static str]) -> Case {
    let valid = json!({
        "robot": robot("pair"),
        "trajectory": {"breakpoints": [0, 1], "pieces": [[[0, 1], [0]]]},
    });
    invalid("/v1/verify", with(valid, pointer, value), names)
}

fn samples(pointer: &str, value: Value, names: &'static [&'static str]) -> Case {
    let valid = json!({
        "robot": robot("pair"),
        "samples": {"interpolation": "linear", "times": [0, 1], "positions": [[0, 0], [1, 1]]},
    });
    invalid("/v1/verify", with(valid, pointer, value), names)
}

fn query(path: &str, names: &'static [&'static str]) -> Case {
    Case { names, ..case(Method::GET, path, None, 422) }
}

fn unreadable() -> Vec<Case> {
    let number = |text: &str| quick_job().to_string().replace("0.5", text);
    vec![
        raw("", &["not JSON", "EOF"]),
        raw("{", &["not JSON", "line 1"]),
        raw("{\"robot\": }", &["line 1 column 11"]),
        raw("{'robot': 1}", &["not JSON"]),
        raw("{\"robot\": \"ur5e\",}", &["trailing comma"]),
        raw("{} {}", &["trailing characters"]),
        raw("robot: ur5e", &["not JSON"]),
        raw(&number("NaN"), &["not JSON"]),
        raw(&number("Infinity"), &["not JSON"]),
        raw(&number("-Infinity"), &["not JSON"]),
        raw(&number("1e999"), &["out of range"]),
        raw(&number("0x10"), &["not JSON"]),
        raw(&number("01"), &["invalid number"]),
        raw(&"[".repeat(100_000), &["recursion limit"]),
        raw(&"{\"task\":".repeat(10_000), &["recursion limit"]),
        Case { body: Some(vec![b'"', 0xff, 0xfe, b'"']), ..raw("", &["not JSON", "line 1"]) },
    ]
}

fn jobs() -> Vec<Case> {
    let many = Value::from((0..100_000).map(|i| json!([i % 2, 0])).collect::<Vec<_>>());
    let labels: Value = (0..65).map(|i| (format!("k{i}"), json!("v"))).collect();
    vec![
        invalid("/v1/jobs", json!([]), &["expected an object"]),
        invalid("/v1/jobs", json!("job"), &["expected an object"]),
        invalid("/v1/jobs", json!(null), &["expected an object"]),
        invalid("/v1/jobs", json!({}), &["/robot", "missing field `robot`"]),
        invalid("/v1/jobs", json!({"robot": "ur5e"}), &["missing field `task`"]),
        job("/colour", json!("red"), &["/colour", "unknown field `colour`"]),
        job("/task/colour", json!("red"), &["/task/colour", "unknown field `colour`"]),
        job("/task/type", json!("dance"), &["/task/type", "unknown task `dance`", "waypoints"]),
        job("/task/type", json!(3), &["/task/type", "string"]),
        job("/task", json!("waypoints"), &["/task", "expected a task object"]),
        job("/task", json!({"waypoints": []}), &["/task/type", "missing field `type`"]),
        job("/seed", json!(-1), &["/seed", "-1"]),
        job("/seed", json!(1.5), &["/seed", "1.5"]),
        job("/seed", json!("7"), &["/seed", "string"]),
        job("/priority", json!(101), &["/priority", "101", "0 to 100"]),
        job("/priority", json!(-1), &["/priority", "-1", "0 to 100"]),
        job("/priority", json!("high"), &["/priority", "string"]),
        job("/deadline_s", json!(0), &["/deadline_s", "positive"]),
        job("/deadline_s", json!(-5), &["/deadline_s", "-5"]),
        job("/start_by", json!("tomorrow"), &["/start_by"]),
        job("/labels", json!({"": "x"}), &["/labels/", "1 to 64 characters"]),
        job("/labels", json!({"cell": 3}), &["/labels/cell", "string"]),
        job("/labels", labels, &["/labels", "65 labels"]),
        job("/labels", json!({"k": "v".repeat(300)}), &["/labels/k", "at most 256"]),
        job("/robot", json!("hal"), &["/robot", "`hal`"]),
        job("/robot", json!(5), &["/robot", "robot object"]),
        job("/robot", json!({"name": "x"}), &["/robot/joints", "0 joints"]),
        job("/robot/joints", json!([]), &["/robot/joints", "0 joints"]),
        job(
            "/robot/joints/0/limits/velocity",
            json!(0),
            &["/robot/joints/0/limits/velocity", "positive"],
        ),
        job("/robot/joints/0/limits/jerk", json!(-1), &["/robot/joints/0/limits/jerk", "positive"]),
        job("/robot/joints/1/name", json!("turn"), &["/robot/joints/1/name", "taken"]),
        job("/task/waypoints", json!([]), &["/task/waypoints", "0 waypoints"]),
        job("/task/waypoints", json!([[0, 0]]), &["/task/waypoints", "1 waypoint"]),
        job("/task/waypoints", json!(7), &["/task/waypoints", "7"]),
        job("/task/waypoints/1", json!([]), &["/task/waypoints/1", "0 values", "2 joints"]),
        job("/task/waypoints/1", json!([1, 2, 3]), &["/task/waypoints/1", "3 values", "2 joints"]),
        job("/task/waypoints/1", json!([0, 0]), &["/task/waypoints/1", "equal"]),
        job("/task/waypoints/1", json!(["a", 0]), &["/task/waypoints/1/0", "string"]),
        job("/task/waypoints/1", json!([null, 0]), &["/task/waypoints/1/0", "null"]),
        job(
            "/task/waypoints/2",
            json!([4, 0]),
            &["/task/waypoints/2/0", "turn", "upper limit of 3"],
        ),
        job(
            "/task/waypoints/2",
            json!([0, -4]),
            &["/task/waypoints/2/1", "slide", "lower limit of -3"],
        ),
        job("/task/waypoints/2", json!([1e308, 0]), &["/task/waypoints/2/0", "beyond"]),
        job("/task/waypoints", many, &["/task/waypoints", "100000 waypoints"]),
        job(
            "/task/interpolation",
            json!("bezier"),
            &["/task/interpolation", "`bezier`", "quintic"],
        ),
        job("/task/interpolation", json!("3-5-3"), &["/task/interpolation", "4 waypoints"]),
        job("/task/clock", json!("sundial"), &["/task/clock", "`sundial`", "shared"]),
        job(
            "/task/optimizer",
            json!({"name": "magic"}),
            &["/task/optimizer/name", "`magic`", "exact"],
        ),
        job(
            "/task/optimizer",
            json!({"population": 5}),
            &["/task/optimizer/name", "missing field"],
        ),
        job(
            "/task/optimizer",
            json!({"name": "pso", "wings": 2}),
            &["/task/optimizer/wings", "no parameter"],
        ),
        job(
            "/task/optimizer",
            json!({"name": "pso", "population": 0}),
            &["/task/optimizer/population", "0"],
        ),
        job(
            "/task/optimizer",
            json!({"name": "pso", "population": "big"}),
            &["population is a number"],
        ),
        job(
            "/task/optimizer",
            json!({"name": "pso", "iterations": 1e18}),
            &["/task/optimizer/iterations"],
        ),
        job("/task/optimizer", json!({"name": "pso", "iterations": 1.5}), &["whole number"]),
        job("/task/constraint_handling", json!("pray"), &["/task/constraint_handling", "`pray`"]),
        job("/task/constraints", json!("none"), &["/task/constraints", "`none`"]),
        job("/task/durations", json!({"min": 0, "max": 1}), &["/task/durations/min", "0 s"]),
        job("/task/durations", json!({"min": 2, "max": 1}), &["/task/durations", "not below"]),
        job("/task/durations", json!([0.1, 5]), &["/task/durations", "expected an object"]),
        job("/task/durations", json!({"min": 1}), &["/task/durations/max", "missing field"]),
        job("/task/duration", json!({"exactly": -4}), &["/task/duration/exactly", "-4 s"]),
        job("/task/duration", json!({"about": 4}), &["/task/duration", "`about`"]),
        job("/task/duration", json!({"exactly": 4, "at_most": 5}), &["/task/duration"]),
        job("/task/objective", json!({"time": 0}), &["/task/objective", "all weights are 0"]),
        job("/task/objective", json!({"energy": 1}), &["/task/objective/time", "slowest"]),
        job("/task/objective", json!({"time": -1}), &["/task/objective/time", "-1"]),
        job("/task/objective", json!({"comfort": 1}), &["/task/objective/comfort", "unknown"]),
        job("/task/objective", json!("fast"), &["/task/objective", "expected an object"]),
        job("/task/pareto", json!({}), &["/task/pareto/objectives", "missing field"]),
        job(
            "/task/pareto",
            json!({"objectives": ["time"]}),
            &["/task/pareto/objectives", "2 or 3"],
        ),
        job(
            "/task/pareto",
            json!({"objectives": ["time", "torque"]}),
            &["/task/pareto/objectives/1", "`torque`"],
        ),
        job(
            "/task/pareto",
            json!({"objectives": ["time", "energy"], "points": 100_000}),
            &["/task/pareto/points", "2 to 200"],
        ),
        job(
            "/task/pareto",
            json!({"objectives": ["time", "energy"], "method": "guess"}),
            &["/task/pareto/method", "`guess`"],
        ),
        job("/task/fixed_durations", json!([1]), &["/task/fixed_durations", "1 durations"]),
        job("/task/fixed_durations", json!([1, "x"]), &["/task/fixed_durations/1", "string"]),
        job("/task/start", json!({"velocity": [1, 0]}), &["/task/start", "only jerk_limited"]),
        job("/task/goal", json!({"velocity": [1, "x"]}), &["/task/goal/velocity/1", "string"]),
        job("/task/goal", json!({"velocity": [1]}), &["/task/goal/velocity", "1 values"]),
        job("/task/start", json!({"place": [1]}), &["/task/start/place", "unknown field"]),
        job("/task/via_tolerance", json!(0.1), &["/task/via_tolerance", "only jerk_limited"]),
        job("/task/via_tolerance", json!("near"), &["/task/via_tolerance", "a number or a list"]),
        job("/limits", json!({"velocity": 0}), &["/limits/velocity", "positive"]),
        job("/limits", json!({"velocity": -1}), &["/limits/velocity", "-1"]),
        job("/limits", json!({"velocity": [1]}), &["/limits/velocity", "1 values", "2 joints"]),
        job("/limits", json!({"velocity": [1, 0]}), &["/limits/velocity/1", "slide"]),
        job("/limits", json!({"velocity": "fast"}), &["/limits/velocity", "expected a number"]),
        job("/limits", json!({"speed": 1}), &["/limits/speed", "unknown field"]),
        job(
            "/limits",
            json!({"velocity": null, "acceleration": null, "jerk": null}),
            &["/limits", "turn moves"],
        ),
        job("/limit_scale", json!({"velocity": 0}), &["/limit_scale/velocity", "(0, 1]"]),
        job("/limit_scale", json!({"jerk": 1.5}), &["/limit_scale/jerk", "1.5"]),
        job("/limit_scale", json!([0.5]), &["/limit_scale", "expected an object"]),
        job("/limit_scale", json!({"all": 0.5}), &["/limit_scale/all", "unknown field"]),
    ]
}

fn comparisons() -> Vec<Case> {
    let compared = |pointer: &str, value, names| {
        invalid("/v1/jobs", with(comparison_job(), pointer, value), names)
    };
    let measured = |pointer: &str, value, names| {
        invalid("/v1/jobs", with(benchmark_job(), pointer, value), names)
    };
    let mut homeless = comparison_job();
    homeless.as_object_mut().unwrap().remove("robot");
    vec![
        invalid("/v1/jobs", homeless, &["/robot", "names no robot"]),
        compared("/robot", json!("nobody"), &["/robot", "`nobody`"]),
        compared("/task/methods", json!("pso"), &["/task/methods"]),
        compared("/task/methods", json!([]), &["/task/methods", "0 methods"]),
        compared(
            "/task/methods/0",
            json!({"label": "x"}),
            &["/task/methods/0", "optimizer's name"],
        ),
        compared("/task/methods/0", json!("gp"), &["/task/methods/0/name", "known: aga"]),
        compared("/task/methods/0", json!("cfpso"), &["/task/methods/1/label", "another one"]),
        compared("/task/methods/1/population", json!(1e9), &["/task/methods/1/population"]),
        compared("/task/methods/1/max_evaluations", json!(5), &["no other limit"]),
        compared("/task/runs", json!(-1), &["/task/runs"]),
        compared("/task/runs", json!(1001), &["/task/runs", "1001", "1000"]),
        compared("/task/max_evaluations", json!(1e300), &["/task/max_evaluations"]),
        compared("/task/success_tolerance", json!(2), &["/task/success_tolerance", "2"]),
        compared("/task/problems", json!([{"name": "p"}]), &["/task/problems/0/task", "missing"]),
        compared("/task/task/interpolation", json!("trapezoidal"), &["no search to compare"]),
        compared("/task/task/interpolation", json!("jerk_limited"), &["no search to compare"]),
        compared("/task/task/optimizer", json!({"name": "ga"}), &["/task/task/optimizer"]),
        compared("/task/task/waypoints/0/0", json!(1e12), &["/task/task/waypoints/0/0"]),
        measured("/task/functions", json!(["f0"]), &["/task/functions/0", "`f0`"]),
        measured("/task/dimension", json!(0), &["/task/dimension", "outside 1"]),
        measured("/task/optimizers", json!(["exact"]), &["/task/optimizers/0", "scaling law"]),
        measured("/task/iterations", json!(4_000_000_000u32), &["/task/iterations"]),
        measured("/task/shifted", json!("yes"), &["/task/shifted"]),
        measured("/task/runs", json!(null), &["/task/runs"]),
    ]
}

fn programs() -> Vec<Case> {
    let leg = |pointer: &str, value, names| {
        invalid("/v1/jobs", with(program_job(), pointer, value), names)
    };
    let program = json!({"type": "program", "legs": []});
    vec![
        leg("/task/legs", json!([]), &["/task/legs", "0 legs"]),
        leg("/task/legs/1/name", json!("AB"), &["/task/legs/1/name", "`AB`"]),
        leg("/task/legs/1/name", json!(""), &["/task/legs/1/name", "1 to 64"]),
        leg("/task/legs/1/task", program, &["/task/legs/1/task", "a program"]),
        leg(
            "/task/legs/1/task/waypoints/0",
            json!([2, 0.1]),
            &["/task/legs/1/task/waypoints/0/0", "leg AB ends at 1"],
        ),
        leg(
            "/task/legs/0/task/waypoints/1",
            json!([9, 9]),
            &["/task/legs/0/task/waypoints/1/0", "upper limit"],
        ),
    ]
}

fn robots() -> Vec<Case> {
    let limits = "/joints/0/limits/velocity";
    let fk = |body: Value, names| invalid("/v1/robots/ur5e/fk", body, names);
    let ik = |body: Value, names| invalid("/v1/robots/ur5e/ik", body, names);
    vec![
        put_robot("/name", json!("other"), &["/name", "`other`", "`mine`"]),
        put_robot("/name", json!(7), &["/name", "string"]),
        put_robot("/joints", json!([]), &["/joints", "0 joints"]),
        put_robot(
            "/joints",
            json!(vec![json!({"name": "j", "type": "revolute"}); 33]),
            &["/joints", "33 joints"],
        ),
        put_robot("/joints/0/type", json!("screw"), &["/joints/0/type", "`screw`"]),
        put_robot("/joints/0/name", json!(" "), &["/joints/0/name", "empty"]),
        put_robot(limits, json!(0), &["/joints/0/limits/velocity", "positive"]),
        put_robot(limits, json!(-2), &["/joints/0/limits/velocity", "-2"]),
        put_robot(limits, json!("fast"), &["/joints/0/limits/velocity", "string"]),
        put_robot(
            "/joints/0/limits/lower",
            json!(5),
            &["/joints/0/limits/lower", "below its upper"],
        ),
        put_robot(
            "/joints/0/limits/torque",
            json!(5),
            &["/joints/0/limits/torque", "unknown field"],
        ),
        put_robot("/kinematics/rows", json!([]), &["/kinematics/rows", "0 rows"]),
        put_robot("/kinematics/convention", json!("euler"), &["/kinematics/convention", "`euler`"]),
        put_robot(
            "/kinematics/rows/0",
            json!({"sign": 2}),
            &["/kinematics/rows/0/sign", "1 or -1"],
        ),
        put_robot(
            "/kinematics/tool",
            json!({"orientation": [0, 0, 0, 0]}),
            &["/kinematics/tool/orientation", "norm 0"],
        ),
        Case {
            method: Method::PUT,
            ..invalid("/v1/robots/Not%20a%20name", robot("x"), &["/name", "Not a name"])
        },
        Case {
            method: Method::PUT,
            status: 409,
            ..invalid("/v1/robots/ur5e", robot("ur5e"), &["ur5e", "catalogue"])
        },
        fk(json!({"joints": [0, 0]}), &["/joints", "2 values", "6 joints"]),
        fk(json!({"joints": "home"}), &["/joints", "string"]),
        ik(json!({}), &["/pose", "missing field"]),
        ik(json!({"pose": {"position": [0, 0]}}), &["/pose/position"]),
        ik(
            json!({"pose": {"position": [0, 0, 9000]}}),
            &["/pose/position/2", "9000 m", "millimetres"],
        ),
        ik(json!({"pose": {"orientation": [0, 0, 0, 2]}}), &["/pose/orientation", "norm 2"]),
        ik(json!({"pose": {}, "seed": [0]}), &["/seed", "1 values", "6 joints"]),
        ik(json!({"pose": {}, "solutions": "best"}), &["/solutions", "unknown variant"]),
        ik(json!({"pose": {}, "tolerance": {"position": -1}}), &["/tolerance/position", "-1 m"]),
        put_robot("/kinematics/urdf", json!("<robot/>"), &["/kinematics", "exclude"]),
        fk(json!({"angles": [0]}), &["/angles", "unknown field"]),
        Case { status: 404, ..invalid("/v1/robots/hal/fk", json!({"joints": [0]}), &["`hal`"]) },
    ]
}

fn verifications() -> Vec<Case> {
    vec![
        invalid("/v1/verify", json!({}), &["/robot", "missing field"]),
        verify("/robot", json!("hal"), &["/robot", "`hal`"]),
        verify(
            "/trajectory",
            json!({"breakpoints": [0], "pieces": []}),
            &["/trajectory", "at least one piece"],
        ),
        verify("/trajectory/breakpoints", json!([0]), &["/trajectory", "2 breakpoints"]),
        verify("/trajectory/breakpoints", json!([0, 0]), &["/trajectory", "ascend"]),
        verify("/trajectory/breakpoints", json!([1, 2]), &["/trajectory", "start at 0"]),
        verify("/trajectory/pieces", json!([[[0]]]), &["/trajectory", "1 joints, not 2"]),
        verify("/trajectory/pieces", json!([[[0], []]]), &["/trajectory", "0 coefficients"]),
        verify(
            "/trajectory/pieces",
            json!([[vec![0; 17], [0]]]),
            &["/trajectory", "17 coefficients"],
        ),
        verify("/trajectory/speed", json!(1), &["/trajectory/speed", "unknown field"]),
        verify("/limits", json!({"velocity": -1}), &["/limits/velocity", "-1"]),
        verify(
            "/waypoints",
            json!([{"time": 0, "position": [1]}]),
            &["/waypoints/0/position", "1 values"],
        ),
        verify("/samples", json!(null), &[]).but_valid(),
        samples("/samples/interpolation", json!("spline"), &["/samples/interpolation", "`spline`"]),
        samples("/samples/times", json!([0]), &["/samples", "times"]),
        samples("/samples/times", json!([1, 0]), &["/samples", "ascend"]),
        samples("/samples/positions/1", json!([1]), &["/samples/positions/1"]),
        samples("/samples/interpolation", json!("cubic"), &["/samples/velocities", "missing"]),
        samples("/samples/interpolation", json!(null), &["/samples/interpolation"]),
        samples("/samples", json!([]), &["/samples", "expected an object"]),
        samples("/samples", json!({}), &["/samples/interpolation", "`quintic`", "/samples/times"]),
        samples("/samples/times", json!([0, 0]), &["/samples/times/1", "ascend"]),
        samples("/samples/times", json!([0, 1, 2]), &["/samples/positions", "2 rows for 3 times"]),
        samples("/samples/speeds", json!([]), &["/samples/speeds", "unknown field"]),
        samples("/samples/joint_names", json!(["turn", "x"]), &["/samples/joint_names", "`slide`"]),
        samples("/trajectory", json!({"breakpoints": [0, 1], "pieces": [[[0], [0]]]}), &["either"]),
    ]
}

impl Case {
    /// The odd one out: shows that the document the others break is right.
    fn but_valid(self) -> Self {
        Self { status: 200, ..self }
    }
}

fn addresses(job: &str) -> Vec<Case> {
    let get = |path: &str, status, names| Case { names, ..case(Method::GET, path, None, status) };
    let quick = || Some(quick_job().to_string().into_bytes());
    let typed = |content_type| Case {
        content_type,
        names: &["application/json"],
        ..case(Method::POST, "/v1/jobs", quick(), 415)
    };
    let of = |view: &str| format!("{job}{view}");
    let unknown = "/v1/jobs/01890000-0000-7000-8000-000000000000";
    vec![
        typed(None),
        typed(Some("text/plain")),
        typed(Some("application/x-www-form-urlencoded")),
        typed(Some("application/xml; charset=utf-8")),
        Case { names: &["DELETE"], ..case(Method::DELETE, "/v1/jobs", None, 405) },
        Case { names: &["PUT"], ..case(Method::PUT, "/v1/verify", quick(), 405) },
        Case { names: &["GET"], ..case(Method::GET, "/v1/verify", None, 405) },
        Case { names: &["PATCH"], ..case(Method::PATCH, job, None, 405) },
        get("/v1/job", 404, &["/v1/job"]),
        get("/v2/jobs", 404, &["/v2/jobs"]),
        get("/v1/jobs/7", 404, &["`7`"]),
        get("/v1/jobs/not%20an%20id/result", 404, &["`not an id`"]),
        get("/v1/jobs/%ff", 404, &["UTF-8"]),
        get(unknown, 404, &["01890000"]),
        get(&format!("{unknown}/result"), 404, &["01890000"]),
        get(&format!("{unknown}/events"), 404, &["01890000"]),
        Case { names: &["01890000"], ..case(Method::DELETE, unknown, None, 404) },
        Case {
            names: &["01890000"],
            ..case(Method::POST, &format!("{unknown}/cancel"), None, 404)
        },
        get("/v1/robots/hal", 404, &["`hal`"]),
        get("/v1/scenarios/hal", 404, &["`hal`", "wood"]),
        get("/problems/hal", 404, &["`hal`"]),
        query("/v1/jobs?state=done", &["state", "`done`"]),
        query("/v1/jobs?page_size=0", &["page_size", "1 to 500"]),
        query("/v1/jobs?page_size=many", &["page_size", "`many`"]),
        query("/v1/jobs?page_token=x", &["page token", "`x`"]),
        query("/v1/jobs?colour=red", &["colour", "unknown query parameter"]),
        query("/v1/robots?page=2", &["page", "unknown query parameter"]),
        query(&of("/trajectory?format=xml"), &["format", "`xml`", "joint_trajectory"]),
        query(&of("/trajectory?format=samples&rate_hz=0"), &["rate_hz", "above 0"]),
        query(&of("/trajectory?format=samples&rate_hz=-5"), &["rate_hz", "-5"]),
        query(&of("/trajectory?format=samples&rate_hz=1e9"), &["rate_hz", "10000"]),
        query(&of("/trajectory?format=samples&rate_hz=NaN"), &["rate_hz", "NaN"]),
        query(&of("/trajectory?format=samples&rate_hz=fast"), &["rate_hz", "`fast`"]),
        query(&of("/trajectory?format=csv&format=csv"), &["format", "more than once"]),
        query(&of("/trajectory?rate_hz=100"), &["rate_hz", "choose another format"]),
        query(&of("/trajectory?format=polynomial&rate_hz=100"), &["rate_hz", "no rate"]),
        query(&of("/trajectory?rate=5"), &["rate", "known: format, rate_hz, leg"]),
        query(&of("/convergence?format=png"), &["format", "`png`"]),
        query(&of("/plot.svg?quantity=snap"), &["quantity", "`snap`"]),
        query(&of("/pareto.svg?colour=red"), &["colour", "unknown query parameter"]),
        get(&of("/pareto.svg"), 404, &["no front", "`pareto`"]),
        query(&of("/events?after_seq=-1"), &["after_seq", "`-1`"]),
        query(&of("/result?partial=perhaps"), &["partial", "`perhaps`"]),
        get(&of("/certificate?leg=AB"), 404, &["`AB`"]),
    ]
}

fn oversized() -> Vec<Case> {
    let mut body = quick_job().to_string().into_bytes();
    body.resize(5 << 20, b' ');
    let large = |method: Method, path: &str| Case {
        names: &["4194304 bytes"],
        ..case(method, path, Some(body.clone()), 413)
    };
    vec![
        large(Method::POST, "/v1/jobs"),
        large(Method::POST, "/v1/verify"),
        large(Method::PUT, "/v1/robots/mine"),
    ]
}

/// Panics within the crate, whichever thread they happen on.
static PANICS: AtomicUsize = AtomicUsize::new(0);

fn count_panics() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if panic.location().is_some_and(|place| place.file().starts_with("src/")) {
            PANICS.fetch_add(1, Ordering::Relaxed);
        }
        report(panic);
    }));
}

#[tokio::test]
async fn bad_requests_are_refused_by_name() {
    count_panics();
    let server = Server::start().await;
    let job = server.succeeded(&quick_job()).await;
    let cases = [
        unreadable(),
        jobs(),
        programs(),
        comparisons(),
        robots(),
        verifications(),
        addresses(&job),
        oversized(),
    ];
    let cases: Vec<Case> = cases.into_iter().flatten().collect();
    assert!(cases.len() >= 80);
    let mut wrong = Vec::new();
    for case in &cases {
        wrong.extend(try_case(&server, case).await);
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
    assert_eq!(PANICS.load(Ordering::Relaxed), 0);
    // Nothing of it was accepted, and the server is well.
    assert_eq!(server.json("/v1/jobs").await["jobs"].as_array().unwrap().len(), 1);
    assert_eq!(server.get("/readyz").await.status(), 200);
}

/// Sends one and tells what is wrong with the answer.
async fn try_case(server: &Server, case: &Case) -> Option<String> {
    let mut request = server.request(case.method.clone(), &case.path);
    if let Some(content_type) = case.content_type {
        request = request.header("Content-Type", content_type);
    }
    if let Some(body) = &case.body {
        request = request.body(body.clone());
    }
    let body = case.body.as_deref().map(String::from_utf8_lossy).unwrap_or_default();
    let body: String = body.chars().take(200).collect();
    let sent = format!("{} {} {body}", case.method, case.path);
    let response = match request.send().await {
        Ok(response) => response,
        Err(error) => return Some(format!("{sent}\n  no answer: {error:?}")),
    };
    let status = response.status().as_u16();
    let content_type = header(&response, "content-type");
    let text = response.text().await.unwrap();
    // Backslashes of JSON strings would hide quoted words.
    let said = text.replace('\\', "");
    let problem = status == 200 || content_type == "application/problem+json";
    let named = case.names.iter().all(|name| said.contains(name));
    let right = status == case.status && problem && named && !text.contains("\"internal\"");
    (!right).then(|| {
        format!("{sent}\n  expected {} {:?}\n  found {status} {text}", case.status, case.names)
    })
}

#[tokio::test]
async fn all_faults_of_a_request_are_told_together() {
    let server = Server::start().await;
    let mut job = job_with("/task/waypoints/1", json!([9, 9]));
    job["priority"] = json!(101);
    job["task"]["optimizer"] = json!({"name": "pso", "population": 0});
    job["limit_scale"] = json!({"jerk": 2});
    let answer = problem(server.post("/v1/jobs", &job).await, 422, "invalid").await;
    let pointers: Vec<_> =
        answer["errors"].as_array().unwrap().iter().map(|e| &e["pointer"]).collect();
    for expected in [
        "/priority",
        "/task/waypoints/1/0",
        "/task/waypoints/1/1",
        "/task/optimizer/population",
        "/limit_scale/jerk",
    ] {
        assert!(pointers.contains(&&json!(expected)), "{expected} not in {pointers:?}");
    }
    assert!(answer["detail"].as_str().unwrap().ends_with("see `errors`"), "{answer}");
}
