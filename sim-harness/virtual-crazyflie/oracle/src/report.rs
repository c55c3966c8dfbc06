//! Prints the findings, and checks that the counts are those expected.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use core_vectors::Outcome;
use serde::Serialize;

use crate::compare::Findings;
use crate::exemptions::EXEMPTIONS;

/// Prints the findings. True if the cores do not differ and nothing was left out unnoticed.
pub(crate) fn finish(
    findings: &Findings,
    expected: u64,
    json: Option<&Path>,
) -> Result<bool, String> {
    println!(
        "{:<28}{:>9}{:>9}{:>9}{:>7}{:>8}{:>6}{:>10}",
        "form", "encodings", "states", "equal", "fault", "exempt", "left", "different"
    );
    let total = findings.total();
    let rows = findings.forms.iter().map(|(name, tally)| (name.as_str(), tally));
    for (name, tally) in rows.chain([("total", &total)]) {
        println!(
            "{name:<28}{:>9}{:>9}{:>9}{:>7}{:>8}{:>6}{:>10}",
            tally.encodings,
            tally.states,
            tally.equal,
            tally.both_fault,
            tally.exempt,
            tally.incomparable,
            tally.different
        );
    }
    for exemption in EXEMPTIONS {
        let count = findings.exemptions.get(exemption.name).unwrap_or(&0);
        println!("exempt {count}: {} ({})", exemption.name, exemption.reason);
    }
    cases(findings);
    println!(
        "{} instructions with a known answer were right in between, on {} engines",
        findings.known, findings.engines
    );
    write(json, &Summary { total: &total, findings })?;
    if total.states != expected || !total.is_complete() {
        return Err(format!(
            "{} states instead of {expected}: something was left out",
            total.states
        ));
    }
    let run = expected - total.incomparable;
    if findings.known < run / 1000 {
        return Err(format!("only {} known answers in {run} states", findings.known));
    }
    // A form of which no state was ever equal has not been compared, whatever else is said of it.
    let never: Vec<&str> = findings
        .forms
        .iter()
        .filter(|(_, tally)| tally.equal == 0 && tally.incomparable == 0)
        .map(|(name, _)| name.as_str())
        .filter(|name| !name.starts_with("UDF"))
        .collect();
    if !never.is_empty() {
        println!("never equal: {}", never.join(", "));
    }
    Ok(total.different == 0 && never.is_empty())
}

/// The first differences of each form, of the form with most of them first.
pub(crate) fn cases(findings: &Findings) {
    let mut cases: Vec<_> = findings.cases.iter().collect();
    cases.sort_by_key(|case| std::cmp::Reverse(findings.forms[&case.form].different));
    for case in cases {
        println!("{}: {:08x}, state {}: {}", case.form, case.encoding, case.index, case.what);
    }
}

/// The counts that are written as JSON.
#[derive(Serialize)]
struct Summary<'a> {
    total: &'a crate::compare::Tally,
    #[serde(flatten)]
    findings: &'a Findings,
}

fn write(json: Option<&Path>, what: &impl Serialize) -> Result<(), String> {
    let Some(path) = json else { return Ok(()) };
    let text = serde_json::to_string_pretty(what).map_err(|error| error.to_string())?;
    fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Encodings of random bits.
#[derive(Default)]
pub(crate) struct Bits {
    /// That the manual defines.
    pub(crate) regular: u64,
    refused_by_both: u64,
    /// By form; without one if it is UNDEFINED, or a hint without a meaning.
    refused_by_ours: BTreeMap<String, (u64, u32)>,
    executed_by_both: u64,
    /// By form; without one if it is UNDEFINED.
    executed_by_ours: BTreeMap<String, (u64, u32)>,
    undefined_yet_executed: u64,
}

impl Bits {
    /// One that is UNDEFINED or UNPREDICTABLE.
    pub(crate) fn irregular(
        &mut self,
        form: Option<&str>,
        encoding: u32,
        (ours, other): &(Outcome, Outcome),
    ) {
        let executed = |outcome: &Outcome| matches!(outcome, Outcome::Done(_));
        match (executed(ours), executed(other)) {
            (false, false) => self.refused_by_both += 1,
            (false, true) => {
                let name = form.unwrap_or("(no form)").to_owned();
                self.refused_by_ours.entry(name).or_insert((0, encoding)).0 += 1;
            }
            (true, true) => self.executed_by_both += 1,
            (true, false) => {
                let name = form.unwrap_or("(no form)").to_owned();
                self.executed_by_ours.entry(name).or_insert((0, encoding)).0 += 1;
                self.undefined_yet_executed += u64::from(form.is_none());
            }
        }
    }

    pub(crate) fn print(&self) {
        println!(
            "of random bits: {} defined; of the others {} refused by both, {} by ours alone, {} \
             executed by both",
            self.regular,
            self.refused_by_both,
            self.refused_by_ours.values().map(|(count, _)| count).sum::<u64>(),
            self.executed_by_both
        );
        for (form, (count, encoding)) in &self.refused_by_ours {
            println!("refused by ours alone: {count} of {form}, {encoding:08x} for one");
        }
        for (form, (count, encoding)) in &self.executed_by_ours {
            println!("executed by ours alone: {count} of {form}, {encoding:08x} for one");
        }
    }

    /// An encoding that has no form and that the other core refuses is UNDEFINED, and must be so on
    /// ours.
    pub(crate) fn is_right(&self) -> bool {
        self.undefined_yet_executed == 0
    }
}

/// The result of a planted bug.
#[derive(Serialize)]
pub(crate) struct Row {
    name: &'static str,
    pub(crate) forms: u64,
    pub(crate) states: u64,
    /// States in which the bug shows.
    pub(crate) wrong: u64,
    /// … and is noticed by comparison.
    pub(crate) caught: u64,
    /// … and by its hash alone, as the frozen vectors would.
    pub(crate) caught_by_hash: u64,
}

impl Row {
    pub(crate) fn new(name: &'static str) -> Self {
        Self { name, forms: 0, states: 0, wrong: 0, caught: 0, caught_by_hash: 0 }
    }
}

/// Prints what came of the bugs. True if each was caught wherever it showed.
pub(crate) fn mutants(rows: &[Row], json: Option<&Path>) -> Result<bool, String> {
    println!(
        "{:<58}{:>6}{:>8}{:>8}{:>8}{:>8}",
        "bug", "forms", "states", "wrong", "caught", "hash"
    );
    for row in rows {
        println!(
            "{:<58}{:>6}{:>8}{:>8}{:>8}{:>8}",
            row.name, row.forms, row.states, row.wrong, row.caught, row.caught_by_hash
        );
    }
    let missed: Vec<&str> = rows.iter().filter(|row| row.caught == 0).map(|row| row.name).collect();
    let hidden: Vec<&str> = rows
        .iter()
        .filter(|row| row.caught != row.wrong || row.caught_by_hash != row.wrong)
        .map(|row| row.name)
        .collect();
    println!(
        "{} bugs, {} missed {missed:?}, {} hidden {hidden:?}",
        rows.len(),
        missed.len(),
        hidden.len()
    );
    write(json, &rows)?;
    Ok(missed.is_empty() && hidden.is_empty())
}
