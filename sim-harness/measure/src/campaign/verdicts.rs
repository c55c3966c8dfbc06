//! Counts the verdicts of a campaign: the share of successes, and why the other missions failed.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::estimate::{Estimate, finite, share};
use super::{Outcome, Run};
use crate::verdict::Ended;

/// The most seeds that are listed for a failure.
const MOST_SEEDS: usize = 5;

/// The verdicts of all missions of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdicts {
    missions: usize,
    success: Estimate,
    /// The part of the missions with each failure, the most frequent first.
    failures: Vec<Share>,
    /// Why explorations ended, with the part of the missions; those that did not occur are left out.
    ended: Vec<(Ended, f64)>,
    /// The part of its reach to which the head came, mean over the missions; NaN without a head.
    depth: f64,
    stood_s: f64,
}

/// The missions with one failure.
#[derive(Clone, Debug, PartialEq)]
struct Share {
    name: String,
    estimate: Estimate,
    /// The first seeds.
    seeds: Vec<u64>,
}

impl Verdicts {
    /// The verdicts of these missions.
    #[must_use]
    pub fn of(runs: &[Run]) -> Self {
        let mut tally = Tally::default();
        runs.iter().for_each(|run| tally.add(run.seed, &Outcome::of(&run.judgement)));
        tally.verdicts()
    }

    /// The number of missions that failed.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.missions - (self.success.value * self.missions as f64).round() as usize
    }

    /// The verdicts as a JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let entry = |share: &Share| {
            let mut entry = share.estimate.json();
            if let Some(entry) = entry.as_object_mut() {
                entry.insert("seeds".into(), json!(share.seeds));
            }
            (share.name.clone(), entry)
        };
        let ended = self.ended.iter().map(|(why, share)| (why.name().to_owned(), json!(share)));
        json!({
            "success": self.success.json(),
            "failures": self.failures.iter().map(entry).collect::<Map<_, _>>(),
            "ended": ended.collect::<Map<_, _>>(),
            "depth": finite(self.depth),
            "stood_s": finite(self.stood_s),
        })
    }

    /// The verdicts as lines of a table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  success                     {}", percent(&self.success));
        for Share { name, estimate, seeds } in &self.failures {
            let seeds: Vec<_> = seeds.iter().map(u64::to_string).collect();
            let seeds = seeds.join(", ");
            let _ = writeln!(text, "  {name:27} {}, seeds {seeds}", percent(estimate));
        }
        let ended =
            self.ended.iter().map(|(why, share)| format!("{} {:.1} %", why.name(), 100.0 * share));
        let ended: Vec<_> = ended.collect();
        if !ended.is_empty() {
            let _ = writeln!(text, "  explorations ended by       {}", ended.join(", "));
        }
        if self.depth.is_finite() {
            let _ = writeln!(
                text,
                "  heads came to               {:.1} % of where they could, and stood for {:.1} s",
                100.0 * self.depth,
                self.stood_s
            );
        }
        text
    }
}

/// Counts verdicts that come one by one.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    missions: usize,
    successes: usize,
    /// The failures in the order in which they first came, each with the number of missions and their
    /// first seeds.
    failures: Vec<(String, usize, Vec<u64>)>,
    ended: [usize; Ended::ALL.len()],
    depth: f64,
    stood_s: f64,
}

impl Tally {
    /// Adds the outcome of the mission of a seed.
    pub fn add(&mut self, seed: u64, outcome: &Outcome) {
        self.missions += 1;
        self.successes += usize::from(outcome.failures.is_empty());
        for (n, name) in outcome.failures.iter().enumerate() {
            if !outcome.failures[..n].contains(name) {
                self.add_failure(seed, name);
            }
        }
        for (count, why) in self.ended.iter_mut().zip(Ended::ALL) {
            *count += usize::from(outcome.ended == Some(why));
        }
        self.depth += f64::from(depth(outcome));
        self.stood_s += f64::from(outcome.stood_s);
    }

    fn add_failure(&mut self, seed: u64, name: &String) {
        match self.failures.iter_mut().find(|(known, ..)| known == name) {
            Some((_, count, seeds)) => {
                *count += 1;
                if seeds.len() < MOST_SEEDS {
                    seeds.push(seed);
                }
            }
            None => self.failures.push((name.clone(), 1, vec![seed])),
        }
    }

    /// The verdicts of all that were added.
    #[must_use]
    pub fn verdicts(&self) -> Verdicts {
        let missions = self.missions;
        let of = |(name, count, seeds): &(String, usize, Vec<u64>)| Share {
            name: name.clone(),
            estimate: share(*count, missions),
            seeds: seeds.clone(),
        };
        let mut failures: Vec<_> = self.failures.iter().map(of).collect();
        failures.sort_by(|a, b| b.estimate.value.total_cmp(&a.estimate.value));
        let ended = Ended::ALL.into_iter().zip(self.ended);
        let ended = ended.map(|(why, count)| (why, share(count, missions).value));
        let mean = |sum: f64| sum / missions.max(1) as f64;
        Verdicts {
            missions,
            success: share(self.successes, missions),
            failures,
            ended: ended.filter(|(_, share)| *share > 0.0).collect(),
            depth: mean(self.depth),
            stood_s: mean(self.stood_s),
        }
    }
}

/// The part of its reach to which a head came; NaN without a head.
fn depth(outcome: &Outcome) -> f32 {
    let part = outcome.came_m / outcome.could_m;
    // NaN stays so.
    if part > 1.0 { 1.0 } else { part }
}

fn percent(estimate: &Estimate) -> String {
    let value = 100.0 * estimate.value;
    match estimate.interval {
        Some((low, high)) => {
            format!("{value:5.1} %   {:.1} to {:.1} %", 100.0 * low, 100.0 * high)
        }
        None => format!("{value:5.1} %"),
    }
}
