//! Reads a comma-separated table by the names in its first row.
//!
//! Each line is read by itself: a quote that is never closed spoils its own row and no other, and
//! the line numbers are the file's.

use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Trim};

use super::lines;
use crate::input_error::InputError;

/// A table whose named columns have been found.
pub(super) struct Table<'a, const N: usize> {
    rows: Box<dyn Iterator<Item = (usize, String)> + 'a>,
    columns: [Option<usize>; N],
    width: usize,
}

/// One row of it.
pub(super) struct Row<const N: usize> {
    /// The number of the line; the first line of the file is 1.
    pub(super) line: usize,
    /// The fields of the named columns, each `None` where the table has no such column.
    pub(super) fields: [Option<String>; N],
    /// Whether it has as many fields as the first row.
    pub(super) whole: bool,
}

impl<'a, const N: usize> Table<'a, N> {
    /// Finds the columns of these names, in any order and among any others. The first `required`
    /// must be there.
    pub(super) fn open(
        bytes: &'a [u8],
        file: &Path,
        names: [&str; N],
        required: usize,
    ) -> Result<Self, InputError> {
        let mut rows = lines(bytes);
        let (line, header) = rows.next().unwrap_or((1, String::new()));
        // Some tables are saved with a byte order mark.
        let found = cells(header.trim_start_matches('\u{feff}'));
        let columns =
            names.map(|name| found.iter().position(|found| found.eq_ignore_ascii_case(name)));
        if let Some((name, _)) =
            names.iter().zip(columns).take(required).find(|(_, column)| column.is_none())
        {
            return Err(InputError::new(
                format!("the first row does not name a column {name:?}"),
                format!("name at least {}", names.get(..required).unwrap_or(&names).join(", ")),
            )
            .at_line(file, line));
        }
        Ok(Self { rows: Box::new(rows), columns, width: found.len() })
    }
}

impl<const N: usize> Iterator for Table<'_, N> {
    type Item = Row<N>;

    fn next(&mut self) -> Option<Row<N>> {
        let (line, row) = self.rows.next()?;
        let mut cells: Vec<Option<String>> = cells(&row).into_iter().map(Some).collect();
        let whole = cells.len() == self.width;
        let fields = self.columns.map(|column| cells.get_mut(column?)?.take());
        Some(Row { line, fields, whole })
    }
}

fn cells(row: &str) -> Vec<String> {
    let mut record = ByteRecord::new();
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .trim(Trim::All)
        .buffer_capacity(row.len().max(1))
        .from_reader(row.as_bytes());
    // Bytes in memory cannot fail to be read; if they did, the row would have no cells.
    let read = reader.read_byte_record(&mut record).unwrap_or(false);
    let cell = |cell: &[u8]| String::from_utf8_lossy(cell).into_owned();
    if read { record.iter().map(cell).collect() } else { Vec::new() }
}
