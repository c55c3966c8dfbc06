//! Frames of the serial line: finding them in a stream of bytes that may be disturbed, and writing
//! them.

/// The most data that one frame carries (`SYSLINK_MTU`).
pub const MAX_DATA: usize = 64;

/// The most bytes that one frame takes on the line.
pub const MAX_FRAME: usize = HEADER + MAX_DATA + CHECKSUM;

const START: [u8; 2] = [0xBC, 0xCF];
/// Bytes of start, type and length.
const HEADER: usize = 4;
const CHECKSUM: usize = 2;

/// The contents of a frame whose checksum was right. The data has not been checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// The type byte.
    pub kind: u8,
    /// The data, at most [`MAX_DATA`] bytes.
    pub data: &'a [u8],
}

/// Counters of what the decoder has found on the line. Each counts up and wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Frames with the right checksum.
    pub good: u32,
    /// Frames with a wrong checksum.
    pub bad_checksums: u32,
    /// The number of times that a good frame was followed by bytes that are no frame.
    pub resyncs: u32,
}

/// Finds the frames in a stream of bytes.
///
/// The decoder keeps the bytes of a frame until it has compared the checksum. When that is wrong,
/// the first byte was no start of a frame, and the search goes on with the second: a frame that
/// begins inside a false one is found. It is returned late, though: when as many bytes have come as
/// the false start promised, 70 at most.
#[derive(Clone, Debug)]
pub struct Decoder {
    /// Bytes that may become a frame: none, or beginning with a start or the first half of one.
    kept: [u8; MAX_FRAME],
    length: usize,
    /// The number of kept bytes that are the frame that was returned last.
    done: usize,
    in_step: bool,
    counters: Counters,
}

/// A verdict on the kept bytes.
enum Look {
    /// The bytes could be the beginning of a frame.
    Unfinished,
    /// The bytes begin with a frame that has this much data.
    Whole(usize),
    /// The bytes are no frame.
    Nothing,
    /// The bytes are a frame but for their checksum.
    BadChecksum,
}

impl Decoder {
    /// A decoder that has received nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            kept: [0; MAX_FRAME],
            length: 0,
            done: 0,
            in_step: true,
            counters: Counters { good: 0, bad_checksums: 0, resyncs: 0 },
        }
    }

    /// The next frame of `line`, which moves on past the bytes that have been used. `None` when all
    /// of them are used; the next call may pass the bytes that follow.
    pub fn next<'d>(&'d mut self, line: &mut &[u8]) -> Option<Frame<'d>> {
        let done = core::mem::take(&mut self.done);
        self.drop_first(done);
        // Each iteration takes a byte from the line or drops one that was kept.
        let data = loop {
            match self.look() {
                Look::Whole(data) => break data,
                Look::Nothing => self.search_on(),
                Look::BadChecksum => {
                    self.counters.bad_checksums = self.counters.bad_checksums.wrapping_add(1);
                    self.search_on();
                }
                Look::Unfinished => {
                    let (&byte, rest) = line.split_first()?;
                    *line = rest;
                    self.keep(byte);
                }
            }
        };
        self.counters.good = self.counters.good.wrapping_add(1);
        self.in_step = true;
        self.done = HEADER + data + CHECKSUM;
        let [_, _, kind, _, data_on @ ..] = &self.kept;
        Some(Frame { kind: *kind, data: data_on.get(..data)? })
    }

    /// The counters of this decoder.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    fn look(&self) -> Look {
        let kept = self.kept.get(..self.length).unwrap_or_default();
        match kept {
            [] => return Look::Unfinished,
            [first] if *first == START[0] => return Look::Unfinished,
            [first, second, ..] if [*first, *second] == START => {}
            _ => return Look::Nothing,
        }
        let [_, _, sealed @ ..] = kept else { return Look::Nothing };
        let [_, data, ..] = sealed else { return Look::Unfinished };
        let data = usize::from(*data);
        if data > MAX_DATA {
            return Look::Nothing;
        }
        match sealed.split_at_checked(2 + data) {
            Some((sealed, [a, b, ..])) if fletcher(sealed) == [*a, *b] => Look::Whole(data),
            Some((_, [_, _, ..])) => Look::BadChecksum,
            _ => Look::Unfinished,
        }
    }

    /// Drops the first byte, and the bytes after it up to the next that may be a start.
    fn search_on(&mut self) {
        if self.in_step {
            self.in_step = false;
            self.counters.resyncs = self.counters.resyncs.wrapping_add(1);
        }
        let kept = self.kept.get(..self.length).unwrap_or_default();
        let next = kept.iter().skip(1).position(|byte| *byte == START[0]);
        self.drop_first(next.map_or(self.length, |behind_first| behind_first + 1));
    }

    fn drop_first(&mut self, count: usize) {
        if count == 0 {
            return;
        }
        let left = self.length.saturating_sub(count);
        for to in 0..left {
            let byte = self.kept.get(to + count).copied().unwrap_or_default();
            if let Some(place) = self.kept.get_mut(to) {
                *place = byte;
            }
        }
        self.length = left;
    }

    /// Keeps a byte. There is room for it, because only an unfinished frame is ever kept.
    fn keep(&mut self, byte: u8) {
        if let Some(place) = self.kept.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

/// Writes a frame whose data is `head` followed by `tail`. `None` when the frame does not fit into
/// `out`, or has more data than a frame can carry.
pub(super) fn write(kind: u8, head: &[u8], tail: &[u8], out: &mut [u8]) -> Option<usize> {
    let data = head.len().checked_add(tail.len()).filter(|data| *data <= MAX_DATA)?;
    let length = HEADER + data + CHECKSUM;
    let (sealed, checksum) = out.get_mut(..length)?.split_at_mut_checked(HEADER + data)?;
    let [a, b] = START;
    let bytes = [a, b, kind, data as u8].into_iter();
    let bytes = bytes.chain(head.iter().copied()).chain(tail.iter().copied());
    for (place, byte) in sealed.iter_mut().zip(bytes) {
        *place = byte;
    }
    let sum = fletcher(sealed.get(START.len()..)?);
    for (place, byte) in checksum.iter_mut().zip(sum) {
        *place = byte;
    }
    Some(length)
}

/// The 8-bit Fletcher checksum of RFC 1146, modulo 256.
fn fletcher(bytes: &[u8]) -> [u8; 2] {
    let mut sums = [0_u8; 2];
    for byte in bytes {
        sums[0] = sums[0].wrapping_add(*byte);
        sums[1] = sums[1].wrapping_add(sums[0]);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_known_vectors() {
        assert_eq!(fletcher(&[]), [0, 0]);
        // 1, 1+2, 1+2+3 …: sums 6 and 1+3+6.
        assert_eq!(fletcher(&[1, 2, 3]), [6, 10]);
        // Modulo 256, where Fletcher-16 as others have it is modulo 255: 0xC8F0 for "abcde".
        assert_eq!(fletcher(b"abcde"), [0xEF, 0xC3]);
        assert_eq!(fletcher(&[0xFF; 3]), [0xFD, 0xFA]);
    }
}
