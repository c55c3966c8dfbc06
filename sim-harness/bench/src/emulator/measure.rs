//! Measures how fast the emulator is, and replays the comparison of its core with another one.

use std::path::Path;
use std::time::Instant;

use core_vectors::summary;
use input::InputError;
use rayon::ThreadPoolBuilder;
use units::NodeId;
use virtual_crazyflie::cpu::FlashTiming;
use virtual_crazyflie::speed;

use bodies::emulated::{Emulated, Firmware};
use mission::Mission;
use scenario::Scenario;

/// The scenario that is flown.
pub const SCENARIO: &str = "short-hop";
/// The aim for instructions per second, in millions, in a loop of floating-point arithmetic.
pub const MIPS_AIM: f64 = 100.0;
/// The aim for one drone on one core, in times of real time.
pub const ONE_AIM: f64 = 5.0;
/// The aim for four drones on two cores.
pub const FOUR_AIM: f64 = 2.0;
/// The simulated time that is measured, from take-off on.
const BEGINS_US: u64 = 6_000_000;
const LASTS_US: u64 = 8_000_000;
/// The number of tries, of which the fastest counts: the others were disturbed.
const TRIES: usize = 3;

/// The figures of the emulator.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Millions of instructions per second in a loop of floating-point arithmetic.
    pub mips: f64,
    /// One drone in flight on one core, in times of real time.
    pub one: f64,
    /// Four drones on two cores, in times of real time.
    pub four: f64,
    /// The number of these drones and of threads: fewer on a smaller machine.
    pub threads: usize,
    /// Millions of instructions per second of the one drone's firmware while its core did not
    /// sleep, by the emulated clock.
    pub busy: f64,
    /// The comparison with another core, replayed.
    pub compared: summary::Summary,
    /// Whether two missions with the same seed ended in the same state, on one thread and on
    /// several.
    pub deterministic: bool,
}

/// Measures all figures.
///
/// # Errors
/// When there is no ELF to fly, or it does what the emulator does not know.
pub fn run((elf, radio): (&Path, Option<&Path>), seed: u64) -> Result<Measured, InputError> {
    let firmware = Firmware::open(elf)?.with_radio(radio)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = cores.min(2);
    let best = |threads, drones| {
        (0..TRIES)
            .map(|_| fly(&firmware, seed, threads, drones))
            .reduce(|one, other| Ok(one?.better(other?)))
            .expect("there is more than one try")
    };
    let one = best(1, 1)?;
    let four = best(threads, 4)?;
    let alone = fly(&firmware, seed, 1, 4)?;
    Ok(Measured {
        mips: (0..TRIES)
            .filter_map(|_| speed::measure(FlashTiming::Ideal))
            .fold(f64::NAN, |most, speed| most.max(speed.mips)),
        one: one.times,
        four: four.times,
        threads,
        busy: one.busy,
        compared: summary::replay().unwrap_or_default(),
        deterministic: four.hashes == alone.hashes,
    })
}

/// One flight.
struct Flight {
    times: f64,
    busy: f64,
    hashes: Vec<u64>,
}

impl Flight {
    fn better(self, other: Self) -> Self {
        if self.times >= other.times { self } else { other }
    }
}

fn fly(firmware: &Firmware, seed: u64, threads: usize, count: u8) -> Result<Flight, InputError> {
    let mut scenario = Scenario::open(SCENARIO)?;
    scenario.drones.relays = usize::from(count).max(2) - 1;
    let world = scenario.world();
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
        InputError::new(format!("cannot start {threads} threads ({error})"), "free some")
    })?;
    let drones = (0..count).map(|node| Emulated::new(&scenario, firmware, NodeId(node), seed));
    let drones = drones.collect();
    pool.install(|| {
        let mut mission = Mission::emulated(&scenario, &world, seed, drones);
        mission.advance(BEGINS_US);
        let before = executed(&mission);
        let begun = Instant::now();
        mission.advance(LASTS_US);
        let elapsed = begun.elapsed().as_secs_f64();
        if let Some(halted) = mission.halted() {
            let remedy = "the emulator has to learn it";
            return Err(InputError::new(halted.to_string(), remedy).in_file(firmware.path()));
        }
        let after = executed(&mission);
        Ok(Flight {
            times: LASTS_US as f64 * 1e-6 / elapsed,
            busy: (after - before) as f64 * 1e-6 / elapsed,
            hashes: (0..usize::from(count))
                .filter_map(|n| Some(mission.emulated_drone(n)?.machine().state_hash()))
                .collect(),
        })
    })
}

/// Instructions of all drones so far.
fn executed(mission: &Mission<'_>) -> u64 {
    let drones = (0..mission.count()).filter_map(|n| mission.emulated_drone(n));
    drones.map(|drone| drone.machine().cpu().instructions()).sum()
}
