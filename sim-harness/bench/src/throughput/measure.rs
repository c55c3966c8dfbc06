//! How fast the simulator is.
//!
//! Point level is measured in drone-rounds per second, with either link: one drone, one round of
//! 0.2 s with its four beams, its filters, its words and ten physics steps. The base, which does
//! not fly, is not counted.
//!
//! Flight level is measured in drone-steps per second: one drone, one millisecond with its
//! sensors, its estimator, its controllers and its body, in the same mission. The rigid body is
//! also measured alone.

use std::time::Instant;
use world::World;

use input::InputError;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use bodies::craft::body::{BodySpec, Drive, RigidBody};
use mission::{Mission, Part, ROUND_US};
use scenario::{Fidelity, LinkModel, Scenario};

/// What is flown.
pub const SCENARIO: &str = "s-turns-5";
/// The links at point level, each with its aim in drone-rounds per second on one core.
pub const LINKS: [(LinkModel, f64); 2] =
    [(LinkModel::Exact, 300_000.0), (LinkModel::Ideal, 1_000_000.0)];
/// How many times each number of threads is measured; the best counts, as the others were
/// disturbed.
const TRIES: usize = 3;

/// The aim for the rigid body alone, in steps per second on one core,
pub const RIGID_AIM: f64 = 3_000_000.0;
/// and at flight level, in drone-steps per second on one core.
pub const FLIGHT_AIM: f64 = 2_000_000.0;
/// How long the mission at flight level is, in microseconds.
const FLIGHT_US: u64 = 20_000_000;

/// Steps of a millisecond per second on one core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// The rigid body alone.
    pub rigid: f64,
    /// Whole drones at flight level.
    pub flight: f64,
}

/// Measures one core.
///
/// # Errors
/// Where no thread can be had.
pub fn steps() -> Result<Steps, InputError> {
    let pool = pool(1)?;
    let scenario = Scenario::open(SCENARIO)?.at(Fidelity::Flight);
    let scenario = Scenario { duration_us: FLIGHT_US, ..scenario };
    let world = scenario.world();
    let best = |measure: &dyn Fn() -> f64| (0..TRIES).map(|_| measure()).fold(0.0, f64::max);
    Ok(Steps { rigid: best(&rigid), flight: pool.install(|| best(&|| flown(&scenario, &world))) })
}

/// A body that hovers, with a little of everything.
fn rigid() -> f64 {
    const STEPS: u32 = 3_000_000;
    let airframe = flight::Airframe::CRAZYFLIE_2_1;
    let spec = BodySpec::of(&airframe);
    let mut body = RigidBody::standing([0.0, 0.0], [1.0, 0.0]);
    let drive = std::hint::black_box(Drive {
        thrust: [airframe.hover_thrust(); 4],
        spin: 7_700.0,
        wind: [0.0; 3],
    });
    let begun = Instant::now();
    for n in 0..STEPS {
        // Anew every second: an undisturbed body comes to rest, in numbers too small for speed.
        if n.is_multiple_of(1_000) {
            body.launch([0.0, 0.0, 1.0], [0.1, 0.0, 0.0], [0.01, 0.02, 0.3]);
        }
        body.advance(&spec, &drive);
    }
    std::hint::black_box(body.position());
    f64::from(STEPS) / begun.elapsed().as_secs_f64()
}

/// A whole mission, the prelude not counted.
fn flown(scenario: &Scenario, world: &World) -> f64 {
    let mut mission = Mission::new(scenario, world, 1);
    let begun = Instant::now();
    while !mission.is_over() {
        mission.round();
    }
    std::hint::black_box(mission.wall_contacts());
    let steps = (scenario.duration_us / 1_000) as f64 * (scenario.drones.relays + 1) as f64;
    steps / begun.elapsed().as_secs_f64()
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, InputError> {
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
        InputError::new(format!("cannot start {threads} threads ({error})"), "free some")
    })
}

/// One measurement at point level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput {
    /// How the drones' words get from one to another.
    pub link: LinkModel,
    /// The aim, in drone-rounds per second on one core.
    pub aim: f64,
    /// Threads.
    pub threads: usize,
    /// Drone-rounds per second over all of them.
    pub drone_rounds_per_s: f64,
    /// Over the threads times what one of them does alone: 1 is linear.
    pub scaling: f64,
}

/// Measures each link on one thread and, where there are more cores, on all of them.
///
/// # Errors
/// Where no threads can be had.
pub fn run(runs_per_thread: usize) -> Result<Vec<Throughput>, InputError> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut measured: Vec<Throughput> = Vec::new();
    for (link, aim) in LINKS {
        let scenario = with_link(link)?;
        let world = scenario.world();
        let mut alone = None;
        for threads in if cores > 1 { vec![1, cores] } else { vec![1] } {
            let pool = pool(threads)?;
            let missions = runs_per_thread * threads;
            let rate = (0..TRIES)
                .map(|_| pool.install(|| measure(&scenario, &world, missions)))
                .fold(0.0, f64::max);
            let scaling = rate / (*alone.get_or_insert(rate) * threads as f64);
            measured.push(Throughput { link, aim, threads, drone_rounds_per_s: rate, scaling });
        }
    }
    Ok(measured)
}

fn with_link(link: LinkModel) -> Result<Scenario, InputError> {
    Ok(Scenario { link, ..Scenario::open(SCENARIO)? })
}

/// The share of the time that each part of the simulation takes with this link, on one thread.
///
/// # Errors
/// None, as long as the built-in scenario is sound.
pub fn profile(link: LinkModel, runs: usize) -> Result<Vec<(Part, f64)>, InputError> {
    let scenario = with_link(link)?;
    let world = scenario.world();
    let mut spent = Part::ALL.map(|part| (part, 0.0));
    for seed in 0..runs as u64 {
        let mut mission = Mission::new(&scenario, &world, seed).timed();
        while !mission.is_over() {
            mission.round();
        }
        for (sum, (_, time)) in spent.iter_mut().zip(mission.spent()) {
            sum.1 += time.as_secs_f64();
        }
    }
    let all: f64 = spent.iter().map(|(_, time)| time).sum();
    Ok(spent.iter().map(|(part, time)| (*part, time / all)).collect())
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
    let drones = (scenario.drones.relays + 1) as f64;
    missions as f64 * rounds * drones / begun.elapsed().as_secs_f64()
}
