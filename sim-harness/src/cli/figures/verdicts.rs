//! `uchain figures --repeat N`: in how many of N repetitions with other seeds each verdict was found.

use std::fmt::Write;

use measure::claim::{Answer, Claim};
use serde_json::{Value, json};

/// The least distance between the first seeds of two repetitions.
const APART: u64 = 1_000;

/// A claim with the verdicts of all repetitions.
struct Counted {
    /// What made it: a reading of the paper; empty where there is one only.
    of: &'static str,
    source: &'static str,
    claim: &'static str,
    /// How often it held, did not hold, and could not be told.
    counts: [usize; 3],
}

impl Counted {
    /// Whether two repetitions contradict each other.
    const fn is_contradicted(&self) -> bool {
        self.counts[0] > 0 && self.counts[1] > 0
    }

    /// The verdict that all repetitions have; where two differ, the claim cannot be told.
    const fn verdict(&self) -> Answer {
        match self.counts {
            [_, 0, 0] => Answer::Holds,
            [0, _, 0] => Answer::DoesNotHold,
            _ => Answer::CannotBeTold,
        }
    }
}

/// The verdicts of several repetitions.
pub(super) struct Verdicts {
    first_seeds: Vec<u64>,
    runs: usize,
    counted: Vec<Counted>,
}

impl Verdicts {
    /// Makes the claims again with so many first seeds of so many runs.
    pub(super) fn count<E>(
        (repeat, seed, runs): (usize, u64, usize),
        mut claims: impl FnMut(u64) -> Result<Vec<(&'static str, Claim)>, E>,
    ) -> Result<Self, E> {
        let apart = APART.max(10 * runs as u64);
        let first_seeds: Vec<u64> =
            (0..repeat as u64).map(|n| seed.wrapping_add(n.wrapping_mul(apart))).collect();
        let mut verdicts = Self { first_seeds, runs, counted: Vec::new() };
        for seed in verdicts.first_seeds.clone() {
            verdicts.add(&claims(seed)?);
        }
        Ok(verdicts)
    }

    /// Adds the claims of one repetition, which are the same ones in the same order each time.
    fn add(&mut self, claims: &[(&'static str, Claim)]) {
        // A claim of which nothing was measured has no verdict.
        let measured = claims.iter().filter(|(_, claim)| !claim.found.is_empty());
        for (n, (of, claim)) in measured.enumerate() {
            if self.counted.len() <= n {
                let Claim { source, claim: words, .. } = *claim;
                self.counted.push(Counted { of, source, claim: words, counts: [0; 3] });
            }
            let column = match claim.answer() {
                Answer::Holds => 0,
                Answer::DoesNotHold => 1,
                Answer::CannotBeTold => 2,
            };
            self.counted[n].counts[column] += 1;
        }
    }

    /// The table of verdicts.
    pub(super) fn table(&self) -> String {
        let (repeated, runs) = (self.first_seeds.len(), self.runs);
        let mut text = format!(
            "Verdicts of {repeated} repetitions with {runs} runs each, whose first seeds are {}:\nin how \
             many a claim holds, does not hold, cannot be told, and the verdict, which cannot be told\n\
             where two repetitions differ\n",
            self.seeds(),
        );
        let mut of = None;
        for it in &self.counted {
            if of != Some(it.of) {
                let _ = writeln!(text, "\n  holds  not  open  verdict{}", named(it.of));
                of = Some(it.of);
            }
            let [holds, not, open] = it.counts;
            // Writing to a string cannot fail.
            let verdict = it.verdict().to_string();
            let _ = writeln!(
                text,
                "  {holds:>5} {not:>4} {open:>5}  {verdict:14}  {}: {}",
                it.source, it.claim,
            );
        }
        let contradicted = self.counted.iter().filter(|it| it.is_contradicted()).count();
        let all = self.counted.len();
        let same = self.counted.iter().filter(|it| it.counts.contains(&repeated)).count();
        let _ = writeln!(
            text,
            "\n{same} of {all} claims have the same verdict in all {repeated}; {contradicted} hold in one \
             and do not hold in another",
        );
        text
    }

    /// The first seeds in words.
    pub(super) fn seeds(&self) -> String {
        match self.first_seeds.as_slice() {
            [first, second, .., last] if self.first_seeds.len() > 2 => {
                format!("{first}, {second}, … {last}")
            }
            few => few.iter().map(u64::to_string).collect::<Vec<_>>().join(" and "),
        }
    }

    pub(super) fn json(&self) -> Value {
        let claims = self.counted.iter().map(|it| {
            json!({
                "reading": it.of,
                "source": it.source,
                "claim": it.claim,
                "holds": it.counts[0],
                "does_not_hold": it.counts[1],
                "cannot_be_told": it.counts[2],
                "verdict": it.verdict().to_string(),
            })
        });
        json!({
            "runs": self.runs,
            "first_seeds": self.first_seeds,
            "verdicts": claims.collect::<Vec<_>>(),
        })
    }
}

/// The name of a reading, where there is one.
fn named(of: &str) -> String {
    if of.is_empty() { String::new() } else { format!("  by {of}") }
}

#[cfg(test)]
mod tests {
    use measure::claim::Needs;
    use measure::intervals::Interval;

    use super::*;

    #[test]
    fn a_verdict_that_turns_into_its_opposite_is_counted_as_such() {
        let claim = |low, high| {
            let empty = Claim::new(("A", "b"), ("c", Needs::MoreThan(0.0)), "Because.");
            vec![("", empty.with(("here", 20), String::new(), Interval { low, high }))]
        };
        let with = |second: (f64, f64)| {
            Verdicts::count((2, 1, 20), |seed| {
                Ok::<_, ()>(if seed == 1 { claim(1.0, 2.0) } else { claim(second.0, second.1) })
            })
            .expect("claims")
            .table()
        };
        let flipped = with((-2.0, -1.0));
        assert!(flipped.contains("      1    1     0  cannot be told  A: b"), "{flipped}");
        assert!(
            flipped.contains("0 of 1 claims have the same verdict in all 2; 1 hold"),
            "{flipped}"
        );
        let open = with((-2.0, 1.0));
        assert!(open.contains("      1    0     1  cannot be told  A: b"), "{open}");
        assert!(open.contains("0 of 1 claims have the same verdict in all 2; 0 hold"), "{open}");
        let same = with((1.0, 1.5));
        assert!(same.contains("      2    0     0  holds           A: b"), "{same}");
        assert!(same.contains("1 of 1 claims"), "{same}");
    }
}
