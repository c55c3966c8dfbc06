//! Signposts: one entry of the list of the pilot's choices at junctions, in a report.

use units::{Branch, Metres, SIGNPOSTS, Signpost};

use super::{Error, steps};

/// Bytes of a [`Signpost`].
pub const SIGNPOST: usize = 4;

/// Steps of the way in one metre.
const WAY: f32 = 16.0;

/// The bytes of `post`; `None` where its numbers contradict each other, or are none:
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `revision` | number of the list of the pilot's choices | |
/// | 1 | bits 0–2 | `index` | number of this entry in the list, from 0 | |
/// | 1 | bits 3–5 | `last` | number of the last entry in the list | |
/// | 1 | bits 6–7 | `branch` | 0 none, 1 left, 2 right, 3 straight | |
/// | 2 | `i16` | `from` | way by the head's odometer from which on the choice counts | 1/16 m |
#[must_use]
pub fn encode_signpost(post: Signpost) -> Option<[u8; SIGNPOST]> {
    let last = post.count.checked_sub(1)?;
    if post.index > last || usize::from(post.count) > SIGNPOSTS {
        return None;
    }
    let [f0, f1] = steps::short(steps::number(post.from.0)? * WAY).to_le_bytes();
    Some([post.revision, post.index | last << 3 | Branch::code(post.branch) << 6, f0, f1])
}

/// The signpost in these bytes.
///
/// # Errors
/// [`Error::Reserved`] where the entry's number is beyond the list's last one.
pub fn decode_signpost([revision, codes, f0, f1]: [u8; SIGNPOST]) -> Result<Signpost, Error> {
    let (index, last) = (codes & 0b111, codes >> 3 & 0b111);
    if index > last {
        return Err(Error::Reserved);
    }
    let from = Metres(f32::from(i16::from_le_bytes([f0, f1])) / WAY);
    Ok(Signpost { revision, index, count: last + 1, from, branch: steps::of_branch(codes >> 6)? })
}
