//! Runs both cores on the same state and judges their outcomes: equal, different, or exempt.

use std::collections::BTreeMap;

use core_vectors::forms::{self, Form};
use core_vectors::{Outcome, Rig, State, States};
use serde::Serialize;

use crate::exemptions::{self, EXEMPTIONS};
use crate::unicorn::Other;

/// The result of one state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Everything is the same after it.
    Equal,
    /// Both say that it is a fault.
    BothFault,
    /// The two differ for a known reason: the number of the exemption.
    Exempt(usize),
    /// The form cannot be compared in this way.
    Incomparable,
    /// The two differ.
    Different(String),
}

/// The counts of each result.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Tally {
    pub(crate) encodings: u64,
    pub(crate) states: u64,
    pub(crate) equal: u64,
    pub(crate) both_fault: u64,
    pub(crate) exempt: u64,
    pub(crate) incomparable: u64,
    pub(crate) different: u64,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.encodings += other.encodings;
        self.states += other.states;
        self.equal += other.equal;
        self.both_fault += other.both_fault;
        self.exempt += other.exempt;
        self.incomparable += other.incomparable;
        self.different += other.different;
    }

    /// Every state has come to something.
    pub(crate) fn is_complete(&self) -> bool {
        self.states
            == self.equal + self.both_fault + self.exempt + self.incomparable + self.different
    }
}

/// A state after which the cores differ.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Case {
    pub(crate) form: String,
    pub(crate) encoding: u32,
    /// Which of the encoding's states.
    pub(crate) index: usize,
    pub(crate) what: String,
}

/// Everything that was found.
#[derive(Default, Serialize)]
pub(crate) struct Findings {
    pub(crate) forms: BTreeMap<String, Tally>,
    pub(crate) exemptions: BTreeMap<&'static str, u64>,
    /// The first few of each form.
    pub(crate) cases: Vec<Case>,
    /// Instructions with a known answer that Unicorn had right in between.
    pub(crate) known: u64,
    /// Engines it took.
    pub(crate) engines: u64,
}

impl Findings {
    pub(crate) fn total(&self) -> Tally {
        let mut total = Tally::default();
        self.forms.values().for_each(|tally| total.add(tally));
        total
    }
}

/// Both cores.
pub(crate) struct Pair {
    ours: Rig,
    other: Other,
    last: Option<u32>,
}

impl Pair {
    pub(crate) fn new() -> Self {
        Self { ours: Rig::new(), other: Other::new(), last: None }
    }

    /// Executes a state on both cores. After an exclusive load the other core must forget its
    /// monitor.
    pub(crate) fn outcomes(&mut self, encoding: u32, state: &State) -> (Outcome, Outcome) {
        if self.last.replace(encoding) != Some(encoding) {
            let exclusive = forms::of(encoding)
                .is_some_and(|form| form.name.contains("EX") && form.aim_is_base());
            if exclusive {
                self.other.forget();
            }
        }
        (self.ours.run(encoding, state), self.other.run(encoding, state))
    }

    /// Compares so many states of an encoding. The caller gets each outcome.
    pub(crate) fn compare(
        &mut self,
        encoding: u32,
        seed: u64,
        count: usize,
        findings: &mut Findings,
        mut each: impl FnMut(usize, &Verdict, &Outcome),
    ) {
        let form = forms::of(encoding);
        let name = form.map_or("(no form)", |form| form.name.as_str()).to_owned();
        let mut tally = Tally { encodings: 1, ..Tally::default() };
        for (index, state) in States::of(encoding, seed).take(count).enumerate() {
            tally.states += 1;
            if form.is_some_and(exemptions::cannot_be_compared) {
                tally.incomparable += 1;
                each(index, &Verdict::Incomparable, &Outcome::Other(String::new()));
                continue;
            }
            let (ours, other) = self.outcomes(encoding, &state);
            let verdict = judge(form, encoding, &state, &ours, &other);
            match &verdict {
                Verdict::Equal => tally.equal += 1,
                Verdict::BothFault => tally.both_fault += 1,
                Verdict::Exempt(which) => {
                    tally.exempt += 1;
                    *findings.exemptions.entry(EXEMPTIONS[*which].name).or_insert(0) += 1;
                }
                Verdict::Incomparable => tally.incomparable += 1,
                Verdict::Different(what) => {
                    tally.different += 1;
                    let before = findings.forms.get(&name).map_or(0, |tally| tally.different);
                    if before + tally.different <= 3 {
                        let case = Case { form: name.clone(), encoding, index, what: what.clone() };
                        findings.cases.push(case);
                    }
                }
            }
            each(index, &verdict, &ours);
        }
        findings.forms.entry(name).or_default().add(&tally);
        (findings.known, findings.engines) = (self.other.known, self.other.engines);
    }
}

/// Judges two outcomes.
pub(crate) fn judge(
    form: Option<&Form>,
    encoding: u32,
    state: &State,
    ours: &Outcome,
    other: &Outcome,
) -> Verdict {
    let what = match (ours, other) {
        (Outcome::Done(a), Outcome::Done(b)) if a == b => return Verdict::Equal,
        (Outcome::Fault(_), Outcome::Fault(_)) => return Verdict::BothFault,
        (Outcome::Done(a), Outcome::Done(b)) => a.differs_from(b).join(", "),
        (a, b) => format!("{} not {}", brief(a), brief(b)),
    };
    exemptions::find(form, encoding, state, ours, other)
        .map_or(Verdict::Different(what), Verdict::Exempt)
}

fn brief(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Done(_) => "done".to_owned(),
        Outcome::Fault(what) => format!("fault {what}"),
        Outcome::Other(what) => format!("stop {what}"),
    }
}
