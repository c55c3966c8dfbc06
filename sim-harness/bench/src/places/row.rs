//! The missions to one depth of a route as a row, and the sums of all rows.

use std::collections::{BTreeMap, BTreeSet};

use scenario::Fidelity;
use serde_json::{Value, json};

use super::depth::Target;
use super::flown::Flight;

/// The share of missions that must arrive, be linked and come home, by fidelity: our own bounds.
const fn least_good(fidelity: Fidelity) -> f64 {
    if matches!(fidelity, Fidelity::Point) { 0.97 } else { 0.90 }
}
/// The head stands for no larger part of the exploration.
const MOST_STOOD: f64 = 0.05;

/// The missions to one depth of a route; none where the place was refused.
pub(super) struct Row {
    pub(super) place: String,
    pub(super) from: String,
    pub(super) depth_m: Option<f32>,
    pub(super) relays: Option<usize>,
    pub(super) fidelity: Fidelity,
    pub(super) flights: Vec<Flight>,
    /// Why there is no mission.
    pub(super) refused: Option<String>,
}

impl Row {
    pub(super) fn of(
        target: &Target<'_>,
        fidelity: Fidelity,
        flights: impl Iterator<Item = Flight>,
    ) -> Self {
        let plan = target.mission.as_ref();
        Self {
            place: target.place.to_owned(),
            from: target.from.to_owned(),
            depth_m: target.depth_m,
            relays: plan.ok().map(|plan| plan.scenario.drones.relays),
            fidelity,
            flights: flights.collect(),
            refused: plan.err().cloned(),
        }
    }

    /// How many of its missions are so.
    pub(super) fn count(&self, is: impl Fn(&Flight) -> bool) -> usize {
        self.flights.iter().filter(|flight| is(flight)).count()
    }

    /// The mean of a figure over the missions that have it.
    pub(super) fn mean(&self, of: impl Fn(&Flight) -> Option<f32>) -> Option<f64> {
        mean(self.flights.iter().filter_map(of))
    }

    /// The sum of the touches.
    pub(super) fn touches(&self) -> u32 {
        self.flights.iter().map(|flight| flight.touches).sum()
    }

    /// Why there is no mission, or the causes of those that are not good, the most frequent first.
    pub(super) fn why(&self) -> String {
        self.refused.clone().unwrap_or_else(|| told(&causes(self.flights.iter())))
    }

    /// The scenarios of its missions that are not good, with their seeds.
    pub(super) fn failed(&self) -> impl Iterator<Item = (u64, &str)> {
        let failed = self.flights.iter().filter(|flight| !flight.is_good());
        failed.map(|flight| (flight.flown.seed, &*flight.file))
    }

    /// The beginning of the names of its missions' files, in letters and digits.
    fn stem(&self) -> String {
        let plain = |text: &str| text.replace(|it: char| !it.is_alphanumeric(), "-");
        let (place, from) = (plain(&self.place), plain(&self.from));
        format!("{place}-from-{from}-{}", self.depth_m.unwrap_or(0.0))
    }

    /// The row as one JSON object.
    pub(super) fn json(&self) -> Value {
        let has = !self.flights.is_empty();
        let count = |is: fn(&Flight) -> bool| has.then(|| self.count(is));
        json!({
            "place": self.place,
            "from": self.from,
            "depth_m": self.depth_m,
            "relays": self.relays,
            "fidelity": self.fidelity.name(),
            "runs": self.flights.len(),
            "arrived": count(Flight::has_arrived),
            "home": count(|flight| flight.flown.is_home()),
            "linked": count(|flight| flight.is_linked),
            "below": self.mean(|flight| Some(flight.flown.weak)),
            "touches": has.then(|| self.touches()),
            "stood": self.mean(|flight| Some(flight.stood)),
            "lost_place": count(|flight| flight.has_lost_place),
            "launched_over_need": self.mean(|flight| Some(flight.launched_over_need)),
            "time_over_way": self.mean(|flight| flight.time_over_way),
            "why": self.why(),
        })
    }

    /// Its missions, one JSON object each.
    pub(super) fn missions_json(&self) -> Vec<Value> {
        let mission = |flight: &Flight| {
            let mut json = flight.json();
            json["place"] = json!(self.place);
            json["from"] = json!(self.from);
            json["asked_m"] = json!(self.depth_m);
            json
        };
        self.flights.iter().map(mission).collect()
    }
}

