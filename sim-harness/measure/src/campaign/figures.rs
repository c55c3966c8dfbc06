//! The figures of a campaign, of runs that come one by one.

use std::io::{self, Cursor, Read, Seek, Write};

use serde_json::{Map, Value};

use super::estimate::{Estimate, Mean, share};
use super::quantiles::Quantiles;
use crate::metrics::{ExploreMetrics, HoldMetrics, RunMetrics, SwarmMetrics};
use bodies::craft::record::FlightMetrics;

/// A named figure of a campaign.
pub struct Figure {
    /// The name of the figure, including its unit.
    pub name: &'static str,
    /// The value of the figure over all runs.
    pub estimate: Estimate,
}

type Number = fn(&RunMetrics) -> f32;
type Test = fn(&RunMetrics) -> bool;

/// What a figure is of all runs.
#[derive(Clone, Copy)]
enum Of {
    Mean(Number),
    Share(Test),
    /// A quantile of the quantity of this place in [`QUANTITIES`].
    Quantile(usize, f64),
}

/// A figure that campaigns have.
struct Known {
    name: &'static str,
    of: Of,
    /// Whether a campaign has it, by its first run.
    has: Test,
}

const fn known(name: &'static str, of: Of) -> Known {
    Known { name, of, has: |_| true }
}

const fn mean(name: &'static str, of: Number) -> Known {
    known(name, Of::Mean(of))
}

const fn part(name: &'static str, has: Test, holds: Test) -> Known {
    Known { name, of: Of::Share(holds), has }
}

const fn quantile(name: &'static str, quantity: usize, q: f64) -> Known {
    known(name, Of::Quantile(quantity, q))
}

/// The quantities of which there are quantiles.
const QUANTITIES: [Number; 7] = [
    |r| r.held(|hold| hold.t3_s),
    |r| r.held(|hold| hold.t_gap1_s),
    |r| r.held(|hold| hold.t_repair_s),
    |r| r.bound_s,
    |r| r.held(|hold| hold.t_gap1_s) / r.bound_s.max(1.0),
    |r| r.t_farthest_s,
    |r| r.head_heard_until_s,
];
const T3: usize = 0;
const T_GAP1: usize = 1;
const T_REPAIR: usize = 2;
const BOUND: usize = 3;
const T_GAP1_OVER_BOUND: usize = 4;
const T_FARTHEST: usize = 5;
const HEAD_HEARD_UNTIL: usize = 6;

const ALWAYS: Test = |_| true;
/// Without a hold, no run converges.
const HOLDS: Test = |first| first.hold.is_ok();
/// Where no relay can be launched, there is no false launch.
const LAUNCHES: Test = |first| !first.launched.is_nan();
/// Where no drone is lost, nothing is repaired.
const LOSES: Test = |first| !first.held(|hold| hold.t_repair_s).is_nan();
const IS_CALLED_DOWN: Test = |first| !first.still_flying.is_nan();

/// All figures, in their order.
const FIGURES: &[Known] = &[
    part("c3", HOLDS, |r| r.held(|hold| hold.t3_s).is_finite()),
    part("c1", HOLDS, |r| r.held(|hold| hold.t1_s).is_finite()),
    part("c_gap1", HOLDS, |r| r.held(|hold| hold.t_gap1_s).is_finite()),
    quantile("t3_median_s", T3, 0.5),
    quantile("t3_p95_s", T3, 0.95),
    quantile("t_gap1_median_s", T_GAP1, 0.5),
    part("c_repair", LOSES, |r| r.held(|hold| hold.t_repair_s).is_finite()),
    quantile("t_repair_median_s", T_REPAIR, 0.5),
    quantile("t_repair_p95_s", T_REPAIR, 0.95),
    quantile("bound_s", BOUND, 0.5),
    quantile("t_gap1_over_bound", T_GAP1_OVER_BOUND, 0.5),
    mean("gap_db", |r| r.held(|hold| hold.gap_db)),
    mean("difference_db", |r| r.held(|hold| hold.difference_db)),
    mean("hold_spread_db", |r| r.held(|hold| hold.spread_db)),
    mean("swing_p95_db", |r| r.held(|hold| hold.swing_p95_db)),
    mean("position_sd_m", |r| r.held(|hold| hold.position_sd_m)),
    mean("path_m", |r| r.held(|hold| hold.path_m)),
    mean("hold_violation", |r| r.held(|hold: &HoldMetrics| hold.violation)),
    mean("relays_beyond_need", |r| r.held(|hold| hold.relays_beyond_need)),
    mean("cruise_gap_db", |r| r.cruise_gap_db),
    mean("launched", |r| r.launched),
    mean("needed", |r| r.needed),
    mean("excess", excess),
    part("false_launch", LAUNCHES, |r| excess(r) > 0.0),
    part("under_launch", LAUNCHES, |r| excess(r) < 0.0),
    mean("violation", |r| r.violation),
    mean("peak_excess_db", |r| r.peak_excess_db),
    mean("farthest_m", |r| r.farthest_m),
    quantile("t_farthest_median_s", T_FARTHEST, 0.5),
    quantile("head_heard_until_median_s", HEAD_HEARD_UNTIL, 0.5),
    part("all_down", IS_CALLED_DOWN, |r| r.still_flying == 0.0),
    part("wall_contact", ALWAYS, |r| r.wall_contacts > 0),
    part("drone_contact", ALWAYS, |r| r.drone_contacts > 0),
    part("ground_contact", ALWAYS, |r| r.ground_contacts > 0),
    part("order_lost", ALWAYS, |r| r.order_lost > 0),
    mean("swarm_finished", |r| swarm(r, |s| f32::from(u8::from(s.unfinished == 0)))),
    mean("covered", |r| swarm(r, |s| s.covered)),
    mean("surveyed_s", |r| swarm(r, |s| s.surveyed_s)),
    mean("gathered_s", |r| swarm(r, |s| s.gathered_s)),
    mean("across_s", |r| swarm(r, |s| s.across_s)),
    mean("closest_drones_m", |r| swarm(r, |s| s.closest_drones_m)),
    mean("explored", |r| explore(r, |e| e.explored)),
    mean("walls_found", |r| explore(r, |e| e.walls_found)),
    mean("false_walls", |r| explore(r, |e| e.false_walls)),
    mean("false_free", |r| explore(r, |e| e.false_free)),
    mean("t50_s", |r| explore(r, |e| e.t50_s)),
    mean("t99_s", |r| explore(r, |e| e.t99_s)),
    mean("ended", |r| explore(r, |e| f32::from(u8::from(e.unfinished == 0)))),
    mean("ended_s", |r| explore(r, |e| e.ended_s)),
    mean("explorers_apart_m", |r| explore(r, |e| e.closest_drones_m)),
    mean("max_tilt_deg", |r| flown(r, |f| f.max_tilt_deg)),
    mean("max_rate_dps", |r| flown(r, |f| f.max_rate_dps)),
    mean("velocity_error_mps", |r| flown(r, |f| f.velocity_error_mps)),
    mean("min_battery_v", |r| flown(r, |f| f.min_battery_v)),
    mean("brought_down", |r| flown(r, |f| (f.ends.iter().skip(1).sum::<u32>()) as f32)),
];

