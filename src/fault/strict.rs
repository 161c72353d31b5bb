//! Reads JSON strictly: an object's members by their names only.
//!
//! Readers that serde derives also take a struct as a list of its fields in
//! order. That is nobody's documented format: fields would change places with
//! the source, and a list in the wrong spot would pass for an object.

use serde::de::value::{MapAccessDeserializer, MapDeserializer, SeqDeserializer, StrDeserializer};
use serde::de::{Deserializer, Error as _, IntoDeserializer, Unexpected, Visitor};
use serde_json::{Error, Map, Value};

/// A value that reads as a struct only if it is an object, and so do the values
/// within it.
#[derive(Clone, Copy)]
pub(super) struct Strict<'de>(pub(super) &'de Value);

impl<'de> Strict<'de> {
    fn object(self) -> Result<&'de Map<String, Value>, Error> {
        let found = match self.0 {
            Value::Object(members) => return Ok(members),
            Value::Array(_) => Unexpected::Other("a list"),
            Value::String(text) => Unexpected::Str(text),
            Value::Bool(value) => Unexpected::Bool(*value),
            Value::Number(_) => Unexpected::Other("a number"),
            Value::Null => Unexpected::Other("null"),
        };
        Err(Error::invalid_type(found, &"an object"))
    }
}

fn visit_members<'de, V: Visitor<'de>>(
    members: &'de Map<String, Value>,
    visitor: V,
) -> Result<V::Value, Error> {
    let mut access = MapDeserializer::new(strict_members(members));
    let value = visitor.visit_map(&mut access)?;
    access.end()?;
    Ok(value)
}

fn strict_members(members: &Map<String, Value>) -> impl Iterator<Item = (&str, Strict<'_>)> {
    members.iter().map(|(name, value)| (name.as_str(), Strict(value)))
}

impl<'de> IntoDeserializer<'de, Error> for Strict<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Strict<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Value::Array(items) => {
                let mut access = SeqDeserializer::new(items.iter().map(Strict));
                let value = visitor.visit_seq(&mut access)?;
                access.end()?;
                Ok(value)
            }
            Value::Object(members) => visit_members(members, visitor),
            scalar => scalar.deserialize_any(visitor),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        if self.0.is_null() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    // Maps too: structs with flattened fields and variants with fields read as such.
    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visit_members(self.object()?, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match self.0 {
            Value::String(variant) => visitor.visit_enum(StrDeserializer::<Error>::new(variant)),
            Value::Object(members) if members.len() == 1 => {
                let members = MapDeserializer::new(strict_members(members));
                visitor.visit_enum(MapAccessDeserializer::new(members))
            }
            other => other.deserialize_enum(name, variants, visitor),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct seq tuple tuple_struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;
    use serde_json::json;

    use super::super::{Faults, read};
    use super::*;

    #[derive(Debug, Default, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Outer {
        inner: Option<Inner>,
        list: Vec<Inner>,
        goal: Option<Goal>,
        flat: Option<Flat>,
        from: Kept,
        pair: Option<(f64, f64)>,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        size: Option<f64>,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Goal {
        Shortest,
        Exactly(f64),
        Within { most: f64 },
        Like(Inner),
    }

    #[derive(Debug, PartialEq, Deserialize)]
    struct Flat {
        name: String,
        #[serde(flatten)]
        rest: BTreeMap<String, Value>,
    }

    #[derive(Debug, Default, PartialEq, Deserialize)]
    #[serde(from = "Option<Values>")]
    struct Kept(Option<Values>);

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(untagged)]
    enum Values {
        One(f64),
        Each(Vec<Option<f64>>),
    }

    impl From<Option<Values>> for Kept {
        fn from(values: Option<Values>) -> Self {
            Self(values)
        }
    }

    fn faults(value: Value) -> Vec<(String, String)> {
        let mut faults = Faults::default();
        assert_eq!(read::<Outer>(value, "", &mut faults), None);
        faults.0.into_iter().map(|fault| (fault.pointer, fault.detail)).collect()
    }

    #[test]
    fn whatever_is_well_formed_reads_as_before() {
        for value in [
            json!({}),
            json!({"inner": null, "goal": null}),
            json!({"inner": {"size": 1}, "list": [{}, {"size": null}], "pair": [1, 2.5]}),
            json!({"goal": "shortest"}),
            json!({"goal": {"exactly": 4}}),
            json!({"goal": {"within": {"most": 2.5}}}),
            json!({"goal": {"like": {"size": 3}}}),
            json!({"flat": {"name": "pso", "count": [1, {"deep": true}]}}),
            json!({"from": 2}),
            json!({"from": [1, null]}),
        ] {
            let expected: Outer = serde_json::from_value(value.clone()).unwrap();
            let mut faults = Faults::default();
            assert_eq!(read::<Outer>(value, "", &mut faults), Some(expected), "{faults}");
        }
    }

    #[test]
    fn only_an_object_reads_as_a_struct() {
        let list = "invalid type: a list, expected an object";
        for (value, pointer, detail) in [
            (json!([]), "", list),
            (json!({"inner": [0.5]}), "/inner", list),
            (json!({"inner": 3}), "/inner", "invalid type: a number, expected an object"),
            (json!({"inner": "x"}), "/inner", "invalid type: string \"x\", expected an object"),
            (json!({"list": [{}, [1]]}), "/list/1", list),
            (json!({"list": [null]}), "/list/0", "invalid type: null, expected an object"),
            (json!({"goal": {"within": [2.5]}}), "/goal/within", list),
            (json!({"goal": {"like": [3]}}), "/goal/like", list),
            (json!({"flat": ["pso"]}), "/flat", list),
        ] {
            assert_eq!(faults(value), [(pointer.to_owned(), detail.to_owned())]);
        }
    }

    #[test]
    fn other_faults_keep_their_places() {
        for (value, pointer) in [
            (json!({"inner": {"sizes": 1}}), "/inner/sizes"),
            (json!({"inner": {"size": "1"}}), "/inner/size"),
            (json!({"goal": {"exactly": "4"}}), "/goal/exactly"),
            (json!({"goal": {"exactly": 4, "shortest": null}}), "/goal"),
            (json!({"goal": 4}), "/goal"),
            (json!({"goal": "longest"}), "/goal"),
            (json!({"flat": {}}), "/flat/name"),
            (json!({"from": {"a": 1}}), "/from"),
            (json!({"pair": [1, 2, 3]}), "/pair"),
        ] {
            let found = faults(value);
            let pointers: Vec<_> = found.iter().map(|(pointer, _)| pointer.as_str()).collect();
            assert_eq!(pointers, [pointer], "{found:?}");
        }
    }
}