/// The beginnings of the names of the rows' files: no two are the same, also where case does not count.
pub(super) fn stems(rows: &[Row]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut unique = |row: &Row| {
        let stem = row.stem();
        let numbered = (2..).map(|n| format!("{stem}-{n}"));
        let mut free = std::iter::once(stem.clone()).chain(numbered);
        free.find(|name| taken.insert(name.to_lowercase())).unwrap_or_else(|| stem.clone())
    };
    rows.iter().map(&mut unique).collect()
}

/// The mean with four digits behind the point; `None` of nothing.
fn mean(values: impl Iterator<Item = f32>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, n), it| (sum + f64::from(it), n + 1));
    (count > 0).then(|| (sum / f64::from(count) * 1e4).round() / 1e4)
}

/// The causes of the missions that are not good, with their numbers, the most frequent first.
fn causes<'a>(flights: impl Iterator<Item = &'a Flight>) -> Vec<(&'static str, usize)> {
    let mut counts = BTreeMap::new();
    for cause in flights.filter_map(Flight::cause) {
        *counts.entry(cause).or_insert(0) += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

fn told(causes: &[(&str, usize)]) -> String {
    let each = causes.iter().map(|(cause, count)| format!("{cause} {count}"));
    each.collect::<Vec<_>>().join(", ")
}

/// The sums of all rows.
pub(super) struct Totals {
    pub(super) missions: usize,
    pub(super) refused: usize,
    /// The missions by what became of them: arrived, linked, home, all of that, good.
    pub(super) counts: [(&'static str, usize); 5],
    pub(super) touches: u32,
    pub(super) lost_place: usize,
    pub(super) stood: Option<f64>,
    pub(super) below: Option<f64>,
    pub(super) causes: Vec<(&'static str, usize)>,
}

impl Totals {
    pub(super) fn of(rows: &[Row]) -> Self {
        let flights = || rows.iter().flat_map(|row| &row.flights);
        let count = |is: fn(&Flight) -> bool| flights().filter(|flight| is(flight)).count();
        let did_all =
            |flight: &Flight| flight.has_arrived() && flight.is_linked && flight.flown.is_home();
        Self {
            missions: flights().count(),
            refused: rows.iter().filter(|row| row.refused.is_some()).count(),
            counts: [
                ("arrived", count(Flight::has_arrived)),
                ("linked", count(|flight| flight.is_linked)),
                ("home", count(|flight| flight.flown.is_home())),
                ("arrived, linked and home", count(did_all)),
                ("and without a touch", count(Flight::is_good)),
            ],
            touches: rows.iter().map(Row::touches).sum(),
            lost_place: count(|flight| flight.has_lost_place),
            stood: mean(flights().map(|flight| flight.stood)),
            below: mean(flights().map(|flight| flight.flown.weak)),
            causes: causes(flights()),
        }
    }

    /// The part of all missions.
    pub(super) fn share(&self, count: usize) -> f64 {
        count as f64 / self.missions.max(1) as f64
    }

    /// The bounds that are missed, one line each.
    pub(super) fn missed(&self, fidelity: Fidelity) -> Vec<String> {
        let mut missed = Vec::new();
        if self.missions == 0 {
            return missed;
        }
        let least = [least_good(fidelity), 1.0];
        for ((name, count), least) in [self.counts[3], self.counts[2]].into_iter().zip(least) {
            let share = self.share(count);
            if share < least {
                missed.push(format!("places: {name} in {share:.3} of the missions, not {least}"));
            }
        }
        if self.touches > 0 {
            missed.push(format!("places: {} touches", self.touches));
        }
        if self.lost_place > 0 {
            missed.push(format!("places: {} missions lost a drone's place", self.lost_place));
        }
        if let Some(stood) = self.stood.filter(|stood| *stood > MOST_STOOD) {
            missed.push(format!("places: heads stood for {stood:.3} of the time"));
        }
        missed
    }

    /// The sums as one JSON object.
    pub(super) fn json(&self) -> Value {
        let shares = self.counts.iter().map(|(name, count)| ((*name).to_owned(), json!(count)));
        json!({
            "missions": self.missions,
            "refused": self.refused,
            "counts": shares.collect::<serde_json::Map<_, _>>(),
            "touches": self.touches,
            "lost_place": self.lost_place,
            "stood": self.stood,
            "below": self.below,
            "causes": self.causes.iter().copied().collect::<BTreeMap<_, _>>(),
        })
    }
}
