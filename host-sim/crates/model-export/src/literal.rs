//! Coefficients as a Rust literal: a value that `serde` can serialise becomes the expression that makes it.
//!
//! A word of the crate `fixed`, which serialises as a struct of `bits`, becomes a call of its `from_bits`, a word in single precision the shortest decimal number
//! that only it is nearest to, in a call of its `new`, and a pair of them likewise: so every number type of the core is written to the last bit.

use std::collections::BTreeSet;
use std::fmt::{self, Debug, Display, Write};

use serde::Serialize;
use serde::ser::{self, Impossible, Serializer};

/// An expression, and the types that it names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Literal {
    pub(crate) expression: String,
    pub(crate) types: BTreeSet<&'static str>,
    /// Depth of the present line.
    depth: usize,
}

impl Literal {
    /// The expression that makes this value.
    ///
    /// # Errors
    /// The value holds what coefficients do not: text, bytes, maps, sequences of no fixed length.
    pub(crate) fn of(value: &impl Serialize) -> Result<Self, Unwritable> {
        let mut literal = Self::default();
        value.serialize(&mut literal)?;
        Ok(literal)
    }

    fn put(&mut self, text: impl Display) -> Result<(), Unwritable> {
        write!(self.expression, "{text}").map_err(ser::Error::custom)
    }

    /// A floating-point number that reads back bit for bit.
    fn put_float(&mut self, of: &str, value: f64, shortest: impl Debug) -> Result<(), Unwritable> {
        if value.is_finite() {
            self.put(format_args!("{shortest:?}"))
        } else if value.is_nan() {
            self.put(format_args!("{of}::NAN"))
        } else {
            self.put(format_args!("{of}::{}INFINITY", if value > 0.0 { "" } else { "NEG_" }))
        }
    }

    fn line(&mut self) -> Result<(), Unwritable> {
        self.put(format_args!("\n{:width$}", "", width = 4 * self.depth))
    }

    /// Opens a value of several parts.
    fn open(&mut self, start: impl Display, end: &'static str) -> Result<Parts<'_>, Unwritable> {
        self.put(start)?;
        Ok(Parts { literal: self, end, is_empty: true })
    }

    /// The type of the value that follows.
    fn named(&mut self, name: &'static str) -> &'static str {
        self.types.insert(name);
        name
    }
}

/// What has no literal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("coefficients cannot be written as Rust: {0}")]
pub(crate) struct Unwritable(String);

impl ser::Error for Unwritable {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// A value of which some parts are written.
pub(crate) struct Parts<'a> {
    literal: &'a mut Literal,
    /// What closes it.
    end: &'static str,
    is_empty: bool,
}

impl Parts<'_> {
    /// A part on a line of its own.
    fn field(&mut self, name: &'static str, value: &(impl Serialize + ?Sized)) -> Result<(), Unwritable> {
        self.literal.depth += 1;
        self.literal.line()?;
        self.literal.put(format_args!("{name}: "))?;
        value.serialize(&mut *self.literal)?;
        self.literal.depth -= 1;
        self.literal.put(",")
    }

    /// A part beside the others.
    fn element(&mut self, value: &(impl Serialize + ?Sized)) -> Result<(), Unwritable> {
        if !self.is_empty {
            self.literal.put(", ")?;
        }
        self.is_empty = false;
        value.serialize(&mut *self.literal)
    }

    fn close(self, on_a_line: bool) -> Result<(), Unwritable> {
        if on_a_line {
            self.literal.line()?;
        }
        self.literal.put(self.end)
    }
}

/// A struct: one field a line; or a word of the crate `fixed`, whose only field is private.
pub(crate) enum Fields<'a> {
    Named(Parts<'a>),
    Word(Parts<'a>),
}

impl ser::SerializeStruct for Fields<'_> {
    type Ok = ();
    type Error = Unwritable;

    fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Unwritable> {
        match self {
            Fields::Named(parts) => parts.field(name, value),
            Fields::Word(parts) => parts.element(value),
        }
    }

    fn end(self) -> Result<(), Unwritable> {
        match self {
            Fields::Named(parts) => parts.close(true),
            Fields::Word(parts) => parts.close(false),
        }
    }
}

/// What is written as its elements, one beside the other.
macro_rules! elements {
    ($($of:ident $serialize:ident),*) => {
        $(impl ser::$of for Parts<'_> {
            type Ok = ();
            type Error = Unwritable;

            fn $serialize<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Unwritable> {
                self.element(value)
            }

            fn end(self) -> Result<(), Unwritable> {
                self.close(false)
            }
        })*
    };
}

