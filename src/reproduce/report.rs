//! A report as data, rendered to Markdown and to a page of HTML.

use serde_json::Value;

use super::verdict::Verdict;
use crate::picture::page::{self, Cell, Html};

/// A report under construction.
#[derive(Clone, Debug)]
pub struct Report {
    /// Its title.
    pub title: String,
    /// What stands out of it, in a few sentences.
    pub headline: Vec<String>,
    /// Its sections in order.
    pub sections: Vec<Section>,
}

/// A part of a report.
#[derive(Clone, Debug)]
pub struct Section {
    heading: String,
    /// What came of it, in a sentence.
    lesson: Option<String>,
    blocks: Vec<Block>,
}

/// Published figures beside ours, each with a verdict and the reason for it.
#[derive(Clone, Debug)]
pub struct Findings {
    heads: Vec<String>,
    rows: Vec<Finding>,
    /// What stands for the table as long as a reader has not opened it.
    folded: Option<String>,
}

/// One published figure and what became of it.
#[derive(Clone, Debug)]
struct Finding {
    cells: Vec<String>,
    verdict: Verdict,
    reason: String,
}

#[derive(Clone, Debug)]
enum Block {
    Paragraph(String),
    Table { heads: Vec<String>, rows: Vec<Vec<Cell>>, stacking: bool },
    Findings(Findings),
    Figure { svg: String, caption: String },
    Requests { title: String, requests: Vec<Value> },
}

impl Findings {
    /// An empty table; `heads` are its columns before the verdict, the first of
    /// which names the figure.
    pub fn new(heads: &[&str]) -> Self {
        let heads = heads.iter().map(|head| (*head).to_owned()).collect();
        Self { heads, rows: Vec::new(), folded: None }
    }

    /// The same, shown on request only, under this title.
    #[must_use]
    pub fn folded(self, title: &str) -> Self {
        Self { folded: Some(title.to_owned()), ..self }
    }

    /// The verdicts, in order.
    pub fn verdicts(&self) -> impl Iterator<Item = Verdict> + '_ {
        self.rows.iter().map(|finding| finding.verdict)
    }

    /// Adds a figure: its cells, what became of it and why.
    pub fn add(&mut self, cells: Vec<String>, verdict: Verdict, reason: impl Into<String>) {
        self.rows.push(Finding { cells, verdict, reason: reason.into() });
    }
}

impl Section {
    /// An empty section.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), lesson: None, blocks: Vec::new() }
    }

    /// Says in a sentence what came of it; the summary repeats it.
    pub fn learn(&mut self, lesson: impl Into<String>) {
        self.lesson = Some(lesson.into());
    }

    /// Heading and lesson, where there is one.
    pub fn lesson(&self) -> Option<(&str, &str)> {
        Some((&self.heading, self.lesson.as_deref()?))
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Paragraph(text.into()));
    }

    /// Adds a table to be read across and down; the first column heads its rows.
    pub fn matrix(&mut self, heads: &[&str], rows: Vec<Vec<Cell>>) {
        self.add_table(heads, rows, false);
    }

    /// Adds a table to be read row by row; narrow screens show each row as a list.
    pub fn rows(&mut self, heads: &[&str], rows: Vec<Vec<Cell>>) {
        self.add_table(heads, rows, true);
    }

    fn add_table(&mut self, heads: &[&str], rows: Vec<Vec<Cell>>, stacking: bool) {
        let heads = heads.iter().map(|head| (*head).to_owned()).collect();
        self.blocks.push(Block::Table { heads, rows, stacking });
    }

    /// Adds figures with their verdicts.
    pub fn findings(&mut self, findings: Findings) {
        self.blocks.push(Block::Findings(findings));
    }

    /// Adds a picture; Markdown has its caption alone.
    pub fn figure(&mut self, svg: String, caption: impl Into<String>) {
        self.blocks.push(Block::Figure { svg, caption: caption.into() });
    }

    /// Adds requests with which a reader gets the same figures.
    pub fn requests(&mut self, title: impl Into<String>, requests: Vec<Value>) {
        self.blocks.push(Block::Requests { title: title.into(), requests });
    }

    /// Adds one such request.
    pub fn request(&mut self, title: impl Into<String>, request: Value) {
        self.requests(title, vec![request]);
    }

    /// The verdicts given in this section.
    pub fn verdicts(&self) -> impl Iterator<Item = Verdict> + '_ {
        let findings = self.blocks.iter().filter_map(|block| match block {
            Block::Findings(findings) => Some(findings),
            _ => None,
        });
        findings.flat_map(Findings::verdicts)
    }
}

