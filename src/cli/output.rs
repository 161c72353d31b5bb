//! Answers to standard output or a file, remarks to standard error.

use std::io::{ErrorKind, Write as _};
use std::path::Path;

use super::failure::Failure;

/// Writes an answer to standard output. A reader that has seen enough, such as
/// `head`, is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(text.as_bytes()).and_then(|()| match text.ends_with('\n') {
        true => stdout.flush(),
        false => stdout.write_all(b"\n").and_then(|()| stdout.flush()),
    });
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::system("cannot write the answer", &error))
        }
        _ => Ok(()),
    }
}

/// Writes an answer to `file`, or to standard output without one.
pub(super) fn deliver(text: &str, file: Option<&Path>) -> Result<(), Failure> {
    match file {
        Some(path) => write(path, text.as_bytes()),
        None => print(text),
    }
}

/// Writes a file.
pub(super) fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    let failed = |error| Failure::system(&format!("cannot write {}", path.display()), &error);
    std::fs::write(path, content).map_err(failed)
}

/// Writes a remark to standard error.
pub(super) fn remark(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// JSON for people.
pub(super) fn pretty<T: serde::Serialize>(value: &T) -> Result<String, Failure> {
    serde_json::to_string_pretty(value)
        .map_err(|error| Failure::system("cannot write the answer as JSON", &error))
}
