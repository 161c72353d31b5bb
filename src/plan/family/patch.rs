//! Changes to a JSON document.

use serde_json::{Map, Value};

/// Applies a JSON merge patch (RFC 7386).
pub fn merge(target: &mut Value, patch: &Map<String, Value>) {
    if !target.is_object() {
        *target = Value::Object(Map::new());
    }
    let Value::Object(members) = target else { return };
    for (name, change) in patch {
        match change {
            Value::Null => {
                members.shift_remove(name);
            }
            Value::Object(change) => merge(members.entry(name).or_insert(Value::Null), change),
            value => {
                members.insert(name.clone(), value.clone());
            }
        }
    }
}

/// Puts `value` where `pointer` (RFC 6901, not empty) points to. Missing
/// objects on the way are made; elements of lists have to be there.
///
/// # Errors
///
/// In words, if `pointer` leads nowhere.
pub fn put(mut target: &mut Value, pointer: &str, value: Value) -> Result<(), String> {
    let mut way = String::new();
    for token in pointer.split('/').skip(1) {
        let name = token.replace("~1", "/").replace("~0", "~");
        target = match target {
            Value::Object(members) => {
                members.entry(name).or_insert_with(|| Value::Object(Map::new()))
            }
            Value::Array(elements) => {
                let count = elements.len();
                let element = name.parse::<usize>().ok().and_then(|at| elements.get_mut(at));
                element.ok_or_else(|| format!("`{way}` has {count} elements and no `{token}`"))?
            }
            _ => return Err(format!("`{way}` is neither an object nor a list")),
        };
        way = format!("{way}/{token}");
    }
    *target = value;
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// The examples of RFC 7386, appendix A, whose patch is an object.
    #[test]
    fn merges_as_the_standard_says() {
        for (target, patch, expected) in [
            (json!({"a": "b"}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "b"}), json!({"b": "c"}), json!({"a": "b", "b": "c"})),
            (json!({"a": "b"}), json!({"a": null}), json!({})),
            (json!({"a": "b", "b": "c"}), json!({"a": null}), json!({"b": "c"})),
            (json!({"a": ["b"]}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "c"}), json!({"a": ["b"]}), json!({"a": ["b"]})),
            (
                json!({"a": {"b": "c"}}),
                json!({"a": {"b": "d", "c": null}}),
                json!({"a": {"b": "d"}}),
            ),
            (json!({"a": [{"b": "c"}]}), json!({"a": [1]}), json!({"a": [1]})),
            (json!({"e": null}), json!({"a": 1}), json!({"e": null, "a": 1})),
            (json!([1, 2]), json!({"a": "b", "c": null}), json!({"a": "b"})),
            (json!({}), json!({"a": {"bb": {"ccc": null}}}), json!({"a": {"bb": {}}})),
        ] {
            let mut merged = target.clone();
            merge(&mut merged, patch.as_object().unwrap());
            assert_eq!(merged, expected, "{target} and {patch}");
        }
    }

    #[test]
    fn puts_values_where_pointers_lead() {
        let mut target = json!({"a": {"b/c": 1}, "l": [[1, 2], [3, 4]]});
        put(&mut target, "/a/b~1c", json!(7)).unwrap();
        put(&mut target, "/l/1/0", json!(null)).unwrap();
        put(&mut target, "/new/deep", json!([0])).unwrap();
        assert_eq!(
            target,
            json!({"a": {"b/c": 7}, "l": [[1, 2], [null, 4]], "new": {"deep": [0]}})
        );
        for lost in ["/l/2", "/l/x", "/a/b~1c/d"] {
            assert!(put(&mut target, lost, json!(1)).is_err(), "{lost}");
        }
    }
}
