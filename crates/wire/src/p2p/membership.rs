//! Messages by which nodes join and leave the chain, and are refused.

use heapless::Vec;
use units::NodeId;

use super::{Epoch, Error, exactly, steps};

/// A change in the members of the chain, in 1 byte or, where a node is refused, 5.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `change` | 1 join, 2 leave, 3 refused | |
/// | 1 | `u8` | `node` | the node that is refused, 0 to 15 | |
/// | 2 | `u24` | `epoch` | its epoch | |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Membership {
    /// The sender asks to be a member.
    Join,
    /// The sender will not transmit again.
    Leave,
    /// A node must not transmit: it has the sender's number.
    Refused {
        /// The number that both nodes have.
        node: NodeId,
        /// The epoch of the refused node, which tells the two apart.
        epoch: Epoch,
    },
}

mod code {
    pub(super) const JOIN: u8 = 1;
    pub(super) const LEAVE: u8 = 2;
    pub(super) const REFUSED: u8 = 3;
}

impl Membership {
    pub(super) fn encode(&self) -> Vec<u8, 5> {
        match *self {
            Self::Join => Vec::from_iter([code::JOIN]),
            Self::Leave => Vec::from_iter([code::LEAVE]),
            Self::Refused { node, epoch } => {
                let [e0, e1, e2] = epoch.to_bytes();
                Vec::from_iter([code::REFUSED, steps::nearest_name(node), e0, e1, e2])
            }
        }
    }

    pub(super) fn decode(body: &[u8]) -> Result<Self, Error> {
        let (&code, rest) = body.split_first().ok_or(Error::Length(0))?;
        match code {
            code::JOIN | code::LEAVE if !rest.is_empty() => Err(Error::Length(body.len())),
            code::JOIN => Ok(Self::Join),
            code::LEAVE => Ok(Self::Leave),
            code::REFUSED => {
                let [_, node, e0, e1, e2] = exactly(body)?;
                let epoch = Epoch::from_bytes([e0, e1, e2]).ok_or(Error::Reserved)?;
                Ok(Self::Refused { node: steps::of_name(node)?, epoch })
            }
            _ => Err(Error::Code(code)),
        }
    }
}
