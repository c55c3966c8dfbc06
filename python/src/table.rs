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
use pyo3::types::{PyCapsule, PyDict, PyIterator, PyList};

/// A table with named columns.
#[pyclass(frozen, module = "uchain")]
pub(crate) struct Table {
    schema: Arc<Schema>,
    /// The rows, in pieces with the columns of the schema.
    batches: Vec<RecordBatch>,
}

/// Makes a piece of a table of columns of one length.
pub(crate) fn batch(columns: Vec<(String, ArrayRef)>) -> PyResult<RecordBatch> {
    let fields =
        columns.iter().map(|(name, array)| Field::new(name, array.data_type().clone(), true));
    let schema = Arc::new(Schema::new(fields.collect::<Vec<_>>()));
    let arrays = columns.into_iter().map(|(_, array)| array).collect();
    let batch = RecordBatch::try_new(schema, arrays);
    batch.map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

impl Table {
    /// Makes a table of columns of one length.
    pub(crate) fn new(columns: Vec<(String, ArrayRef)>) -> PyResult<Self> {
        Self::of(vec![batch(columns)?])
    }

    /// Makes a table of pieces with the same columns, of which there is at least one.
    pub(crate) fn of(batches: Vec<RecordBatch>) -> PyResult<Self> {
        match batches.first() {
            Some(first) => Ok(Self { schema: first.schema(), batches }),
            None => Err(PyRuntimeError::new_err("a table of no columns: this is a defect")),
        }
    }

    fn list<'py>(&self, py: Python<'py>, column: usize) -> PyResult<Bound<'py, PyList>> {
        macro_rules! list {
            ($kind:ty) => {{
                let arrays = self.batches.iter().map(|batch| batch.column(column).as_any());
                let arrays = arrays.filter_map(|array| array.downcast_ref::<$kind>());
                PyList::new(py, arrays.flat_map(|array| array.iter()).collect::<Vec<_>>())
            }};
        }
        match self.schema.field(column).data_type() {
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
        let batches = self.batches.clone().into_iter().map(Ok);
        let batches = RecordBatchIterator::new(batches, self.schema.clone());
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new(py, stream, Some(c"arrow_array_stream".to_owned()))
    }

    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyList>> {
        match self.schema.index_of(name) {
            Ok(column) => self.list(py, column),
            Err(_) => Err(PyKeyError::new_err(name.to_owned())),
        }
    }

    /// The names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    /// The columns as lists by name; `None` stands where there is no value.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (column, field) in self.schema.fields().iter().enumerate() {
            dict.set_item(field.name(), self.list(py, column)?)?;
        }
        Ok(dict)
    }

    /// The table of the first rows.
    #[pyo3(signature = (rows = 5))]
    fn head(&self, rows: usize) -> Self {
        let mut left = rows;
        let mut batches = Vec::new();
        for batch in &self.batches {
            let taken = batch.slice(0, left.min(batch.num_rows()));
            left -= taken.num_rows();
            batches.push(taken);
        }
        Self { schema: Arc::clone(&self.schema), batches }
    }

    /// The names of the columns that have no value in any row.
    #[getter]
    fn empty_columns(&self) -> Vec<String> {
        let is_empty = |n: usize| {
            self.batches.iter().all(|batch| batch.column(n).null_count() == batch.num_rows())
        };
        let fields = self.schema.fields().iter().enumerate();
        fields.filter(|(n, _)| is_empty(*n)).map(|(_, field)| field.name().clone()).collect()
    }

    /// What a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("uchain.notebook")?.call_method1("table_html", (slf,))
    }

    /// The rows, one after the other, as dicts by the names of the columns.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let names = self.column_names();
        let columns = (0..names.len()).map(|column| self.list(py, column));
        let columns = columns.collect::<PyResult<Vec<_>>>()?;
        let rows = (0..self.__len__()).map(|row| {
            let dict = PyDict::new(py);
            for (name, column) in names.iter().zip(&columns) {
                dict.set_item(name, column.get_item(row)?)?;
            }
            Ok(dict)
        });
        PyList::new(py, rows.collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    fn __repr__(&self) -> String {
        let (rows, columns) = (self.__len__(), self.schema.fields().len());
        format!("<uchain.Table of {rows} rows and {columns} columns>")
    }
}
