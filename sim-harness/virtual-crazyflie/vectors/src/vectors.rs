//! Reads and writes the file of outcomes on which both cores agreed.
//!
//! `vectors/README.md` has the format.

use crate::outcome::Outcome;
use crate::rig::Rig;
use crate::state::States;

/// The number of states that are kept for each encoding.
pub const STATES: usize = 16;
/// The seed of the states.
pub const SEED: u64 = 0x0D01_0403;

const MAGIC: &[u8; 8] = b"CM4FVEC1";

/// The kept outcomes of one encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vector {
    /// The instruction.
    pub encoding: u32,
    /// Which of the states are compared, one bit each: the others faulted, or differ for a reason.
    pub compared: u16,
    /// The value of [`crate::After::hash`] after each of them; zero where it is not compared.
    pub hashes: [u32; STATES],
}

impl Vector {
    /// The states for which our core's outcome is not the one that is kept.
    #[must_use]
    pub fn wrong(&self, rig: &mut Rig) -> Vec<usize> {
        States::of(self.encoding, SEED)
            .take(STATES)
            .enumerate()
            .filter(|(index, _)| self.compared >> index & 1 == 1)
            .filter(|(index, state)| match rig.run(self.encoding, state) {
                Outcome::Done(after) => after.hash() != self.hashes[*index],
                Outcome::Fault(_) | Outcome::Other(_) => true,
            })
            .map(|(index, _)| index)
            .collect()
    }
}

/// Writes the file.
#[must_use]
pub fn write(vectors: &[Vector]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    for vector in vectors {
        bytes.extend(vector.encoding.to_le_bytes());
        bytes.extend(vector.compared.to_le_bytes());
        for (index, hash) in vector.hashes.iter().enumerate() {
            if vector.compared >> index & 1 == 1 {
                bytes.extend(hash.to_le_bytes());
            }
        }
    }
    bytes
}

/// Reads a file; `None` if its format is wrong.
#[must_use]
pub fn read(bytes: &[u8]) -> Option<Vec<Vector>> {
    let mut rest = bytes.strip_prefix(MAGIC)?;
    let mut vectors = Vec::new();
    while !rest.is_empty() {
        let encoding = u32::from_le_bytes(take(&mut rest)?);
        let compared = u16::from_le_bytes(take(&mut rest)?);
        let mut hashes = [0; STATES];
        for (index, hash) in hashes.iter_mut().enumerate() {
            if compared >> index & 1 == 1 {
                *hash = u32::from_le_bytes(take(&mut rest)?);
            }
        }
        vectors.push(Vector { encoding, compared, hashes });
    }
    Some(vectors)
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, remaining) = rest.split_first_chunk::<N>()?;
    *rest = remaining;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_can_be_read() {
        let mut hashes = [0; STATES];
        (hashes[0], hashes[15]) = (1, 2);
        let vectors = [
            Vector { encoding: 0xBF00, compared: 0x8001, hashes },
            Vector { encoding: 0xEE30_0A81, compared: 0, hashes: [0; STATES] },
        ];
        assert_eq!(read(&write(&vectors)).as_deref(), Some(&vectors[..]));
        assert_eq!(read(b"CM4FVEC1\0"), None);
        assert_eq!(read(b"no vectors"), None);
    }
}
