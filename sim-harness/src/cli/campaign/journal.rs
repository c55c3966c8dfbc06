//! The rows of a campaign under way, in a file beside its folder of results, from which it goes on when
//! it was stopped.
//!
//! The first line names the campaign. Each line after it is a row behind its CRC-32; the last line
//! of a campaign that was killed may be cut short, and is flown again.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use input::InputError;

use super::Campaign;
use measure::campaign::Row;

/// The ending that makes the name of the file out of the folder's.
const ENDING: &str = ".rows";

pub(super) struct Journal {
    path: PathBuf,
    out: Mutex<Out>,
    /// The rows that an earlier command has written, in the order of the missions.
    rows: Vec<Row>,
}

struct Out {
    file: File,
    /// Why a row could not be written.
    failed: Option<io::Error>,
}

impl Journal {
    /// Opens the file of a campaign, which begins or goes on.
    pub(super) fn open(out: &Path, campaign: &Campaign, resume: bool) -> Result<Self, InputError> {
        let path = path_beside(out);
        let title = format!("# uchain campaign {} {}\n", campaign.crc32, campaign.shard);
        let former = match fs::read(&path) {
            Ok(bytes) => Some(String::from_utf8_lossy(&bytes).into_owned()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(unwritable(&path, &error)),
        };
        let (rows, kept) = match (former, resume) {
            (None, _) => (Vec::new(), 0),
            (Some(text), true) => read(&path, &text, &title, campaign)?,
            (Some(_), false) => {
                let wrong = "these are the rows of a campaign that was stopped";
                let remedy = "add --resume to go on with it, or remove the file";
                return Err(InputError::new(wrong, remedy).in_file(&path));
            }
        };
        let begun = begin(&path, &title, kept).map_err(|error| unwritable(&path, &error))?;
        Ok(Self { path, out: Mutex::new(Out { file: begun, failed: None }), rows })
    }

    /// The rows that an earlier command has written, in the order of the missions.
    pub(super) fn take_rows(&mut self) -> Vec<Row> {
        std::mem::take(&mut self.rows)
    }

    /// Adds a row; returns whether it could be written.
    pub(super) fn add(&self, row: &Row) -> bool {
        let fields = [row.point.to_string(), row.seed.to_string()];
        let text = fields.into_iter().chain(row.texts()).collect::<Vec<_>>().join(",");
        let line = format!("{:08x} {text}\n", crc32fast::hash(text.as_bytes()));
        let mut out = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        if out.failed.is_none() {
            out.failed = out.file.write_all(line.as_bytes()).err();
        }
        out.failed.is_none()
    }

    /// Makes sure that every row could be written.
    pub(super) fn is_written(&self) -> Result<(), InputError> {
        let out = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        out.failed.as_ref().map_or(Ok(()), |error| Err(unwritable(&self.path, error)))
    }

    /// Removes the file of a campaign that is complete.
    pub(super) fn remove(self) -> Result<(), InputError> {
        fs::remove_file(&self.path).map_err(|error| unwritable(&self.path, &error))
    }
}

/// The path of the file beside a folder; it is in one without a name, such as the working directory.
fn path_beside(out: &Path) -> PathBuf {
    // Without a separator at the end.
    let mut path = out.components().as_path().as_os_str().to_owned();
    if out.file_name().is_none() {
        path.push("/campaign");
    }
    path.push(ENDING);
    PathBuf::from(path)
}

/// Opens the file behind so many bytes of it.
fn begin(path: &Path, title: &str, kept: usize) -> io::Result<File> {
    if let Some(above) = path.parent() {
        fs::create_dir_all(above)?;
    }
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    file.set_len(kept as u64)?;
    if kept == 0 {
        file.write_all(title.as_bytes())?;
    }
    Ok(file)
}

/// Reads the rows of before; returns them with the number of bytes that hold them.
fn read(
    path: &Path,
    text: &str,
    title: &str,
    campaign: &Campaign,
) -> Result<(Vec<Row>, usize), InputError> {
    // A line that was cut short is the last one, and is flown again.
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let mut lines = text[..whole].lines();
    match lines.next() {
        None => return Ok((Vec::new(), 0)),
        Some(line) if line == title.trim_end() => {}
        Some(_) => {
            let wrong = "these are the rows of another campaign, or of another part of it";
            let remedy = "give the options of that campaign, or remove the file";
            return Err(InputError::new(wrong, remedy).in_file(path));
        }
    }
    let mut rows = Vec::new();
    for (n, line) in lines.enumerate() {
        let row = line_of(line, campaign).ok_or_else(|| {
            let remedy = "remove the line, and its mission is flown again";
            InputError::new("this row is damaged", remedy).at_line(path, n + 2)
        })?;
        rows.push(row);
    }
    rows.sort_by_key(|row| (row.point, row.seed));
    rows.dedup_by_key(|row| (row.point, row.seed));
    Ok((rows, whole))
}

fn line_of(line: &str, campaign: &Campaign) -> Option<Row> {
    let (crc, text) = line.split_once(' ')?;
    if u32::from_str_radix(crc, 16).ok()? != crc32fast::hash(text.as_bytes()) {
        return None;
    }
    let fields: Vec<&str> = text.split(',').collect();
    let [point, seed, values @ ..] = fields.as_slice() else { return None };
    let point: usize = point.parse().ok().filter(|point| *point < campaign.points.len())?;
    Row::read(point, seed.parse().ok()?, values.iter().copied())
}

fn unwritable(path: &Path, error: &io::Error) -> InputError {
    let wrong = format!("the rows of the campaign cannot be kept here: {error}");
    let remedy = "make room on the disk or give --out another folder; --resume goes on from here";
    InputError::new(wrong, remedy).in_file(path)
}
