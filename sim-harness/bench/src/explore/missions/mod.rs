//! Missions of drones that explore plans: each flies the code that it has on board.
//!
//! | module | holds |
//! |---|---|
//! | `plans` | the named floor plans, and the scenario of a plan |
//! | `drawn` | a floor plan from a seed |
//! | `measure` | the missions of one case, and what came of them |

mod drawn;
mod measure;
mod plans;

use std::fmt::Write;

use input::InputError;
use scenario::Fidelity;

use self::measure::{Case, Flown, Row, STOPS_S};
use self::plans::Plan;
use super::measure::Named;
use crate::missions::{shown, tally};
use crate::{Outcome, Session};

/// What is flown.
pub(super) struct Choice {
    /// How many plans the seeds draw; the named ones where it is none.
    pub(super) drawn: Option<usize>,
    pub(super) rules: Vec<Named>,
    pub(super) drones: Vec<usize>,
    pub(super) fidelity: Fidelity,
    /// Whether a positioning system tells drones their places.
    pub(super) has_fixes: bool,
    /// The number of missions of a row.
    pub(super) runs: usize,
}

impl Choice {
    fn plans(&self, seed: u64) -> Vec<Plan> {
        match self.drawn {
            None => Plan::named(),
            Some(count) => (0..count as u64).map(|n| drawn::plan(seed.wrapping_add(n))).collect(),
        }
    }

    fn cases(&self, seed: u64) -> Result<Vec<Case>, InputError> {
        let mut cases = Vec::new();
        for plan in self.plans(seed) {
            for &rule in &self.rules {
                for &drones in &self.drones {
                    let text = plan.text(drones, self.has_fixes, self.fidelity);
                    cases.push(Case::of(&plan.name, text, drones, rule)?);
                }
            }
        }
        Ok(cases)
    }
}

/// Flies the missions.
pub(super) fn bench(choice: &Choice, session: &mut Session<'_>) -> Result<Outcome, InputError> {
    let cases = choice.cases(session.seed)?;
    let progress = session.progress(cases.len() * choice.runs, "missions");
    let seeds = (choice.runs, session.seed);
    let rows: Vec<Row> =
        cases.into_iter().map(|case| measure::fly(case, seeds, || progress.step())).collect();
    drop(progress);
    if let Some(folder) = &mut session.folder {
        for row in &rows {
            let name = format!("{}-{}.toml", row.case.plan, row.case.drones);
            folder.put_text(&name, &row.case.text)?;
        }
    }
    Ok(Outcome {
        table: table(choice, &rows),
        json: rows.iter().map(Row::json).collect(),
        missed: missed(&rows),
        seeds: crate::seeds(session.seed, choice.runs),
    })
}

/// The bounds that were missed, one line each.
fn missed(rows: &[Row]) -> Vec<String> {
    let of = |what: &str, is: fn(&Flown) -> bool| {
        let count: usize = rows.iter().map(|row| row.count(is)).sum();
        (count > 0).then(|| format!("explore: {count} missions {what}, must be 0"))
    };
    let touched = of("with a touch", |flown| flown.judgement.touched());
    let wrongly = of("called a success wrongly", Flown::is_false_success);
    touched.into_iter().chain(wrongly).collect()
}

fn table(choice: &Choice, rows: &[Row]) -> String {
    let mut text = format!(
        "explore: missions of drones, {} a row, level {}, {}; good: a success, with 99 % known and the \
         maps right\n\n  {:14} {:13} {:>6} {:>5} {:>5} {:>8} {:>5} {:>5} {:>7} {:>6} {:>7}  {}\n",
        choice.runs,
        choice.fidelity.name(),
        if choice.has_fixes { "with fixes" } else { "without fixes" },
        "plan",
        "rule",
        "drones",
        "runs",
        "good",
        "explored",
        "99 %",
        "right",
        "touched",
        "t99 s",
        "after s",
        "what was wrong",
    );
    for row in rows {
        let wrong = tally(row.flown.iter().flat_map(Flown::wrong));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:14} {:13} {:>6} {:>5} {:>5} {:>8.4} {:>5} {:>5} {:>7} {:>6} {:>7}  {}",
            row.case.plan,
            row.case.rule,
            row.case.drones,
            row.flown.len(),
            row.count(Flown::is_good),
            row.explored(),
            row.count(Flown::is_known),
            row.count(Flown::is_right),
            row.count(|flown| flown.judgement.touched()),
            shown(row.t99_s()),
            shown(row.stopped_after_s().map(f64::from)),
            wrong,
        );
    }
    let _ = writeln!(
        text,
        "\n  after s: the longest time that drones went on after 99 % were known; at most {STOPS_S:.0} s \
         are asked"
    );
    text
}
