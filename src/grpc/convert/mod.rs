//! Between domain values and the messages they travel as, field by field.
//!
//! A domain type and its message have the same fields under the same names;
//! [`message_form!`] writes both directions from one list of them and names
//! every field, so one added on either side only does not compile. Where the
//! two differ, the conversion is written out.

use std::collections::BTreeMap;
use std::fmt;

use crate::fault::{Faults, escape};

/// Implements [`MessageForm`] for a domain struct whose message has the same
/// fields. A field of another form than
/// its message's field has is followed by the wrapper that bridges the two.
macro_rules! message_form {
    ($domain:ident { $($fields:tt)* }) => {
        message_form!($domain as $domain { $($fields)* });
    };
    ($domain:ident as $message:ident { $($field:ident $(: $inner:ident)?),* $(,)? }) => {
        impl $crate::grpc::convert::MessageForm<$crate::grpc::proto::$message> for $domain {
            #[allow(unused_parens, reason = "they hold a wrapper's field where there is one")]
            fn into_message(self) -> $crate::grpc::proto::$message {
                let $domain { $($field),* } = self;
                $(let $field = $($crate::grpc::convert::$inner)?($field);)*
                $crate::grpc::proto::$message {
                    $($field: $crate::grpc::convert::MessageForm::into_message($field)),*
                }
            }

            #[allow(unused_parens, reason = "they hold a wrapper's field where there is one")]
            fn from_message(
                message: $crate::grpc::proto::$message,
                place: $crate::grpc::convert::Place<'_>,
                faults: &mut $crate::fault::Faults,
            ) -> Self {
                let $crate::grpc::proto::$message { $($field),* } = message;
                $(let $($crate::grpc::convert::$inner)?($field) =
                    $crate::grpc::convert::MessageForm::from_message(
                        $field,
                        place.field(stringify!($field)),
                        faults,
                    );)*
                $domain { $($field),* }
            }
        }
    };
}

/// Implements [`MessageForm`] for a domain enum whose message has the same
/// variants and one more, `Unspecified`, which stands for `$unspecified`; it is
/// refused where that is `None`.
macro_rules! message_enum {
    ($domain:ident { $first:ident $(, $variant:ident)* $(,)? }, unspecified: $unspecified:expr) => {
        impl $crate::grpc::convert::MessageForm<i32> for $domain {
            fn into_message(self) -> i32 {
                match self {
                    $domain::$first => $crate::grpc::proto::$domain::$first.into(),
                    $($domain::$variant => $crate::grpc::proto::$domain::$variant.into(),)*
                }
            }

            fn from_message(
                message: i32,
                place: $crate::grpc::convert::Place<'_>,
                faults: &mut $crate::fault::Faults,
            ) -> Self {
                use $crate::grpc::proto::$domain as Message;
                let known = match Message::try_from(message) {
                    Ok(Message::Unspecified) => $unspecified,
                    Ok(Message::$first) => Some($domain::$first),
                    $(Ok(Message::$variant) => Some($domain::$variant),)*
                    Err(_) => None,
                };
                known.unwrap_or_else(|| {
                    let names = [Message::$first $(, Message::$variant)*];
                    let names = names.map(|name| name.as_str_name()).join(", ");
                    place.fault(faults, format!("expected one of {names}"));
                    $domain::$first
                })
            }
        }
    };
}

// The macros above hold from here on.
mod family;
mod geometry;
mod job;
mod motion;
mod path;
mod request;
mod result;
mod robot;
mod scene;
mod study;
#[cfg(test)]
mod tests;
mod values;

/// A domain value that travels as an `M`.
pub trait MessageForm<M>: Sized {
    /// The value as a message.
    fn into_message(self) -> M;

    /// Reads `message`, which stands at `place`, and adds what is wrong with it
    /// to `faults`. With a fault the value stands in only so that the rest can
    /// be looked at.
    fn from_message(message: M, place: Place<'_>, faults: &mut Faults) -> Self;
}

/// Reads a whole message.
///
/// # Errors
///
/// Everything that is wrong with it; pointers count from the message.
pub fn read<T: MessageForm<M>, M>(message: M) -> Result<T, Faults> {
    let mut faults = Faults::default();
    let value = T::from_message(message, Place::Root, &mut faults);
    faults.into_result(value)
}

/// Where a value stands, as a pointer into the JSON form of the whole. It is
/// written out only if there is a fault.
#[derive(Clone, Copy, Debug)]
pub enum Place<'a> {
    /// The whole.
    Root,
    /// A member of an object.
    Field(&'a Place<'a>, &'a str),
    /// An element of a list.
    Element(&'a Place<'a>, usize),
}

impl Place<'_> {
    /// The member `name` of what stands here.
    pub fn field<'a>(&'a self, name: &'a str) -> Place<'a> {
        Place::Field(self, name)
    }

