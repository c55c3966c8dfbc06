//! An ELF that emulated drones run, and where in it their thoughts lie.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use agent::Outputs;
use flight::Status;
use serde::Deserialize;
use serde::de::IgnoredAny;
use virtual_crazyflie::board::Crazyflie;
use virtual_crazyflie::cpu::Program;
use virtual_crazyflie::image::Image;
use virtual_crazyflie::inspect::{Arguments, Inspector, Place};
use virtual_crazyflie::machine::{self, Machine, MachineConfig};
use virtual_crazyflie::memory::Memory;
use wire::p2p::{Counter, Epoch};

use crate::input_error::InputError;

/// What the firmware calls them.
const THOUGHTS: &str = "uchain_firmware::mind::LATEST";
const STATUS: &str = "uchain_firmware::control::STATUS";
const LINK: &str = "uchain_firmware::link::END";
const STEP: &str = "uchain_firmware::mind::step";

/// What builds it.
const BUILD: &str = "build it with `cargo fw`, or name another with --elf";

/// An ELF, read once and shared by all drones that run it.
#[derive(Clone)]
pub struct Firmware(Arc<Shared>);

struct Shared {
    path: PathBuf,
    image: Arc<Image>,
    program: Program,
    thoughts: Place,
    status: Place,
    end: Option<Place>,
    step: Option<Arguments>,
    /// Keeps the types that the places have.
    _inspector: Inspector,
}

impl Firmware {
    /// The file that `cargo fw` makes, seen from the repository.
    pub const DEFAULT: &str = "target/thumbv7em-none-eabihf/firmware/uchain-firmware";

    /// Reads an ELF.
    ///
    /// # Errors
    /// When it cannot be read, is none that could be flashed, or was built without debug
    /// information.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let bytes = std::fs::read(path).map_err(|why| {
            InputError::new(format!("cannot be read: {why}"), BUILD).in_file(path)
        })?;
        let inspector = Inspector::of(&bytes, &[THOUGHTS, STATUS, LINK], &[STEP])
            .map_err(|why| InputError::new(why, BUILD).in_file(path))?;
        let place = |name: &str| {
            let place = inspector.variable(name).map(Place::inner);
            place.ok_or_else(|| InputError::new(format!("has no {name}"), BUILD).in_file(path))
        };
        let (thoughts, status) = (place(THOUGHTS)?, place(STATUS)?);
        let end = inspector.variable(LINK).and_then(end);
        let image = Image::parse(bytes)
            .map_err(|why| InputError::new(why.to_string(), BUILD).in_file(path))?;
        let program = machine::decode(&image);
        let step = inspector.function(STEP).cloned();
        let path = path.to_owned();
        let image = Arc::new(image);
        let shared =
            Shared { path, image, program, thoughts, status, end, step, _inspector: inspector };
        Ok(Self(Arc::new(shared)))
    }

    /// Where it was read.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// The ELF.
    #[must_use]
    pub fn image(&self) -> &Arc<Image> {
        &self.0.image
    }

    /// A machine that runs it.
    pub(super) fn machine(&self, board: Crazyflie, config: MachineConfig) -> Machine<Crazyflie> {
        Machine::with_program(Arc::clone(&self.0.image), self.0.program.clone(), board, config)
    }

    /// Where the arguments of the agent's step are.
    pub(super) fn step(&self) -> Option<&Arguments> {
        self.0.step.as_ref()
    }

    /// What the agent last decided; `None` before its first step.
    pub(super) fn thoughts(&self, memory: &Memory) -> Option<Outputs> {
        self.0.thoughts.get(memory).ok().flatten()
    }

    /// What the flight code last said; `None` before its first step.
    pub(super) fn status(&self, memory: &Memory) -> Option<Status> {
        self.0.status.get(memory).ok().flatten()
    }

    /// The number of the last order that a drone's link has opened.
    pub(super) fn heeded(&self, memory: &Memory) -> Option<Counter> {
        let End::Drone(teller) = self.0.end.as_ref()?.get(memory).ok()? else { return None };
        let Number(number) = teller.last?;
        Counter::new(Epoch::new((number >> 24) as u32)?, number as u32 & 0xFF_FFFF)
    }
}

/// Where a drone's link keeps what its end of it has heard: `Airlink::end`, in a cell that is in a
/// static that is made when the keys are there.
fn end(link: &Place) -> Option<Place> {
    link.part("val")?.inner().part("value")?.inner().part("end")
}

/// What is looked at of it.
#[derive(Deserialize)]
enum End {
    Base(IgnoredAny),
    Drone(Teller),
}

#[derive(Deserialize)]
struct Teller {
    last: Option<Number>,
}

/// `wire::p2p::Counter`.
#[derive(Deserialize)]
struct Number(u64);
