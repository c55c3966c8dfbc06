//! Claims of a paper, and what a simulation says of each: an interval of what was measured against
//! what the claim needs.

use std::fmt;

use serde_json::{Value, json};

use super::intervals::{CONFIDENCE, Interval};

/// What so many runs say of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The whole interval meets the claim.
    Holds,
    /// No part of the interval meets the claim.
    DoesNotHold,
    /// The interval has values of both kinds.
    CannotBeTold,
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold",
            Self::CannotBeTold => "cannot be told",
        })
    }
}

impl Answer {
    /// The answer of several places together: a claim holds where it holds in each, and one place in
    /// which it does not hold is enough against it.
    fn of_all(answers: impl Iterator<Item = Self>) -> Self {
        answers.fold(Self::Holds, |all, one| match (all, one) {
            (Self::DoesNotHold, _) | (_, Self::DoesNotHold) => Self::DoesNotHold,
            (Self::CannotBeTold, _) | (_, Self::CannotBeTold) => Self::CannotBeTold,
            (Self::Holds, Self::Holds) => Self::Holds,
        })
    }
}

/// The values of a quantity that meet a claim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Needs {
    /// Values greater than this.
    MoreThan(f64),
    /// This value, or greater ones.
    AtLeast(f64),
    /// This value, or smaller ones.
    AtMost(f64),
}

impl Needs {
    fn answer(self, Interval { low, high }: Interval) -> Answer {
        let (all, none) = match self {
            Self::MoreThan(least) => (low > least, high <= least && low < high || high < least),
            Self::AtLeast(least) => (low >= least, high < least),
            Self::AtMost(most) => (high <= most, low > most),
        };
        match (all, none) {
            (true, _) => Answer::Holds,
            (false, true) => Answer::DoesNotHold,
            (false, false) => Answer::CannotBeTold,
        }
    }
}

impl fmt::Display for Needs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MoreThan(least) => write!(f, "more than {least}"),
            Self::AtLeast(least) => write!(f, "at least {least}"),
            Self::AtMost(most) => write!(f, "at most {most}"),
        }
    }
}

/// What was measured in one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The place: a corridor, or a kind of place.
    pub place: &'static str,
    /// What was measured of each policy, in words with their units.
    pub told: String,
    /// The interval of the claim's quantity.
    pub interval: Interval,
    /// What the place says of the claim.
    pub answer: Answer,
}

/// A claim, and what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Where the paper makes it.
    pub source: &'static str,
    /// The claim, in our words.
    pub claim: &'static str,
    /// The quantity that decides it, with its unit.
    pub quantity: &'static str,
    /// The values of the quantity that meet it.
    pub needs: Needs,
    /// The number of runs of each policy in each place; the smallest, where places have other numbers.
    pub runs: usize,
    /// What was found in each place.
    pub found: Vec<Found>,
    /// Why it does not hold.
    why: &'static str,
}

impl Claim {
    /// A claim of which nothing has been measured. `why` is a sentence that says why it does not
    /// hold, in case it does not.
    #[must_use]
    pub const fn new(
        (source, claim): (&'static str, &'static str),
        (quantity, needs): (&'static str, Needs),
        why: &'static str,
    ) -> Self {
        Self { source, claim, quantity, needs, runs: 0, found: Vec::new(), why }
    }

    /// The claim with what was measured in one more place.
    #[must_use]
    pub fn with(
        mut self,
        (place, runs): (&'static str, usize),
        told: String,
        interval: Interval,
    ) -> Self {
        self.runs = if self.found.is_empty() { runs } else { self.runs.min(runs) };
        let answer = self.needs.answer(interval);
        self.found.push(Found { place, told, interval, answer });
        self
    }

    /// What all places together say.
    #[must_use]
    pub fn answer(&self) -> Answer {
        Answer::of_all(self.found.iter().map(|found| found.answer))
    }

    /// Why the claim does not hold; `None` where it holds, or cannot be told.
    #[must_use]
    pub fn why(&self) -> Option<&'static str> {
        (self.answer() == Answer::DoesNotHold).then_some(self.why)
    }

    /// The verdict in words: `cannot be told from 30 runs`.
    #[must_use]
    pub fn verdict(&self) -> String {
        match self.answer() {
            Answer::CannotBeTold => format!("cannot be told from {} runs", self.runs),
            answer => answer.to_string(),
        }
    }

    /// The claim as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let found = self.found.iter().map(|found| {
            json!({
                "place": found.place,
                "told": found.told,
                "low": limit(found.interval.low),
                "high": limit(found.interval.high),
                "answer": found.answer.to_string(),
            })
        });
        json!({
            "source": self.source,
            "claim": self.claim,
            "quantity": self.quantity,
            "needs": self.needs.to_string(),
            "runs": self.runs,
            "confidence": CONFIDENCE,
            "answer": self.answer().to_string(),
            "why": self.why(),
            "found": found.collect::<Vec<_>>(),
        })
    }
}

