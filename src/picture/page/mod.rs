//! Pages that stand alone: HTML with everything inside, for screen and paper,
//! light and dark.
//!
//! [`page`], [`section`], [`figure`] and [`Table`] make any report; what a page
//! is about stands in a file of its own. Whatever text goes in is escaped here,
//! so nothing a user named can become markup.

mod comparison;
mod family;

pub use comparison::comparison;
pub use family::family;

use super::canvas::escaped;
use crate::plan::PlanResult;

const STYLE: &str = include_str!("style.css");

/// The page of a result, if its kind has one.
pub fn of(result: &PlanResult) -> Option<String> {
    match result {
        PlanResult::Family(result) => Some(family(result)),
        PlanResult::Comparison(result) => Some(comparison(result)),
        PlanResult::Trajectory(_) | PlanResult::Program(_) | PlanResult::Path(_) => None,
    }
}

/// A finished piece of markup.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Html(String);

impl Html {
    /// The pieces one after the other.
    pub fn join(parts: impl IntoIterator<Item = Html>) -> Self {
        Self(parts.into_iter().map(|part| part.0).collect())
    }
}

/// Text within a page; `<` and the like are shown, not obeyed.
pub fn escape(text: &str) -> String {
    escaped(text).replace('\'', "&#39;")
}

/// Text of ours, in which what stands between backticks is set as code.
fn prose(text: &str) -> String {
    let text = escape(text);
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        // One backtick has no partner: none means code.
        return text;
    }
    let part = |(at, part): (usize, &&str)| match at % 2 {
        0 => (*part).to_owned(),
        _ => format!("<code>{part}</code>"),
    };
    parts.iter().enumerate().map(part).collect()
}

/// A paragraph of text.
pub fn paragraph(text: &str) -> Html {
    Html(format!("<p>{}</p>\n", prose(text)))
}

/// A paragraph that stands out: what a reader in a hurry should take along.
pub fn verdict(text: &str) -> Html {
    Html(format!("<p class=\"verdict\">{}</p>\n", prose(text)))
}

/// A part of a page with a heading.
pub fn section(heading: &str, content: Html) -> Html {
    Html(format!("<section>\n<h2>{}</h2>\n{}</section>\n", escape(heading), content.0))
}

/// A picture, as one of this module's functions draws it, with its caption.
pub fn figure(svg: &str, caption: &str) -> Html {
    // The markup of our own pictures may have an XML head, which HTML has not.
    let svg = svg.find("<svg").map_or("", |start| &svg[start..]);
    Html(format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", prose(caption)))
}

/// What is shown once a reader opens it.
pub fn details(title: &str, content: Html) -> Html {
    Html(format!("<details>\n<summary>{}</summary>\n{}</details>\n", prose(title), content.0))
}

/// Text as a machine reads it, to be copied.
pub fn code(text: &str) -> Html {
    Html(format!("<pre><code>{}</code></pre>\n", escape(text)))
}

/// A whole page.
pub fn page(title: &str, content: Html) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n{}</main>\n</body>\n</html>\n",
        content.0
    )
}

/// A cell of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    text: String,
    heat: Option<f64>,
    marked: bool,
    number: bool,
    prose: bool,
}

impl Cell {
    /// Text, set to the left.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// A number, set to the right.
    pub fn number(text: impl Into<String>) -> Self {
        Self { text: text.into(), number: true, ..Self::default() }
    }

    /// The same, broken into lines: for sentences.
    #[must_use]
    pub fn prose(self) -> Self {
        Self { prose: true, ..self }
    }

    /// True if it is set to the right.
    pub fn is_number(&self) -> bool {
        self.number
    }

    /// The text it shows.
    pub fn shown(&self) -> &str {
        &self.text
    }

    /// The same on a ground between good (0) and bad (1).
    #[must_use]
    pub fn heat(self, heat: f64) -> Self {
        Self { heat: Some(heat.clamp(0.0, 1.0)), ..self }
    }

    /// The same, marked as the best of its kind if `marked`.
    #[must_use]
    pub fn marked(self, marked: bool) -> Self {
        Self { marked, ..self }
    }

    /// Markup of the cell; `head` names its column where rows may be shown as lists.
    fn html(&self, tag: &str, head: Option<&str>) -> String {
        let mut classes = Vec::new();
        classes.extend(self.prose.then_some("prose"));
        classes.extend(self.number.then_some("number"));
        classes.extend(self.marked.then_some("best"));
        let class = match classes.join(" ") {
            none if none.is_empty() => String::new(),
            classes => format!(" class=\"{classes}\""),
        };
        // From green to red; the page's style chooses how bright.
        let hue = |heat: f64| format!(" style=\"--hue:{:.0}\" data-heat", 140.0 * (1.0 - heat));
        let heat = self.heat.map(hue).unwrap_or_default();
        let mark = if self.marked { " \u{2605}" } else { "" };
        let head = head.map(|head| format!(" data-head=\"{}\"", escape(head))).unwrap_or_default();
        let text = if self.prose { prose(&self.text) } else { escape(&self.text) };
        format!("<{tag}{class}{heat}{head}>{text}{mark}</{tag}>")
    }
}

/// A table under construction.
#[derive(Clone, Debug, Default)]
pub struct Table {
    heads: Vec<Cell>,
    rows: Vec<Vec<Cell>>,
    stacking: bool,
}

impl Table {
    /// A table with these column heads.
    pub fn new(heads: impl IntoIterator<Item = Cell>) -> Self {
        Self { heads: heads.into_iter().collect(), ..Self::default() }
    }

    /// Adds a row; its first cell heads it.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The same, each row shown as a list on narrow screens.
    #[must_use]
    pub fn stacking(self) -> Self {
        Self { stacking: true, ..self }
    }

    /// The finished table; wide ones scroll within the page.
    pub fn html(&self) -> Html {
        let head = |at: usize| {
            let named = self.stacking && at > 0;
            self.heads.get(at).filter(|_| named).map(Cell::shown)
        };
        let cells = |cells: &[Cell], rest: &str| -> String {
            let tag = |at| if at == 0 { "th" } else { rest };
            let head = |at| head(at).filter(|_| rest == "td");
            cells.iter().enumerate().map(|(at, cell)| cell.html(tag(at), head(at))).collect()
        };
        let class = if self.stacking { " class=\"stacking\"" } else { "" };
        let head = cells(&self.heads, "th");
        let rows = self.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells(row, "td")));
        let rows: String = rows.collect();
        Html(format!(
            "<div class=\"wide\"><table{class}>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n\
             </table></div>\n"
        ))
    }
}