elements!(
    SerializeTuple serialize_element, SerializeTupleStruct serialize_field, SerializeTupleVariant serialize_field
);

/// Numbers that are written as they are shown.
macro_rules! integers {
    ($($serialize:ident $integer:ident),*) => {
        $(fn $serialize(self, value: $integer) -> Result<(), Unwritable> {
            self.put(value)
        })*
    };
}

fn unwritable<T>(what: &str) -> Result<T, Unwritable> {
    Err(Unwritable(format!("they hold {what}")))
}

impl<'a> Serializer for &'a mut Literal {
    type Ok = ();
    type Error = Unwritable;
    type SerializeSeq = Impossible<(), Unwritable>;
    type SerializeTuple = Parts<'a>;
    type SerializeTupleStruct = Parts<'a>;
    type SerializeTupleVariant = Parts<'a>;
    type SerializeMap = Impossible<(), Unwritable>;
    type SerializeStruct = Fields<'a>;
    type SerializeStructVariant = Impossible<(), Unwritable>;

    integers!(
        serialize_bool bool, serialize_i8 i8, serialize_i16 i16, serialize_i32 i32, serialize_i64 i64, serialize_u8 u8,
        serialize_u16 u16, serialize_u32 u32, serialize_u64 u64
    );

    fn serialize_f32(self, value: f32) -> Result<(), Unwritable> {
        self.put_float("f32", f64::from(value), value)
    }
    fn serialize_f64(self, value: f64) -> Result<(), Unwritable> {
        self.put_float("f64", value, value)
    }
    fn serialize_char(self, _: char) -> Result<(), Unwritable> {
        unwritable("a character")
    }
    fn serialize_str(self, _: &str) -> Result<(), Unwritable> {
        unwritable("text")
    }
    fn serialize_bytes(self, _: &[u8]) -> Result<(), Unwritable> {
        unwritable("bytes")
    }
    fn serialize_none(self) -> Result<(), Unwritable> {
        self.put("None")
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Unwritable> {
        self.put("Some(")?;
        value.serialize(&mut *self)?;
        self.put(")")
    }
    fn serialize_unit(self) -> Result<(), Unwritable> {
        self.put("()")
    }
    fn serialize_unit_struct(self, name: &'static str) -> Result<(), Unwritable> {
        let name = self.named(name);
        self.put(name)
    }
    fn serialize_unit_variant(self, of: &'static str, _: u32, variant: &'static str) -> Result<(), Unwritable> {
        let of = self.named(of);
        self.put(format_args!("{of}::{variant}"))
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, name: &'static str, value: &T) -> Result<(), Unwritable> {
        let name = self.named(name);
        // Its range is its own affair, so its word is private.
        let constructor = if name == "Single" { "::new" } else { "" };
        self.put(format_args!("{name}{constructor}("))?;
        value.serialize(&mut *self)?;
        self.put(")")
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        of: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Unwritable> {
        let of = self.named(of);
        self.put(format_args!("{of}::{variant}("))?;
        value.serialize(&mut *self)?;
        self.put(")")
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Self::SerializeSeq, Unwritable> {
        unwritable("a sequence")
    }
    fn serialize_tuple(self, _: usize) -> Result<Parts<'a>, Unwritable> {
        // The core has arrays and no tuples.
        self.open("[", "]")
    }
    fn serialize_tuple_struct(self, name: &'static str, _: usize) -> Result<Parts<'a>, Unwritable> {
        // The only one, a pair of words, keeps them to itself as well.
        let name = self.named(name);
        self.open(format_args!("{name}::new("), ")")
    }
    fn serialize_tuple_variant(
        self,
        of: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Parts<'a>, Unwritable> {
        let of = self.named(of);
        self.open(format_args!("{of}::{variant}("), ")")
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, Unwritable> {
        unwritable("a map")
    }
    fn serialize_struct(self, name: &'static str, _: usize) -> Result<Fields<'a>, Unwritable> {
        let name = self.named(name);
        if name.starts_with("Fixed") {
            return Ok(Fields::Word(self.open(format_args!("{name}::from_bits("), ")")?));
        }
        Ok(Fields::Named(self.open(format_args!("{name} {{"), "}")?))
    }
    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, Unwritable> {
        unwritable("a variant with names")
    }
}

impl fmt::Debug for Parts<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Parts({})", self.end)
    }
}

#[cfg(test)]
mod tests {
    use fixed::types::{I4F28, U16F16};
    use model_core::number::{Number, PerUnit, Single};

    use super::*;

    #[derive(Serialize)]
    enum Kind {
        One,
        Pair(f64, Option<bool>),
    }

    #[derive(Serialize)]
    struct Part {
        gain: I4F28,
        steep: Option<U16F16>,
    }

    #[derive(Serialize)]
    struct Whole {
        kinds: [Kind; 2],
        part: Part,
        most: [f32; 3],
    }

    #[test]
    fn a_value_becomes_the_expression_that_makes_it() {
        let whole = Whole {
            kinds: [Kind::One, Kind::Pair(0.1, Some(true))],
            part: Part { gain: I4F28::from_num(-0.5), steep: None },
            most: [f32::INFINITY, f32::NEG_INFINITY, 1e-7],
        };
        let literal = Literal::of(&whole).unwrap();
        let expected = "Whole {\n    kinds: [Kind::One, Kind::Pair(0.1, Some(true))],\n    part: Part {\n        \
                        gain: FixedI32::from_bits(-134217728),\n        steep: None,\n    },\n    \
                        most: [f32::INFINITY, f32::NEG_INFINITY, 1e-7],\n}";
        assert_eq!(literal.expression, expected);
        assert_eq!(literal.types.into_iter().collect::<Vec<_>>(), ["FixedI32", "Kind", "Part", "Whole"]);
    }

    #[test]
    fn words_of_both_number_types_are_calls_that_a_constant_may_make() {
        // A word of the smallest magnitudes, too, and the sign of nothing.
        const READ: [Single; 3] = [Single::new(-0.1), Single::new(3.918_315e-39), Single::new(-0.0)];
        let literal = Literal::of(&[Some(PerUnit::from_bits(-3))]).unwrap();
        assert_eq!(literal.expression, "[Some(PerUnit(FixedI32::from_bits(-3)))]");
        let words = [Single::new(-0.1), Single::new(f32::MIN_POSITIVE / 3.0), -Single::new(0.0)];
        let literal = Literal::of(&words).unwrap();
        assert_eq!(literal.expression, "[Single::new(-0.1), Single::new(3.918315e-39), Single::new(-0.0)]");
        assert_eq!(literal.types.into_iter().collect::<Vec<_>>(), ["Single"]);
        let literal = Literal::of(&Single::travel(0.4)).unwrap();
        assert_eq!(literal.expression, "SinglePair::new(0.4, -5.9604646e-9)");
        assert_eq!(READ.map(Single::to_bits), words.map(Single::to_bits));
    }

    #[test]
    fn what_coefficients_do_not_hold_is_refused() {
        assert_eq!(
            Literal::of(&"text").unwrap_err().to_string(),
            "coefficients cannot be written as Rust: they hold text"
        );
    }
}
