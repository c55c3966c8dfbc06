//! The log formats: recognizes the format of a file, and calls its parser.
//!
//! Every parser takes any bytes. A row that is wrong in itself is an [`Anomaly`]; a file that is
//! not what it claims to be is an [`InputError`].
//!
//! [`Anomaly`]: super::recording::Anomaly

mod ble_robot;
mod csv;
pub mod mcap;
mod mitll;
mod table;
mod tetam;
mod trace;
mod uchain_flight;
pub(crate) mod usd;

use std::fmt;
use std::path::Path;

use clap::ValueEnum;
use input::InputError;
use serde::{Deserialize, Serialize};
use units::{Dbm, Instant, Metres};

use super::mcap_file;
use super::recording::{Recording, Wrong};
use table::Header;

/// A format of logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// A flight of the U-Chain authors: `t,r0,r1,…,` with losses in whole dB, 0 = never heard.
    UchainFlight,
    /// A position-annotated BLE track of the TETAM set.
    Tetam,
    /// The raw packets of the BLE and UWB anchors round a robot.
    BleRobot,
    /// A still link of the MITLL set, as received by an nRF52.
    Mitll,
    /// A table of packets with a header: `time_s, link, rssi_dbm, velocity_mps`.
    Csv,
    /// The trace.csv that `uchain run --out` writes.
    Trace,
    /// The trace.mcap that `uchain run --out` writes, or the station.mcap of the ground station.
    Mcap,
    /// A log of the Crazyflie's µSD card deck.
    Usd,
}

impl Format {
    /// The description of one row, for an error message.
    const fn row(self) -> &'static str {
        match self {
            Self::UchainFlight => "a row of a U-Chain flight (time, then one loss per link)",
            Self::Tetam => "a row of a TETAM track (16 comma-separated fields)",
            Self::BleRobot => "a row of a BLE robot log (7 or more tab-separated integers)",
            Self::Mitll => "a row of a MITLL log (Frame, Time, Source, DeviceName, RSSI, …)",
            Self::Csv => "a row of time_s, link and rssi_dbm",
            Self::Trace => "a row of the trace.csv of a run",
            Self::Mcap => "a message of /drone/N/link/front or back, or of /drone/N/report",
            Self::Usd => "an event of a µSD log",
        }
    }

    fn parse(self, bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
        match self {
            Self::UchainFlight => Ok(uchain_flight::parse(bytes)),
            Self::Tetam => Ok(tetam::parse(bytes, &tetam::receivers_of(file)?)),
            Self::BleRobot => {
                Ok(ble_robot::parse(bytes, &ble_robot::surroundings_of(file, bytes)?))
            }
            Self::Mitll => mitll::parse(bytes, file),
            Self::Csv => csv::parse(bytes, file),
            Self::Trace => trace::parse(bytes, file),
            Self::Mcap => mcap::parse(bytes, file),
            Self::Usd => usd::parse(bytes, file),
        }
    }

    /// The check that recognizes its rows, for a format without a header.
    const fn rows_told_by(self) -> Option<fn(&str) -> bool> {
        match self {
            Self::UchainFlight => Some(uchain_flight::is_row),
            Self::Tetam => Some(tetam::is_row),
            Self::BleRobot => Some(ble_robot::is_row),
            Self::Mitll | Self::Csv | Self::Trace | Self::Mcap | Self::Usd => None,
        }
    }

    /// Recognizes the format of a file by its first rows.
    fn told_from(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(mcap_file::MAGIC) {
            return Some(Self::Mcap);
        }
        if bytes.first() == Some(&usd::MAGIC) {
            return Some(Self::Usd);
        }
        let rows = first_rows(bytes);
        let (_, first) = rows.first()?;
        if mitll::is_header(first) {
            return Some(Self::Mitll);
        }
        let header = Header::of(rows.iter().cloned())?;
        if csv::is_header(&header) {
            return Some(Self::Csv);
        }
        if trace::is_header(&header) {
            return Some(Self::Trace);
        }
        let without_header = [Self::Tetam, Self::BleRobot, Self::UchainFlight]
            .into_iter()
            .find(|format| format.first_stranger(&rows).is_none());
        // Its parser says which column is missing.
        without_header.or_else(|| csv::is_incomplete_header(&header).then_some(Self::Csv))
    }

    /// The first row that is not of this format, if most of these rows are not.
    fn first_stranger(self, rows: &[(usize, String)]) -> Option<usize> {
        let is_row = self.rows_told_by()?;
        let mut strangers = rows.iter().filter(|(_, row)| !is_row(row)).map(|(line, _)| *line);
        let first = strangers.next()?;
        ((1 + strangers.count()) * 2 > rows.len()).then_some(first)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::UchainFlight => "uchain-flight",
            Self::Tetam => "tetam",
            Self::BleRobot => "ble-robot",
            Self::Mitll => "mitll",
            Self::Csv => "csv",
            Self::Trace => "trace",
            Self::Mcap => "mcap",
            Self::Usd => "usd",
        })
    }
}

