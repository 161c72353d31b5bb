//! Faults in what a user sent: where, and what is wrong.
//!
//! Input is checked once, at the edge, and every fault of a request is
//! reported together.

pub mod parameter;
mod strict;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_path_to_error::Segment;
use utoipa::ToSchema;

use strict::Strict;

/// One fault of a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Fault {
    /// JSON pointer (RFC 6901) into the request body.
    pub pointer: String,
    /// What is wrong, naming value and limit.
    pub detail: String,
}

/// The faults found so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// More faults than this help nobody; the rest is only counted.
    pub const SHOWN: usize = 50;

    /// Adds a fault at `pointer`.
    pub fn add(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.0.push(Fault { pointer: pointer.into(), detail: detail.into() });
    }

    /// Takes over `other`'s faults, their pointers below `prefix`.
    pub fn add_below(&mut self, prefix: &str, other: Faults) {
        let below = |fault: Fault| Fault { pointer: format!("{prefix}{}", fault.pointer), ..fault };
        self.0.extend(other.0.into_iter().map(below));
    }

    /// `value` if nothing was found, else the faults.
    pub fn into_result<T>(mut self, value: T) -> Result<T, Faults> {
        if self.0.is_empty() {
            return Ok(value);
        }
        if self.0.len() > Self::SHOWN {
            let hidden = self.0.len() - Self::SHOWN;
            self.0.truncate(Self::SHOWN);
            self.add("", format!("and {hidden} more faults"));
        }
        Err(self)
    }

    /// True if nothing was found.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl std::fmt::Display for Faults {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, fault) in self.0.iter().enumerate() {
            if index > 0 {
                f.write_str("; ")?;
            }
            if fault.pointer.is_empty() {
                write!(f, "{}", fault.detail)?;
            } else {
                write!(f, "{}: {}", fault.pointer, fault.detail)?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

/// One step of a JSON pointer, escaped as RFC 6901 asks.
pub fn escape(token: &str) -> String {
    token.replace('~', "~0").replace('/', "~1")
}

/// Reads `value`, which stands at `pointer`, as a `T`; a struct only from an
/// object, though serde would take a list as well.
///
/// The reader of one field stops at its first fault. To report all of them
/// together, a field that could not be read is noted, taken out, and the rest
/// is read again.
pub fn read<T: DeserializeOwned>(
    mut value: Value,
    pointer: &str,
    faults: &mut Faults,
) -> Option<T> {
    let mut removed = false;
    for _ in 0..=Faults::SHOWN {
        let error = match serde_path_to_error::deserialize::<_, T>(Strict(&value)) {
            Ok(parsed) => return (!removed).then_some(parsed),
            Err(error) => error,
        };
        let path = pointer_of(error.path().iter());
        // A choice without its content would be another fault: it goes as a whole.
        let whole = error.path().iter().take_while(|step| !matches!(step, Segment::Enum { .. }));
        let removable = pointer_of(whole);
        let error = error.into_inner().to_string();
        // After a removal, "missing field" would blame the user for our own deed.
        if removed && error.starts_with("missing field") {
            return None;
        }
        let place = missing_field(&error).map_or(path.clone(), |name| format!("{path}/{name}"));
        faults.add(format!("{pointer}{place}"), error);
        if !remove(&mut value, &removable) {
            return None;
        }
        removed = true;
    }
    None
}

fn missing_field(error: &str) -> Option<&str> {
    error.strip_prefix("missing field `")?.split('`').next()
}

fn pointer_of<'a>(path: impl Iterator<Item = &'a Segment>) -> String {
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => format!("/{}", escape(key)),
        Segment::Enum { variant } => format!("/{}", escape(variant)),
        Segment::Unknown => String::new(),
    };
    path.map(step).collect()
}

/// Takes the member at `pointer` out of its object; false if it is none.
fn remove(value: &mut Value, pointer: &str) -> bool {
    let Some((parent, key)) = pointer.rsplit_once('/') else { return false };
    // An array element cannot be taken out without moving its neighbours, so
    // the whole array goes.
    match value.pointer_mut(parent) {
        Some(Value::Object(map)) => {
            map.shift_remove(&key.replace("~1", "/").replace("~0", "~")).is_some()
        }
        Some(Value::Array(_)) => remove(value, parent),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only reading it is tested")]
    struct Sample {
        size: f64,
        #[serde(default)]
        rows: Vec<Vec<f64>>,
    }

    #[test]
    fn reports_every_fault_with_its_pointer() {
        let value = serde_json::json!({"size": 1, "rows": [[1, "x"]], "sizes": 3, "a/b": 1});
        let mut faults = Faults::default();
        assert!(read::<Sample>(value, "/task", &mut faults).is_none());
        let pointers: Vec<&str> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(pointers.len(), 3, "{faults}");
        for expected in ["/task/rows/0/1", "/task/sizes", "/task/a~1b"] {
            assert!(pointers.contains(&expected), "{expected} not in {pointers:?}");
        }
    }

    #[test]
    fn names_the_missing_field() {
        let mut faults = Faults::default();
        assert!(read::<Sample>(serde_json::json!({}), "", &mut faults).is_none());
        assert_eq!(faults.0[0].pointer, "/size");
    }
}