    /// Element `index` of the list that stands here.
    pub fn element(&self, index: usize) -> Place<'_> {
        Place::Element(self, index)
    }

    /// Adds a fault of what stands here.
    pub fn fault(&self, faults: &mut Faults, detail: impl Into<String>) {
        faults.add(self.to_string(), detail);
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Root => Ok(()),
            Self::Field(parent, name) => write!(f, "{parent}/{}", escape(name)),
            Self::Element(parent, index) => write!(f, "{parent}/{index}"),
        }
    }
}

/// A value without which the whole makes no sense: its message has to be there.
pub(super) struct Required<T>(pub T);

impl<T: MessageForm<M>, M: Default> MessageForm<Option<M>> for Required<T> {
    fn into_message(self) -> Option<M> {
        Some(self.0.into_message())
    }

    fn from_message(message: Option<M>, place: Place<'_>, faults: &mut Faults) -> Self {
        let Some(message) = message else {
            place.fault(faults, "must be given");
            // One fault is enough: those of the stand-in are nobody's.
            return Self(T::from_message(M::default(), place, &mut Faults::default()));
        };
        Self(T::from_message(message, place, faults))
    }
}

/// A value that may be left out and then has its default.
pub(super) struct Defaulted<T>(pub T);

impl<T: MessageForm<M> + Default, M> MessageForm<Option<M>> for Defaulted<T> {
    fn into_message(self) -> Option<M> {
        Some(self.0.into_message())
    }

    fn from_message(message: Option<M>, place: Place<'_>, faults: &mut Faults) -> Self {
        Self(message.map(|message| T::from_message(message, place, faults)).unwrap_or_default())
    }
}

impl<T: MessageForm<M>, M> MessageForm<Option<M>> for Option<T> {
    fn into_message(self) -> Option<M> {
        self.map(T::into_message)
    }

    fn from_message(message: Option<M>, place: Place<'_>, faults: &mut Faults) -> Self {
        message.map(|message| T::from_message(message, place, faults))
    }
}

impl<T: MessageForm<M>, M> MessageForm<M> for Box<T> {
    fn into_message(self) -> M {
        T::into_message(*self)
    }

    fn from_message(message: M, place: Place<'_>, faults: &mut Faults) -> Self {
        Self::new(T::from_message(message, place, faults))
    }
}

impl<T: MessageForm<M>, M> MessageForm<Vec<M>> for Vec<T> {
    fn into_message(self) -> Vec<M> {
        self.into_iter().map(T::into_message).collect()
    }

    fn from_message(message: Vec<M>, place: Place<'_>, faults: &mut Faults) -> Self {
        let elements = message.into_iter().enumerate();
        elements.map(|(i, element)| T::from_message(element, place.element(i), faults)).collect()
    }
}

/// An empty list is an absent one: messages know no difference.
impl<T: MessageForm<M>, M> MessageForm<Vec<M>> for Option<Vec<T>> {
    fn into_message(self) -> Vec<M> {
        self.unwrap_or_default().into_message()
    }

    fn from_message(message: Vec<M>, place: Place<'_>, faults: &mut Faults) -> Self {
        (!message.is_empty()).then(|| MessageForm::from_message(message, place, faults))
    }
}

impl<T: MessageForm<M>, M> MessageForm<BTreeMap<String, M>> for BTreeMap<String, T> {
    fn into_message(self) -> BTreeMap<String, M> {
        self.into_iter().map(|(key, value)| (key, value.into_message())).collect()
    }

    fn from_message(message: BTreeMap<String, M>, place: Place<'_>, faults: &mut Faults) -> Self {
        let read = |(key, value): (String, M)| {
            let value = T::from_message(value, place.field(&key), faults);
            (key, value)
        };
        message.into_iter().map(read).collect()
    }
}

/// The number 0 of an enumeration is an absent value.
impl<T: MessageForm<i32>> MessageForm<i32> for Option<T> {
    fn into_message(self) -> i32 {
        self.map_or(0, T::into_message)
    }

    fn from_message(message: i32, place: Place<'_>, faults: &mut Faults) -> Self {
        (message != 0).then(|| T::from_message(message, place, faults))
    }
}
