//! One or two commands in one packet.

use super::{Capsule, Error, MAX_BODY, ORDER, TAG, steps};

/// Bytes of one command.
const ONE: usize = 7 + ORDER + TAG;

const _: () = assert!(2 * ONE <= MAX_BODY, "two commands are one packet");

/// One command, or two for two nodes, the more urgent one first, in 19 bytes each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Commands {
    /// The first command.
    pub first: Capsule<ORDER>,
    /// The second command. One for the same node as the first is left out on the air.
    pub second: Option<Capsule<ORDER>>,
}

impl Commands {
    pub(super) fn encode(&self, out: &mut [u8; MAX_BODY]) -> usize {
        let name = |capsule: &Capsule<ORDER>| steps::nearest_name(capsule.node);
        let second = self.second.filter(|second| name(second) != name(&self.first));
        let mut length = self.first.encode(out);
        if let Some(second) = second {
            let mut bytes = [0; MAX_BODY];
            let end = length + second.encode(&mut bytes);
            if let (Some(room), Some(bytes)) = (out.get_mut(length..end), bytes.get(..end - length))
            {
                room.copy_from_slice(bytes);
                length = end;
            }
        }
        length
    }

    pub(super) fn decode(body: &[u8]) -> Result<Self, Error> {
        let Some((first, second)) = body.split_at_checked(ONE).filter(|(_, rest)| !rest.is_empty())
        else {
            return Ok(Self { first: Capsule::decode(body)?, second: None });
        };
        let length = |_| Error::Length(body.len());
        let second: &[u8; ONE] = second.try_into().map_err(length)?;
        let (first, second) = (Capsule::decode(first)?, Capsule::decode(second)?);
        if first.node == second.node {
            return Err(Error::Reserved);
        }
        Ok(Self { first, second: Some(second) })
    }
}

impl From<Capsule<ORDER>> for Commands {
    fn from(first: Capsule<ORDER>) -> Self {
        Self { first, second: None }
    }
}
