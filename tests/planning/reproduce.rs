//! The report of published experiments: complete, honest about known
//! contradictions, repeatable, and a page that stands alone.

use std::sync::Mutex;

use takt::reproduce::{PAPERS, Paper, Report, Verdict, paper, reproduce};

/// The cells of the first row of a Markdown table that starts with `name`.
fn row<'a>(text: &'a str, name: &str) -> Vec<&'a str> {
    let start = format!("| {name} |");
    let found = text.lines().find(|line| line.starts_with(&start));
    let line = found.unwrap_or_else(|| panic!("no `{name}` in {text}"));
    line.trim_matches('|').split(" | ").map(str::trim).collect()
}

/// The verdict of a finding: the last cell but one.
fn verdict<'a>(text: &'a str, name: &str) -> &'a str {
    let cells = row(text, name);
    assert!(!cells[cells.len() - 1].is_empty(), "no reason for {name}");
    cells[cells.len() - 2]
}

fn report(papers: &[&Paper], runs: u32) -> Report {
    reproduce(papers, runs, &|_| {}).unwrap()
}

#[test]
fn the_report_tells_the_known_contradictions_and_repeats() {
    let papers: Vec<&Paper> = PAPERS.iter().collect();
    let (first, second) = (report(&papers, 2), report(&papers, 2));
    let text = first.markdown();
    assert_eq!(text, second.markdown());
    assert_eq!(first.html(), second.html());

    let heads: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    assert_eq!(heads[..2], ["Summary", "What is possible"]);
    let of = |author: &str| heads.iter().filter(|head| head.starts_with(author)).count();
    let counts =
        ["Chen et al.", "Han et al.", "Shu et al.", "Lin and Yang", "Zhang et al."].map(of);
    assert_eq!(counts, [5, 5, 1, 2, 3], "{heads:?}");
    assert_eq!(heads.last(), Some(&"Papers"));
    contradictions(&text);
    counts_add_up(&first, &text);
    stands_alone(&first.html(), heads.len());
}

fn contradictions(text: &str) {
    let broken = Verdict::BreaksItsLimits.words();
    for (method, ratio) in [("PSO", "1.034"), ("Gold-SA", "1.040"), ("GoldS-PSO", "1.071")] {
        let cells = row(text, &format!("{method} 1"));
        assert_eq!(cells[3], "7.2401", "{cells:?}");
        assert_eq!((cells[5], cells[6]), (ratio, broken), "{cells:?}");
    }
    let (contradicts, lost) =
        (Verdict::PaperContradictsItself.words(), Verdict::CannotBeCompared.words());
    for name in [
        "PSO 2",
        "F5 PSO",
        "F6 PSO, standard deviation",
        "F1 CFPSO, standard deviation",
        "Total of the conclusion, s",
        "GoldS-PSO shorter than PSO, abstract, %",
        "AB, saved, s",
        "All sections, saved, %",
        "big U rod, improved PSO",
        "initial",
        "joint 1",
    ] {
        assert_eq!(verdict(text, name), contradicts, "{name}");
    }
    assert_eq!(row(text, "Total of the conclusion, s")[1..3], ["7.8876", "7.8776"]);
    assert_eq!(row(text, "All sections, saved, %")[1..3], ["16.7", "12.69"]);
    assert_eq!(row(text, "as printed")[1..], ["41.23", "34.33", "6.90", "16.74"]);
    assert_eq!(row(text, "row AB from Table 5")[1..], ["40.34", "35.22", "5.12", "12.69"]);
    assert_eq!(verdict(text, "improved PSO 2, under Table 4"), broken);
    assert_eq!(row(text, "AB, improved PSO, peak speed, rad/s")[1..4], ["1", "1.476", broken]);
    // The peaks at Han's published times: 0.5 rad/s for joints 1 to 5, 1.0 for joint 6.
    let speeds = [("1", "0.500"), ("2", "0.503"), ("3", "0.500"), ("5", "0.499"), ("6", "1.007")];
    for (joint, speed) in speeds {
        assert_eq!(row(text, &format!("improved PSO {joint}"))[4], speed);
    }
    // Rounding explains joint 2's 0.503 rad/s, not joint 6's 1.007.
    assert_eq!(verdict(text, "improved PSO 6"), broken);
    assert_ne!(verdict(text, "improved PSO 2"), broken);
    for name in ["BC, improved PSO, total, s", "AB, dual PSO", "joint 6"] {
        let mut found = text.lines().filter(|line| line.starts_with(&format!("| {name} |")));
        assert!(found.next_back().unwrap().contains(lost), "{name}");
    }
    // The optima of the paper's own curves, all joints at once.
    assert_eq!(row(text, "Chen et al.")[1..3], ["7.8776", "7.4756"]);
    assert_eq!(row(text, "Han et al., AB")[1..3], ["7.8900", "7.0255"]);
}

