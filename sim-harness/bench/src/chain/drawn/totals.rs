//! Sums up many missions in drawn places, beside the bounds that they are to keep.

use serde_json::{Map, Value, json};

use super::{Cause, Flown};
use crate::chain::cases::Bound;
use measure::campaign::{Estimate, fraction, mean};

/// A figure of many missions, and its bound if it has one.
#[derive(Clone, Copy, Debug)]
pub struct Total {
    /// The name.
    pub name: &'static str,
    /// The value, with its interval.
    pub estimate: Estimate,
    /// What it is to be: our own bound.
    pub bound: Option<Bound>,
}

impl Total {
    /// Whether the bound is missed.
    #[must_use]
    pub fn misses(&self) -> bool {
        self.bound.is_some_and(|bound| !bound.is_met_by(Some(self.estimate.value)))
    }
}

/// A cause, and the missions in which it came first.
#[derive(Clone, Debug)]
pub struct First {
    /// The cause.
    pub cause: Cause,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// In how many missions it came at all.
    pub at_all: usize,
}

/// All missions of one policy.
#[derive(Clone, Debug)]
pub struct Totals {
    /// The policy.
    pub policy: String,
    /// The number of missions.
    pub missions: usize,
    /// The figures.
    pub figures: Vec<Total>,
    /// What went wrong first, the most frequent cause first.
    pub causes: Vec<First>,
}

impl Totals {
    /// Sums up the missions of a policy.
    #[must_use]
    pub fn of(policy: &str, flown: &[&Flown]) -> Self {
        let part = |name, bound, holds: fn(&Flown) -> bool| Total {
            name,
            estimate: fraction(flown, |flown| holds(flown)),
            bound,
        };
        let value = |name, bound, of: fn(&Flown) -> f32| {
            let known: Vec<_> = flown.iter().filter(|flown| of(flown).is_finite()).collect();
            Total { name, estimate: mean(&known, |flown| of(flown)), bound }
        };
        let (most, least) = (|bound| Some(Bound::Most(bound)), |bound| Some(Bound::Least(bound)));
        let figures = vec![
            part("good", None, |flown| flown.wrong.is_empty()),
            part("deep_in_time", least(0.98), |flown| flown.is_quick()),
            part("deep", None, Flown::is_deep),
            value("depth_ratio", None, |flown| flown.depth_m / flown.oracle_m),
            value("time_ratio", None, |flown| flown.deep_s / flown.oracle_s),
            part("deadlock", most(0.0), |flown| flown.has(Cause::Deadlock)),
            part("touched", most(0.001), |flown| flown.walls + flown.drones > 0),
            part("order_lost", most(0.001), |flown| flown.disordered > 0),
            part("home_and_apart", least(0.995), Flown::is_home),
            part("left_inside", None, |flown| !flown.left.is_empty()),
            value("below_limit", most(0.05), |flown| flown.weak),
            value("relays_beyond_need", None, |flown| {
                flown.surplus.map_or(f32::NAN, |surplus| surplus as f32)
            }),
            value("rest_m", None, |flown| flown.rest_m),
            value("swing_p95_db", None, |flown| flown.swing_db),
            part("beats_oracle", most(0.0), |flown| flown.beats_oracle),
        ];
        let first = |cause| {
            let is_first = |flown: &&&Flown| flown.first_wrong().is_some_and(|(_, it)| it == cause);
            let seeds = flown.iter().filter(is_first).map(|flown| flown.seed).collect();
            let at_all = flown.iter().filter(|flown| flown.has(cause)).count();
            First { cause, seeds, at_all }
        };
        let mut causes: Vec<_> = Cause::ALL.into_iter().map(first).collect();
        causes.retain(|first| first.at_all > 0);
        causes.sort_by_key(|first| std::cmp::Reverse(first.seeds.len()));
        Self { policy: policy.to_owned(), missions: flown.len(), figures, causes }
    }

    /// The totals as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let figure = |total: &Total| {
            let Estimate { value, interval } = total.estimate;
            let (low, high) = interval.unzip();
            let bound = total.bound.map(|bound| match bound {
                Bound::Most(most) => json!({ "most": most, "met": !total.misses() }),
                Bound::Least(least) => json!({ "least": least, "met": !total.misses() }),
            });
            let value = json!({ "value": value, "low": low, "high": high, "bound": bound });
            (total.name.to_owned(), value)
        };
        let figures: Map<_, _> = self.figures.iter().map(figure).collect();
        let causes = self.causes.iter().map(|first| {
            json!({ "first": first.cause.name(), "seeds": first.seeds, "at_all": first.at_all })
        });
        json!({
            "policy": self.policy,
            "missions": self.missions,
            "figures": figures,
            "causes": causes.collect::<Vec<_>>(),
        })
    }
}
