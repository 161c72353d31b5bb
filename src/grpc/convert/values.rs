//! Numbers, texts, times and JSON.

use jiff::Timestamp;
use prost_types::value::Kind;
use serde_json::{Map, Number, Value};

use super::{MessageForm, Place};
use crate::fault::Faults;

/// Types that travel as they are.
macro_rules! same_form {
    ($($type:ty),*) => {$(
        impl MessageForm<$type> for $type {
            fn into_message(self) -> $type {
                self
            }

            fn from_message(message: $type, _: Place<'_>, _: &mut Faults) -> Self {
                message
            }
        }
    )*};
}

same_form!(bool, u32, u64, String);

/// JSON and the store hold finite numbers only.
impl MessageForm<f64> for f64 {
    fn into_message(self) -> f64 {
        self
    }

    fn from_message(message: f64, place: Place<'_>, faults: &mut Faults) -> Self {
        if !message.is_finite() {
            place.fault(faults, format!("{message} is not a finite number"));
        }
        message
    }
}

/// An integer that is at most as wide here as in its message.
macro_rules! integer_form {
    ($domain:ty as $message:ty) => {
        impl MessageForm<$message> for $domain {
            fn into_message(self) -> $message {
                self as $message
            }

            fn from_message(message: $message, place: Place<'_>, faults: &mut Faults) -> Self {
                Self::try_from(message).unwrap_or_else(|_| {
                    place.fault(faults, format!("{message} is larger than {}", Self::MAX));
                    Self::MAX
                })
            }
        }
    };
}

integer_form!(u8 as u32);
integer_form!(usize as u64);

impl MessageForm<prost_types::Timestamp> for Timestamp {
    fn into_message(self) -> prost_types::Timestamp {
        // jiff counts both parts towards zero, protobuf counts nanoseconds up.
        let (seconds, nanos) = (self.as_second(), self.subsec_nanosecond());
        let borrow = i64::from(nanos < 0);
        let nanos = if nanos < 0 { nanos + 1_000_000_000 } else { nanos };
        prost_types::Timestamp { seconds: seconds - borrow, nanos }
    }

    fn from_message(
        message: prost_types::Timestamp,
        place: Place<'_>,
        faults: &mut Faults,
    ) -> Self {
        let prost_types::Timestamp { seconds, nanos } = message;
        let lawful = (0..1_000_000_000).contains(&nanos);
        let time = lawful.then(|| Timestamp::new(seconds, nanos).ok()).flatten();
        time.unwrap_or_else(|| {
            place.fault(faults, format!("{seconds} s and {nanos} ns are not a time"));
            Timestamp::UNIX_EPOCH
        })
    }
}

/// Whole numbers up to this magnitude are exact in a double.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// A protobuf value knows only doubles: a whole number is read as an integer,
/// and integers beyond 2^53 are rounded.
impl MessageForm<prost_types::Value> for Value {
    fn into_message(self) -> prost_types::Value {
        let kind = match self {
            Value::Null => Kind::NullValue(0),
            Value::Bool(value) => Kind::BoolValue(value),
            Value::Number(value) => Kind::NumberValue(value.as_f64().unwrap_or(f64::NAN)),
            Value::String(value) => Kind::StringValue(value),
            Value::Array(values) => {
                Kind::ListValue(prost_types::ListValue { values: values.into_message() })
            }
            Value::Object(members) => Kind::StructValue(members.into_message()),
        };
        prost_types::Value { kind: Some(kind) }
    }

    fn from_message(message: prost_types::Value, place: Place<'_>, faults: &mut Faults) -> Self {
        match message.kind {
            None => {
                place.fault(faults, "must be given");
                Value::Null
            }
            Some(Kind::NullValue(_)) => Value::Null,
            Some(Kind::BoolValue(value)) => Value::Bool(value),
            Some(Kind::NumberValue(value)) => number(f64::from_message(value, place, faults)),
            Some(Kind::StringValue(value)) => Value::String(value),
            Some(Kind::ListValue(list)) => {
                Value::Array(MessageForm::from_message(list.values, place, faults))
            }
            Some(Kind::StructValue(members)) => {
                Value::Object(MessageForm::from_message(members, place, faults))
            }
        }
    }
}

impl MessageForm<prost_types::Struct> for Map<String, Value> {
    fn into_message(self) -> prost_types::Struct {
        let fields = self.into_iter();
        let fields = fields.map(|(key, value)| (key, value.into_message())).collect();
        prost_types::Struct { fields }
    }

    fn from_message(message: prost_types::Struct, place: Place<'_>, faults: &mut Faults) -> Self {
        let read = |(key, value): (String, prost_types::Value)| {
            let value = Value::from_message(value, place.field(&key), faults);
            (key, value)
        };
        message.fields.into_iter().map(read).collect()
    }
}

fn number(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() <= MAX_EXACT {
        // Whole and within the type's range: nothing is cut off.
        return Value::from(value as i64);
    }
    Number::from_f64(value).map_or(Value::Null, Value::Number)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::grpc::convert::read;

    #[test]
    fn json_returns_as_it_went() {
        let value = json!({"n": null, "b": true, "i": 50, "f": 0.5, "neg": -3, "s": "x",
            "l": [1, [], {"deep": 2.25}]});
        let message: prost_types::Value = value.clone().into_message();
        assert_eq!(read::<Value, _>(message), Ok(value));
        assert_eq!(number(4.0), json!(4));
        assert_eq!(number(1e300), json!(1e300));
    }

    #[test]
    fn what_json_cannot_hold_is_a_fault() {
        let list = vec![
            prost_types::Value { kind: Some(Kind::NumberValue(f64::NAN)) },
            prost_types::Value { kind: None },
        ];
        let message = prost_types::Value {
            kind: Some(Kind::ListValue(prost_types::ListValue { values: list })),
        };
        let faults = read::<Value, _>(message).unwrap_err();
        let pointers: Vec<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(pointers, ["/0", "/1"]);
    }

    #[test]
    fn times_return_as_they_went_even_before_1970() {
        for text in
            ["2026-11-05T12:00:00.123456Z", "1969-12-31T23:59:58.75Z", "1970-01-01T00:00:00Z"]
        {
            let time: Timestamp = text.parse().unwrap();
            let message: prost_types::Timestamp = time.into_message();
            assert!((0..1_000_000_000).contains(&message.nanos));
            assert_eq!(read::<Timestamp, _>(message), Ok(time));
        }
        for (seconds, nanos) in [(i64::MAX, 0), (0, -1), (0, 1_000_000_000)] {
            assert!(read::<Timestamp, _>(prost_types::Timestamp { seconds, nanos }).is_err());
        }
    }

    #[test]
    fn numbers_that_do_not_fit_are_faults() {
        assert_eq!(read::<u8, u32>(255), Ok(255));
        assert!(read::<u8, u32>(256).is_err());
        assert!(read::<f64, f64>(f64::INFINITY).is_err());
    }
}
