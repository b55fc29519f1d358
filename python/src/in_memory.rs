//! Recordings from memory: by Arrow's capsules, which copy nothing, and by the buffer protocol of `numpy`'s arrays, whose times are read as numbers.
//!
//! A recording owns its numbers, in SI units. So each known column is read once, in the memory of whoever holds it, and written once; columns that are not
//! known are not read.

use std::collections::HashMap;
use std::sync::Arc;

use ::recording::{ColumnInMemory, Held};
use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_pyarrow::{FromPyArrow, Table};
use arrow_schema::{DataType, TimeUnit};
use pyo3::buffer::{Element, PyBuffer, PyUntypedBuffer};
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::machine::Machine;
use crate::recording::{Recording, channels};

/// The recording of a table: anything with `__arrow_c_stream__` or `__arrow_c_array__`.
#[pyfunction]
pub(crate) fn from_arrow(
    py: Python<'_>,
    table: &Bound<'_, PyAny>,
    name: &str,
    units: HashMap<String, String>,
    machine: Option<Py<Machine>>,
    maps: Vec<String>,
) -> PyResult<Recording> {
    let batches = if table.hasattr("__arrow_c_stream__")? {
        Table::from_pyarrow_bound(table)?.into_inner()
    } else {
        let batch = RecordBatch::from_pyarrow_bound(table)?;
        let schema = batch.schema();
        (vec![batch], schema)
    };
    let (batches, schema) = batches;
    let channels = channels(machine.as_ref().map(Py::get), &maps).or_raise(py)?;
    let rows = batches.iter().map(RecordBatch::num_rows).sum();
    let column = |(index, field): (usize, &Arc<arrow_schema::Field>)| {
        let parts: Vec<ArrayRef> = batches.iter().map(|batch| Arc::clone(batch.column(index))).collect();
        let (held, unit) = of_arrays(parts, field.data_type(), rows);
        let unit = units.get(field.name()).cloned().or(unit);
        ColumnInMemory { name: field.name().clone(), unit, rows, held }
    };
    let columns = schema.fields().iter().enumerate().map(column).collect();
    let held = ::recording::Recording::of_columns(name, columns, &channels).or_raise(py)?;
    Ok(Recording::from_memory(held))
}

/// What the parts of a column hold, and its unit, where the type states one.
fn of_arrays(parts: Vec<ArrayRef>, of: &DataType, rows: usize) -> (Held<'static>, Option<String>) {
    if let DataType::Timestamp(unit, _) | DataType::Duration(unit) = of {
        return (stamps(parts, *unit), Some("s".to_owned()));
    }
    let numbers = |fill: fn(&ArrayRef, &mut Vec<f64>)| {
        Held::Numbers(Box::new(move || {
            let mut values = Vec::with_capacity(rows);
            for part in &parts {
                fill(part, &mut values);
            }
            values
        }))
    };
    let held = match of {
        DataType::Float64 => numbers(doubles),
        DataType::Float32 => numbers(|part, to| primitive::<Float32Type>(part, to, f64::from)),
        DataType::Int8 => numbers(|part, to| primitive::<Int8Type>(part, to, f64::from)),
        DataType::Int16 => numbers(|part, to| primitive::<Int16Type>(part, to, f64::from)),
        DataType::Int32 => numbers(|part, to| primitive::<Int32Type>(part, to, f64::from)),
        DataType::Int64 => numbers(|part, to| primitive::<Int64Type>(part, to, |value| value as f64)),
        DataType::UInt8 => numbers(|part, to| primitive::<UInt8Type>(part, to, f64::from)),
        DataType::UInt16 => numbers(|part, to| primitive::<UInt16Type>(part, to, f64::from)),
        DataType::UInt32 => numbers(|part, to| primitive::<UInt32Type>(part, to, f64::from)),
        DataType::UInt64 => numbers(|part, to| primitive::<UInt64Type>(part, to, |value| value as f64)),
        DataType::Boolean => numbers(|part, to| {
            to.extend(part.as_boolean().iter().map(|value| value.map_or(f64::NAN, |value| f64::from(u8::from(value)))));
        }),
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => Held::Other("text"),
        _ => Held::Other("neither numbers nor times"),
    };
    (held, None)
}

