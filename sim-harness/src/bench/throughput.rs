//! Drone-rounds per second: one drone, one round of 0.2 s with its four beams, its filters, its
//! packets and ten physics steps. The base, which does not fly, is not counted.

use std::time::Instant;

use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use crate::input_error::InputError;
use crate::mission::{Mission, ROUND_US, World};
use crate::scenario::Scenario;

/// What is flown.
pub const SCENARIO: &str = "s-turns-5";
/// The aim, in drone-rounds per second on one core.
pub const AIM: f64 = 1_000_000.0;
/// How many times each number of threads is measured; the best counts, as the others were
/// disturbed.
const TRIES: usize = 3;

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput {
    /// Threads.
    pub threads: usize,
    /// Drone-rounds per second over all of them.
    pub drone_rounds_per_s: f64,
    /// Over the threads times what one of them does alone: 1 is linear.
    pub scaling: f64,
}

/// Measures one thread and, where there are more cores, all of them.
///
/// # Errors
/// Where no threads can be had.
pub fn run(runs_per_thread: usize) -> Result<Vec<Throughput>, InputError> {
    let scenario = Scenario::open(SCENARIO)?;
    let world = World::of(&scenario);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut measured: Vec<Throughput> = Vec::new();
    for threads in if cores > 1 { vec![1, cores] } else { vec![1] } {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
            InputError::new(format!("cannot start {threads} threads ({error})"), "free some")
        })?;
        let missions = runs_per_thread * threads;
        let rate = (0..TRIES)
            .map(|_| pool.install(|| measure(&scenario, &world, missions)))
            .fold(0.0, f64::max);
        let alone = measured.first().map_or(rate, |one| one.drone_rounds_per_s);
        let scaling = rate / (alone * threads as f64);
        measured.push(Throughput { threads, drone_rounds_per_s: rate, scaling });
    }
    Ok(measured)
}

fn measure(scenario: &Scenario, world: &World, missions: usize) -> f64 {
    let begun = Instant::now();
    (0..missions as u64).into_par_iter().for_each(|seed| {
        let mut mission = Mission::new(scenario, world, seed);
        while !mission.is_over() {
            mission.round();
        }
        std::hint::black_box(mission.wall_contacts());
    });
    let rounds = scenario.duration_us.div_ceil(ROUND_US) as f64;
    let drones = (scenario.relays + 1) as f64;
    missions as f64 * rounds * drones / begun.elapsed().as_secs_f64()
}
