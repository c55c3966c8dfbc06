//! [`Opened`], a packet as all nodes with the fleet's key read it.

use units::Duration;
use wire::p2p::{Header, MAX_BODY, Message, TAG};

use crate::counters::Reason;
use crate::nonce;
use crate::schedule::Schedule;
use crate::seal::{Scope, Seal};

/// A packet whose hop has been opened and whose message has been decoded, or why it could not be.
/// Nothing in it depends on the node that received the packet.
#[derive(Clone, Debug)]
pub struct Opened {
    pub(super) content: Result<Content, Reason>,
}

/// What is in a packet whose tag is right.
#[derive(Clone, Debug)]
pub(super) struct Content {
    pub(super) header: Header,
    /// Time from the beginning of the sender's frame to the packet's arrival.
    pub(super) since_frame: Duration,
    /// `None` if the body is no message.
    pub(super) message: Option<Message>,
}

impl Opened {
    pub(super) fn open(seal: &impl Seal, schedule: &Schedule, data: &[u8]) -> Self {
        Self { content: Content::open(seal, schedule, data) }
    }
}

impl Content {
    fn open(seal: &impl Seal, schedule: &Schedule, data: &[u8]) -> Result<Self, Reason> {
        let (header, rest) = Header::decode(data).map_err(|_| Reason::Malformed)?;
        let (sealed, tag) = rest.split_last_chunk::<TAG>().ok_or(Reason::Malformed)?;
        let mut bytes = [0; MAX_BODY];
        let body = bytes.get_mut(..sealed.len()).ok_or(Reason::Malformed)?;
        body.copy_from_slice(sealed);
        if !schedule.has_turns(header.from) {
            return Err(Reason::NoSlot);
        }
        let encoded = header.encode();
        if !seal.open(Scope::Fleet, &nonce::hop(encoded), &encoded, body, tag) {
            return Err(Reason::Tag);
        }
        let message = Message::decode(header.kind, body).ok();
        let since_frame = schedule.since_frame(&header, data.len());
        Ok(Self { header, since_frame, message })
    }
}
