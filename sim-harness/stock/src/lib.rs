//! Simulates a drone that runs Bitcraze's crazyflie-firmware, as it is released, in the emulator,
//! with the body of a drone at flight level in a room.
//!
//! No code of this project controls this drone: Bitcraze's drivers read the emulated sensors, its
//! estimator and its controller fly the body, and its radio link answers a ground station. So its
//! flights test the models of sensors, motors, buses and chip independently of this project's
//! firmware.
//!
//! | module | what it holds |
//! |---|---|
//! | `firmware` | the ELF |
//! | [`client`] | a ground station that speaks CRTP to it, in simulated time |
//! | [`transcript`] | the traffic on its sensor buses, beside that of this project's drivers |
//! | [`served`] | the drone for cflib, over UDP |

pub mod client;
mod firmware;
pub mod served;
pub mod transcript;

use flight::FlightConfig;
use random::{Purpose, Stream};
use units::{Dbm, Point2};
use virtual_crazyflie::board::Crazyflie;
use virtual_crazyflie::machine::{Halt, Machine};
use world::Tunnel;
use world::layout::Layout;

use bodies::craft::{Craft, Surroundings};
use bodies::emulated::coupling;
use bodies::others::Others;
use scenario::Ground;
use scenario::VehicleSpec;

pub use firmware::StockFirmware;

/// Nanoseconds in the millisecond of a step.
const MS: u64 = 1_000_000;
/// The strength with which the drone hears a ground station across the room.
const ACROSS_A_ROOM: Dbm = Dbm(-50.0);
/// Half the width of the room, m: within the side rangers' reach.
const HALF_WIDTH: f32 = 1.5;

/// The drone.
pub struct StockDrone {
    machine: Machine<Crazyflie>,
    craft: Craft,
    room: Tunnel,
    vehicle: VehicleSpec,
    now_ms: u64,
}

impl StockDrone {
    /// A drone that has just been switched on, on the floor in the middle of a room.
    #[must_use]
    pub fn new(firmware: &StockFirmware, seed: u64) -> Self {
        let vehicle = VehicleSpec::DEFAULT;
        let random = Stream::new(seed, Purpose::Craft(0));
        let config = FlightConfig::CRAZYFLIE_2_1;
        let mut craft = Craft::standing(config, Point2::default(), [1.0, 0.0], &vehicle, random);
        craft.fly_from_outside();
        let machine = firmware.machine();
        Self { machine, craft, room: room(), vehicle, now_ms: 0 }
    }

    /// Milliseconds since it was switched on.
    #[must_use]
    pub const fn now_ms(&self) -> u64 {
        self.now_ms
    }

    /// The drone's body.
    #[must_use]
    pub const fn craft(&self) -> &Craft {
        &self.craft
    }

    /// The machine, for observation.
    #[must_use]
    pub const fn machine(&self) -> &Machine<Crazyflie> {
        &self.machine
    }

    /// The board, to record its buses.
    pub const fn board_mut(&mut self) -> &mut Crazyflie {
        self.machine.board_mut()
    }

    /// Simulates a millisecond.
    ///
    /// # Errors
    /// When the firmware does something that the emulator does not model.
    pub fn advance(&mut self) -> Result<(), Halt> {
        self.now_ms += 1;
        self.machine.run_until(self.now_ms * MS)?;
        self.machine.radio_runs()?;
        let around = Surroundings {
            tunnel: &self.room,
            ground: Ground::GOOD,
            vehicle: &self.vehicle,
            others: Others::NONE,
        };
        let board = self.machine.board_mut();
        let observed = self.craft.observe(around, coupling::wants(board));
        coupling::show(board, &observed);
        self.craft.obey(around, coupling::duties(&self.machine), None);
        Ok(())
    }

    /// Delivers a packet of the ground station to the drone's radio chip.
    pub fn hear(&mut self, packet: &[u8]) {
        let now = self.machine.now();
        self.machine.board_mut().hear_crtp(now, packet, ACROSS_A_ROOM);
    }

    /// The packets with which the radio chip has acknowledged those of the ground station.
    pub fn take_answers(&mut self) -> impl Iterator<Item = Vec<u8>> + use<> {
        self.machine.board_mut().take_crtp().into_iter().map(|answer| answer.data)
    }
}

fn room() -> Tunnel {
    let layout = Layout::corridor(&[[-0.05, 0.0], [0.05, 0.0]], HALF_WIDTH);
    Tunnel::dig(&layout).expect("a room is a layout that can be built")
}