/// The number of bytes at the start of a file by which its format is recognized.
const SNIFFED: usize = 16 * 1024;

/// The rows by which a format is recognized, without a last one that may be cut short.
fn first_rows(bytes: &[u8]) -> Vec<(usize, String)> {
    let end = end_of_line(bytes);
    let start = bytes
        .get(..SNIFFED)
        .map_or(bytes, |start| start.rsplitn(2, |byte| *byte == end).nth(1).unwrap_or(start));
    lines(start).take(20).collect()
}

/// The largest file that is read, so that a wrong path cannot fill the memory: days of flight.
pub(super) const LARGEST: u64 = 256 * 1024 * 1024;

/// Reads and checks a log, in the format given or the one that its content shows.
pub fn read(file: &Path, format: Option<Format>) -> Result<(Format, Recording), InputError> {
    let bytes = read_bytes(file)?;
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(
            InputError::new("the file is empty", "give a log with at least one row").in_file(file)
        );
    }
    if let Some((wrong, remedy)) = other_coding(&bytes) {
        return Err(InputError::new(wrong, remedy).in_file(file));
    }
    let format = format.or_else(|| Format::told_from(&bytes)).ok_or_else(|| {
        InputError::new(
            "this is in none of the known log formats",
            "name one with --format uchain-flight|tetam|ble-robot|mitll|csv|trace|mcap|usd",
        )
        .in_file(file)
    })?;
    // This is checked before a file that belongs to the log is missed, or a large one is read to
    // its end.
    if let Some(line) = format.first_stranger(&first_rows(&bytes)) {
        return Err(not_the_format(format, line, file));
    }
    let recording = format.parse(&bytes, file)?;
    check(format, recording, &bytes, file).map(|recording| (format, recording))
}

/// What is wrong with a file whose first bytes show that it has to be decoded before it can be read,
/// and the remedy.
fn other_coding(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let packed = "the file as a whole is compressed";
    match bytes {
        // With a byte order mark, or without one where it begins with two letters of ASCII.
        [0xff, 0xfe, ..]
        | [0xfe, 0xff, ..]
        | [1..=127, 0, 1..=127, 0, ..]
        | [0, 1..=127, 0, 1..=127, ..] => Some(("this is text in UTF-16", "save it as UTF-8")),
        // The marks of RFC 1952, of RFC 8878, of the LZ4 frame format 1.6 and of ZIP (APPNOTE 6.3).
        [0x1f, 0x8b, ..] => Some((packed, "unpack it with gunzip")),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => Some((packed, "unpack it with unzstd")),
        [0x04, 0x22, 0x4d, 0x18, ..] => Some((packed, "unpack it with unlz4")),
        [b'P', b'K', 3, 4, ..] => Some((packed, "unpack it with unzip")),
        _ => None,
    }
}

fn check(
    format: Format,
    recording: Recording,
    bytes: &[u8],
    file: &Path,
) -> Result<Recording, InputError> {
    if let Some(line) = recording.mostly_malformed() {
        return Err(match &recording.wrong {
            Some((line, wrong)) => wrong_row(format, *line, wrong, bytes, file),
            None => not_the_format(format, line, file),
        });
    }
    if recording.rows == 0 {
        return Err(InputError::new(
            "no row follows the header",
            "give a log with at least one row",
        )
        .in_file(file));
    }
    if recording.samples.is_empty() {
        return Err(InputError::new(
            format!("none of its {} rows holds a usable sample", recording.rows),
            format!("each row must be {}", format.row()),
        )
        .in_file(file));
    }
    Ok(recording)
}

/// The error of a table of which most rows are wrong, by the first of them.
fn wrong_row(format: Format, line: usize, wrong: &Wrong, bytes: &[u8], file: &Path) -> InputError {
    let text = format!("{}, and most other rows are wrong, too", wrong.what);
    let error = InputError::new(text, format!("each row must be {}", format.row()));
    let row = lines(bytes).find(|(number, _)| *number == line).map(|(_, row)| row);
    match wrong.field.zip(row) {
        Some((field, row)) => {
            error.at_column(file, line, table::column_of(&row, wrong.separator, field))
        }
        None => error.at_line(file, line),
    }
}

fn not_the_format(format: Format, line: usize, file: &Path) -> InputError {
    InputError::new(
        format!("this is not {}, and neither are most other rows", format.row()),
        "check --format, or leave it out: the format is then recognized by the content",
    )
    .at_line(file, line)
}

/// The bytes of a log.
///
/// # Errors
/// [`InputError`] where the file cannot be read, or is larger than `LARGEST`.
pub fn read_bytes(file: &Path) -> Result<Vec<u8>, InputError> {
    read_companion(file, "check the path and its permissions")
}

