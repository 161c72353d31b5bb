//! A family as text.

use crate::plan::{FamilyResult, MemberResult};

use super::table::Table;

/// A table of all members, the worst case marked, and the verdict.
pub(super) fn summary(family: &FamilyResult) -> String {
    let mut table = Table::new([
        "member",
        ">duration",
        ">at least",
        ">gap",
        "lawful",
        ">largest peak",
        "held back most by",
    ]);
    for member in &family.members {
        let mark = if family.is_slowest(member) { " *" } else { "" };
        let [duration, bound, gap, lawful, peak, held] = figures(member);
        let name = format!("{}{mark}", member.name);
        table.row([name, duration, bound, gap, lawful, peak, held]);
    }
    format!(
        "{}* slowest; {}\n{} evaluations in {:.3} s\n",
        table.text(),
        family.verdict,
        family.evaluations,
        family.planning_s
    )
}

fn figures(member: &MemberResult) -> [String; 6] {
    if let Some(failure) = &member.failure {
        let empty = String::new;
        let why = format!("{} ({})", failure.message, failure.code);
        return ["failed".to_owned(), empty(), empty(), empty(), empty(), why];
    }
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let seconds = |value: Option<f64>| value.map(|it| format!("{it:.4} s")).unwrap_or_default();
    let lawful = if member.lawful == Some(true) { "yes" } else { "NO" };
    [
        seconds(member.duration),
        seconds(member.lower_bound),
        member.gap.map(percent).unwrap_or_default(),
        lawful.to_owned(),
        member.worst_ratio.map(percent).unwrap_or_default(),
        member.most_binding.as_ref().map(ToString::to_string).unwrap_or_default(),
    ]
}
