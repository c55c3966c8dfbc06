//! The thesis' sentences about figures 3.14, 3.15 and 3.17, which show one exploration each: here the
//! quantity of many.

use measure::claim::{Claim, Needs, number};
use measure::intervals::{median, share};
use units::Point2;

use super::claims::ALL;
use super::watched::{Targets, Watched, WatchedRow};
use super::{Figures, OURS, PAIR, THESIS};

/// Two targets are the same one where they are nearer than candidates lie apart, m (thesis, table 3.1).
const SAME_M: f64 = 0.3;
/// A target is close to another one within so much of the room of 8 m; our own number.
const CLOSE_M: f64 = 1.0;

const EDGES: &str =
    "Why: not measured; candidates that lie 0.3 m apart and are equally good take turns.";
const FAR: &str =
    "Why: not measured; the second robot may have candidates of its own that are nearer to it.";
const LEFT: &str = "Why: not measured; cells of the room's edge that no robot can see well stay on the border of \
                    what is known.";
const PEAKS: &str = "Why: not measured.";

impl Figures {
    /// The claims of what was watched.
    pub(super) fn claims_of_watched(&self) -> Vec<Claim> {
        let mut claims = vec![
            self.spreads(THESIS, "two UAVs that start close to each other are spread"),
            self.spreads(OURS, "the same of our rule"),
            self.rises_first(),
            self.none_left(),
        ];
        claims.extend(self.targets());
        claims
    }

    fn watched(&self, rule: &str, robots: usize) -> Option<&WatchedRow> {
        self.watched.iter().find(|row| row.rule == rule && row.robots == robots)
    }

    /// Whether two robots are farther apart until 99 % are known than at the start.
    fn spreads(&self, rule: &'static str, words: &'static str) -> Claim {
        let quantity = "median of the mean distance until 99 % are known less that at the start, m";
        let claim = Claim::new(("figure 3.14", words), (quantity, Needs::MoreThan(0.0)), PEAKS);
        let (Some(row), Some(watched)) = (self.row(rule, PAIR), self.watched(rule, PAIR)) else {
            return claim;
        };
        let pairs = row.runs.iter().zip(&watched.runs);
        let apart: Vec<[f64; 2]> = pairs
            .filter_map(|(run, watched)| {
                let until = run.t99_s.map_or(usize::MAX, |t99| t99 as usize);
                let apart = watched.apart_m.get(..until).unwrap_or(&watched.apart_m);
                let mean = apart.iter().sum::<f32>() / apart.len().max(1) as f32;
                Some([f64::from(*apart.first()?), f64::from(mean)])
            })
            .collect();
        let more: Vec<f64> = apart.iter().map(|[start, mean]| mean - start).collect();
        let of = |n: usize| number(middle(apart.iter().map(|both| both[n]).collect()));
        let told = format!("medians: {} m at the start, then {} m", of(0), of(1));
        claim.with(("2 robots", more.len()), told, median(&more))
    }

    /// Whether candidates are most numerous in the first half of the exploration.
    fn rises_first(&self) -> Claim {
        let words = "the candidates become more at the beginning, and then fewer";
        let quantity =
            "median of the time of their greatest number, in parts of the time to the last stop";
        let empty = Claim::new(("figure 3.15", words), (quantity, Needs::AtMost(0.5)), PEAKS);
        self.each_number(empty, |claim, place, row| {
            let peak = |run: &Watched| {
                let most = run.candidates.iter().copied().max()?;
                let at = run.candidates.iter().position(|count| *count == most)?;
                Some((at + 1) as f64 / run.candidates.len() as f64)
            };
            let peaks: Vec<f64> = row.runs.iter().filter_map(peak).collect();
            let told = format!("median {}", number(middle(peaks.clone())));
            claim.with((place, peaks.len()), told, median(&peaks))
        })
    }

    fn none_left(&self) -> Claim {
        let words = "at the end no candidate is left";
        let quantity = "share of runs that end without a free cell beside an unknown one";
        let empty = Claim::new(("figure 3.15", words), (quantity, Needs::AtLeast(ALL)), LEFT);
        self.each_number(empty, |claim, place, row| {
            let none = |run: &&Watched| run.candidates.last() == Some(&0);
            let (hits, runs) = (row.runs.iter().filter(none).count(), row.runs.len());
            let last = row.runs.iter().filter_map(|run| run.candidates.last());
            let left = number(middle(last.map(|count| *count as f64).collect()));
            let told = format!("{hits} of {runs} runs, median {left} cells");
            claim.with((place, runs), told, share(hits, runs))
        })
    }

    /// A claim with something of the thesis' rule for one to three robots.
    fn each_number(
        &self,
        empty: Claim,
        add: impl Fn(Claim, &'static str, &WatchedRow) -> Claim,
    ) -> Claim {
        let numbers = [(1, "1 robot"), (2, "2 robots"), (3, "3 robots")];
        numbers.into_iter().fold(empty, |claim, (robots, place)| {
            match self.watched(THESIS, robots) {
                Some(row) => add(claim, place, row),
                None => claim,
            }
        })
    }

    /// The three cases of figure 3.17, each time half of the room is known.
    fn targets(&self) -> [Claim; 3] {
        let runs = self.watched(THESIS, PAIR).map_or(&[][..], |row| &row.runs);
        let all: Vec<&Targets> = runs.iter().filter_map(|run| run.targets.as_ref()).collect();
        let off = |of: fn(&Targets) -> Point2| -> Vec<f64> {
            all.iter().map(|it| f64::from(it.first.distance(of(it)).0)).collect()
        };
        let (alike, removed, scheduled) =
            (off(|it| it.alike), off(|it| it.removed), off(|it| it.scheduled));
        let more: Vec<f64> =
            scheduled.iter().zip(&removed).map(|(one, other)| one - other).collect();
        let quantity = "median of the distance between the two targets when half is known, m";
        let claim = |source, words, (quantity, needs), why, values: &[f64], told| {
            let empty = Claim::new((source, words), (quantity, needs), why);
            if values.is_empty() {
                return empty;
            }
            empty.with(("2 robots", values.len()), told, median(values))
        };
        let told = |values: &[f64]| format!("median {} m", number(middle(values.to_vec())));
        [
            claim(
                "figure 3.17b",
                "without further processing both get the same target",
                (quantity, Needs::AtMost(SAME_M)),
                FAR,
                &alike,
                told(&alike),
            ),
            claim(
                "figure 3.17c",
                "with the first target removed, the second is close to it (here: 1 m)",
                (quantity, Needs::AtMost(CLOSE_M)),
                FAR,
                &removed,
                told(&removed),
            ),
            claim(
                "figure 3.17d",
                "with gains scheduled they are spaced out",
                (
                    "median of their distance less that without scheduling in the same run, m",
                    Needs::MoreThan(0.0),
                ),
                EDGES,
                &more,
                format!("{}, {}", told(&removed), told(&scheduled)),
            ),
        ]
    }
}

/// The median of the values themselves.
fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
