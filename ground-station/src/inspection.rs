//! Asks one drone by CRTP what a pre-flight check looks at: version, limits, decks and battery.
//!
//! An inspection owns no clock and no socket, as a [`Session`](crate::session::Session). It only
//! reads, so that every drone of a chain answers it.

use std::collections::BTreeMap;

use units::{Duration, Instant};
use wire::crtp::{LogType, Packet, ParamRequest, PlatformRequest, Port, Request};

use crate::blocks::BlockSetup;
use crate::table::{Rows, Service, TableReader};

/// The time after which a question without an answer is asked again.
const AGAIN: Duration = Duration::from_millis(300);

/// The parameters that are read.
const PARAMETERS: [&str; 10] = [
    "uchain.node",
    "uchain.role",
    "uchain.launchLimit",
    "uchain.retreatLimit",
    "uchain.height",
    "deck.bcFlow2",
    "deck.bcMultiranger",
    "firmware.revision0",
    "firmware.revision1",
    "firmware.radio",
];

/// The log block that is read, and its variables in the order in which `Inspection::receive` reads
/// them.
const BLOCK: u8 = 0;
const VARIABLES: [(&str, LogType); 2] =
    [("pm.vbat", LogType::F32), ("supervisor.info", LogType::U16)];

/// What a drone has told of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told {
    /// The firmware's version.
    pub version: String,
    /// The values of the parameters that the drone has, as bytes.
    parameters: BTreeMap<&'static str, Vec<u8>>,
    /// The battery's voltage; 0 while the drone does not know it.
    pub battery_v: f32,
    /// The bits of `supervisor.info`.
    pub supervisor: u16,
    /// What the drone has printed on its console meanwhile.
    pub console: String,
}

impl Told {
    /// A parameter of one byte.
    #[must_use]
    pub fn byte(&self, name: &str) -> Option<u8> {
        self.parameters.get(name)?.first().copied()
    }

    /// A parameter that is a `float`.
    #[must_use]
    pub fn float(&self, name: &str) -> Option<f32> {
        let (bytes, _) = self.parameters.get(name)?.split_first_chunk::<4>()?;
        Some(f32::from_le_bytes(*bytes))
    }

    /// The first 12 hexadecimal digits of the firmware's revision.
    #[must_use]
    pub fn revision(&self) -> Option<String> {
        let (first, _) = self.parameters.get("firmware.revision0")?.split_first_chunk::<4>()?;
        let (next, _) = self.parameters.get("firmware.revision1")?.split_first_chunk::<2>()?;
        Some(format!("{:08x}{:04x}", u32::from_le_bytes(*first), u16::from_le_bytes(*next)))
    }

    /// The release of the radio chip's firmware, such as `2025.02`; `None` where the drone does not
    /// know it, or it is no release of the vendor's.
    #[must_use]
    pub fn radio(&self) -> Option<String> {
        let (bytes, _) = self.parameters.get("firmware.radio")?.split_first_chunk::<4>()?;
        let release = u32::from_le_bytes(*bytes);
        (release != 0).then(|| format!("{:04}.{:02}", release / 100, release % 100))
    }
}

/// How far the inspection has come.
#[derive(Debug)]
enum Stage {
    Version(Option<Instant>),
    Table(TableReader),
    Values {
        rows: Rows,
        /// The number of [`PARAMETERS`] that are known, or that the drone does not have.
        read: usize,
        asked: Option<Instant>,
    },
    Log(TableReader),
    Block(BlockSetup),
    Measuring,
    Done,
}

/// An inspection of one drone.
#[derive(Debug)]
pub struct Inspection {
    stage: Stage,
    told: Told,
}

impl Default for Inspection {
    fn default() -> Self {
        Self { stage: Stage::Version(None), told: Told::default() }
    }
}

impl Inspection {
    /// What the drone has told, once it has told everything.
    #[must_use]
    pub const fn done(&self) -> Option<&Told> {
        match self.stage {
            Stage::Done => Some(&self.told),
            _ => None,
        }
    }

    /// The next packet to be sent, if one is due.
    pub fn poll(&mut self, now: Instant) -> Option<Packet> {
        let is_due = |asked: &mut Option<Instant>| {
            let due = asked.is_none_or(|asked| now.since(asked) >= AGAIN);
            if due {
                *asked = Some(now);
            }
            due
        };
        match &mut self.stage {
            Stage::Version(asked) => {
                is_due(asked).then(|| Request::Platform(PlatformRequest::Firmware).packet())
            }
            Stage::Table(reader) | Stage::Log(reader) => reader.poll(now),
            Stage::Values { rows, read, asked } => {
                let row = rows.get(*PARAMETERS.get(*read)?)?;
                is_due(asked).then(|| Request::Param(ParamRequest::Read(*row)).packet())
            }
            Stage::Block(setup) => setup.poll(now),
            Stage::Measuring | Stage::Done => None,
        }
    }

