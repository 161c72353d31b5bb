//! Why a command failed, for people and for scripts.

use std::io::Write as _;
use std::process::ExitCode;

use crate::fault::Faults;

/// The exit status of a failed command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    /// Planning failed, or a trajectory is unlawful.
    Planning = 1,
    /// The input is wrong.
    Input = 2,
    /// No server answers, or it takes no jobs at present.
    Unreachable = 3,
}

/// Why a command failed.
#[derive(Debug)]
pub(super) struct Failure {
    exit: Exit,
    message: String,
    notes: Vec<String>,
}

impl Failure {
    pub(super) fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: message.into(), notes: Vec::new() }
    }

    pub(super) fn input(message: impl Into<String>) -> Self {
        Self::new(Exit::Input, message)
    }

    pub(super) fn planning(message: impl Into<String>) -> Self {
        Self::new(Exit::Planning, message)
    }

    /// The operating system refused something: a file, a port, a thread.
    pub(super) fn system(what: &str, error: &dyn std::error::Error) -> Self {
        Self::input(format!("{what}: {}", with_causes(error)))
    }

    /// All faults of an input, each in its line.
    pub(super) fn faults(message: impl Into<String>, faults: &Faults) -> Self {
        let place = |pointer: &str| match pointer {
            "" => String::new(),
            pointer => format!("{pointer}: "),
        };
        let lines =
            faults.0.iter().map(|fault| format!("{}{}", place(&fault.pointer), fault.detail));
        Self::input(message).with_notes(lines)
    }

    /// Adds lines below the message.
    pub(super) fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// What is written to standard error.
    pub(super) fn text(&self) -> String {
        let mut text = format!("error: {}\n", self.message);
        for note in &self.notes {
            text.push_str(&format!("  {note}\n"));
        }
        text
    }

    /// Tells the user, and the exit status.
    pub(super) fn report(&self) -> ExitCode {
        // Where even standard error is closed there is nobody to tell.
        let _ = std::io::stderr().write_all(self.text().as_bytes());
        ExitCode::from(self.exit as u8)
    }

    #[cfg(test)]
    pub(super) fn exit(&self) -> Exit {
        self.exit
    }
}

/// An error's message and those of its causes, as far as they add something.
pub(super) fn with_causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let message = error.to_string();
        if !text.contains(&message) {
            text.push_str(": ");
            text.push_str(&message);
        }
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_every_fault_with_its_pointer() {
        let mut faults = Faults::default();
        faults.add("/task/waypoints/1", "has 5 values, the robot 6 joints");
        faults.add("", "and 3 more faults");
        let failure = Failure::faults("cell.json cannot be planned", &faults);
        assert_eq!(
            failure.text(),
            "error: cell.json cannot be planned\n  \
             /task/waypoints/1: has 5 values, the robot 6 joints\n  and 3 more faults\n"
        );
        assert_eq!(failure.exit(), Exit::Input);
    }
}