fn doubles(part: &ArrayRef, to: &mut Vec<f64>) {
    let part = part.as_primitive::<Float64Type>();
    if part.null_count() == 0 {
        to.extend_from_slice(part.values());
    } else {
        to.extend(part.iter().map(|value| value.unwrap_or(f64::NAN)));
    }
}

fn primitive<T: ArrowPrimitiveType>(part: &ArrayRef, to: &mut Vec<f64>, number: fn(T::Native) -> f64) {
    to.extend(part.as_primitive::<T>().iter().map(|value| value.map_or(f64::NAN, number)));
}

/// Times since the first one, s, as those of Parquet: a double holds no date to the microsecond.
fn stamps(parts: Vec<ArrayRef>, unit: TimeUnit) -> Held<'static> {
    let unit_s = match unit {
        TimeUnit::Second => 1.0,
        TimeUnit::Millisecond => 1e-3,
        TimeUnit::Microsecond => 1e-6,
        TimeUnit::Nanosecond => 1e-9,
    };
    Held::Numbers(Box::new(move || since_first(parts.iter().flat_map(counts).collect(), unit_s)))
}

/// Counts of a unit of time, s, as s since the first one; NaN where there is none.
fn since_first(counts: Vec<Option<i64>>, unit_s: f64) -> Vec<f64> {
    let first = counts.iter().flatten().next().copied().unwrap_or(0);
    // The difference of the integers is exact; the count since 1970 would be rounded.
    let since = |count: Option<i64>| count.map_or(f64::NAN, |count| count.wrapping_sub(first) as f64 * unit_s);
    counts.into_iter().map(since).collect()
}

/// The counts of a column of times, whatever its unit: 64-bit numbers by another name.
fn counts(part: &ArrayRef) -> Vec<Option<i64>> {
    let data = part.to_data();
    let counts = data.buffers().first().map_or(&[][..], |buffer| buffer.typed_data::<i64>());
    let counts = &counts[data.offset()..][..data.len()];
    counts.iter().enumerate().map(|(row, count)| part.is_valid(row).then_some(*count)).collect()
}

/// A column as Python passes it: its name, its unit beside the name, and an array or a sequence.
type Given<'py> = (String, Option<String>, Bound<'py, PyAny>);

/// The recording of named arrays: whatever has the buffer protocol, and sequences of numbers.
#[pyfunction]
pub(crate) fn from_columns<'py>(
    py: Python<'py>,
    columns: Vec<Given<'py>>,
    name: &str,
    machine: Option<Py<Machine>>,
    maps: Vec<String>,
) -> PyResult<Recording> {
    let channels = channels(machine.as_ref().map(Py::get), &maps).or_raise(py)?;
    let column = |(name, unit, values): Given<'py>| {
        if let Some((rows, held)) = of_numpy_times(&values) {
            return ColumnInMemory { name, unit: unit.or_else(|| Some("s".to_owned())), rows, held };
        }
        let (rows, held) = of_object(&values);
        ColumnInMemory { name, unit, rows, held }
    };
    let columns = columns.into_iter().map(column).collect();
    let held = ::recording::Recording::of_columns(name, columns, &channels).or_raise(py)?;
    Ok(Recording::from_memory(held))
}

/// What `numpy` writes where a time is missing (`NaT`).
const NOT_A_TIME: i64 = i64::MIN;

