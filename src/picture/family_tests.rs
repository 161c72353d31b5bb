//! Pictures of families and of what holds a motion back.

use serde_json::json;

use crate::plan::FamilyResult;

use super::tests::{assert_well_formed, result};
use super::{Section, family, page, timeline};

/// A family with these durations on the axis `/limit_scale/jerk`, or named
/// one by one; members without a duration failed.
fn durations(durations: &[Option<f64>], swept: bool) -> FamilyResult {
    let member = |(at, duration): (usize, &Option<f64>)| {
        let failure = json!({ "code": "limits_unreachable", "message": "no <way>", "details": {} });
        json!({ "name": format!("m{at} & n"), "values": if swept { json!([at]) } else { json!([]) },
            "duration": duration, "lower_bound": duration.map(|it| 0.5 * it), "gap": 1.0,
            "lawful": true, "worst_ratio": 1.0, "most_binding": null, "evaluations": 1,
            "failure": if duration.is_none() { failure } else { json!(null) } })
    };
    let slowest = durations.iter().enumerate().filter_map(|(at, it)| Some((at, (*it)?)));
    let slowest = slowest.reduce(|a, b| if b.1 > a.1 { b } else { a }).map_or(0, |it| it.0);
    let values: Vec<usize> = (0..durations.len()).collect();
    let sweep = json!([{ "path": "/limit_scale/jerk", "values": values }]);
    serde_json::from_value(json!({ "robot": "arm & leg", "verdict": "all `planned`",
        "sweep": if swept { sweep } else { json!([]) },
        "members": durations.iter().enumerate().map(member).collect::<Vec<_>>(),
        "fastest": "m0 & n", "slowest": format!("m{slowest} & n"), "median_duration": 1.0,
        "failed": durations.iter().filter(|it| it.is_none()).count(), "lawful": true,
        "worst_ratio": 1.0, "worst_case": result(2, 1.0, 1.0, |_| Some(1.5)), "evaluations": 1,
        "planning_s": 0.0, "seed": 0, "version": "" }))
    .unwrap()
}

#[test]
fn bars_stand_from_slow_to_fast_and_are_named_while_they_can_be_read() {
    let few = family(&durations(&[Some(2.0), Some(3.0), None, Some(1.0)], false));
    assert_well_formed(&few);
    let at = |name: &str| few.find(&format!(">\n{name}\n")).unwrap();
    assert!(at("m1 &amp; n") < at("m0 &amp; n") && at("m0 &amp; n") < at("m3 &amp; n"));
    assert!(!few.contains(">\nm2 &amp; n\n") && few.contains("1 not planned"));
    let rectangles = |svg: &str| svg.matches("<rect").count();
    // The ground and a bar each.
    assert_eq!(rectangles(&few), 1 + 3);
    let many: Vec<_> = (0..200).map(|at| Some(1.0 + f64::from(at))).collect();
    let many = family(&durations(&many, false));
    assert_well_formed(&many);
    assert_eq!(rectangles(&many), 1 + 200);
    assert!(!many.contains(">\nm7 &amp; n\n") && many.contains("slowest m199"));
}

#[test]
fn a_sweep_is_a_line_that_breaks_where_a_member_failed() {
    let whole = family(&durations(&[Some(4.0), Some(3.0), Some(2.0), Some(1.5), Some(1.0)], true));
    let broken = family(&durations(&[Some(4.0), Some(3.0), None, Some(1.5), Some(1.0)], true));
    for (svg, dots, lines) in [(&whole, 5, 2), (&broken, 4, 4)] {
        assert_well_formed(svg);
        assert_eq!(svg.matches("<circle").count(), dots);
        let curves = svg.lines().filter(|line| line.starts_with("<polyline"));
        let curves = curves.filter(|it| ["\"22\"", "\"12\""].iter().any(|w| it.contains(w)));
        // The legend has one of the thin ones.
        assert_eq!(curves.count(), lines + 1);
    }
    assert!(whole.contains("limit scale jerk"));
}

#[test]
fn families_survive_any_values() {
    for value in [0.0, 1e-300, 1.0, 1e300, f64::INFINITY, f64::NAN] {
        for swept in [true, false] {
            let mut result = durations(&[Some(1.0), None, Some(2.0)], swept);
            result.members[0].duration = Some(value);
            result.members[2].lower_bound = Some(value);
            assert_well_formed(&family(&result));
        }
    }
    assert_well_formed(&family(&durations(&[None], false)));
    let html = page::family(&durations(&[Some(1.0), None], false));
    for text in ["arm &amp; leg", "all <code>planned</code>", "no &lt;way&gt;", "(slowest)"] {
        assert!(html.contains(text), "{text}");
    }
}

#[test]
fn a_timeline_has_a_row_per_joint_and_a_bar_per_interval() {
    let quiet = result(3, 1.0, 1.0, |_| Some(1e6));
    let svg = timeline(&[Section { name: None, start: 0.0, result: &quiet }]);
    assert_well_formed(&svg);
    assert_eq!(svg.matches(">\njoint_").count(), 3);
    assert_eq!(svg.matches("<rect").count(), 1, "the ground alone");
    assert!(svg.contains("at least one limit holds 0.0 %"));
    // Peak speed is 15/8 of the way per second, in the middle of both pieces.
    let mut busy = result(1, 1.0, 1.0, |_| Some(1e6));
    busy.certificate.joints[0].velocity.limit = Some(1.875);
    let svg = timeline(&[
        Section { name: Some("there"), start: 0.0, result: &busy },
        Section { name: Some("back"), start: 2.0, result: &busy },
    ]);
    assert_well_formed(&svg);
    assert_eq!(svg.matches("<rect").count(), 1 + 4);
}

#[test]
fn timelines_survive_any_number_of_joints_and_any_size() {
    for dof in [0, 1, 32] {
        for size in [0.0, 1e-300, 1.0, 1e300] {
            for limit in [None, Some(0.0), Some(1e-9), Some(1.0), Some(f64::INFINITY)] {
                let mut result = result(dof, size, 1.0, |_| Some(1.0));
                for joint in &mut result.certificate.joints {
                    (joint.velocity.limit, joint.jerk.limit) = (limit, limit);
                }
                let section = Section { name: None, start: 0.0, result: &result };
                assert_well_formed(&timeline(&[section]));
            }
        }
    }
    assert_well_formed(&timeline(&[]));
}
