//! A table of numbers, which any program that knows Arrow takes without a copy.

use std::sync::Arc;

use ::recording::WrittenColumn;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, RecordBatchIterator};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule};

/// Columns of equal length under their headers.
#[pyclass(frozen, module = "host_sim._native", skip_from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Table {
    schema: SchemaRef,
    columns: Vec<ArrayRef>,
}

impl Table {
    pub(crate) fn of(columns: impl IntoIterator<Item = WrittenColumn>) -> Self {
        let (fields, columns): (Vec<Field>, Vec<ArrayRef>) = columns
            .into_iter()
            .map(|(header, values)| {
                let is_blank = values.iter().any(Option::is_none);
                let array: ArrayRef = if is_blank {
                    Arc::new(Float64Array::from(values))
                } else {
                    Arc::new(Float64Array::from_iter_values(values.into_iter().flatten()))
                };
                (Field::new(header, DataType::Float64, true), array)
            })
            .unzip();
        Self { schema: Arc::new(Schema::new(fields)), columns }
    }
}

/// Doubles as Python's bytes, which `numpy` reads in place.
pub(crate) fn bytes_of<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    PyBytes::new(py, &bytes)
}

#[pymethods]
impl Table {
    #[getter]
    fn headers(&self) -> Vec<&str> {
        self.schema.fields().iter().map(|field| field.name().as_str()).collect()
    }

    /// A column as the bytes of doubles; NaN where a cell is blank.
    fn column<'py>(&self, py: Python<'py>, header: &str) -> PyResult<Bound<'py, PyBytes>> {
        let column = self.schema.index_of(header).ok().map(|index| &self.columns[index]);
        let column = column.and_then(|column| column.as_any().downcast_ref::<Float64Array>());
        let column = column.ok_or_else(|| PyKeyError::new_err(header.to_owned()))?;
        if column.null_count() == 0 {
            return Ok(bytes_of(py, column.values()));
        }
        Ok(bytes_of(py, &column.iter().map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<_>>()))
    }

    /// A column; None where a cell is blank.
    fn cells(&self, header: &str) -> PyResult<Vec<Option<f64>>> {
        let column = self.schema.index_of(header).ok().map(|index| &self.columns[index]);
        let column = column.and_then(|column| column.as_any().downcast_ref::<Float64Array>());
        column.map(|column| column.iter().collect()).ok_or_else(|| PyKeyError::new_err(header.to_owned()))
    }

    /// Arrow's capsule of a stream; no number is copied.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A wish that a producer need not fulfil: these are doubles.
        drop(requested_schema);
        let failed = |error: ArrowError| PyRuntimeError::new_err(error.to_string());
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), self.columns.clone()).map_err(failed)?;
        let batches = RecordBatchIterator::new([Ok(batch)], Arc::clone(&self.schema));
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), c"arrow_array_stream")
    }
}