/// The number of times or durations of an array of `numpy`, which has no buffer for them, and what they hold in s since the first one.
fn of_numpy_times<'py>(values: &Bound<'py, PyAny>) -> Option<(usize, Held<'py>)> {
    let dtype = values.getattr("dtype").ok()?;
    let kind: String = dtype.getattr("kind").ok()?.extract().ok()?;
    if !matches!(kind.as_str(), "M" | "m") {
        return None;
    }
    let rows = values.len().ok()?;
    if values.getattr("ndim").ok()?.extract::<usize>().ok()? != 1 {
        return Some((rows, Held::Other(NOT_ONE_DIMENSIONAL)));
    }
    // `<M8[ns]`, `<M8[10ms]`.
    let name: String = dtype.getattr("str").ok()?.extract().ok()?;
    let unit = name.split_once('[').and_then(|(_, unit)| length_s(unit.strip_suffix(']')?));
    let Some(unit_s) = unit else {
        return Some((rows, Held::Other("times in months, years or no unit")));
    };
    let values = values.clone();
    let read = move || {
        let counts = values.call_method1("astype", ("int64",)).ok().and_then(|counts| whole_numbers(&counts));
        let present = |count: i64| (count != NOT_A_TIME).then_some(count);
        since_first(counts.unwrap_or_default().into_iter().map(present).collect(), unit_s)
    };
    Some((rows, Held::Numbers(Box::new(read))))
}

/// The length of one of `numpy`'s units of time, s; none for months and years, whose lengths differ.
fn length_s(unit: &str) -> Option<f64> {
    let at = unit.find(|letter: char| !letter.is_ascii_digit())?;
    let (count, unit) = unit.split_at(at);
    let one_s = match unit {
        "W" => 604_800.0,
        "D" => 86_400.0,
        "h" => 3_600.0,
        "m" => 60.0,
        "s" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "ps" => 1e-12,
        "fs" => 1e-15,
        "as" => 1e-18,
        _ => return None,
    };
    if count.is_empty() { Some(one_s) } else { Some(count.parse::<f64>().ok()? * one_s) }
}

fn whole_numbers(values: &Bound<'_, PyAny>) -> Option<Vec<i64>> {
    PyBuffer::<i64>::get(values).ok()?.to_vec(values.py()).ok()
}

const NOT_ONE_DIMENSIONAL: &str = "an array that is not one-dimensional";

/// The number of values of an array or a sequence, and what it holds.
fn of_object<'py>(values: &Bound<'py, PyAny>) -> (usize, Held<'py>) {
    if let Ok(buffer) = PyUntypedBuffer::get(values) {
        if buffer.dimensions() != 1 {
            return (buffer.item_count(), Held::Other(NOT_ONE_DIMENSIONAL));
        }
        let (rows, py) = (buffer.item_count(), values.py());
        let held = None
            .or_else(|| typed::<f64>(py, &buffer, |value| value))
            .or_else(|| typed::<f32>(py, &buffer, f64::from))
            .or_else(|| typed::<i64>(py, &buffer, |value| value as f64))
            .or_else(|| typed::<i32>(py, &buffer, f64::from))
            .or_else(|| typed::<i16>(py, &buffer, f64::from))
            .or_else(|| typed::<i8>(py, &buffer, f64::from))
            .or_else(|| typed::<u64>(py, &buffer, |value| value as f64))
            .or_else(|| typed::<u32>(py, &buffer, f64::from))
            .or_else(|| typed::<u16>(py, &buffer, f64::from))
            .or_else(|| typed::<u8>(py, &buffer, f64::from));
        return (rows, held.unwrap_or(Held::Other("an array of something else than numbers")));
    }
    match values.extract::<Vec<f64>>() {
        Ok(numbers) => (numbers.len(), Held::Numbers(Box::new(move || numbers.clone()))),
        Err(_) => (values.len().unwrap_or(0), Held::Other("something else than numbers")),
    }
}

/// A buffer of this type of numbers; it is read where it is, when it is asked for.
fn typed<'py, T: Element + 'py>(py: Python<'py>, buffer: &PyUntypedBuffer, number: fn(T) -> f64) -> Option<Held<'py>> {
    let obj = buffer.as_typed::<T>().ok().and_then(|_| buffer.obj(py).cloned())?;
    Some(Held::Numbers(Box::new(move || {
        let Ok(buffer) = PyBuffer::<T>::get(&obj) else { return Vec::new() };
        match buffer.as_slice(py) {
            Some(cells) => cells.iter().map(|cell| number(cell.get())).collect(),
            None => buffer.to_vec(py).unwrap_or_default().into_iter().map(number).collect(),
        }
    })))
}
