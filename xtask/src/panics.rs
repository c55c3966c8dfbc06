//! The calls of panics that are left in the firmware, and who is to answer for each.
//!
//! A panic is a function of the standard library, or of defmt, that never comes back and ends in
//! the panic handler. Who calls it is asked of the debug information: `a[i]` in a function that was
//! inlined into ten others is that function's. The standard library's own functions pass the
//! question on to their callers.

use std::collections::{BTreeMap, BTreeSet};

use crate::flow::Target;
use crate::graph::Program;
use crate::inlining::{Inlining, is_core, root};
use crate::rules::{Panics, Pattern};

/// What is to be said about one function's panics.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Somebody else's, and listed.
    Allowed { why: String },
    /// Made up by the compiler, and listed.
    Generated { why: String },
    /// Not allowed: ours.
    Ours,
    /// Not allowed: in no list.
    Unlisted,
}

/// The panics of one function.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    pub(crate) function: String,
    /// What it was inlined into: the nearest function of ours, or else the outermost.
    pub(crate) within: Option<String>,
    pub(crate) calls: u32,
    /// The panic functions that it calls.
    pub(crate) panics: BTreeSet<String>,
    pub(crate) verdict: Verdict,
}

/// The panic handler.
pub(crate) fn handler(program: &Program) -> Option<usize> {
    program.functions.iter().position(|function| function.name.ends_with("rust_begin_unwind"))
}

/// All that the functions `among` have.
pub(crate) fn find(
    program: &Program,
    among: &BTreeSet<usize>,
    inlining: &Inlining<'_>,
    rules: &Panics,
) -> Vec<Finding> {
    let panics = panic_functions(program);
    let mut calls = vec![];
    for i in among.iter().filter(|i| !panics.contains(i)) {
        let function = &program.functions[*i];
        for call in function.flow.iter().flat_map(|flow| &flow.calls) {
            let Target::At(to) = call.to else { continue };
            let Some(panic) = program.at(to).filter(|to| panics.contains(to)) else { continue };
            // Of a call that several have in common, those are asked who branch to it.
            let ways = program.ways_to(*i, call.at, &|at| inlining.is_exact(at));
            let from = if ways.is_empty() { BTreeSet::from([call.at]) } else { ways };
            for at in from {
                let chain = inlining.chain(at, &function.name);
                calls.push((chain, program.functions[panic].name.clone()));
            }
        }
    }
    judge(calls, rules)
}

fn panic_functions(program: &Program) -> BTreeSet<usize> {
    let Some(handler) = handler(program) else { return BTreeSet::new() };
    let edges = program.direct_calls();
    let ends_there = |i: usize| edges.reach([i]).contains(&handler);
    let panics =
        program.functions.iter().enumerate().filter(|(i, function)| {
            function.diverges() && passes_on(&function.name) && ends_there(*i)
        });
    panics.map(|(i, _)| i).collect()
}

/// Whether a function panics on behalf of its caller: the standard library's and defmt's do.
fn passes_on(name: &str) -> bool {
    let of_defmt = name.starts_with("defmt::export::") || name.ends_with("_panic");
    is_core(name) || of_defmt && name.contains("defmt")
}

/// Calls, each with the functions it is in and the panic it is of, by who answers for them.
fn judge(calls: Vec<(Vec<String>, String)>, rules: &Panics) -> Vec<Finding> {
    let is_ours = |name: &&String| rules.ours.iter().any(|ours| ours == root(name));
    let mut findings = BTreeMap::<(String, Option<String>, bool), Finding>::new();
    for (chain, panic) in calls {
        let at = chain.iter().position(|name| !passes_on(name)).unwrap_or(chain.len() - 1);
        let (author, around) = (&chain[at], &chain[at + 1..]);
        let within = around.iter().find(is_ours).or(around.last());
        let generated = rules.generated.iter().find(|rule| rule.function.matches(&panic));
        let verdict = || match generated {
            Some(rule) => Verdict::Generated { why: rule.why.clone() },
            None if is_ours(&author) => Verdict::Ours,
            None => {
                let rule = rules.allowed.iter().find(|rule| {
                    let there = |within: &Pattern| around.iter().any(|name| within.matches(name));
                    rule.function.matches(author) && rule.within.as_ref().is_none_or(there)
                });
                rule.map_or(Verdict::Unlisted, |rule| Verdict::Allowed { why: rule.why.clone() })
            }
        };
        let key = (author.clone(), within.cloned(), generated.is_some());
        let finding = findings.entry(key).or_insert_with(|| Finding {
            function: author.clone(),
            within: within.cloned(),
            calls: 0,
            panics: BTreeSet::new(),
            verdict: verdict(),
        });
        finding.calls += 1;
        finding.panics.insert(panic);
    }
    findings.into_values().collect()
}

