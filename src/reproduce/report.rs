//! A report as data, rendered to Markdown and to a page of HTML.

use super::verdict::Verdict;
use crate::picture::page::{self, Cell, Html};

/// A report under construction.
#[derive(Clone, Debug)]
pub struct Report {
    /// Its title.
    pub title: String,
    /// Its sections in order.
    pub sections: Vec<Section>,
}

/// A part of a report.
#[derive(Clone, Debug)]
pub struct Section {
    heading: String,
    blocks: Vec<Block>,
    verdicts: Vec<Verdict>,
}

#[derive(Clone, Debug)]
enum Block {
    Paragraph(String),
    Table { heads: Vec<String>, rows: Vec<Vec<String>> },
    Figure { svg: String, caption: String },
}

impl Section {
    /// An empty section.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), blocks: Vec::new(), verdicts: Vec::new() }
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Paragraph(text.into()));
    }

    /// Adds a table; the first column heads its rows.
    pub fn table(&mut self, heads: &[&str], rows: Vec<Vec<String>>) {
        let heads = heads.iter().map(|head| (*head).to_owned()).collect();
        self.blocks.push(Block::Table { heads, rows });
    }

    /// Adds a picture; Markdown has its caption alone.
    pub fn figure(&mut self, svg: String, caption: impl Into<String>) {
        self.blocks.push(Block::Figure { svg, caption: caption.into() });
    }

    /// Counts a verdict given in a table and returns its words.
    pub fn judge(&mut self, verdict: Verdict) -> String {
        self.verdicts.push(verdict);
        verdict.words().to_owned()
    }

    /// Adds a verdict on one figure with its reason.
    pub fn finding(&mut self, figure: &str, verdict: Verdict, reason: &str) {
        let words = self.judge(verdict);
        self.paragraph(format!("{figure}: {words}. {reason}"));
    }

    /// The verdicts given in this section.
    pub fn verdicts(&self) -> &[Verdict] {
        &self.verdicts
    }
}

impl Report {
    /// The report as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", self.title);
        for section in &self.sections {
            text.push_str(&format!("\n## {}\n", section.heading));
            section.blocks.iter().for_each(|block| text.push_str(&block.markdown()));
        }
        text
    }

    /// The report as a page that stands alone.
    pub fn html(&self) -> String {
        let section = |section: &Section| {
            page::section(&section.heading, Html::join(section.blocks.iter().map(Block::html)))
        };
        page::page(&self.title, Html::join(self.sections.iter().map(section)))
    }
}

impl Block {
    fn markdown(&self) -> String {
        match self {
            Self::Paragraph(text) => format!("\n{text}\n"),
            Self::Figure { caption, .. } => format!("\n(Picture in report.html: {caption})\n"),
            Self::Table { heads, rows } => {
                let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
                let rule = format!("|{}\n", "---|".repeat(heads.len()));
                let rows: String = rows.iter().map(|row| line(row)).collect();
                format!("\n{}{rule}{rows}", line(heads))
            }
        }
    }

    fn html(&self) -> Html {
        match self {
            Self::Paragraph(text) => page::paragraph(text),
            Self::Figure { svg, caption } => page::figure(svg, caption),
            Self::Table { heads, rows } => {
                let mut table = page::Table::new(heads.iter().map(Cell::text));
                rows.iter().for_each(|row| table.row(row.iter().map(Cell::text)));
                table.html()
            }
        }
    }
}
