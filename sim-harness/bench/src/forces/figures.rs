//! Makes tables 2 and 3 of the paper on swarms by virtual forces again, and what its text says of
//! figures 12 and 14, which are pictures without values, for several readings of it.

mod claims;

use rayon::prelude::*;
use serde_json::{Value, json};
use swarms::bench::{Case, PAPER_MOST, Row, Rule, flights, rows};
use swarms::{Flight, Leg, Phase, Place, TooMany};
use units::Metres;
use virtual_forces::{Config, ObstacleForce, Sweep, Weight};

/// Table 2 of the paper: mean rounds of a survey with 1 to 6 drones.
pub const TABLE_2: [f32; 6] = [1210.0, 764.0, 555.0, 425.0, 416.0, 233.0];
/// Table 3 of the paper: mean number of links lost in a survey with 2 to 6 drones.
pub const TABLE_3: [f32; 5] = [0.05, 0.09, 0.77, 2.03, 3.51];

/// The readings of the paper's open points, and our rule.
#[must_use]
pub fn readings() -> [Rule; 7] {
    let paper = Config::PAPER;
    let rule = |name, config| Rule { name, config, late_news: false };
    let passing = Config { tolerance: Metres(0.015), stops_on_goals: false, ..paper };
    let mirrored = Config { sweep: Sweep::Mirror, tolerance: Metres(0.04), ..paper };
    [
        rule("literal", paper),
        Rule { name: "late-news", config: passing, late_news: true },
        rule("mirrored", mirrored),
        rule("signed-weight", Config { weight: Weight::Signed, ..paper }),
        rule("linear-obstacles", Config { obstacle: ObstacleForce::Linear, ..paper }),
        rule("far-obstacles", Config { obstacle_range: Metres(0.9), ..paper }),
        rule("ours", Config::OURS),
    ]
}

/// All flights of one case.
struct Flown {
    case: Case,
    flights: Vec<Flight>,
}

impl Flown {
    /// The phase in the flight of each seed; `None` where the swarm got stuck before it.
    fn legs(&self, phase: Phase) -> impl Iterator<Item = Option<&Leg>> {
        self.flights.iter().map(move |flight| flight.legs.iter().find(|leg| leg.phase == phase))
    }

    /// The rounds that a phase took in the flight of each seed; infinite where the swarm got stuck.
    fn rounds(&self, phase: Phase) -> Vec<f64> {
        self.legs(phase).map(|leg| rounds(leg).unwrap_or(f64::INFINITY)).collect()
    }

    /// The same in ideal durations.
    fn ratios(&self, phase: Phase) -> Vec<f64> {
        let ratio = |leg: &Leg| Some(rounds(Some(leg))? / f64::from(leg.ideal));
        self.legs(phase).map(|leg| leg.and_then(ratio).unwrap_or(f64::INFINITY)).collect()
    }
}

fn rounds(leg: Option<&Leg>) -> Option<f64> {
    leg?.rounds.map(f64::from)
}

/// All flights of one reading.
pub struct Reading {
    /// The rule that was flown.
    pub rule: Rule,
    /// A row for each phase of each case.
    pub rows: Vec<Row>,
    flown: Vec<Flown>,
}

/// The number of cases that [`make`] flies.
#[must_use]
pub fn cases() -> usize {
    readings().len() * usize::from(PAPER_MOST) * Place::ALL.len()
}

/// Flies every reading with 1 to 6 drones through every passage, `runs` times each from `seed` on.
///
/// # Errors
/// None, as long as a swarm may have six drones.
pub fn make(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Result<Vec<Reading>, TooMany> {
    let made = readings().into_iter().map(|rule| {
        let drones = (1..=PAPER_MOST).into_par_iter();
        let cases = drones.flat_map_iter(|drones| {
            Place::ALL.into_iter().map(move |place| Case { rule, drones, place })
        });
        let flown = cases.map(|case| {
            let flights = flights(&case, runs, seed)?;
            after_each();
            Ok(Flown { case, flights })
        });
        let flown: Vec<Flown> = flown.collect::<Result<_, TooMany>>()?;
        let rows = flown.iter().flat_map(|one| rows(&one.case, &one.flights)).collect();
        Ok(Reading { rule, rows, flown })
    });
    made.collect()
}

impl Reading {
    fn flown(&self, place: Place, drones: u16) -> Option<&Flown> {
        self.flown.iter().find(|one| (one.case.place, one.case.drones) == (place, drones))
    }

    fn row(&self, phase: Phase, place: Place, drones: u16) -> Option<&Row> {
        self.rows.iter().find(|row| (row.phase, row.place, row.drones) == (phase, place, drones))
    }

    /// Returns the row of a survey.
    #[must_use]
    pub fn survey(&self, drones: u16) -> Option<&Row> {
        self.row(Phase::Survey, Place::A, drones)
    }

    /// Returns the mean ratio of a phase to its ideal, as in figures 12 and 14; infinite where no
    /// flight finished.
    #[must_use]
    pub fn ratio(&self, phase: Phase, place: Place, drones: u16) -> f32 {
        let ratio = self.row(phase, place, drones).and_then(|row| row.ratio_to_ideal);
        ratio.unwrap_or(f32::INFINITY)
    }

    /// The rounds that the survey of each flight took; infinite where the swarm got stuck.
    #[must_use]
    pub fn survey_rounds(&self, drones: u16) -> Vec<f32> {
        self.of(Place::A, drones, |flown| flown.rounds(Phase::Survey))
    }

    /// The links that were lost in the survey of each flight that ended.
    #[must_use]
    pub fn survey_links_lost(&self, drones: u16) -> Vec<f32> {
        let lost = |flown: &Flown| {
            let legs = flown.legs(Phase::Survey).flatten().filter(|leg| leg.rounds.is_some());
            legs.map(|leg| f64::from(leg.links_lost)).collect()
        };
        self.of(Place::A, drones, lost)
    }

    /// The ratios of a phase to its ideal in each flight, as in figures 12 and 14; infinite where the swarm got stuck.
    #[must_use]
    pub fn leg_ratios(&self, phase: Phase, place: Place, drones: u16) -> Vec<f32> {
        self.of(place, drones, |flown| flown.ratios(phase))
    }

    fn of(&self, place: Place, drones: u16, values: impl Fn(&Flown) -> Vec<f64>) -> Vec<f32> {
        let values = self.flown(place, drones).map(values).unwrap_or_default();
        values.into_iter().map(|value| value as f32).collect()
    }

    /// The reading as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let claims: Vec<Value> = self.claims().iter().map(::measure::claim::Claim::json).collect();
        let rows: Vec<Value> =
            self.rows.iter().map(|row| super::measure::json(row, &self.rows)).collect();
        json!({ "reading": self.rule.name, "claims": claims, "rows": rows })
    }
}

#[cfg(test)]
mod tests;