    /// Takes a packet of the drone.
    pub fn receive(&mut self, packet: &Packet) {
        if packet.port() == Ok(Port::Console) {
            let text = String::from_utf8_lossy(packet.data());
            self.told.console.push_str(text.trim_matches('\0'));
        }
        match &mut self.stage {
            Stage::Version(_) => {
                if let (Ok(Port::Platform), 1, [1, version @ ..]) =
                    (packet.port(), packet.channel(), packet.data())
                {
                    let version = String::from_utf8_lossy(version);
                    self.told.version = version.trim_matches('\0').to_owned();
                    self.stage = Stage::Table(TableReader::new(Service::Param));
                }
            }
            Stage::Table(reader) => {
                if let Some(rows) = reader.receive(packet) {
                    self.stage = next_value(rows, 0);
                }
            }
            Stage::Values { rows, read, .. } => {
                let Some(name) = PARAMETERS.get(*read) else { return };
                let (Ok(Port::Param), 1, [a, b, 0, value @ ..]) =
                    (packet.port(), packet.channel(), packet.data())
                else {
                    return;
                };
                if rows.get(*name) == Some(&u16::from_le_bytes([*a, *b])) {
                    self.told.parameters.insert(name, value.to_vec());
                    self.stage = next_value(std::mem::take(rows), *read + 1);
                }
            }
            Stage::Log(reader) => {
                if let Some(rows) = reader.receive(packet) {
                    let setup = BlockSetup::of_one(BLOCK, &VARIABLES, &rows);
                    self.stage = setup.map_or(Stage::Done, Stage::Block);
                }
            }
            Stage::Block(setup) => {
                setup.receive(packet);
                if setup.is_done() {
                    self.stage = Stage::Measuring;
                }
            }
            Stage::Measuring => {
                if let (Ok(Port::Log), 2, [BLOCK, _, _, _, a, b, c, d, e, f, ..]) =
                    (packet.port(), packet.channel(), packet.data())
                {
                    self.told.battery_v = f32::from_le_bytes([*a, *b, *c, *d]);
                    self.told.supervisor = u16::from_le_bytes([*e, *f]);
                    self.stage = Stage::Done;
                }
            }
            Stage::Done => {}
        }
    }
}

/// The question for the next parameter that the drone has, or what follows the last one.
fn next_value(rows: Rows, from: usize) -> Stage {
    let next = (from..PARAMETERS.len())
        .find(|index| PARAMETERS.get(*index).is_some_and(|name| rows.contains_key(*name)));
    match next {
        Some(read) => Stage::Values { rows, read, asked: None },
        None => Stage::Log(TableReader::new(Service::Log)),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use crtp::{Access, Outcome, Parameters, Server, Snapshot};
    use units::{NodeId, Role};
    use wire::syslink::Release;

    use super::*;

    /// Asks a drone with these parameters, which any client may read and none may change, and which
    /// stands on the ground.
    pub(crate) fn inspect(mut parameters: Parameters) -> Told {
        let (mut server, mut snapshot) = (Server::new(), Snapshot::DEFAULT);
        snapshot.state = Some(agent::State::Idle);
        let mut inspection = Inspection::default();
        for now in (0..10_000).step_by(10).map(Instant::from_millis) {
            snapshot.taken = now;
            while let Some(packet) = inspection.poll(now) {
                server.receive(now, packet.bytes(), Access::Read, &mut parameters, |_, _| {
                    Outcome::Done
                });
            }
            while let Some(packet) = server.poll(now, &snapshot, &parameters) {
                inspection.receive(&packet);
            }
        }
        inspection.done().expect("a drone has told everything within ten seconds").clone()
    }

    #[test]
    fn a_drone_that_may_be_read_tells_everything() {
        let mut parameters = Parameters::DEFAULT;
        (parameters.about.node, parameters.about.role) = (NodeId(3), Role::Relay);
        parameters.about.revision = 0x0123_4567_89AB;
        parameters.about.has_flow = true;
        parameters.about.radio = Some(Release { year: 2025, month: 2 });
        let told = inspect(parameters);
        assert_eq!(told.radio().as_deref(), Some("2025.02"));
        assert!(told.version.starts_with("uchain"), "{}", told.version);
        assert_eq!(told.revision().as_deref(), Some("0123456789ab"));
        assert_eq!((told.byte("uchain.node"), told.byte("deck.bcFlow2")), (Some(3), Some(1)));
        assert_eq!(told.float("uchain.launchLimit"), Some(parameters.launch_limit.0));
    }
}
