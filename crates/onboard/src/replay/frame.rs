//! Turns records into frames of bytes, and bytes back into frames.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::Vec;
use storage::crc32;

use crate::words::Writer;

/// The upper half of a frame's first word: "UR".
pub const MAGIC: u32 = 0x5552;
/// The version of all records. It grows with every change of what they hold.
pub const VERSION: u8 = 4;

/// Words of a frame at most: a step with [`HEARD`](super::HEARD) reports of 24 words, and a strength
/// of 2 words for each of 16 links, takes 420.
pub const LONGEST: usize = 425;

/// The longest run of bytes without a zero that one code byte stands for.
const RUN: usize = 254;

/// Why bytes are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Bytes were lost, added or damaged.
    Damaged,
    /// The frame has more words than [`LONGEST`].
    TooLong,
    /// The sender has another [`VERSION`] of the records.
    Version(u8),
}

/// A frame whose CRC is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// The kind of the record.
    pub(super) kind: u8,
    /// The number of the request.
    pub number: u32,
    /// The record.
    pub(super) body: &'a [u32],
}

/// Collects the bytes of frames.
#[derive(Debug)]
pub struct Receiver {
    words: Vec<u32, LONGEST>,
    /// The bytes of the word that is not complete, the first one lowest, and how many they are.
    partial: (u32, u32),
    /// The bytes that follow until the next code byte.
    left: u8,
    /// Whether a zero stands between the present run and the next.
    zero_follows: bool,
    failed: Option<FrameError>,
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

impl Receiver {
    /// A receiver of which no byte has come.
    #[must_use]
    pub const fn new() -> Self {
        Self { words: Vec::new(), partial: (0, 0), left: 0, zero_follows: false, failed: None }
    }

    /// Takes the next byte. At the end of a frame it calls `take` with the frame, or with the reason
    /// why it is none, and returns the result.
    pub fn push<R>(
        &mut self,
        byte: u8,
        take: impl FnOnce(Result<Frame<'_>, FrameError>) -> R,
    ) -> Option<R> {
        if byte != 0 {
            self.take_in(byte);
            return None;
        }
        let is_empty = self.words.is_empty() && self.partial.1 == 0 && self.failed.is_none();
        let result = (!is_empty).then(|| take(self.frame()));
        *self = Self::new();
        result
    }

    fn take_in(&mut self, byte: u8) {
        if self.left > 0 {
            self.left -= 1;
            return self.decoded(byte);
        }
        if self.zero_follows {
            self.decoded(0);
        }
        self.zero_follows = usize::from(byte) <= RUN;
        self.left = byte - 1;
    }

    fn decoded(&mut self, byte: u8) {
        let (word, count) = self.partial;
        let word = word | u32::from(byte) << (8 * count);
        self.partial = if count < 3 { (word, count + 1) } else { (0, 0) };
        if count == 3 && self.words.push(word).is_err() {
            self.failed = Some(FrameError::TooLong);
        }
    }

    fn frame(&self) -> Result<Frame<'_>, FrameError> {
        if let Some(why) = self.failed {
            return Err(why);
        }
        let is_whole = self.left == 0 && self.partial.1 == 0;
        let Some((crc, words)) = self.words.split_last().filter(|_| is_whole) else {
            return Err(FrameError::Damaged);
        };
        let [head, number, body @ ..] = words else { return Err(FrameError::Damaged) };
        if *crc != crc32(words.iter().flat_map(|word| word.to_le_bytes())) || head >> 16 != MAGIC {
            return Err(FrameError::Damaged);
        }
        let [kind, version, ..] = head.to_le_bytes();
        if version != VERSION {
            return Err(FrameError::Version(version));
        }
        Ok(Frame { kind, number: *number, body })
    }
}

/// The words of one frame that is being written; its memory is that of a slot of the probe, so that
/// one writer serves both.
struct Outgoing {
    words: [AtomicU32; LONGEST],
}

impl Outgoing {
    fn word(&self, at: usize) -> u32 {
        self.words.get(at).map_or(0, |word| word.load(Ordering::Relaxed))
    }

    fn byte(&self, at: usize) -> u8 {
        (self.word(at / 4) >> (8 * (at % 4))) as u8
    }
}

/// Writes a record as a frame, byte by byte.
#[inline(never)]
pub(super) fn send(
    kind: u8,
    number: u32,
    put: impl FnOnce(&mut Writer<'_>),
    mut byte: impl FnMut(u8),
) {
    let frame = Outgoing { words: [const { AtomicU32::new(0) }; LONGEST] };
    let mut writer = Writer::new(&frame.words);
    writer.word(MAGIC << 16 | u32::from(VERSION) << 8 | u32::from(kind));
    writer.word(number);
    put(&mut writer);
    // Room for the CRC stays; a record that is too long would be no record for its receiver.
    let written = writer.length().min(LONGEST - 1);
    writer = Writer::new(frame.words.get(written..).unwrap_or_default());
    writer.word(crc32((0..4 * written).map(|at| frame.byte(at))));
    stuff(4 * (written + 1), |at| frame.byte(at), &mut byte);
}

/// Stuffs `length` bytes and ends them with a zero.
fn stuff(length: usize, source: impl Fn(usize) -> u8, byte: &mut impl FnMut(u8)) {
    let mut at = 0;
    loop {
        let run = (at..length).take(RUN).take_while(|at| source(*at) != 0).count();
        byte(run as u8 + 1);
        (at..at + run).for_each(|at| byte(source(at)));
        at += run;
        if at >= length {
            return byte(0);
        }
        // A full run stands for no zero behind it.
        at += usize::from(run < RUN);
        if at == length && run < RUN {
            byte(1);
            return byte(0);
        }
    }
}