/// A figure that only swarms have.
fn swarm(run: &RunMetrics, of: impl Fn(&SwarmMetrics) -> f32) -> f32 {
    run.swarm.as_ref().map_or(f32::NAN, of)
}

/// A figure that only explorations have.
fn explore(run: &RunMetrics, of: impl Fn(&ExploreMetrics) -> f32) -> f32 {
    run.explore.as_ref().map_or(f32::NAN, of)
}

/// A figure that only rigid bodies have.
fn flown(run: &RunMetrics, of: impl Fn(&FlightMetrics) -> f32) -> f32 {
    run.flight.as_ref().map_or(f32::NAN, of)
}

/// The figures of a campaign while its runs come. Its memory does not grow with their number: what the
/// quantiles need is kept in a file.
pub struct Figures<S: Read + Write + Seek> {
    first: Option<RunMetrics>,
    runs: usize,
    /// One for each of [`FIGURES`]; of use where that is a mean.
    means: [Mean; FIGURES.len()],
    /// The same where it is a share.
    hits: [usize; FIGURES.len()],
    quantiles: Quantiles<{ QUANTITIES.len() }, S>,
}

impl<S: Read + Write + Seek> Figures<S> {
    /// No runs yet; the file, which is empty, takes 28 bytes for each of them.
    #[must_use]
    pub fn new(store: S) -> Self {
        Self {
            first: None,
            runs: 0,
            means: [Mean::default(); FIGURES.len()],
            hits: [0; FIGURES.len()],
            quantiles: Quantiles::new(store),
        }
    }

    /// Adds a run. Runs that are added in the order of their seeds give the same bits each time.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn add(&mut self, run: &RunMetrics) -> io::Result<()> {
        self.first.get_or_insert(*run);
        self.runs += 1;
        for ((figure, mean), hits) in FIGURES.iter().zip(&mut self.means).zip(&mut self.hits) {
            match figure.of {
                Of::Mean(of) => mean.add(of(run)),
                Of::Share(holds) => *hits += usize::from(holds(run)),
                Of::Quantile(..) => {}
            }
        }
        self.quantiles.add(QUANTITIES.map(|of| of(run)))
    }

    /// All figures that the scenario of the campaign has; figures that need a head in the air at the
    /// start are left out where it stands on the ground.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn finish(mut self) -> io::Result<Vec<Figure>> {
        let Some(first) = self.first else { return Ok(Vec::new()) };
        let mut figures = Vec::new();
        for (n, known) in FIGURES.iter().enumerate().filter(|(_, known)| (known.has)(&first)) {
            let estimate = match known.of {
                Of::Mean(_) => self.means[n].estimate(),
                Of::Share(_) => share(self.hits[n], self.runs),
                Of::Quantile(quantity, q) => self.quantiles.estimate(quantity, q)?,
            };
            figures.push(Figure { name: known.name, estimate });
        }
        figures.retain(|figure| !figure.estimate.value.is_nan());
        Ok(figures)
    }
}

/// All figures of these runs.
#[must_use]
pub fn figures(runs: &[RunMetrics]) -> Vec<Figure> {
    let mut figures = Figures::new(Cursor::new(Vec::new()));
    let added = runs.iter().try_for_each(|run| figures.add(run));
    match added.and_then(|()| figures.finish()) {
        Ok(figures) => figures,
        Err(_) => unreachable!("memory is written and read without errors"),
    }
}

/// The number of relays that flew, less the number that an optimal chain needs.
#[must_use]
pub fn excess(run: &RunMetrics) -> f32 {
    run.launched - run.needed
}

/// The figures as a JSON object by name.
#[must_use]
pub fn json(figures: &[Figure]) -> Value {
    let entries = figures.iter().map(|f| (f.name.to_owned(), f.estimate.json()));
    Value::Object(entries.collect::<Map<_, _>>())
}
