//! Writes small logs of the µSD card deck.

use std::fs;
use std::path::{Path, PathBuf};

/// A log of one event type.
pub(crate) struct UsdLog {
    names: Vec<String>,
    rows: Vec<(u64, Vec<f32>)>,
}

impl UsdLog {
    pub(crate) fn new(names: &[&str]) -> Self {
        Self { names: names.iter().map(|name| (*name).to_owned()).collect(), rows: Vec::new() }
    }

    pub(crate) fn row(&mut self, time_s: f64, values: &[f32]) {
        assert_eq!(values.len(), self.names.len());
        self.rows.push(((time_s * 1e6).round() as u64, values.to_vec()));
    }

    /// Gives one row other values.
    pub(crate) fn replace(&mut self, row: usize, values: &[f32]) {
        self.rows[row].1.copy_from_slice(values);
    }

    /// The same log with these variables alone.
    pub(crate) fn only(&self, keeps: impl Fn(&str) -> bool) -> Self {
        let places: Vec<usize> =
            (0..self.names.len()).filter(|place| keeps(&self.names[*place])).collect();
        let row = |(time, values): &(u64, Vec<f32>)| {
            (*time, places.iter().map(|place| values[*place]).collect())
        };
        Self {
            names: places.iter().map(|place| self.names[*place].clone()).collect(),
            rows: self.rows.iter().map(row).collect(),
        }
    }

    /// The file, in version 2 of the format.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0xBC, 2, 0, 1, 0, 7, 0];
        bytes.extend(b"fixedFrequency\0");
        bytes.extend((self.names.len() as u16).to_le_bytes());
        for name in &self.names {
            bytes.extend(name.as_bytes());
            bytes.extend(b"(f)\0");
        }
        for (time, values) in &self.rows {
            bytes.extend(7_u16.to_le_bytes());
            bytes.extend(time.to_le_bytes());
            bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        let checksum = crc32fast::hash(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    pub(crate) fn write(&self, name: &str) -> PathBuf {
        write(name, &self.bytes())
    }
}

/// A file of this test's own.
pub(crate) fn write(name: &str, bytes: &[u8]) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("flights").join(name);
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(&file, bytes).unwrap();
    file
}
