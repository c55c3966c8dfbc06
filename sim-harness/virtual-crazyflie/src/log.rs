//! Decodes what the firmware logs by defmt.
//!
//! The firmware writes into a ring in its RAM, and a debug probe reads it there (SEGGER's RTT).
//! Here the emulator is that probe, or only reads along without changing anything.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use defmt_decoder::{DecodeError, Encoding, Table};

use crate::bus::Width;
use crate::image::{Image, Source};
use crate::memory::Memory;
use crate::rtt::ControlBlock;
use crate::soc::Nanos;

/// The flag by which the firmware waits while the ring is full.
const BLOCK_IF_FULL: u32 = 2;
/// No position in any ring: until the firmware has written the block anew, there is nothing.
const NOWHERE: u32 = u32::MAX;
/// More than this without an end is no message.
const LONGEST: usize = 64 * 1024;

/// The level of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// `defmt::trace!`
    Trace,
    /// `defmt::debug!`
    Debug,
    /// `defmt::info!`
    Info,
    /// `defmt::println!`, which has no level: it is always shown.
    Print,
    /// `defmt::warn!`
    Warn,
    /// `defmt::error!`
    Error,
    /// Not a message: bytes that could not be decoded, described in words.
    Garbled,
}

impl Level {
    fn by_name(name: &str) -> Self {
        match name {
            "trace" => Self::Trace,
            "debug" => Self::Debug,
            "info" => Self::Info,
            "warn" => Self::Warn,
            "error" => Self::Error,
            _ => Self::Print,
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Trace => "TRACE",
            Self::Debug => "DEBUG",
            Self::Info => "INFO",
            Self::Print => "PRINT",
            Self::Warn => "WARN",
            Self::Error => "ERROR",
            Self::Garbled => "?????",
        })
    }
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// When it was seen in the ring, complete.
    pub at: Nanos,
    /// The level.
    pub level: Level,
    /// The firmware's timestamp, if it has one (`defmt::timestamp!`).
    pub timestamp: Option<String>,
    /// The message.
    pub text: String,
    /// The line in the source, if the image has debug information.
    pub location: Option<Source>,
}

impl fmt::Display for LogLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, rest) = (self.at / 1_000_000_000, self.at % 1_000_000_000);
        write!(f, "{seconds:>6}.{:06} {:<5} {}", rest / 1000, self.level, self.text)?;
        match &self.location {
            Some(location) => write!(f, "  ({location})"),
            None => Ok(()),
        }
    }
}

/// Whether a debug probe reads the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// There is none, as in flight: the firmware overwrites the oldest bytes. The log sees all that
    /// it reads before it is overwritten.
    Absent,
    /// A debug probe, which makes the firmware wait while the ring is full, until the log is
    /// drained. Nothing is lost, but the firmware's timing changes.
    Attached,
}

/// Why an image's messages cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LogError {
    /// The firmware does not log by defmt.
    NoDefmt,
    /// The firmware has no RTT control block.
    NoRtt,
    /// The firmware's table of messages is damaged or of another version.
    Table(String),
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDefmt => write!(f, "the image does not log by defmt"),
            Self::NoRtt => write!(f, "the image has no RTT control block (_SEGGER_RTT)"),
            Self::Table(why) => write!(f, "the image's defmt table: {why}"),
        }
    }
}

impl std::error::Error for LogError {}

/// The messages of an image, by their indices. All drones that fly the image may share them.
pub struct Messages {
    control_block: ControlBlock,
    table: Table,
    /// The line in the source of each message, by its index.
    locations: BTreeMap<u64, Source>,
}

impl fmt::Debug for Messages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Messages")
            .field("control_block", &self.control_block)
            .finish_non_exhaustive()
    }
}

impl Messages {
    /// Those of an image.
    ///
    /// # Errors
    /// If it does not log, or not in a way that is known here.
    pub fn of(image: &Image) -> Result<Self, LogError> {
        let wrong = |why: &dyn fmt::Display| LogError::Table(why.to_string());
        let table = Table::parse(image.file()).map_err(|why| wrong(&why))?;
        let table = table.ok_or(LogError::NoDefmt)?;
        let control_block = ControlBlock::of(image).ok_or(LogError::NoRtt)?;
        // Without debug information there are none.
        let shortened = image.shortened_paths();
        let locations = table.get_locations(image.file()).unwrap_or_default();
        let locations = locations.into_iter().map(|(index, location)| {
            let file = shortened(&location.file.to_string_lossy());
            (index, Source { file, line: u32::try_from(location.line).unwrap_or(0) })
        });
        let locations = locations.collect();
        Ok(Self { control_block, table, locations })
    }