/// A limit in JSON, which has no infinite numbers: those are words there.
fn limit(limit: f64) -> Value {
    match limit {
        f64::INFINITY => json!("infinite"),
        f64::NEG_INFINITY => json!("-infinite"),
        limit => json!(limit),
    }
}

/// As the lines of a table.
impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  {}: {}", self.source, self.claim)?;
        writeln!(f, "    {}", self.verdict())?;
        writeln!(f, "    {}, {}:", self.quantity, self.needs)?;
        for Found { place, told, interval, answer } in &self.found {
            let (low, high) = (number(interval.low), number(interval.high));
            writeln!(f, "      {place:13} {low} to {high}: {answer} ({told})")?;
        }
        self.why().map_or(Ok(()), |why| writeln!(f, "    {why}"))
    }
}

/// A number to three digits, or to so many decimals where it is small.
#[must_use]
pub fn number(value: f64) -> String {
    match value {
        f64::INFINITY => "∞".to_owned(),
        f64::NEG_INFINITY => "−∞".to_owned(),
        value => {
            let text =
                if value.abs() < 9.995 { format!("{value:.3}") } else { format!("{value:.1}") };
            text.replace('-', "−")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(needs: Needs, intervals: &[(f64, f64)]) -> Claim {
        let empty = Claim::new(("A", "b"), ("c, s", needs), "Because of d.");
        intervals.iter().fold(empty, |claim, (low, high)| {
            claim.with(("one", 20), String::new(), Interval { low: *low, high: *high })
        })
    }

    #[test]
    fn an_interval_on_both_sides_tells_nothing() {
        let more = Needs::MoreThan(0.0);
        for (intervals, answer) in [
            (&[(0.1, 0.2), (0.3, f64::INFINITY)][..], Answer::Holds),
            (&[(0.1, 0.2), (-0.1, 0.2)][..], Answer::CannotBeTold),
            (&[(0.1, 0.2), (-0.1, 0.2), (-0.2, -0.1)][..], Answer::DoesNotHold),
            (&[(f64::NEG_INFINITY, 0.0)][..], Answer::DoesNotHold),
            // Where both are always equal, neither is larger; but nothing says so of other runs.
            (&[(0.0, 0.0)][..], Answer::CannotBeTold),
        ] {
            assert_eq!(claim(more, intervals).answer(), answer, "{intervals:?}");
        }
        assert_eq!(claim(Needs::AtLeast(0.95), &[(0.96, 1.0)]).answer(), Answer::Holds);
        assert_eq!(claim(Needs::AtLeast(0.95), &[(0.8, 1.0)]).answer(), Answer::CannotBeTold);
        assert_eq!(claim(Needs::AtMost(0.05), &[(0.06, 0.1)]).answer(), Answer::DoesNotHold);
    }

    #[test]
    fn only_a_claim_that_does_not_hold_says_why() {
        let more = Needs::MoreThan(0.0);
        let fails = claim(more, &[(-2.0, -1.0)]);
        assert!(fails.to_string().ends_with("    Because of d.\n"), "{fails}");
        let open = claim(more, &[(-2.0, 1.0)]);
        assert!(open.to_string().contains("cannot be told from 20 runs"), "{open}");
        assert!(!open.to_string().contains("Because"), "{open}");
        assert_eq!(open.json()["why"], Value::Null);
    }
}
