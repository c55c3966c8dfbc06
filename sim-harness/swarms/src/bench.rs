//! Measures the paper's rule and ours side by side, and holds ours against its bounds.

#[cfg(any(unix, windows))]
use cpu_time::ThreadTime;
use virtual_forces::Config;

use crate::{Flight, Leg, Mission, Phase, Place, TooMany, Trouble, fly};

// A browser has no clock of the processor time.
#[cfg(not(any(unix, windows)))]
use std::time::Instant as ThreadTime;

/// The sizes of the swarms: the paper's, and three larger ones.
pub const SIZES: [u16; 9] = [1, 2, 3, 4, 5, 6, 12, 24, 50];
/// The largest swarm of the paper.
pub const PAPER_MOST: u16 = 6;
/// The part of the runs that larger swarms fly.
const LARGE_SHARE: usize = 10;
/// The least distance between two drones, in safety distances: the paper's claim (section 6.3.1).
pub const CLEAR: f32 = 1.3;
/// The longest crossing of six drones by our rule, in crossings by the paper's rule.
pub const CROSSING: f32 = 0.6;
/// The longest survey by our rule, in surveys by the paper's rule, and that of five drones, whose
/// rows run the shorter way.
pub const SURVEY: (f32, f32) = (1.05, 0.85);
/// The least share of the flights through e that stay connected; in a to d it is all of them.
pub const CONNECTED_IN_E: f32 = 0.99;
/// The least drone-rounds per second on one core for six drones and for fifty. JBotSim has 2,750,000
/// and 870,000.
pub const SPEED: [(u16, f64); 2] = [(6, 3_000_000.0), (50, 1_500_000.0)];

/// A rule, by the name that tables use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Its name.
    pub name: &'static str,
    /// Its configuration.
    pub config: Config,
    /// Whether its drones hear of each other's progress a round late.
    pub late_news: bool,
}

/// The rules that are compared.
pub const RULES: [Rule; 2] = [
    Rule { name: "paper", config: Config::PAPER, late_news: false },
    Rule { name: "ours", config: Config::OURS, late_news: false },
];

/// One size of swarm that flies one rule through one passage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// The rule.
    pub rule: Rule,
    /// The number of drones.
    pub drones: u16,
    /// The passage.
    pub place: Place,
}

/// What all flights of a case came to in one phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The phase.
    pub phase: Phase,
    /// Where it was flown.
    pub place: Place,
    /// The number of drones.
    pub drones: u16,
    /// The name of the rule.
    pub rule: &'static str,
    /// The flights that began the phase.
    pub runs: usize,
    /// The flights that got stuck in it.
    pub stuck: usize,
    /// The mean number of rounds of the others,
    pub steps: Option<f32>,
    /// and its standard deviation.
    pub steps_sd: Option<f32>,
    /// The mean over the others of their rounds in the ideal of the paper's table 1.
    pub ratio_to_ideal: Option<f32>,
    /// The mean over the others of the rounds of one drone in the passage.
    pub own_steps: Option<f32>,
    /// The least distance between two drones, in safety distances; none with one drone.
    pub min_drone_drone_dsafe: Option<f32>,
    /// The least distance between a wall and a drone that has left the survey, in safety distances;
    /// none where all survey.
    pub min_drone_wall_dsafe: Option<f32>,
    /// The mean number of links lost.
    pub links_lost: f32,
    /// The mean number of links made.
    pub links_made: f32,
    /// The share of the flights in which the swarm was connected after every round.
    pub connected: f32,
}

/// Returns all cases.
#[must_use]
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for rule in RULES {
        for drones in SIZES {
            cases.extend(Place::ALL.map(|place| Case { rule, drones, place }));
        }
    }
    cases
}

/// Flies a case `runs` times, from `seed` on, and returns a row for each phase that was flown. Swarms of
/// more than six drones fly a tenth of the runs.
///
/// # Errors
/// Where the number of drones is none or too large.
pub fn run(case: &Case, runs: usize, seed: u64) -> Result<Vec<Row>, TooMany> {
    Ok(rows(case, &flights(case, runs, seed)?))
}

/// Flies a case as [`run`] does, and returns the flights in the order of their seeds.
///
/// # Errors
/// Where the number of drones is none or too large.
pub fn flights(case: &Case, runs: usize, seed: u64) -> Result<Vec<Flight>, TooMany> {
    let large = case.drones > PAPER_MOST;
    let runs = if large { runs.div_ceil(LARGE_SHARE) } else { runs };
    let Case { rule: Rule { config, late_news, .. }, drones, place } = *case;
    let trouble = Trouble { late_news, ..Trouble::NONE };
    let mission = Mission { config, drones, place, until: Phase::Crossing, trouble };
    (0..runs as u64).map(|run| fly(&mission, seed.wrapping_add(run))).collect()
}

/// Returns a row for each phase that was flown. The survey, which is the same before every passage, has
/// its row with passage a alone.
#[must_use]
pub fn rows(case: &Case, flights: &[Flight]) -> Vec<Row> {
    let rows = Phase::ALL.into_iter().filter_map(|phase| {
        let legs = flights.iter().flat_map(|flight| &flight.legs);
        let legs: Vec<&Leg> = legs.filter(|leg| leg.phase == phase).collect();
        (!legs.is_empty()).then(|| row(case, phase, &legs))
    });
    rows.filter(|row| row.phase != Phase::Survey || case.place == Place::A).collect()
}