    fn line(&self, at: Nanos, frame: &defmt_decoder::Frame<'_>) -> LogLine {
        let location = self.locations.get(&frame.index()).cloned();
        LogLine {
            at,
            level: frame.level().map_or(Level::Print, |level| Level::by_name(level.as_str())),
            timestamp: frame.display_timestamp().map(|time| time.to_string()),
            text: frame.display_message().to_string(),
            location,
        }
    }

    /// Decodes all complete messages, takes them off the bytes, and hands each on.
    fn decode(&self, at: Nanos, bytes: &mut Vec<u8>, lines: &mut Vec<LogLine>) {
        match self.table.encoding() {
            Encoding::Rzcobs => self.decode_framed(at, bytes, lines),
            _ => self.decode_raw(at, bytes, lines),
        }
        if bytes.len() > LONGEST {
            lines.push(garbled(at, bytes.len()));
            bytes.clear();
        }
    }

    /// Messages that end with a zero byte: what is garbled ends there.
    fn decode_framed(&self, at: Nanos, bytes: &mut Vec<u8>, lines: &mut Vec<LogLine>) {
        let Some(last) = bytes.iter().rposition(|byte| *byte == 0) else { return };
        let complete: Vec<u8> = bytes.drain(..=last).collect();
        for message in complete.split_inclusive(|byte| *byte == 0) {
            if message.len() == 1 {
                continue;
            }
            let mut decoder = self.table.new_stream_decoder();
            decoder.received(message);
            lines.push(match decoder.decode() {
                Ok(frame) => self.line(at, &frame),
                Err(_) => garbled(at, message.len() - 1),
            });
        }
    }

    /// Messages one after the other: after one that is garbled, none can be told from another.
    fn decode_raw(&self, at: Nanos, bytes: &mut Vec<u8>, lines: &mut Vec<LogLine>) {
        loop {
            let used = match self.table.decode(bytes) {
                Ok((frame, used)) => {
                    lines.push(self.line(at, &frame));
                    used
                }
                Err(DecodeError::UnexpectedEof) => return,
                Err(DecodeError::Malformed) => {
                    lines.push(garbled(at, bytes.len()));
                    bytes.len()
                }
            };
            bytes.drain(..used);
        }
    }
}

fn garbled(at: Nanos, bytes: usize) -> LogLine {
    LogLine {
        at,
        level: Level::Garbled,
        timestamp: None,
        text: format!("{bytes} bytes that are no message"),
        location: None,
    }
}

/// One drone's log.
#[derive(Debug)]
pub struct Log {
    messages: Arc<Messages>,
    probe: Probe,
    /// The position in the ring up to which it has been read, or [`NOWHERE`].
    read: u32,
    /// The beginning of a message that is not yet complete.
    partial: Vec<u8>,
    lines: Vec<LogLine>,
}

impl Log {
    /// An empty one.
    #[must_use]
    pub fn new(messages: Arc<Messages>, probe: Probe) -> Self {
        Self { messages, probe, read: NOWHERE, partial: vec![], lines: vec![] }
    }

    /// Reads what is new in the ring. It costs a comparison where nothing is.
    #[inline]
    pub fn drain(&mut self, memory: &mut Memory, now: Nanos) {
        let write = memory.load(self.messages.control_block.first_write(), Width::Word);
        if write != Some(self.read) {
            self.look(memory, now);
        }
    }

    /// The chip is about to be reset: the ring is read to its end and, until the firmware has
    /// written its control block anew, no more.
    ///
    /// This overwrites one word of the control block, which the firmware writes anew before it
    /// reads it.
    pub fn reset(&mut self, memory: &mut Memory, now: Nanos) {
        self.drain(memory, now);
        if !self.partial.is_empty() {
            self.lines.push(LogLine {
                text: format!("{} bytes of a message that a reset cut off", self.partial.len()),
                ..garbled(now, 0)
            });
            self.partial.clear();
        }
        self.read = NOWHERE;
        memory.store(self.messages.control_block.first_write(), Width::Word, NOWHERE);
    }

    /// All messages so far, but for those that have been taken.
    #[must_use]
    pub fn lines(&self) -> &[LogLine] {
        &self.lines
    }

    /// Takes them.
    pub fn take(&mut self) -> Vec<LogLine> {
        std::mem::take(&mut self.lines)
    }

    #[cold]
    fn look(&mut self, memory: &mut Memory, now: Nanos) {
        let Some(ring) = self.messages.control_block.up(memory, 0) else { return };
        if self.read >= ring.size {
            // The first look at this block.
            self.read = 0;
            if self.probe == Probe::Attached {
                ring.set_flags(memory, ring.flags & !3 | BLOCK_IF_FULL);
            }
        }
        self.partial.extend(ring.since(memory, self.read));
        self.read = ring.write;
        if self.probe == Probe::Attached {
            ring.set_read(memory);
        }
        let messages = self.messages.clone();
        messages.decode(now, &mut self.partial, &mut self.lines);
    }
}
