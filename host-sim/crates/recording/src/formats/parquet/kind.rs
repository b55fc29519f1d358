//! What the numbers of a Parquet column are, by the types that the file states.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::schema::types::ColumnDescPtr;

/// How the numbers of a column are interpreted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Signed,
    Unsigned,
    /// Timestamps, with the length of their unit, s; they count from the first.
    Stamp(f64),
    /// Durations or times of day, with the length of their unit, s.
    Span(f64),
    /// Decimal numbers: whole numbers of this size.
    Decimal(f64),
    /// Floating numbers of 16 bits.
    Half,
}

impl Kind {
    /// The kind of a column; `duration_s` is the length of its unit where it holds durations. An error tells what it holds instead of numbers.
    pub(super) fn of(column: &ColumnDescPtr, duration_s: Option<f64>) -> Result<Self, &'static str> {
        if column.max_rep_level() > 0 {
            return Err("lists");
        }
        let unit_s = |unit: TimeUnit| match unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        };
        let kind = match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(stamp)), _) => Kind::Stamp(unit_s(stamp.unit)),
            (Some(LogicalType::Time(time)), _) => Kind::Span(unit_s(time.unit)),
            (Some(LogicalType::Integer(whole)), _) if !whole.is_signed => Kind::Unsigned,
            (Some(LogicalType::Float16), _) => Kind::Half,
            (Some(LogicalType::Date), _) | (_, ConvertedType::DATE) => {
                return Err("dates; times with fractions of a second are read, as timestamps or durations");
            }
            (_, ConvertedType::INTERVAL) => {
                return Err("intervals of months, days and ms; as a number of s they are read");
            }
            // Older programs state no other type.
            (None, ConvertedType::TIMESTAMP_MILLIS) => Kind::Stamp(1e-3),
            (None, ConvertedType::TIMESTAMP_MICROS) => Kind::Stamp(1e-6),
            (None, ConvertedType::TIME_MILLIS) => Kind::Span(1e-3),
            (None, ConvertedType::TIME_MICROS) => Kind::Span(1e-6),
            (
                None,
                ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64,
            ) => Kind::Unsigned,
            (Some(LogicalType::Decimal(_)), _) | (None, ConvertedType::DECIMAL) => {
                Kind::Decimal(10_f64.powi(column.type_scale().max(0)))
            }
            (Some(LogicalType::Integer(_)), _)
            | (
                None,
                ConvertedType::NONE
                | ConvertedType::INT_8
                | ConvertedType::INT_16
                | ConvertedType::INT_32
                | ConvertedType::INT_64,
            ) => match (column.physical_type(), duration_s) {
                (Type::INT96, _) => Kind::Stamp(1e-9),
                (Type::INT64, Some(unit_s)) => Kind::Span(unit_s),
                _ => Kind::Signed,
            },
            _ => return Err("text or bytes"),
        };
        let physical = column.physical_type();
        let fits = match kind {
            Kind::Half => physical == Type::FIXED_LEN_BYTE_ARRAY && column.type_length() == 2,
            Kind::Decimal(_) if physical == Type::FIXED_LEN_BYTE_ARRAY => (1..=16).contains(&column.type_length()),
            Kind::Decimal(_) => matches!(physical, Type::INT32 | Type::INT64),
            _ => !matches!(physical, Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY),
        };
        if fits { Ok(kind) } else { Err("text or bytes") }
    }

    /// Whether its values come out in s.
    pub(super) fn is_in_seconds(self) -> bool {
        matches!(self, Kind::Stamp(_) | Kind::Span(_))
    }

    /// The value of a whole number; `first` is the first of its column.
    pub(super) fn of_whole(self, value: i64, first: &mut Option<i64>) -> f64 {
        match self {
            Kind::Unsigned => value.cast_unsigned() as f64,
            // The difference of the integers is exact; the count since 1970 would be rounded.
            Kind::Stamp(unit_s) => value.wrapping_sub(*first.get_or_insert(value)) as f64 * unit_s,
            Kind::Span(unit_s) => value as f64 * unit_s,
            Kind::Decimal(size) => value as f64 / size,
            Kind::Signed | Kind::Half => value as f64,
        }
    }

    /// The value of some bytes: a number of 16 bits, or a decimal number with the high byte first.
    pub(super) fn of_bytes(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Kind::Half, [low, high]) => half::f16::from_le_bytes([*low, *high]).to_f64(),
            (Kind::Decimal(size), [first, ..]) => {
                let sign = if *first >= 0x80 { -1 } else { 0 };
                bytes.iter().fold(sign, |number: i128, byte| number << 8 | i128::from(*byte)) as f64 / size
            }
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use parquet::schema::parser::parse_message_type;
    use parquet::schema::types::SchemaDescriptor;

    use super::*;

    fn kind(field: &str) -> Result<Kind, &'static str> {
        let schema = parse_message_type(&format!("message schema {{ {field}; }}")).unwrap();
        Kind::of(&SchemaDescriptor::new(Arc::new(schema)).columns()[0], None)
    }

    #[test]
    fn types_are_told_by_both_of_their_names() {
        assert_eq!(kind("optional int64 t"), Ok(Kind::Signed));
        assert_eq!(kind("optional int96 t"), Ok(Kind::Stamp(1e-9)));
        for (field, expected) in [
            ("required int64 t (TIMESTAMP_MICROS)", Kind::Stamp(1e-6)),
            ("required int64 t (TIMESTAMP(NANOS,true))", Kind::Stamp(1e-9)),
            ("required int32 t (TIME_MILLIS)", Kind::Span(1e-3)),
            ("required int32 t (UINT_32)", Kind::Unsigned),
            ("required int32 t (INTEGER(16,true))", Kind::Signed),
            ("required int64 t (DECIMAL(10,3))", Kind::Decimal(1000.0)),
            ("required fixed_len_byte_array(2) t (FLOAT16)", Kind::Half),
            ("required boolean t", Kind::Signed),
        ] {
            assert_eq!(kind(field), Ok(expected), "{field}");
        }
        assert!(kind("required int32 t (DATE)").unwrap_err().starts_with("dates"));
        assert_eq!(kind("required byte_array t (UTF8)"), Err("text or bytes"));
        assert_eq!(kind("required byte_array t"), Err("text or bytes"));
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "every number here is exact")]
    fn bytes_are_numbers_of_their_kind() {
        assert_eq!(Kind::Half.of_bytes(&[0x00, 0x3e]), 1.5);
        assert_eq!(Kind::Decimal(100.0).of_bytes(&[0xff, 0xff, 0xff, 0x6a]), -1.5);
        assert_eq!(Kind::Decimal(1.0).of_bytes(&[0x01, 0x00]), 256.0);
        assert!(Kind::Half.of_bytes(&[]).is_nan());
    }
}
