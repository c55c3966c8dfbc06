//! Sets the readings of the paper beside its figures: tables 2 and 3, and what its text says of
//! figures 12 and 14, which are pictures without values.

use units::Metres;
use virtual_forces::{Config, ObstacleForce, Sweep, Weight};

use crate::bench::{CLEAR, Case, PAPER_MOST, Row, Rule};
use crate::{Phase, Place};

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

/// Returns the cases of all readings: 1 to 6 drones in every passage.
#[must_use]
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for rule in readings() {
        for drones in 1..=PAPER_MOST {
            cases.extend(Place::ALL.map(|place| Case { rule, drones, place }));
        }
    }
    cases
}

/// A sentence of the paper, and whether it holds for one reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Where the paper says it.
    pub source: &'static str,
    /// What it says.
    pub claim: &'static str,
    /// Whether the reading agrees.
    pub holds: bool,
    /// What was found.
    pub found: String,
}

/// The rows of one reading.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a>(pub &'a [Row]);

impl Reading<'_> {
    fn row(&self, phase: Phase, place: Place, drones: u16) -> Option<&Row> {
        self.0.iter().find(|row| (row.phase, row.place, row.drones) == (phase, place, drones))
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

    fn ratios(&self, phase: Phase, place: Place) -> impl Iterator<Item = f32> + '_ {
        (1..=PAPER_MOST).map(move |drones| self.ratio(phase, place, drones))
    }

    /// Returns the paper's claims, and whether they hold for this reading.
    #[must_use]
    pub fn claims(&self) -> Vec<Claim> {
        let mut claims = vec![self.durations(), self.links(), self.clearance()];
        claims.extend(self.set_up());
        claims.extend(self.crossings());
        claims.push(self.connectivity());
        claims
    }

    fn durations(&self) -> Claim {
        let errors = (1..).zip(TABLE_2).map(|(drones, paper)| {
            let steps = self.survey(drones).and_then(|row| row.steps);
            steps.map_or(f32::INFINITY, |steps| (steps / paper - 1.0).abs())
        });
        let worst = errors.fold(0.0, f32::max);
        Claim {
            source: "table 2",
            claim: "all six durations of the survey, within 10 %",
            holds: worst <= 0.1,
            found: format!("off by at most {:.0} %", 100.0 * worst),
        }
    }

    fn links(&self) -> Claim {
        let lost: Vec<f32> =
            (2..=PAPER_MOST).filter_map(|n| self.survey(n)).map(|row| row.links_lost).collect();
        let alike = |(lost, paper): (&f32, &f32)| (paper / 2.0..=paper * 2.0).contains(lost);
        Claim {
            source: "table 3",
            claim: "all five numbers of links lost, within a factor of 2",
            holds: lost.len() == TABLE_3.len() && lost.iter().zip(&TABLE_3).all(alike),
            found: list(lost.iter().copied()),
        }
    }

    fn clearance(&self) -> Claim {
        let near =
            self.0.iter().flat_map(|row| [row.min_drone_drone_dsafe, row.min_drone_wall_dsafe]);
        let least = near.flatten().fold(f32::INFINITY, f32::min);
        Claim {
            source: "section 6.3.1",
            claim: "everything stays 1.3 safety distances apart",
            holds: least >= CLEAR,
            found: format!("down to {least:.2}"),
        }
    }

    fn set_up(&self) -> [Claim; 2] {
        let all = || Place::ALL.into_iter().flat_map(|place| self.ratios(Phase::Setup, place));
        let single = Place::ALL.into_iter().all(|place| {
            let mut ratios = self.ratios(Phase::Setup, place);
            let first = ratios.next().unwrap_or(f32::INFINITY);
            ratios.all(|ratio| ratio >= first)
        });
        [
            Claim {
                source: "figure 12",
                claim: "every set-up below 1.4 times the ideal",
                holds: all().all(|ratio| ratio < 1.4),
                found: format!("up to {:.2}", all().fold(0.0, f32::max)),
            },
            Claim {
                source: "figure 12",
                claim: "a single drone is the fastest in every passage",
                holds: single,
                found: format!("in a {}", list(self.ratios(Phase::Setup, Place::A))),
            },
        ]
    }

    fn crossings(&self) -> [Claim; 5] {
        let of = |place| self.ratios(Phase::Crossing, place).collect::<Vec<f32>>();
        let [a, b, c, d, e] = Place::ALL.map(of);
        let growth = |ratios: &[f32], from: usize| match ratios.get(from - 1..=from) {
            Some([before, after]) => after / before,
            _ => f32::NAN,
        };
        let spread = a.iter().fold(0.0, |most: f32, one| most.max(*one))
            / a.iter().fold(f32::INFINITY, |least, one| least.min(*one));
        let slower = |ratios: &[f32]| match ratios.split_first() {
            Some((first, rest)) => rest.iter().all(|ratio| ratio > first),
            None => false,
        };
        let claim = |claim, holds, ratios: &[f32]| Claim {
            source: "figure 14",
            claim,
            holds,
            found: list(ratios.iter().copied()),
        };
        [
            claim("a takes as long with any number of drones, within 10 %", spread <= 1.1, &a),
            claim("c is crossed faster than b", b.iter().zip(&c).skip(1).all(|(b, c)| c < b), &c),
            claim(
                "b to e take longer with several drones than with one",
                [&b, &c, &d, &e].into_iter().all(|ratios| slower(ratios)),
                &b,
            ),
            claim(
                "d grows from 4 to 5 drones by 20 % more than b",
                growth(&d, 4) > 1.2 * growth(&b, 4),
                &d,
            ),
            claim("e grows by 20 % from 3 to 4 drones", growth(&e, 3) > 1.2, &e),
        ]
    }

    fn connectivity(&self) -> Claim {
        let crossings = self.0.iter().filter(|row| row.phase == Phase::Crossing);
        let least = crossings.map(|row| row.connected).fold(1.0, f32::min);
        Claim {
            source: "section 6.3.4",
            claim: "the swarm stays connected in every passage",
            holds: least >= 1.0,
            found: format!("in {:.0} % of the flights where it is least so", 100.0 * least),
        }
    }
}

fn list(numbers: impl Iterator<Item = f32>) -> String {
    let texts: Vec<String> = numbers
        .map(|one| if one.is_finite() { format!("{one:.2}") } else { "stuck".to_owned() })
        .collect();
    texts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::run;

    #[test]
    fn our_rule_holds_what_the_paper_says_of_safety_and_links() {
        let ours = cases().into_iter().filter(|case| case.rule.name == "ours");
        let rows: Vec<Row> =
            ours.flat_map(|case| run(&case, 3, 200_000).expect("at most six drones")).collect();
        for claim in Reading(&rows).claims() {
            let promised = claim.source.starts_with("section");
            assert!(claim.holds || !promised, "{claim:?}");
        }
    }
}
