//! Tables that other libraries read without copying, by the Arrow PyCapsule interface.

use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    Array, ArrayRef, BooleanArray, Float32Array, Float64Array, Int64Array, RecordBatch,
    RecordBatchIterator, StringArray, UInt32Array, UInt64Array,
};
use arrow_schema::{DataType, Field, Schema};
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList};

/// A table with named columns.
#[pyclass(frozen, module = "uchain")]
pub(crate) struct Table {
    batch: RecordBatch,
}

impl Table {
    /// Makes a table of columns of one length.
    pub(crate) fn new(columns: Vec<(String, ArrayRef)>) -> PyResult<Self> {
        let fields =
            columns.iter().map(|(name, array)| Field::new(name, array.data_type().clone(), true));
        let schema = Arc::new(Schema::new(fields.collect::<Vec<_>>()));
        let arrays = columns.into_iter().map(|(_, array)| array).collect();
        let batch = RecordBatch::try_new(schema, arrays);
        Ok(Self { batch: batch.map_err(|error| PyRuntimeError::new_err(error.to_string()))? })
    }

    fn list<'py>(&self, py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyList>> {
        macro_rules! list {
            ($kind:ty) => {
                match array.as_any().downcast_ref::<$kind>() {
                    Some(array) => PyList::new(py, array.iter().collect::<Vec<_>>()),
                    None => PyList::new(py, Vec::<Option<f64>>::new()),
                }
            };
        }
        match array.data_type() {
            DataType::Boolean => list!(BooleanArray),
            DataType::Float32 => list!(Float32Array),
            DataType::Float64 => list!(Float64Array),
            DataType::Int64 => list!(Int64Array),
            DataType::UInt32 => list!(UInt32Array),
            DataType::UInt64 => list!(UInt64Array),
            _ => list!(StringArray),
        }
    }
}

#[pymethods]
impl Table {
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A consumer that asks for other types has to convert these itself, as the interface allows.
        let _ = requested_schema;
        let schema = self.batch.schema();
        let batches = RecordBatchIterator::new([Ok(self.batch.clone())], schema);
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new(py, stream, Some(c"arrow_array_stream".to_owned()))
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyList>> {
        match self.batch.column_by_name(name) {
            Some(array) => self.list(py, array),
            None => Err(PyKeyError::new_err(name.to_owned())),
        }
    }

    /// The names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.batch.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    /// The columns as lists by name; `None` stands where there is no value.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (field, array) in self.batch.schema().fields().iter().zip(self.batch.columns()) {
            dict.set_item(field.name(), self.list(py, array)?)?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        let (rows, columns) = (self.batch.num_rows(), self.batch.num_columns());
        format!("<uchain.Table of {rows} rows and {columns} columns>")
    }
}
