//! The paper's claims about figure 3, each with the interval of the quantity that decides it.
//!
//! Runs of two policies with the same seed begin alike, so that the quantity is their difference in
//! each pair. A run that never settles counts as one that takes for ever, and is in every interval.

use super::{CORRIDORS, Cell, Figures, Place, label};
use crate::campaign::{excess, quantile_of};
use crate::claim::{Claim, Needs, number};
use crate::intervals::{Interval, difference_of_shares, median, share};

/// The share of runs that must converge. With 90 of 90, as the paper saw, a smaller one would be
/// seen once in a hundred times: 0.95⁹⁰ is less than 1 %.
const ALL: f64 = 0.95;
/// The largest share of runs with a needless launch that counts as none.
const NONE: f64 = 0.05;

/// Why K does not settle: the table of the ingredients of K tuned is in the book.
const SWINGS: &str = "Why: with the gain of eq. 11, a third per round, half a decibel asks for full \
                      speed, and relays swing about the place of equal links; K tuned, whose gain \
                      is a small part of that, settles.";

impl Figures {
    /// The paper's claims about figure 3, of those whose policies were flown. Where a claim is about
    /// K, it follows for K with a small gain.
    #[must_use]
    pub fn claims(&self) -> Vec<Claim> {
        let mut claims = vec![
            self.converges("k", "all runs of K converge to equal links (3 dB), from anywhere"),
            self.converges("k-tuned", "the same of K tuned, which has a smaller gain"),
            self.launches_less("k", "T0 launches needless relays in more runs than K"),
            self.launches_none("k", "K launches no needless relay (here: in at most 5 % of runs)"),
            self.launches_none("k-tuned", "the same of K tuned"),
            self.settles_sooner("k", "after the head's stop K converges sooner than T5"),
            self.settles_sooner("k-tuned", "the same of K tuned"),
            self.is_calmer("k", "after it K oscillates less than T0"),
            self.is_calmer("k-tuned", "the same of K tuned"),
            self.is_calmer("t5", "after it T5 oscillates less than T0"),
        ];
        claims.retain(|claim| !claim.found.is_empty());
        claims
    }

    /// Adds what each corridor says in which all of these policies flew.
    fn in_corridors<const N: usize>(
        &self,
        claim: Claim,
        policies: [&str; N],
        look: impl Fn([&Cell; N]) -> (String, Interval),
    ) -> Claim {
        CORRIDORS.into_iter().fold(claim, |claim, Place { scenario, .. }| {
            let cells: Vec<&Cell> =
                policies.iter().filter_map(|policy| self.cell(scenario, policy)).collect();
            let Ok(cells) = <[&Cell; N]>::try_from(cells) else { return claim };
            let runs = cells.iter().map(|cell| cell.exploration.len()).min().unwrap_or(0);
            let (told, interval) = look(cells);
            claim.with((scenario, runs), told, interval)
        })
    }

    fn converges(&self, policy: &str, words: &'static str) -> Claim {
        let needs = ("share of runs that converge", Needs::AtLeast(ALL));
        let claim = Claim::new(("A to C", words), needs, SWINGS);
        self.in_corridors(claim, [policy], |[cell]| {
            let runs = &cell.convergence;
            let hits = runs.iter().filter(|run| run.held(|hold| hold.t3_s).is_finite()).count();
            (counted(policy, hits, runs.len()), share(hits, runs.len()))
        })
    }

