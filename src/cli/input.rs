//! What users name: a file, a built-in scenario, or standard input.

use std::io::Read as _;
use std::path::Path;

use clap::Args;
use serde_json::Value;

use crate::plan::scenarios::{self, Scenario};

use super::failure::Failure;

/// A request and what to call it in messages.
#[derive(Debug)]
pub(super) struct Input {
    pub(super) name: String,
    pub(super) value: Value,
}

/// What may be set where a scenario is named.
#[derive(Debug, Default, Args)]
pub(super) struct SetOptions {
    /// Set a parameter of a scenario; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = pair)]
    pub(super) settings: Vec<(String, String)>,
}

/// Reads `NAME=VALUE`.
pub(super) fn pair(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.to_owned(), value.to_owned()))
}

/// Reads the request that `source` names: `-` for standard input, a file, or a
/// scenario, in this order. A scenario may also come as a file.
pub(super) fn request(source: &str, set: &SetOptions) -> Result<Input, Failure> {
    if source == "-" || Path::new(source).exists() {
        return selected(document(source)?, set);
    }
    if let Some(scenario) = scenarios::get(source) {
        return Ok(Input { name: source.to_owned(), value: select(scenario, source, set)? });
    }
    let looks_like_a_file = source.contains(['/', '\\', '.']);
    if looks_like_a_file {
        return Err(Failure::input(format!("there is no file `{source}`")));
    }
    let names = scenarios::all().iter().map(|scenario| scenario.name.as_str());
    Err(unknown("there is no file and no scenario", source, names))
}

/// The request in a document, which may be a scenario.
fn selected(document: Input, set: &SetOptions) -> Result<Input, Failure> {
    let Input { name, value } = document;
    if value.get("request").is_none() {
        if let Some((parameter, _)) = set.settings.first() {
            let message =
                format!("{name} is a request, not a scenario: `{parameter}` cannot be set");
            return Err(Failure::input(message));
        }
        return Ok(Input { name, value });
    }
    let invalid = |faults| Failure::faults(format!("{name} is no valid scenario"), &faults);
    let scenario = Scenario::parse(value).map_err(invalid)?;
    let value = select(&scenario, &name, set)?;
    Ok(Input { name, value })
}

/// The scenario's request for what was set.
pub(super) fn select(scenario: &Scenario, name: &str, set: &SetOptions) -> Result<Value, Failure> {
    scenario.select(&set.settings).map_err(|mut faults| {
        for fault in &mut faults.0 {
            fault.pointer = fault.pointer.trim_start_matches('/').to_owned();
        }
        Failure::faults(format!("{name} cannot be set up"), &faults)
    })
}

/// Reads the JSON document in a file, or on standard input for `-`.
pub(super) fn document(source: &str) -> Result<Input, Failure> {
    let (name, text) = if source == "-" {
        let mut text = String::new();
        let read = std::io::stdin().lock().read_to_string(&mut text);
        ("standard input".to_owned(), read.map(|_| text))
    } else {
        (source.to_owned(), std::fs::read_to_string(source))
    };
    let text = text.map_err(|error| Failure::system(&format!("cannot read {name}"), &error))?;
    let value = parse(&name, &text)?;
    Ok(Input { name, value })
}

/// Reads JSON; a syntax error names line and column.
fn parse(name: &str, text: &str) -> Result<Value, Failure> {
    serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let (line, column) = (error.line(), error.column());
        let message = message.trim_end_matches(&format!(" at line {line} column {column}"));
        let shown = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
        let note = (shown.chars().count() <= 100).then(|| shown.trim().to_owned());
        Failure::input(format!("{name}:{line}:{column}: not JSON: {message}"))
            .with_notes(note.filter(|note| !note.is_empty()))
    })
}

/// Tells that `name` is unknown, with names the user may have meant.
pub(super) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Failure {
    let known: Vec<&str> = known.into_iter().collect();
    let near = near(name, &known);
    let note = if near.is_empty() {
        format!("known: {}", known.join(", "))
    } else {
        format!("did you mean {}?", near.join(" or "))
    };
    Failure::input(format!("{what} `{name}`")).with_notes([note])
}

/// At most three of `known` that resemble `name`, the nearest first.
fn near<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let name = name.to_lowercase().replace('_', "-");
    let distance = |known: &str| {
        let known = known.to_lowercase().replace('_', "-");
        let contained = name.len() >= 2 && (known.contains(&name) || name.contains(&known));
        if contained { 1 } else { edit_distance(&name, &known) }
    };
    let tolerated = (name.chars().count() / 3).max(2);
    let mut near: Vec<(usize, &str)> =
        known.iter().map(|&known| (distance(known), known)).collect();
    near.retain(|&(distance, _)| distance <= tolerated);
    near.sort();
    near.into_iter().take(3).map(|(_, name)| name).collect()
}

/// Insertions, deletions and replacements that turn `a` into `b`.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, a) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &b) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::failure::Exit;

    #[test]
    fn suggests_near_names() {
        let known = ["mcb-ab", "mcb-assembly", "wood"];
        assert_eq!(near("mcb_ab", &known), ["mcb-ab"]);
        assert_eq!(near("assembly", &known), ["mcb-assembly"]);
        assert_eq!(near("wod", &known), ["wood"]);
        assert_eq!(near("mcb", &known), ["mcb-ab", "mcb-assembly"]);
        assert!(near("palletizing", &known).is_empty());
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn syntax_errors_name_line_and_column() {
        let failure = parse("cell.json", "{\n  \"robot\": \"ur5e\"\n  \"task\": 1\n}").unwrap_err();
        assert_eq!(failure.exit(), Exit::Input);
        assert_eq!(
            failure.text(),
            "error: cell.json:3:3: not JSON: expected `,` or `}`\n  \"task\": 1\n"
        );
    }

    #[test]
    fn a_missing_file_is_not_taken_for_a_scenario() {
        let failure = request("no/such/file.json", &SetOptions::default()).unwrap_err();
        assert_eq!(failure.text(), "error: there is no file `no/such/file.json`\n");
    }
}