/// The summary counts what the sections say.
fn counts_add_up(report: &Report, text: &str) {
    let given: Vec<Verdict> = report.sections.iter().flat_map(|it| it.verdicts()).collect();
    for wanted in Verdict::ALL {
        let count = given.iter().filter(|it| **it == wanted).count();
        assert_eq!(row(text, wanted.words())[1], count.to_string(), "{wanted:?}");
        assert!(count > 0, "{wanted:?} is told apart and never given");
    }
    assert!(report.headline[0].starts_with(&format!("{} published figures", given.len())));
    assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
}

/// No resource from elsewhere, and every tag closed where it was opened.
fn stands_alone(page: &str, sections: usize) {
    assert_eq!(page.matches("<section>").count(), sections);
    assert!(page.matches("<svg").count() >= 7);
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "src=", "href=", "url(", "@import", "<script", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let void = ["meta", "br", "!DOCTYPE"];
    let mut open: Vec<&str> = Vec::new();
    for tag in page.split('<').skip(1) {
        let inside = tag.split('>').next().unwrap();
        let name = inside.split([' ', '\n']).next().unwrap();
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if inside.ends_with('/') || void.contains(&name) => {}
            None => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn one_paper_alone_reports_on_itself() {
    let told = Mutex::new(Vec::new());
    let tell = |line: &str| told.lock().unwrap().push(line.to_owned());
    let report = reproduce(&[paper("lin_yang").unwrap()], 1, &tell).unwrap();
    let text = report.markdown();
    assert!(!text.contains("Chen") && !text.contains("Shu"), "{text}");
    // Nothing published can be compared, so nothing is claimed.
    assert_eq!(report.headline.len(), 1);
    assert_eq!(told.into_inner().unwrap()[0], "1 of 1: Lin and Yang, runs of each method: 1");
    assert!(paper("nobody").is_none());
}

/// A substitute map proves no figure, and paths are no motions.
#[test]
fn planners_are_compared_on_substitutes_and_say_so() {
    let text = report(&[paper("zhang").unwrap()], 2).markdown();
    assert!(!text.contains("## What is possible"), "{text}");
    let lost = Verdict::CannotBeCompared.words();
    for map in ["map 1", "map 2"] {
        for (what, published) in [
            ("length against PQ-RRT*, by how much", ["-5.24", "-6.34"]),
            ("iterations against Bi-APF-RRT*", ["-56.46", "-31.25"]),
        ] {
            let name = format!("{map}, {what}");
            assert_eq!(verdict(&text, &name), lost, "{name}");
            let published = published[usize::from(map == "map 2")];
            assert_eq!(row(&text, &name)[1], published, "{name}");
        }
    }
    for planner in ["rrt_star", "informed_rrt_star", "bi_apf_rrt_star", "ipq_rrt_star_connect"] {
        assert!(row(&text, planner)[1].ends_with(" of 2"), "{planner}");
    }
    let straight = ["1059.6", "924.6", "838.6", "1213.7"];
    for (name, straight) in ["P0 to P1", "P1 to P2", "P2 to P3", "P3 to P1"].iter().zip(straight) {
        assert_eq!(row(&text, name)[1], straight, "{name}");
    }
}

/// What a report says was run is what was run: its requests are valid as they stand.
#[test]
fn the_requests_shown_can_be_planned() {
    let text = report(&[paper("han").unwrap(), paper("shu").unwrap()], 1).markdown();
    let requests: Vec<serde_json::Value> = text
        .split("```json\n")
        .skip(1)
        .map(|block| serde_json::from_str(block.split("\n```").next().unwrap()).unwrap())
        .collect();
    assert_eq!(requests.len(), 13);
    for request in requests {
        let parsed = takt::plan::PlanRequest::parse(request).unwrap();
        takt::plan::validate(&parsed, &takt::robot::catalogue::get).unwrap();
    }
}
