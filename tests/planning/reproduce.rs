//! The report of published experiments: complete, honest about known
//! contradictions, repeatable, and a page that stands alone.

use takt::reproduce::{PAPERS, Paper, reproduce};

#[test]
fn the_report_tells_the_known_contradictions_and_repeats() {
    let papers: Vec<&Paper> = PAPERS.iter().collect();
    let report = || reproduce(&papers, 2, &|_| {}).unwrap();
    let (first, second) = (report(), report());
    let text = first.markdown();
    assert_eq!(text, second.markdown());
    assert_eq!(first.html(), second.html());

    let heads: Vec<&str> = text.lines().filter(|line| line.starts_with("## ")).collect();
    assert_eq!(heads.len(), 8, "{heads:?}");
    let row = |start: &str| {
        let found = text.lines().find(|line| line.starts_with(start));
        found.unwrap_or_else(|| panic!("no `{start}` in {text}"))
    };
    for method in ["PSO", "Gold-SA", "GoldS-PSO"] {
        let row = row(&format!("| {method} 1 |"));
        assert!(row.contains("breaks its own limits") && row.contains("| 7.2401 |"), "{row}");
    }
    assert!(row("| GoldS-PSO 1 |").contains("| 1.071 |"));
    assert!(row("| PSO 2 |").contains("the paper contradicts itself"));
    assert!(row("Total of the conclusion").contains("7.8776 s, the conclusion 7.8876 s"));
    assert!(row("Table 5 under Table 4").contains("breaks its own limits"));
    assert!(row("Row AB:").contains("the paper contradicts itself"));
    assert!(row("| as printed |").contains("| 6.90 | 16.7"));
    assert!(row("| row AB from Table 5 |").contains("| 40.34 | 35.22 | 5.12 | 12.69 |"));
    assert!(row("Rows BC, CD and DE").contains("cannot be compared"));

    let page = first.html();
    assert!(!page.contains("src=\"http") && !page.contains("<script"));
    assert_eq!(page.matches("<section>").count(), 8);
}
