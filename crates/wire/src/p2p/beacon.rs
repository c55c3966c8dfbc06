//! Beacons: each node sends one at boot, and one a second.

use units::{Role, Volts};

use super::{Error, exactly, steps};

/// The existence of a node, in 3 bytes.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `role` | 0 head, 1 relay, 2 base | |
/// | 1 | `u8` | `state` | state of the node's agent, by its code | |
/// | 2 | `u8` | `battery` | 0 none | 20 mV |
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Beacon {
    /// The sender's role.
    pub role: Role,
    /// The state of the sender's agent: `agent::State::code`.
    pub state: u8,
    /// The sender's battery, to 20 mV; `None` where it has none or has not measured it.
    pub battery: Option<Volts>,
}

impl Beacon {
    pub(super) fn encode(&self) -> [u8; 3] {
        let role = match self.role {
            Role::Head => 0,
            Role::Relay => 1,
            Role::Base => 2,
        };
        [role, self.state, steps::voltage(self.battery)]
    }

    pub(super) fn decode(body: &[u8]) -> Result<Self, Error> {
        let [role, state, battery] = exactly(body)?;
        let role = match role {
            0 => Role::Head,
            1 => Role::Relay,
            2 => Role::Base,
            _ => return Err(Error::Code(role)),
        };
        Ok(Self { role, state, battery: steps::of_voltage(battery) })
    }
}