    fn launches_less(&self, policy: &str, words: &'static str) -> Claim {
        let quantity = "share of runs with a needless relay, T0 less K in the same runs";
        let claim = Claim::new(
            ("D", words),
            (quantity, Needs::MoreThan(0.0)),
            "Why: in that corridor the links under T0 seldom pass the limit either.",
        );
        self.in_corridors(claim, ["t0", policy], |[raw, other]| {
            let pairs = || raw.exploration.iter().zip(&other.exploration);
            let is = |run: &super::Explored| excess(&run.metrics) > 0.0;
            let only_raw = pairs().filter(|(raw, other)| is(raw) && !is(other)).count();
            let only_other = pairs().filter(|(raw, other)| !is(raw) && is(other)).count();
            let runs = pairs().count();
            let told = [("t0", needless(raw)), (policy, needless(other))]
                .map(|(policy, hits)| counted(policy, hits, runs));
            (told.join(", "), difference_of_shares(only_raw, only_other, runs))
        })
    }

    fn launches_none(&self, policy: &str, words: &'static str) -> Claim {
        let needs = ("share of runs with a needless relay", Needs::AtMost(NONE));
        let why =
            "Why: the limit lies 1 dB beyond the best chain, and the links of K swing by more.";
        self.in_corridors(Claim::new(("D", words), needs, why), [policy], |[cell]| {
            let (hits, runs) = (needless(cell), cell.exploration.len());
            (counted(policy, hits, runs), share(hits, runs))
        })
    }

    fn settles_sooner(&self, policy: &str, words: &'static str) -> Claim {
        let quantity = "median of T5's time to 3 dB less the other's in the same run, s";
        let why = if policy == "k" { SWINGS } else { SLOWER };
        let claim = Claim::new(("E", words), (quantity, Needs::MoreThan(0.0)), why);
        self.in_corridors(claim, ["t5", policy], |[t5, other]| {
            let differences = paired(t5, other, |run| run.settled_s);
            let told = [("t5", t5), (policy, other)].map(|(policy, cell)| settling(policy, cell));
            (told.join(", "), median(&differences))
        })
    }

    fn is_calmer(&self, policy: &str, words: &'static str) -> Claim {
        let quantity = "median of T0's variance of the relays' places less the other's, m²";
        let why = "Why: the filter takes the noise out of the links, but with the gain of eq. 11 \
                   relays swing without noise, too; K tuned, whose gain is small, is calm.";
        let claim = Claim::new(("F", words), (quantity, Needs::MoreThan(0.0)), why);
        self.in_corridors(claim, ["t0", policy], |[raw, other]| {
            let differences = paired(raw, other, |run| run.variance_m2);
            let told = [("t0", raw), (policy, other)].map(|(policy, cell)| {
                let middle = quantile_of(&cell.exploration, 0.5, |run| run.variance_m2).value;
                format!("{} {} m²", label(policy), number(middle))
            });
            (format!("medians: {}", told.join(", ")), median(&differences))
        })
    }
}

/// Why K tuned settles later than T5 in some corridor.
const SLOWER: &str = "Why: T5 flies at full speed until its links are within its tolerance, K tuned \
                      by a small gain.";

fn needless(cell: &Cell) -> usize {
    cell.exploration.iter().filter(|run| excess(&run.metrics) > 0.0).count()
}

/// A value of the one less that of the other in each pair of runs with the same seed. Two that both
/// never come to the event are equal.
fn paired(one: &Cell, other: &Cell, of: fn(&super::Explored) -> f32) -> Vec<f64> {
    let pairs = one.exploration.iter().zip(&other.exploration);
    pairs
        .map(|(one, other)| (f64::from(of(one)), f64::from(of(other))))
        .map(|(one, other)| if one == other { 0.0 } else { one - other })
        .collect()
}

fn counted(policy: &str, hits: usize, runs: usize) -> String {
    format!("{} {hits} of {runs} runs", label(policy))
}

fn settling(policy: &str, cell: &Cell) -> String {
    let runs = &cell.exploration;
    let settled = runs.iter().filter(|run| run.settled_s.is_finite()).count();
    let median = quantile_of(runs, 0.5, |run| run.settled_s).value;
    let median = if median.is_finite() { format!("{median:.1} s") } else { "never".to_owned() };
    format!("{} median {median}, {settled} of {} settle", label(policy), runs.len())
}