impl Report {
    /// The report as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", self.title);
        self.headline.iter().for_each(|line| text.push_str(&format!("\n**{line}**\n")));
        for section in &self.sections {
            text.push_str(&format!("\n## {}\n", section.heading));
            section.lesson.iter().for_each(|line| text.push_str(&format!("\n**{line}**\n")));
            section.blocks.iter().for_each(|block| text.push_str(&block.markdown()));
        }
        text
    }

    /// The report as a page that stands alone.
    pub fn html(&self) -> String {
        let section = |section: &Section| {
            let lesson = section.lesson.iter().map(|lesson| page::verdict(lesson));
            let blocks = section.blocks.iter().map(Block::html);
            page::section(&section.heading, Html::join(lesson.chain(blocks)))
        };
        let headline = self.headline.iter().map(|line| page::verdict(line));
        page::page(&self.title, Html::join(headline.chain(self.sections.iter().map(section))))
    }
}

/// A table in Markdown.
fn markdown_table<'a>(heads: &[&str], rows: impl Iterator<Item = Vec<&'a str>>) -> String {
    let line = |cells: &[&str]| format!("| {} |\n", cells.join(" | ").replace('\n', " "));
    let rows: String = rows.map(|row| line(&row)).collect();
    format!("\n{}|{}\n{rows}", line(heads), "---|".repeat(heads.len()))
}

impl Block {
    fn markdown(&self) -> String {
        match self {
            Self::Paragraph(text) => format!("\n{text}\n"),
            Self::Figure { caption, .. } => format!("\n(Picture in report.html: {caption})\n"),
            Self::Requests { title, requests } => {
                let block = |request: &Value| format!("\n```json\n{request}\n```\n");
                let blocks: String = requests.iter().map(block).collect();
                format!("\n{title}:\n{blocks}")
            }
            Self::Table { heads, rows, .. } => {
                let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
                markdown_table(&heads, rows.iter().map(|row| row.iter().map(Cell::shown).collect()))
            }
            Self::Findings(findings) => findings.markdown(),
        }
    }

    fn html(&self) -> Html {
        match self {
            Self::Paragraph(text) => page::paragraph(text),
            Self::Figure { svg, caption } => page::figure(svg, caption),
            Self::Requests { title, requests } => {
                let code = requests.iter().map(|request| page::code(&request.to_string()));
                page::details(title, Html::join(code))
            }
            Self::Table { heads, rows, stacking } => {
                // A column's head stands as its cells do.
                let first = rows.first().map_or(&[][..], Vec::as_slice);
                let head = |(at, head): (usize, &String)| match first.get(at) {
                    Some(cell) if cell.is_number() => Cell::number(head),
                    _ => Cell::text(head),
                };
                let mut table = page::Table::new(heads.iter().enumerate().map(head));
                rows.iter().for_each(|row| table.row(row.iter().cloned()));
                if *stacking { table.stacking().html() } else { table.html() }
            }
            Self::Findings(findings) => findings.html(),
        }
    }
}

impl Findings {
    fn heads(&self) -> impl Iterator<Item = &str> {
        self.heads.iter().map(String::as_str).chain(["verdict", "why"])
    }

    fn markdown(&self) -> String {
        let heads: Vec<&str> = self.heads().collect();
        let row = |finding: &'_ Finding| -> Vec<String> {
            let judged = [finding.verdict.words().to_owned(), finding.reason.clone()];
            finding.cells.iter().cloned().chain(judged).collect()
        };
        let rows: Vec<Vec<String>> = self.rows.iter().map(row).collect();
        let rows = rows.iter().map(|row| row.iter().map(String::as_str).collect());
        markdown_table(&heads, rows)
    }

    fn html(&self) -> Html {
        let figures = 1..self.heads.len();
        let head = |(at, head)| match figures.contains(&at) {
            true => Cell::number(head),
            false => Cell::text(head),
        };
        let mut table = page::Table::new(self.heads().enumerate().map(head));
        for finding in &self.rows {
            let figures = finding.cells.iter().skip(1).map(Cell::number);
            let name = finding.cells.iter().take(1).map(Cell::text);
            let verdict = Cell::text(finding.verdict.words());
            let verdict = match finding.verdict.heat() {
                Some(heat) => verdict.heat(heat),
                None => verdict,
            };
            let judged = [verdict, Cell::text(&finding.reason).prose()];
            table.row(name.chain(figures).chain(judged));
        }
        let html = table.stacking().html();
        match &self.folded {
            Some(title) => page::details(title, html),
            None => html,
        }
    }
}
