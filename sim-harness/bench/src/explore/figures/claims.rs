//! The thesis' sentences about its figures, each with the interval of the quantity that decides it. Runs
//! of the same seed are compared with each other; one that never comes to 99 % takes for ever.

use explorers::Outcome;
use measure::campaign::quantile_of;
use measure::claim::{Claim, Needs, number};
use measure::intervals::{median, share};

use super::{DRIFTS, Figures, OURS, OURS_DRIFTS, PAIR, THESIS, time_s, way_m};

/// The share of the runs that counts as all.
pub(super) const ALL: f64 = 0.95;

/// A quantity of a run, with its name and its unit.
#[derive(Clone, Copy)]
struct Quantity {
    of: fn(&Outcome) -> f32,
    unit: &'static str,
    /// What is compared of two rules.
    more: &'static str,
}

const TIME: Quantity = Quantity {
    of: time_s,
    unit: "s",
    more: "median of the second's time less the first's in the same run, s",
};
const WAY: Quantity = Quantity {
    of: way_m,
    unit: "m",
    more: "median of the second's way less the first's in the same run, m",
};
/// The small and the large λ.
const LAMBDAS: [&str; 2] = ["λ 0.05", "λ 0.8"];

/// What may be why several robots save less than the thesis says.
const FAST_ALONE: &str = "Why: not measured; in so small a room one robot may see most of it so soon that \
                          little is left to save.";
/// Why λ works the other way.
const TURNED: &str = "Why: by the thesis' equation, which is flown, a larger λ counts the distance \
                      more; its text has it the other way round.";
/// What may be why 20 s are not the best.
const WAITS: &str = "Why: not measured; here robots may reach their goals sooner, and wait for the rest of \
                     the 20 s.";
/// What may be why longer rounds are not slower.
const NO_WAIT: &str = "Why: not measured; the robots' goals may be so far that they do not wait.";
/// Why localisation costs no time here.
const SLOW_THERE: &str = "Why: the thesis' robots flew more slowly for their camera's sake; here they fly as fast, and \
                          only their positions drift.";
/// Why the overlap is another.
const UNKNOWN: &str = "Why: not known; the thesis does not say how its maps were compared.";

impl Figures {
    /// The claims: of the thesis' rule, and what follows of ours.
    #[must_use]
    pub fn claims(&self) -> Vec<Claim> {
        let mut claims = vec![
            self.all_explored(THESIS, "at the end all is explored (here: 99 %)"),
            self.all_explored(OURS, "the same of our rule"),
        ];
        for (rule, words) in [
            (
                THESIS,
                ["with two UAVs the time is 25 % less", "with three UAVs the time is 30 % less"],
            ),
            (OURS, ["with two, the same of our rule", "with three, the same of our rule"]),
        ] {
            claims.push(self.saves(("figure 3.22", words[0]), rule, TIME, (2, 0.25)));
            claims.push(self.saves(("figure 3.22", words[1]), rule, TIME, (3, 0.30)));
        }
        for (rule, words) in [
            (THESIS, ["with two UAVs the way of each is 55 % less", "with three UAVs 62 %"]),
            (OURS, ["with two, the same of our rule", "with three, the same of our rule"]),
        ] {
            claims.push(self.saves(("figure 3.21", words[0]), rule, WAY, (2, 0.55)));
            claims.push(self.saves(("figure 3.21", words[1]), rule, WAY, (3, 0.62)));
        }
        claims.extend([
            self.overlaps(THESIS, "two UAVs overlap by 33 % at the end"),
            self.overlaps(OURS, "the same of our rule"),
            self.is_less(("figure 3.11", "with a small λ the way is short"), LAMBDAS, WAY, TURNED),
            self.is_less(("figure 3.11", "and so is the time"), LAMBDAS, TIME, TURNED),
            self.is_less(
                ("figure 3.12", "every 20 s is faster than every 10 s"),
                [THESIS, "every 10 s"],
                TIME,
                WAITS,
            ),
            self.is_less(
                ("figure 3.12", "every 20 s is faster than every 40 s"),
                [THESIS, "every 40 s"],
                TIME,
                NO_WAIT,
            ),
        ]);
        claims.extend(self.claims_of_watched());
        claims.extend(self.localised());
        claims
    }

