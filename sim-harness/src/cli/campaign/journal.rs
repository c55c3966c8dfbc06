//! The rows of a campaign under way, in a file beside its folder of results, from which it goes on when
//! it was stopped.
//!
//! The first line names the campaign. Each line after it is a row behind its CRC-32; the last line
//! of a campaign that was killed may be cut short, and is flown again.
//!
//! Missions are flown in chunks one after the other, so the rows of one chunk stand together. A campaign
//! that goes on reads them chunk by chunk; a row that stands elsewhere is flown again.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Write};
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
    /// The bytes that an earlier command has written.
    former: u64,
}

/// The rows that an earlier command has written.
pub(super) struct Former<'a> {
    campaign: &'a Campaign,
    lines: Lines,
    /// The row that was read and belongs to a later chunk, behind the number of its mission.
    next: Option<(usize, Row)>,
}

/// The lines of a file up to the end of its last whole line.
struct Lines {
    path: PathBuf,
    reader: BufReader<io::Take<File>>,
    line: Vec<u8>,
    number: usize,
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
        let former = match File::open(&path) {
            Ok(file) => Some(file),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(unwritable(&path, &error)),
        };
        let former = match (former, resume) {
            (None, _) => 0,
            (Some(file), true) => check(Lines::of(&path, file, u64::MAX), &title, campaign)?,
            (Some(_), false) => {
                let wrong = "these are the rows of a campaign that was stopped";
                let remedy = "add --resume to go on with it, or remove the file";
                return Err(InputError::new(wrong, remedy).in_file(&path));
            }
        };
        let begun = begin(&path, &title, former).map_err(|error| unwritable(&path, &error))?;
        Ok(Self { path, out: Mutex::new(Out { file: begun, failed: None }), former })
    }

    /// The rows that an earlier command has written.
    pub(super) fn rows<'a>(&self, campaign: &'a Campaign) -> Result<Former<'a>, InputError> {
        let file = File::open(&self.path).map_err(|error| unwritable(&self.path, &error))?;
        let mut lines = Lines::of(&self.path, file, self.former);
        // The title.
        lines.next()?;
        Ok(Former { campaign, lines, next: None })
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
fn begin(path: &Path, title: &str, kept: u64) -> io::Result<File> {
    if let Some(above) = path.parent() {
        fs::create_dir_all(above)?;
    }
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    file.set_len(kept)?;
    if kept == 0 {
        file.write_all(title.as_bytes())?;
    }
    Ok(file)
}

/// Makes sure that the rows of before are whole and of this campaign; returns the number of bytes that
/// hold them.
fn check(mut lines: Lines, title: &str, campaign: &Campaign) -> Result<u64, InputError> {
    let Some(first) = lines.next()? else { return Ok(0) };
    if first != title.trim_end() {
        let wrong = "these are the rows of another campaign, or of another part of it";
        let remedy = "give the options of that campaign, or remove the file";
        return Err(InputError::new(wrong, remedy).in_file(&lines.path));
    }
    let mut whole = title.len() as u64;
    while let Some(bytes) = lines.next_row(campaign)?.map(|_| lines.line.len()) {
        whole += bytes as u64;
    }
    Ok(whole)
}

impl Former<'_> {
    /// The rows of this chunk of the missions at a place, in the order of the seeds.
    pub(super) fn of(&mut self, point: usize, chunk: &[u64]) -> Result<Vec<Row>, InputError> {
        let mut rows = Vec::new();
        let Some((first, last)) = chunk.first().zip(chunk.last()) else { return Ok(rows) };
        let [first, last] = [first, last].map(|seed| self.campaign.number(point, *seed));
        loop {
            let read = match self.next.take() {
                Some(row) => Some(row),
                None => self.lines.next_row(self.campaign)?,
            };
            match read {
                None => break,
                Some((number, row)) if number > last => {
                    self.next = Some((number, row));
                    break;
                }
                Some((number, row)) if number >= first => rows.push(row),
                Some(_) => {}
            }
        }
        rows.sort_by_key(|row| row.seed);
        rows.dedup_by_key(|row| row.seed);
        Ok(rows)
    }
}

impl Lines {
    fn of(path: &Path, file: File, bytes: u64) -> Self {
        let reader = BufReader::new(file.take(bytes));
        Self { path: path.to_owned(), reader, line: Vec::new(), number: 0 }
    }

    /// The next whole line. A line that was cut short is the last one, and is flown again.
    fn next(&mut self) -> Result<Option<String>, InputError> {
        self.line.clear();
        self.number += 1;
        let read = self.reader.read_until(b'\n', &mut self.line);
        read.map_err(|error| unwritable(&self.path, &error))?;
        let whole = self.line.strip_suffix(b"\n");
        Ok(whole.map(|line| String::from_utf8_lossy(line).into_owned()))
    }

    /// The next row, behind the number of its mission.
    fn next_row(&mut self, campaign: &Campaign) -> Result<Option<(usize, Row)>, InputError> {
        let Some(line) = self.next()? else { return Ok(None) };
        let row = line_of(&line, campaign).ok_or_else(|| {
            let remedy = "remove the line, and its mission is flown again";
            InputError::new("this row is damaged", remedy).at_line(&self.path, self.number)
        })?;
        Ok(Some((campaign.number(row.point, row.seed), row)))
    }
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
