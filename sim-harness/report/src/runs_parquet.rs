//! Writes the runs of a campaign as a Parquet file, which pandas, Polars and DuckDB read.
//!
//! The columns are those of `runs.csv`: the varied keys, the seed, and [`COLUMNS`]. A value that there is
//! none of is null. Rows wait in memory until a row group is full, so that the memory does not grow with
//! their number; and the groups depend on the rows alone, so that equal campaigns give equal bytes.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use toml::Value as Toml;

use measure::campaign::grid::Axis;
use measure::campaign::{COLUMNS, Cell, Kind, Row};
use scenario::Setting;

/// The rows of a row group.
const GROUP: usize = 8_192;

/// The file, while rows are added.
pub struct RunsParquet<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    keys: Vec<KeyKind>,
    /// The cells of each column of the rows that wait.
    columns: Vec<Vec<Value>>,
}

/// What the values of a varied key are.
#[derive(Clone, Copy)]
enum KeyKind {
    Whole,
    Number,
    Flag,
    Text,
}

enum Value {
    None,
    Flag(bool),
    Text(String),
    Single(f32),
    Double(f64),
    Count(u32),
    Whole(i64),
}

impl<W: Write + Send> RunsParquet<W> {
    /// Begins the file of a campaign with these keys varied.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(out: W, axes: &[Axis]) -> io::Result<Self> {
        let keys: Vec<KeyKind> = axes.iter().map(KeyKind::of).collect();
        let mut fields = Vec::new();
        for (axis, kind) in axes.iter().zip(&keys) {
            fields.push(kind.field(axis.key())?);
        }
        fields.push(field("seed", Physical::INT64, Some(unsigned(64)))?);
        for column in COLUMNS.iter() {
            let (physical, logical) = match column.kind {
                Kind::Flag => (Physical::BOOLEAN, None),
                Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
                Kind::Number => (Physical::FLOAT, None),
                Kind::Count => (Physical::INT32, Some(unsigned(32))),
            };
            fields.push(field(column.name, physical, logical)?);
        }
        let columns = fields.iter().map(|_| Vec::with_capacity(GROUP)).collect();
        let schema = Type::group_type_builder("runs").with_fields(fields).build().map_err(as_io)?;
        let properties = Arc::new(WriterProperties::builder().build());
        let writer = SerializedFileWriter::new(out, Arc::new(schema), properties).map_err(as_io)?;
        Ok(Self { writer, keys, columns })
    }

    /// Adds a row, of the place of the grid with these settings.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, settings: &[Setting], row: &Row) -> io::Result<()> {
        let keys = self.keys.iter().zip(settings).map(|(kind, it)| kind.value(it.value()));
        // Parquet keeps a number without a sign as the bits of one with it.
        let seed = Value::Whole(i64::from_ne_bytes(row.seed.to_ne_bytes()));
        let cells = COLUMNS.iter().map(|column| Value::of(column.cell(row)));
        let values = keys.chain([seed]).chain(cells);
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        match self.columns.first().is_some_and(|column| column.len() == GROUP) {
            true => self.end_group(),
            false => Ok(()),
        }
    }

    /// Ends the file, and returns what it was written to.
    ///
    /// # Errors
    /// If the rest of it cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        if self.columns.first().is_some_and(|column| !column.is_empty()) {
            self.end_group()?;
        }
        self.writer.into_inner().map_err(as_io)
    }

    fn end_group(&mut self) -> io::Result<()> {
        let mut group = self.writer.next_row_group().map_err(as_io)?;
        for values in &mut self.columns {
            if let Some(mut column) = group.next_column().map_err(as_io)? {
                write(column.untyped(), values).map_err(as_io)?;
                column.close().map_err(as_io)?;
            }
            values.clear();
        }
        group.close().map(|_| ()).map_err(as_io)
    }
}

fn unsigned(bit_width: i8) -> LogicalType {
    LogicalType::Integer { bit_width, is_signed: false }
}

fn field(name: &str, physical: Physical, logical: Option<LogicalType>) -> io::Result<Arc<Type>> {
    let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
    field.with_logical_type(logical).build().map(Arc::new).map_err(as_io)
}

impl KeyKind {
    /// The narrowest kind that has all values of the key.
    fn of(axis: &Axis) -> Self {
        let all = |is: fn(&Toml) -> bool| axis.values().iter().all(is);
        if all(Toml::is_integer) {
            Self::Whole
        } else if all(|value| value.is_integer() || value.is_float()) {
            Self::Number
        } else if all(Toml::is_bool) {
            Self::Flag
        } else {
            Self::Text
        }
    }

    fn field(self, name: &str) -> io::Result<Arc<Type>> {
        match self {
            Self::Whole => field(name, Physical::INT64, None),
            Self::Number => field(name, Physical::DOUBLE, None),
            Self::Flag => field(name, Physical::BOOLEAN, None),
            Self::Text => field(name, Physical::BYTE_ARRAY, Some(LogicalType::String)),
        }
    }

    fn value(self, value: &Toml) -> Value {
        let number = || value.as_float().or(value.as_integer().map(|whole| whole as f64));
        let found = match self {
            Self::Whole => value.as_integer().map(Value::Whole),
            Self::Number => number().map(Value::Double),
            Self::Flag => value.as_bool().map(Value::Flag),
            Self::Text => {
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                Some(Value::Text(text))
            }
        };
        found.unwrap_or(Value::None)
    }
}

impl Value {
    fn of(cell: Cell) -> Self {
        match cell {
            Cell::None => Self::None,
            Cell::Flag(flag) => Self::Flag(flag),
            Cell::Text(text) => Self::Text(text),
            Cell::Number(number) => Self::Single(number),
            Cell::Count(count) => Self::Count(count),
        }
    }
}

/// Writes one column of a group: its values, and which of the rows have one.
fn write(writer: &mut ColumnWriter<'_>, values: &[Value]) -> Result<(), ParquetError> {
    let has: Vec<i16> = values.iter().map(|it| i16::from(!matches!(it, Value::None))).collect();
    macro_rules! write {
        ($writer:expr, $of:pat => $value:expr) => {{
            let values =
                values.iter().filter_map(|it| if let $of = it { Some($value) } else { None });
            $writer.write_batch(&values.collect::<Vec<_>>(), Some(&has), None)
        }};
    }
    let written = match writer {
        ColumnWriter::BoolColumnWriter(out) => write!(out, Value::Flag(flag) => *flag),
        ColumnWriter::FloatColumnWriter(out) => write!(out, Value::Single(number) => *number),
        ColumnWriter::DoubleColumnWriter(out) => write!(out, Value::Double(number) => *number),
        ColumnWriter::Int64ColumnWriter(out) => write!(out, Value::Whole(whole) => *whole),
        ColumnWriter::Int32ColumnWriter(out) => {
            write!(out, Value::Count(count) => i32::from_ne_bytes(count.to_ne_bytes()))
        }
        ColumnWriter::ByteArrayColumnWriter(out) => {
            write!(out, Value::Text(text) => ByteArray::from(text.as_str()))
        }
        _ => return Ok(()),
    };
    written.map(|_| ())
}

fn as_io(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        other => io::Error::other(other),
    }
}