fn row(case: &Case, phase: Phase, legs: &[&Leg]) -> Row {
    let safe = case.rule.config.safety_distance().0;
    let done: Vec<(&&Leg, f32)> =
        legs.iter().filter_map(|leg| Some((leg, leg.rounds? as f32))).collect();
    let mean = |of: &dyn Fn(&Leg, f32) -> f32| {
        let sum: f32 = done.iter().map(|(leg, rounds)| of(leg, *rounds)).sum();
        (!done.is_empty()).then(|| sum / done.len() as f32)
    };
    let of_all =
        |of: &dyn Fn(&Leg) -> f32| legs.iter().map(|leg| of(leg)).sum::<f32>() / legs.len() as f32;
    let least = |of: &dyn Fn(&Leg) -> f32| {
        let least = legs.iter().map(|leg| of(leg)).fold(f32::INFINITY, f32::min) / safe;
        least.is_finite().then_some(least)
    };
    let steps = mean(&|_, rounds| rounds);
    let variance = steps.and_then(|steps| mean(&|_, rounds| (rounds - steps) * (rounds - steps)));
    Row {
        phase,
        place: case.place,
        drones: case.drones,
        rule: case.rule.name,
        runs: legs.len(),
        stuck: legs.len() - done.len(),
        steps,
        steps_sd: variance.map(f32::sqrt),
        ratio_to_ideal: mean(&|leg, rounds| rounds / leg.ideal),
        own_steps: mean(&|leg, _| leg.own_rounds).filter(|_| phase == Phase::Crossing),
        min_drone_drone_dsafe: least(&|leg| leg.closest_drones.0),
        min_drone_wall_dsafe: least(&|leg| leg.closest_wall.0),
        links_lost: of_all(&|leg| leg.links_lost as f32),
        links_made: of_all(&|leg| leg.links_made as f32),
        connected: of_all(&|leg| f32::from(u8::from(leg.connected))),
    }
}

impl Row {
    /// Returns the rounds of this row in rounds of the paper's rule, where both finish.
    #[must_use]
    pub fn over_paper(&self, rows: &[Self]) -> Option<f32> {
        let paper = rows.iter().find(|row| {
            let same = (row.phase, row.place, row.drones) == (self.phase, self.place, self.drones);
            same && row.rule == "paper"
        })?;
        Some(self.steps? / paper.steps?)
    }

    /// Returns what the row is called in a message.
    #[must_use]
    pub fn title(&self) -> String {
        let place = if self.phase == Phase::Survey { "the area" } else { self.place.name() };
        format!(
            "forces: {} of {place} with {} drones by {}",
            self.phase.name(),
            self.drones,
            self.rule
        )
    }
}

/// Returns a line for each bound that our rule misses.
#[must_use]
pub fn missed(rows: &[Row]) -> Vec<String> {
    let ours = rows.iter().filter(|row| row.rule == "ours");
    ours.flat_map(|row| {
        let misses = [too_near(row), cut(row), slow(row, rows), stuck(row)];
        misses.into_iter().flatten().map(|what| format!("{}: {what}", row.title()))
    })
    .collect()
}

fn too_near(row: &Row) -> Option<String> {
    let near = row.min_drone_drone_dsafe.filter(|near| *near < CLEAR)?;
    Some(format!("two drones {near:.2} safety distances apart; bound {CLEAR}"))
}

fn cut(row: &Row) -> Option<String> {
    let bound = if row.place == Place::E { CONNECTED_IN_E } else { 1.0 };
    let cut = row.phase == Phase::Crossing && row.connected < bound;
    cut.then(|| format!("{:.3} of the flights connected; bound {bound}", row.connected))
}

fn slow(row: &Row, rows: &[Row]) -> Option<String> {
    let bound = match row.phase {
        Phase::Survey if row.drones == 5 => SURVEY.1,
        Phase::Survey => SURVEY.0,
        Phase::Crossing if row.drones == PAPER_MOST => CROSSING,
        Phase::Setup | Phase::Crossing => return None,
    };
    let share = row.over_paper(rows).filter(|share| *share > bound)?;
    Some(format!("{share:.2} times the rounds of the paper's rule; bound {bound}"))
}

fn stuck(row: &Row) -> Option<String> {
    (row.stuck > 0).then(|| format!("{} of {} flights stuck; bound 0", row.stuck, row.runs))
}

/// Measures how many drone-rounds of a survey one core flies per second of its time: the best of
/// `tries`, as the others were disturbed.
///
/// # Errors
/// Where the number of drones is none or too large.
pub fn speed(rule: &Rule, drones: u16, tries: usize) -> Result<f64, TooMany> {
    /// The drones that one try flies, which takes a fraction of a second.
    const DRONES: u16 = 600;
    let mission = Mission {
        config: rule.config,
        drones,
        place: Place::A,
        until: Phase::Survey,
        trouble: Trouble::NONE,
    };
    let mut best = 0.0_f64;
    for _ in 0..tries {
        let began = ThreadTime::now();
        let mut rounds = 0;
        for seed in 0..u64::from(DRONES / drones.max(1)) {
            rounds += fly(&mission, seed)?.drone_rounds;
        }
        best = best.max(rounds as f64 / began.elapsed().as_secs_f64());
    }
    Ok(best)
}
