//! Reads a table by the names in its first row. Fields are separated by commas, semicolons, tabs or
//! vertical bars, as the first row shows.
//!
//! Each line is read by itself: a quote that is never closed spoils its own row and no other, and
//! the line numbers are the file's. Comments, lines that begin with `#`, and the line `sep=;` with
//! which Excel names a separator are passed over.

use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};
use input::InputError;

use super::{number, untrimmed_lines};
use crate::recording::{Recorder, Wrong};

/// The separators of fields.
const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b'|'];

/// The names in the first row of a table.
pub(super) struct Header {
    line: usize,
    separator: u8,
    names: Vec<String>,
}

impl Header {
    /// The first of these rows that is no comment, split by the separator that makes the most
    /// fields of it.
    pub(super) fn of(rows: impl IntoIterator<Item = (usize, String)>) -> Option<Self> {
        let (line, row) = rows.into_iter().find(|(_, row)| !is_comment(row))?;
        // Some tables are saved with a byte order mark.
        let row = row.trim_start_matches('\u{feff}');
        let split = SEPARATORS.map(|separator| (separator, cells(row, separator)));
        let (separator, names) = split.into_iter().rev().max_by_key(|(_, names)| names.len())?;
        Some(Self { line, separator, names })
    }

    /// The place of a column among the others.
    fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|found| found.eq_ignore_ascii_case(name))
    }

    /// How many of these columns it names.
    pub(super) fn named(&self, names: &[&str]) -> usize {
        names.iter().filter(|name| self.column(name).is_some()).count()
    }
}

/// Whether a line is no row of the table.
fn is_comment(row: &str) -> bool {
    let row = row.trim_start_matches('\u{feff}').trim_start();
    row.starts_with('#') || row.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("sep="))
}

/// A table whose named columns have been found.
pub(super) struct Table<'a, const N: usize> {
    rows: Box<dyn Iterator<Item = (usize, String)> + 'a>,
    names: [&'a str; N],
    columns: [Option<usize>; N],
    separator: u8,
    width: usize,
}

/// One row of it.
pub(super) struct Row<const N: usize> {
    /// The number of the line; the first line of the file is 1.
    pub(super) line: usize,
    /// The fields of the named columns, each `None` where the table has no such column.
    pub(super) fields: [Option<String>; N],
    /// Whether it has as many fields as the first row.
    pub(super) is_whole: bool,
    /// The number of its fields.
    pub(super) width: usize,
}

impl<'a, const N: usize> Table<'a, N> {
    /// Finds the columns of these names, in any order and among any others. The first `required`
    /// must be there.
    pub(super) fn open(
        bytes: &'a [u8],
        file: &Path,
        names: [&'a str; N],
        required: usize,
    ) -> Result<Self, InputError> {
        let header = Header::of(untrimmed_lines(bytes)).unwrap_or(Header {
            line: 1,
            separator: b',',
            names: Vec::new(),
        });
        let columns = names.map(|name| header.column(name));
        if let Some((name, _)) =
            names.iter().zip(columns).take(required).find(|(_, column)| column.is_none())
        {
            return Err(InputError::new(
                format!("the first row does not name a column {name:?}"),
                format!("name at least {}", names.get(..required).unwrap_or(&names).join(", ")),
            )
            .at_line(file, header.line));
        }
        let Header { line: first, separator, names: found } = header;
        let rows =
            untrimmed_lines(bytes).filter(move |(line, row)| *line > first && !is_comment(row));
        Ok(Self { rows: Box::new(rows), names, columns, separator, width: found.len() })
    }

    /// Parses a finite number. Where fields are not separated by commas, a number may have one for
    /// its point, as spreadsheets of many countries write it.
    pub(super) fn number(&self, text: &str) -> Option<f64> {
        let has_comma = self.separator != b',' && !text.contains('.');
        number(text).or_else(|| number(&text.replacen(',', ".", 1)).filter(|_| has_comma))
    }

    /// Says what was found of the table that is not as the book has it.
    pub(super) fn remark(&self, recorder: &mut Recorder) {
        match self.separator {
            b';' => recorder.note("its fields are separated by semicolons"),
            b'\t' => recorder.note("its fields are separated by tabs"),
            b'|' => recorder.note("its fields are separated by vertical bars"),
            _ => {}
        }
    }

    /// What is wrong with a row: its length, or a field that is missing.
    pub(super) fn incomplete(&self, row: &Row<N>) -> Wrong {
        let missing = self.names.iter().zip(&row.fields).zip(self.columns);
        let empty = |field: &Option<String>| field.as_deref().is_none_or(str::is_empty);
        match missing.into_iter().find(|((_, field), column)| column.is_some() && empty(field)) {
            Some(((name, _), column)) if row.is_whole => {
                Wrong { field: column, separator: self.separator, what: format!("{name} is empty") }
            }
            _ => {
                let Row { width, .. } = row;
                let what = format!("it has {width} fields where the first row has {}", self.width);
                Wrong { field: None, separator: self.separator, what }
            }
        }
    }

    /// What is wrong with a field: its name and text, and what it should be.
    pub(super) fn wrong(&self, field: usize, text: &str, should: &str) -> Wrong {
        let name = self.names.get(field).copied().unwrap_or_default();
        Wrong {
            field: self.columns.get(field).copied().flatten(),
            separator: self.separator,
            what: format!("{name} = {text:?} is no {should}"),
        }
    }
}

/// The column of a row at which a field begins, counted in characters from 1.
pub(super) fn column_of(row: &str, separator: u8, field: usize) -> usize {
    let (mut quoted, mut passed) = (false, 0);
    for (before, character) in row.chars().enumerate() {
        if passed == field {
            return before + 1;
        }
        quoted ^= character == '"';
        passed += usize::from(!quoted && character == char::from(separator));
    }
    row.chars().count() + 1
}

impl<const N: usize> Iterator for Table<'_, N> {
    type Item = Row<N>;

    fn next(&mut self) -> Option<Row<N>> {
        let (line, row) = self.rows.next()?;
        let mut cells: Vec<Option<String>> =
            cells(&row, self.separator).into_iter().map(Some).collect();
        let width = cells.len();
        let fields = self.columns.map(|column| cells.get_mut(column?)?.take());
        Some(Row { line, fields, is_whole: width == self.width, width })
    }
}

fn cells(row: &str, separator: u8) -> Vec<String> {
    let mut record = ByteRecord::new();
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .delimiter(separator)
        .trim(Trim::All)
        .buffer_capacity(row.len().max(1))
        .from_reader(row.as_bytes());
    // Bytes in memory cannot fail to be read; if they did, the row would have no cells.
    let read = reader.read_byte_record(&mut record).unwrap_or(false);
    let cell = |cell: &[u8]| String::from_utf8_lossy(cell).into_owned();
    if read { record.iter().map(cell).collect() } else { Vec::new() }
}
