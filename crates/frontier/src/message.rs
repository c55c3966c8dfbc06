//! The packets in which a robot tells its points: at most 60 bytes each, little-endian.
//!
//! | bytes | field |
//! |---|---|
//! | 0 | the sender's number, 0 to 7; bit 7 is set where the points are occupied cells |
//! | 1 | round, which counts up with each set of points |
//! | 2 | number of this chunk, from 0 |
//! | 3 | number of chunks, at least 1 |
//! | 4.. | up to 11 points of 5 bytes: x and y in centimetres as `i16`, gain as `u8` |

use heapless::Vec;
use units::Point2;

use crate::candidate::Candidate;
use crate::cluster::ROBOTS;

/// The points of a full chunk.
pub const POINTS: usize = 11;
/// The bytes of a full chunk; a packet of the radio carries 60.
pub const MOST_CHUNK_BYTES: usize = HEADER + POINTS * POINT;

const HEADER: usize = 4;
const POINT: usize = 5;
const IS_OCCUPIED: u8 = 0x80;
const CENTIMETRES: f32 = 100.0;

/// What the points of a chunk are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Frontiers with their gain.
    Frontiers,
    /// Occupied cells, which serve the test for overlap alone; their gain is 0.
    Occupied,
}

/// One packet of a robot's points.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// The sender's number.
    pub from: u8,
    /// What the points are.
    pub content: Content,
    /// The round, which counts up with each set of points and wraps.
    pub round: u8,
    /// The number of this chunk, from 0.
    pub index: u8,
    /// The number of chunks.
    pub count: u8,
    /// The points, rounded to centimetres on the air.
    pub points: Vec<Candidate, POINTS>,
}

/// Bytes that are no chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChunkError {
    /// The length is none that a chunk can have.
    Length,
    /// The sender's number is not below [`ROBOTS`].
    Sender,
    /// The chunk's number is not below the number of chunks.
    Index,
    /// A gain is above [`grid_map::MOST_GAIN`].
    Gain,
}

impl Chunk {
    /// The chunk's bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8, MOST_CHUNK_BYTES> {
        let flag = if self.content == Content::Occupied { IS_OCCUPIED } else { 0 };
        let mut bytes = Vec::new();
        // There is room for all points of a full chunk.
        let _ = bytes.extend_from_slice(&[self.from | flag, self.round, self.index, self.count]);
        for point in &self.points {
            let [a, b] = centimetres(point.position.x).to_le_bytes();
            let [c, d] = centimetres(point.position.y).to_le_bytes();
            let _ = bytes.extend_from_slice(&[a, b, c, d, point.gain]);
        }
        bytes
    }

    /// Reads a chunk.
    ///
    /// # Errors
    /// [`ChunkError`] says what is wrong with the bytes.
    pub fn decode(bytes: &[u8]) -> Result<Self, ChunkError> {
        let (header, body) = bytes.split_first_chunk::<HEADER>().ok_or(ChunkError::Length)?;
        let [first, round, index, count] = *header;
        let from = first & !IS_OCCUPIED;
        if bytes.len() > MOST_CHUNK_BYTES || !body.len().is_multiple_of(POINT) {
            return Err(ChunkError::Length);
        }
        if usize::from(from) >= ROBOTS {
            return Err(ChunkError::Sender);
        }
        if index >= count {
            return Err(ChunkError::Index);
        }
        let is_occupied = first & IS_OCCUPIED != 0;
        let content = if is_occupied { Content::Occupied } else { Content::Frontiers };
        let points: Vec<Candidate, POINTS> =
            body.as_chunks::<POINT>().0.iter().map(point).collect();
        if points.iter().any(|point| point.gain > grid_map::MOST_GAIN) {
            return Err(ChunkError::Gain);
        }
        Ok(Self { from, content, round, index, count, points })
    }
}

fn point(&[a, b, c, d, gain]: &[u8; POINT]) -> Candidate {
    let metres = |low, high| f32::from(i16::from_le_bytes([low, high])) / CENTIMETRES;
    Candidate { position: Point2::new(metres(a, b), metres(c, d)), gain }
}

/// The nearest whole centimetre; what is beyond ±327 m is told as that.
fn centimetres(metres: f32) -> i16 {
    libm::roundf(metres * CENTIMETRES) as i16
}