    /// With positions that drift, in place of the thesis' relative localisation by a camera.
    fn localised(&self) -> [Claim; 3] {
        let source = "figure 3.24";
        let words = "while robots localise themselves, the time with two is 43 % less";
        let slower = "exploring takes longer than with exact positions";
        [
            self.saves((source, words), DRIFTS, TIME, (2, 0.43)),
            self.saves((source, "the same of our rule"), OURS_DRIFTS, TIME, (2, 0.43)),
            self.is_less((source, slower), [THESIS, DRIFTS], TIME, SLOW_THERE),
        ]
    }

    fn all_explored(&self, rule: &'static str, words: &'static str) -> Claim {
        let needs = ("share of runs in which 99 % are known", Needs::AtLeast(ALL));
        let why = "Why: nothing keeps the rule from a candidate that a robot cannot reach, and robots \
                   stop where the test by points leaves no candidate.";
        let claim = Claim::new(("section 3.4", words), needs, why);
        let numbers = [(1, "1 robot"), (2, "2 robots"), (3, "3 robots")];
        numbers.into_iter().fold(claim, |claim, (robots, place)| {
            let Some(row) = self.row(rule, robots) else { return claim };
            let (hits, runs) = (row.count(|run| run.t99_s.is_some()), row.runs.len());
            claim.with((place, runs), format!("{hits} of {runs} runs"), share(hits, runs))
        })
    }

    /// What part of a quantity of one robot is saved with several.
    fn saves(
        &self,
        source: (&'static str, &'static str),
        rule: &'static str,
        quantity: Quantity,
        (robots, least): (usize, f64),
    ) -> Claim {
        let name = "median of the part that is saved over one robot in the same run";
        let claim = Claim::new(source, (name, Needs::AtLeast(least)), FAST_ALONE);
        let (Some(alone), Some(several)) = (self.row(rule, 1), self.row(rule, robots)) else {
            return claim;
        };
        let pairs = alone.runs.iter().zip(&several.runs);
        let saved: Vec<f64> =
            pairs.map(|(one, other)| saved((quantity.of)(one), (quantity.of)(other))).collect();
        let middle = |row: &super::Row| quantile_of(&row.runs, 0.5, quantity.of).value;
        let [one, more] = [alone, several].map(|row| number(middle(row)));
        let told = format!("medians: {one} {unit}, then {more} {unit}", unit = quantity.unit);
        claim.with(("room", saved.len()), told, median(&saved))
    }

    fn overlaps(&self, rule: &'static str, words: &'static str) -> Claim {
        let quantity = "median of the part of the known that two know";
        let claim = Claim::new(("figure 3.18", words), (quantity, Needs::AtMost(0.33)), UNKNOWN);
        let Some(row) = self.row(rule, PAIR) else { return claim };
        let overlaps: Vec<f64> = row.runs.iter().map(|run| f64::from(run.overlap)).collect();
        let middle = quantile_of(&row.runs, 0.5, |run| run.overlap).value;
        let told = format!("median {}", number(middle));
        claim.with(("room", overlaps.len()), told, median(&overlaps))
    }

    /// Whether a quantity of the first rule is less than that of the second.
    fn is_less(
        &self,
        source: (&'static str, &'static str),
        rules: [&'static str; 2],
        quantity: Quantity,
        why: &'static str,
    ) -> Claim {
        let claim = Claim::new(source, (quantity.more, Needs::MoreThan(0.0)), why);
        let [Some(one), Some(other)] = rules.map(|rule| self.row(rule, PAIR)) else {
            return claim;
        };
        let pairs = one.runs.iter().zip(&other.runs);
        let less: Vec<f64> = pairs
            .map(|(one, other)| (f64::from((quantity.of)(one)), f64::from((quantity.of)(other))))
            .map(|(one, other)| if one == other { 0.0 } else { other - one })
            .collect();
        let told = [one, other].map(|row| {
            let middle = quantile_of(&row.runs, 0.5, quantity.of).value;
            format!("{} {} {}", row.rule, number(middle), quantity.unit)
        });
        let told = format!("medians: {}", told.join(", "));
        claim.with(("2 robots", less.len()), told, median(&less))
    }
}

/// The part of a time or a way that is saved; none where both are infinite.
fn saved(alone: f32, several: f32) -> f64 {
    match (alone.is_finite(), several.is_finite()) {
        (false, false) => 0.0,
        (false, true) => 1.0,
        _ => 1.0 - f64::from(several) / f64::from(alone),
    }
}
