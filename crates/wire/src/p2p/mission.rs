//! Mission messages: what a drone tells the others of its mission, for the mission alone to read.

use units::{MissionKind, Payload};

use super::{Error, MAX_BODY, fill};

/// A mission's own message, in 1 to 44 bytes.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `mission` | 0 chain, 1 swarm, 2 explore | |
/// | 1 | 0 to 43 bytes | `payload` | the mission's own bytes | |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MissionMessage {
    /// The mission that the sender flies, whose drones alone can read the payload.
    pub mission: MissionKind,
    /// What the mission tells.
    pub payload: Payload,
}

const _: () = assert!(Payload::MOST + 1 == MAX_BODY, "a payload fills a packet");

impl MissionMessage {
    pub(super) fn encode(&self, out: &mut [u8; MAX_BODY]) -> usize {
        fill(out, [&[self.mission.code()], self.payload.as_bytes()])
    }

    pub(super) fn decode(body: &[u8]) -> Result<Self, Error> {
        let (&code, payload) = body.split_first().ok_or(Error::Length(0))?;
        let payload = Payload::new(payload).ok_or(Error::Length(body.len()))?;
        let mission = MissionKind::from_code(code).ok_or(Error::Code(code))?;
        Ok(Self { mission, payload })
    }
}