/// Reads a file that belongs to a log; `remedy` says where it should be.
fn read_companion(file: &Path, remedy: &str) -> Result<Vec<u8>, InputError> {
    let unreadable = |error: std::io::Error| {
        InputError::new(format!("cannot be read: {error}"), remedy).in_file(file)
    };
    input::file::read(file, LARGEST).map_err(|error| match error.kind() {
        std::io::ErrorKind::FileTooLarge => {
            InputError::new("is larger than 256 MiB", "cut the log into parts").in_file(file)
        }
        _ => unreadable(error),
    })
}

/// The lines of a text that are not empty, with their numbers; the first is 1. Bytes that are not
/// text are replaced, so that a row of them fails as a row and not as a file.
fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, String)> {
    untrimmed_lines(bytes).map(|(number, line)| (number, line.trim_ascii_end().to_owned()))
}

/// The byte that ends each line of a text. A text without a line feed has the ends of lines of the old
/// Macintosh, with which some spreadsheets still save a table.
fn end_of_line(bytes: &[u8]) -> u8 {
    if bytes.contains(&b'\n') { b'\n' } else { b'\r' }
}

/// The same lines with the blanks at their ends: a tab there is the end of an empty field.
fn untrimmed_lines(bytes: &[u8]) -> impl Iterator<Item = (usize, String)> {
    let end = end_of_line(bytes);
    bytes
        .split(move |byte| *byte == end)
        .enumerate()
        .map(|(index, line)| {
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            (index + 1, String::from_utf8_lossy(line).into_owned())
        })
        .filter(|(_, line)| !line.trim().is_empty())
}

/// Parses a finite number.
fn number(field: &str) -> Option<f64> {
    field.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

/// Seconds since boot or since 1970; the year 5138 is as far as they go.
fn instant(seconds: f64) -> Option<Instant> {
    (0.0..1e11).contains(&seconds).then(|| Instant::from_micros((seconds * 1e6).round() as u64))
}

/// A strength that a receiver can read. Under −120 dBm there is less signal than thermal noise in
/// a channel of 1 MHz (−114 dBm); 0 dBm is all that most of these transmitters send, and what
/// several logs write for "not measured".
fn received(dbm: f64) -> Option<Dbm> {
    (-120.0..0.0).contains(&dbm).then_some(Dbm(dbm as f32))
}

/// x, y, z in metres.
type Position = [f64; 3];

fn distance(a: &Position, b: &Position) -> Metres {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    Metres(libm::sqrt(squares) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_told_from_the_content() {
        let cases: [(&str, Option<Format>); 9] = [
            ("time_s,link,rssi_dbm\n0,a,-50\n", Some(Format::Csv)),
            (
                "time_s,node,role,x_m,y_m,z_m,front_peer,front_raw_dbm,back_peer,back_raw_dbm\n",
                Some(Format::Trace),
            ),
            ("Frame,Time,Source,DeviceName,RSSI\n", Some(Format::Mitll)),
            ("1.5,aa,bb,-60,1,2,3,1,0,0,0,1,0,0,0,1\n", Some(Format::Tetam)),
            ("1628\t4\t1\t19\t1\t0\t0\n", Some(Format::BleRobot)),
            ("0.4,52,47,\n0.8,52,\n", Some(Format::UchainFlight)),
            ("1,2\nnot a number,3\nat all,4\n", None),
            ("\u{89}PNG\r\n\u{1a}\n", None),
            ("", None),
        ];
        for (text, format) in cases {
            assert_eq!(Format::told_from(text.as_bytes()), format, "{text:?}");
        }
    }

    #[test]
    fn lines_end_as_those_of_unix_dos_or_the_old_macintosh() {
        let text = "time_s,link,rssi_dbm\n0,a,-50\n\n1,a,-51\n";
        let rows: Vec<_> = lines(text.as_bytes()).collect();
        assert_eq!(rows[2], (4, "1,a,-51".to_owned()));
        for end in ["\r\n", "\r"] {
            let other = text.replace('\n', end);
            assert_eq!(lines(other.as_bytes()).collect::<Vec<_>>(), rows, "{end:?}");
            assert_eq!(Format::told_from(other.as_bytes()), Some(Format::Csv), "{end:?}");
        }
        // The rows by which a long text is recognized are whole.
        let long = "time_s,link,rssi_dbm\r".to_owned() + &"0.25,a,-50\r".repeat(SNIFFED);
        assert!(first_rows(long.as_bytes()).iter().skip(1).all(|(_, row)| row == "0.25,a,-50"));
    }

    #[test]
    fn what_no_receiver_reads_is_no_strength() {
        assert_eq!(received(-57.0), Some(Dbm(-57.0)));
        for wrong in [102.0, 0.0, -121.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(received(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_time_that_cannot_be_counted_is_none() {
        assert_eq!(
            instant(1_581_252_411.243_835),
            Some(Instant::from_micros(1_581_252_411_243_835))
        );
        for wrong in [-0.1, 1e11, f64::NAN] {
            assert_eq!(instant(wrong), None, "{wrong}");
        }
    }
}
