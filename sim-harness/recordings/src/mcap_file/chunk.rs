//! Unpacks the chunks of an MCAP file.

use std::borrow::Cow;
use std::io::Read;

use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

use super::Damage;
use super::record::{Fields, Record};

/// A chunk of channels and messages, as it stands in the file.
pub(super) struct Chunk<'a> {
    /// The size of what is packed in it, as the file claims.
    claimed: u64,
    /// The CRC-32 of what is packed in it; 0 for none.
    pub(super) crc: u32,
    /// The times of its first and its last message, ns.
    pub(super) span_ns: (u64, u64),
    packing: &'a str,
    packed: &'a [u8],
    /// The place of the packed bytes.
    pub(super) at: usize,
    /// The place of the chunk.
    record_at: usize,
}

/// What was packed in a chunk, up to where it is damaged.
pub(super) struct Unpacked<'a> {
    pub(super) bytes: Cow<'a, [u8]>,
    pub(super) damage: Option<Damage>,
}

impl<'a> Chunk<'a> {
    pub(super) fn of(record: &Record<'a>) -> Result<Self, Damage> {
        let mut fields = Fields::of(record);
        let span_ns = (fields.u64()?, fields.u64()?);
        let (claimed, crc, packing) = (fields.u64()?, fields.u32()?, fields.text()?);
        let length = usize::try_from(fields.u64()?).unwrap_or(usize::MAX);
        let at = record.body_at() + record.body.len() - fields.rest().len();
        let packed = fields.take(length)?;
        Ok(Self { claimed, crc, span_ns, packing, packed, at, record_at: record.at })
    }

    pub(super) const fn is_packed(&self) -> bool {
        !self.packing.is_empty()
    }

    /// Unpacks at most so many bytes.
    pub(super) fn unpacked(&self, most: usize) -> Unpacked<'a> {
        let damaged = |why: String| Damage::new(self.record_at, why);
        let whole = usize::try_from(self.claimed).unwrap_or(usize::MAX);
        let (bytes, trouble) = match self.packing {
            "" => (Cow::Borrowed(self.packed), None),
            "zstd" | "lz4" => {
                // A byte more than there may be shows that there is more.
                let limit = whole.min(most).saturating_add(1);
                let mut bytes = Vec::new();
                let done = if self.packing == "lz4" {
                    from_lz4(self.packed, limit, &mut bytes)
                } else {
                    from_zstd(self.packed, limit, &mut bytes)
                };
                (Cow::Owned(bytes), done.err())
            }
            other => {
                let why = format!("a chunk packed with {other:?}, where zstd and lz4 are read");
                return Unpacked { bytes: Cow::Borrowed(&[]), damage: Some(damaged(why)) };
            }
        };
        let found = bytes.len();
        let why = match trouble {
            Some(error) => Some(format!("a chunk that cannot be unpacked: {error}")),
            None if self.is_packed() && found > most => {
                Some("its chunks hold more than 256 MiB when unpacked".to_owned())
            }
            None if found != whole => {
                let sizes = format!("of {} bytes holds {found}", self.claimed);
                let more = if self.is_packed() && found > whole { " or more" } else { "" };
                Some(format!("a chunk {sizes}{more}"))
            }
            None => None,
        };
        Unpacked { bytes, damage: why.map(damaged) }
    }
}

/// Unpacks zstd, frame by frame; the memory of a frame's window is bounded by the decoder.
fn from_zstd(mut packed: &[u8], limit: usize, bytes: &mut Vec<u8>) -> Result<(), String> {
    while !packed.is_empty() && bytes.len() < limit {
        let decoder = StreamingDecoder::new(&mut packed).map_err(|error| one_line(&error))?;
        let room = (limit - bytes.len()) as u64;
        decoder.take(room).read_to_end(bytes).map_err(|error| one_line(&error))?;
    }
    Ok(())
}

/// Unpacks lz4, frame by frame.
fn from_lz4(mut packed: &[u8], limit: usize, bytes: &mut Vec<u8>) -> Result<(), String> {
    while !packed.is_empty() && bytes.len() < limit {
        let room = (limit - bytes.len()) as u64;
        let decoder = FrameDecoder::new(&mut packed);
        decoder.take(room).read_to_end(bytes).map_err(|error| one_line(&error))?;
    }
    Ok(())
}

/// An error's text without line breaks.
fn one_line(error: &dyn std::error::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
