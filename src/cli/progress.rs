//! How a search goes, while it goes: a bar on a terminal, else a few lines.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::output;

/// Where a search stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Standing<'a> {
    pub(super) leg: Option<&'a str>,
    pub(super) method: Option<&'a str>,
    pub(super) iteration: u64,
    pub(super) evaluations: u64,
    pub(super) best: Option<f64>,
    pub(super) lower_bound: Option<f64>,
    /// Members of a family that are done, and all.
    pub(super) members: Option<[usize; 2]>,
    /// Duration of the slowest member so far, s.
    pub(super) slowest: Option<f64>,
}

impl Standing<'_> {
    fn text(&self) -> String {
        if let Some([done, of]) = self.members {
            let span = self.best.zip(self.slowest);
            let span = span.map(|(least, most)| format!(", {least:.4} to {most:.4} s"));
            return format!(
                "{done} of {of} members{}, {} evaluations",
                span.unwrap_or_default(),
                self.evaluations
            );
        }
        let leg = match (self.leg, self.method) {
            (Some(leg), Some(method)) => format!("{leg}, {method}: "),
            (Some(name), None) | (None, Some(name)) => format!("{name}: "),
            (None, None) => String::new(),
        };
        let best = match self.best {
            // Where methods are compared, a function's value is no time.
            Some(best) if self.method.is_some() => format!("best {best:.6}"),
            // A weighted objective has neither unit nor bound.
            Some(best) if self.lower_bound.is_none() => format!("best {best:.4}"),
            Some(best) => format!("best {best:.4} s"),
            None => "nothing feasible yet".to_owned(),
        };
        let bound = self.lower_bound.map(|bound| format!(", at least {bound:.4} s"));
        let bound = bound.unwrap_or_default();
        let Self { iteration, evaluations, .. } = self;
        format!("{leg}{best}{bound} after {iteration} iterations, {evaluations} evaluations")
    }
}

/// Shows progress on standard error.
pub(super) struct Display {
    bar: Option<ProgressBar>,
    title: String,
    leg: Option<String>,
    shown: Option<Instant>,
}

impl Display {
    /// Lines come no closer than this where there is no terminal.
    const INTERVAL: Duration = Duration::from_secs(1);

    /// A display for what `title` names.
    pub(super) fn new(title: impl Into<String>) -> Self {
        let title = title.into();
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix} {msg}") {
                bar.set_style(style);
            }
            bar.set_prefix(title.clone());
            bar.enable_steady_tick(Duration::from_millis(100));
            bar
        });
        Self { bar, title, leg: None, shown: None }
    }

    /// Shows where the search stands.
    pub(super) fn show(&mut self, standing: &Standing<'_>) {
        if let Some(bar) = &self.bar {
            bar.set_message(standing.text());
            return;
        }
        // Members come and go side by side; a line for each would be too much.
        let new_leg = standing.members.is_none() && standing.leg != self.leg.as_deref();
        if new_leg || self.shown.is_none_or(|shown| shown.elapsed() >= Self::INTERVAL) {
            output::remark(&format!("{}  {}", self.title, standing.text()));
            self.leg = standing.leg.map(str::to_owned);
            self.shown = Some(Instant::now());
        }
    }

    /// Shows what happens where there is no search to tell of.
    pub(super) fn message(&mut self, text: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(text.to_owned()),
            None => output::remark(&format!("{}  {text}", self.title)),
        }
    }

    /// Takes the bar away and leaves `text` in its place.
    pub(super) fn finish(self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        output::remark(text);
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_where_a_search_stands() {
        let standing = Standing {
            leg: Some("AB"),
            method: None,
            iteration: 12,
            evaluations: 650,
            best: Some(7.02554),
            lower_bound: Some(5.0),
            ..Standing::default()
        };
        assert_eq!(
            standing.text(),
            "AB: best 7.0255 s, at least 5.0000 s after 12 iterations, 650 evaluations"
        );
        let start = Standing { evaluations: 50, ..Standing::default() };
        assert_eq!(start.text(), "nothing feasible yet after 0 iterations, 50 evaluations");
    }
}
