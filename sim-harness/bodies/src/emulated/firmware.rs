//! Reads an ELF that emulated drones run, and finds the address of its probe.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use flight::Status;
use input::InputError;
use onboard::probe::{self, Probe, Round};
use units::NodeId;
use virtual_crazyflie::board::{Crazyflie, RadioFirmware};
use virtual_crazyflie::cpu::Program;
use virtual_crazyflie::image::Image;
use virtual_crazyflie::machine::{self, Machine, MachineConfig};
use virtual_crazyflie::memory::Memory;
use wire::p2p::{Counter, Epoch};

use super::{Emulated, open_radio, unfit};
use scenario::Scenario;

/// How to build it.
const BUILD: &str = "build it with `cargo fw`, or name another with --elf";

/// An ELF, read once and shared by all drones that run it.
#[derive(Clone)]
pub struct Firmware {
    shared: Arc<Shared>,
    radio: Option<RadioFirmware>,
}

struct Shared {
    path: PathBuf,
    image: Arc<Image>,
    program: Program,
    /// The address of the probe.
    probe: u32,
}

impl Firmware {
    /// The file that `cargo fw` makes, seen from the repository.
    pub const DEFAULT: &str = "target/thumbv7em-none-eabihf/firmware/uchain-firmware";

    /// Reads an ELF.
    ///
    /// # Errors
    /// When the file cannot be read, is not an ELF that could be flashed, or has no probe.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let bytes = input::file::read(path, input::file::LARGEST_ELF).map_err(|why| {
            InputError::new(format!("cannot be read: {why}"), BUILD).in_file(path)
        })?;
        let image = Image::parse(bytes)
            .map_err(|why| InputError::new(why.to_string(), BUILD).in_file(path))?;
        let Some(probe) = image.address_of(probe::SYMBOL) else {
            let why = format!("has no {}", probe::SYMBOL);
            return Err(InputError::new(why, BUILD).in_file(path));
        };
        let program = machine::decode(&image);
        let (path, image) = (path.to_owned(), Arc::new(image));
        Ok(Self { shared: Arc::new(Shared { path, image, program, probe }), radio: None })
    }

    /// Adds the radio chip's own firmware, where a file with it is given.
    ///
    /// # Errors
    /// When the file has none that the chip runs.
    pub fn with_radio(self, path: Option<&Path>) -> Result<Self, InputError> {
        Ok(Self { radio: path.map(open_radio).transpose()?, ..self })
    }

    /// The radio chip's own firmware, if the drones have it in place of the model.
    #[must_use]
    pub const fn radio(&self) -> Option<&RadioFirmware> {
        self.radio.as_ref()
    }

    /// Makes the virtual drones of a mission: all that fly.
    ///
    /// # Errors
    /// When the scenario has something that the firmware does not fly with.
    pub fn fleet(&self, scenario: &Scenario, seed: u64) -> Result<Vec<Emulated>, InputError> {
        if let Some(what) = unfit(scenario) {
            let wrong = format!("the scenario has what the firmware does not fly with: {what}");
            return Err(InputError::new(wrong, "fly it with --fidelity flight"));
        }
        let flying = 0..=scenario.drones.relays as u8;
        Ok(flying.map(|node| Emulated::new(scenario, self, NodeId(node), seed)).collect())
    }

    /// The path that it was read from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.shared.path
    }

    /// The ELF.
    #[must_use]
    pub fn image(&self) -> &Arc<Image> {
        &self.shared.image
    }

    /// A machine that runs it.
    pub fn machine(&self, board: Crazyflie, config: MachineConfig) -> Machine<Crazyflie> {
        Machine::with_program(
            Arc::clone(&self.shared.image),
            self.shared.program.clone(),
            board,
            config,
        )
    }

    /// The inputs and outputs of the agent in its last round; `None` before its first round. The
    /// number counts the rounds.
    pub(super) fn round(&self, memory: &Memory) -> Option<(u32, Round)> {
        let (count, words) = self.slot(memory, Probe::ROUND_AT)?;
        Some((count, probe::round(&words)?))
    }

    /// The number of the agent's last round; 0 before its first.
    pub(super) fn rounds(&self, memory: &Memory) -> u32 {
        word(memory, self.shared.probe + Probe::ROUND_AT as u32).unwrap_or_default()
    }

    /// The status of the flight code; `None` before its first step.
    pub(super) fn status(&self, memory: &Memory) -> Option<Status> {
        probe::flight(&self.slot(memory, Probe::FLIGHT_AT)?.1)
    }

    /// The number of the last order that a drone's link has brought.
    pub(super) fn last_order(&self, memory: &Memory) -> Option<Counter> {
        let number = probe::order(&self.slot(memory, Probe::ORDER_AT)?.1)?;
        Counter::new(Epoch::new((number >> 24) as u32)?, number as u32 & 0xFF_FFFF)
    }

    /// The words of a slot of the probe, and how often it was written; `None` while it is being
    /// written, and where the firmware has another layout.
    fn slot(&self, memory: &Memory, at: usize) -> Option<(u32, Vec<u32>)> {
        let start = self.shared.probe + at as u32;
        let (count, length) = (word(memory, start)?, word(memory, start + 4)?);
        let is_whole = count != 0 && count.is_multiple_of(2);
        if word(memory, self.shared.probe)? != probe::VERSION || !is_whole {
            return None;
        }
        let words = memory.bytes(start + 8, 4 * length)?.as_chunks::<4>().0;
        Some((count, words.iter().copied().map(u32::from_le_bytes).collect()))
    }
}

fn word(memory: &Memory, address: u32) -> Option<u32> {
    memory.bytes(address, 4)?.first_chunk().copied().map(u32::from_le_bytes)
}