/// The entries that nothing has needed.
pub(crate) fn idle(rules: &Panics) -> Vec<String> {
    let allowed =
        rules.allowed.iter().flat_map(|rule| [Some(&rule.function), rule.within.as_ref()]);
    let generated = rules.generated.iter().map(|rule| Some(&rule.function));
    let patterns = allowed.chain(generated).flatten();
    patterns.filter(|pattern| !pattern.was_used()).map(ToString::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules() -> Panics {
        toml::from_str(
            "ours = [\"agent\"]
             [[generated]]
             function = \"core::panicking::panic_const::panic_const_async*\"
             why = \"made up\"
             [[allowed]]
             function = \"embassy_stm32::rcc::*\"
             why = \"at boot\"
             [[allowed]]
             function = \"defmt_rtt::*\"
             why = \"not any more\"",
        )
        .unwrap()
    }

    fn call(chain: &[&str], panic: &str) -> (Vec<String>, String) {
        (chain.iter().map(|name| (*name).to_owned()).collect(), panic.to_owned())
    }

    fn verdicts(calls: Vec<(Vec<String>, String)>) -> Vec<(String, u32, Verdict)> {
        judge(calls, &rules()).into_iter().map(|f| (f.function, f.calls, f.verdict)).collect()
    }

    #[test]
    fn who_wrote_the_call_answers_and_not_whom_it_was_inlined_into() {
        let unwrap = "core::option::unwrap_failed";
        let in_rcc = ["<core::option::Option<T>>::unwrap", "embassy_stm32::rcc::init", "main"];
        let found = verdicts(vec![call(&in_rcc, unwrap), call(&in_rcc, unwrap)]);
        let allowed = Verdict::Allowed { why: "at boot".into() };
        assert_eq!(found, [("embassy_stm32::rcc::init".into(), 2, allowed)]);
        let found = verdicts(vec![call(&["agent::Agent::step", "embassy_stm32::rcc::x"], unwrap)]);
        assert_eq!(found, [("agent::Agent::step".into(), 1, Verdict::Ours)]);
    }

    #[test]
    fn a_rule_can_be_for_one_place_only() {
        let rules: Panics = toml::from_str(
            "ours = [\"agent\"]
             [[allowed]]
             function = \"heapless::*\"
             within = \"agent::full\"
             why = \"it has room\"",
        )
        .unwrap();
        let panic = "core::option::unwrap_failed";
        let found = judge(
            vec![
                call(&["heapless::extend", "agent::full", "main"], panic),
                call(&["heapless::extend", "agent::other", "main"], panic),
            ],
            &rules,
        );
        assert_eq!(found[0].within.as_deref(), Some("agent::full"));
        assert_eq!(found[0].verdict, Verdict::Allowed { why: "it has room".into() });
        assert_eq!(found[1].verdict, Verdict::Unlisted);
    }

    #[test]
    fn what_is_in_no_list_is_not_allowed() {
        let found = verdicts(vec![call(&["heapless::Vec::push"], "core::panicking::panic")]);
        assert_eq!(found, [("heapless::Vec::push".into(), 1, Verdict::Unlisted)]);
        let only_core = ["core::fmt::Formatter::pad"];
        let found = verdicts(vec![call(&only_core, "core::str::slice_error_fail")]);
        assert_eq!(found, [("core::fmt::Formatter::pad".into(), 1, Verdict::Unlisted)]);
    }

    #[test]
    fn what_the_compiler_makes_up_is_nobodys() {
        let resumed = "core::panicking::panic_const::panic_const_async_fn_resumed";
        let found = verdicts(vec![
            call(&["agent::run::{closure#0}"], resumed),
            call(&["agent::run::{closure#0}"], "core::panicking::panic"),
        ]);
        assert_eq!(found[0].2, Verdict::Ours);
        assert_eq!(found[1].2, Verdict::Generated { why: "made up".into() });
    }

    #[test]
    fn entries_without_use_are_told() {
        let rules = rules();
        judge(vec![call(&["embassy_stm32::rcc::init"], "core::panicking::panic")], &rules);
        assert_eq!(
            idle(&rules),
            ["defmt_rtt::*", "core::panicking::panic_const::panic_const_async*"]
        );
    }
}
