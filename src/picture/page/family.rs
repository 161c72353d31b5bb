//! The page of a family: its worst case, at a glance.

use super::{Cell, Html, Table, figure, page, paragraph, section, verdict};
use crate::picture::{self, Section};
use crate::plan::{FamilyResult, MemberResult};
use crate::trajectory::Quantity;

/// A page that shows a family.
pub fn family(result: &FamilyResult) -> String {
    let title = if result.sweep.is_empty() { "One motion, many variants" } else { "What if?" };
    let content = [
        verdict(&format!("{}.", result.verdict)),
        paragraph(&setting(result)),
        section("Durations", figure(&picture::family(result), caption(result))),
        section("Members", members(result)),
        section(&format!("Worst case: {}", result.slowest), worst_case(result)),
        section("How to read this", paragraph(&method(result))),
    ];
    page(title, Html::join(content))
}

fn setting(result: &FamilyResult) -> String {
    let swept: Vec<String> = result
        .sweep
        .iter()
        .map(|axis| {
            let values: Vec<String> = axis.values.iter().map(ToString::to_string).collect();
            format!("`{}` over {}", axis.path, values.join(", "))
        })
        .collect();
    let swept = match &swept[..] {
        [] => String::new(),
        swept => format!(", swept: {}", swept.join("; ")),
    };
    let lawful = match result.lawful {
        true => "Every planned member keeps all known limits",
        false => "NOT EVERY member keeps its limits",
    };
    format!(
        "Robot {}, {} members{swept}. {lawful}; the largest peak is {:.2} % of its limit.",
        result.robot,
        result.members.len(),
        100.0 * result.worst_ratio
    )
}

fn caption(result: &FamilyResult) -> &'static str {
    if result.sweep.is_empty() {
        "All planned members, slowest first. No lawful motion through the member's waypoints is \
         shorter than the dark line."
    } else {
        "Durations over the swept values. No lawful motion through the member's waypoints is \
         shorter than the thin line or mark."
    }
}

fn members(result: &FamilyResult) -> Html {
    let heads = ["duration", "at least", "gap", "largest peak"].map(Cell::number);
    let heads = [Cell::text("member")].into_iter().chain(heads);
    let mut table = Table::new(heads.chain(["lawful", "held back most by"].map(Cell::text)));
    for member in &result.members {
        let name = if result.is_slowest(member) {
            format!("{} (slowest)", member.name)
        } else {
            member.name.clone()
        };
        let name = Cell::text(name).marked(member.name == result.fastest);
        table.row([name].into_iter().chain(figures(member)));
    }
    let note = "A star marks the fastest member.";
    Html::join([table.html(), paragraph(note)])
}

fn figures(member: &MemberResult) -> [Cell; 6] {
    let text = |value: Option<String>| value.unwrap_or_else(|| "\u{2013}".to_owned());
    let seconds = |value: Option<f64>| Cell::number(text(value.map(|it| format!("{it:.4} s"))));
    let percent = |value: Option<f64>| {
        Cell::number(text(value.map(|share| format!("{:.2} %", 100.0 * share))))
    };
    let last = match &member.failure {
        Some(failure) => Cell::text(format!("not planned: {}", failure.message)).prose(),
        None => Cell::text(text(member.most_binding.as_ref().map(ToString::to_string))),
    };
    let lawful = match member.lawful {
        Some(true) => "yes",
        Some(false) => "NO",
        None => "\u{2013}",
    };
    [
        seconds(member.duration),
        seconds(member.lower_bound),
        percent(member.gap),
        percent(member.worst_ratio),
        Cell::text(lawful),
        last,
    ]
}

fn worst_case(result: &FamilyResult) -> Html {
    let section = Section { name: Some(&result.slowest), start: 0.0, result: &result.worst_case };
    let held = "Which limit of which joint holds the slowest member back, and when.";
    let motion = "The slowest member's motion: all joints over time with their limits.";
    Html::join([
        figure(&picture::timeline(&[section]), held),
        figure(&picture::plot(&[section], &Quantity::ALL), motion),
    ])
}

fn method(result: &FamilyResult) -> String {
    format!(
        "Every member was planned as if it had come alone, with seed {} unless it sets its own. \
         \"At least\" is a proven lower bound for any motion, the gap is how far the duration is \
         above it. {} evaluations in {:.3} s, by Takt {}.",
        result.seed, result.evaluations, result.planning_s, result.version
    )
}
