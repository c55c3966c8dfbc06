//! Computes the worst case of the stack: thread mode, interrupted at its deepest by the lowest
//! interrupt priority, that by the next, and so on up to a fault.
//!
//! | row | what |
//! |---|---|
//! | thread | everything below the reset vector: start-up, `main`, its executor and the tasks |
//! | priority *n* | the deepest handler of the level, be it an ordinary one or an executor's |
//! | fault | the deepest of the handlers that never return, which can only be the last |
//!
//! A handler that changes over to a stack of its own is measured against that.
//!
//! Handlers of one level do not interrupt each other. Each interruption puts an exception frame on
//! the stack. What the code does not show is in `stack.toml`: which functions a call through a
//! pointer reaches, and the interrupts' priorities, which are set while running. A call without a
//! rule is a complaint, and so is a function that nothing calls: that is a call that no rule
//! resolves.

use std::collections::{BTreeMap, BTreeSet};

use crate::Result;
use crate::elf::Elf;
use crate::flow::Target;
use crate::graph::{Bound, Edges, Program};
use crate::image;
use crate::inlining::is_core;
use crate::rules::{Indirect, Pattern, Stack};

/// The bytes that the processor pushes: 26 words with the floating-point registers, and up to one
/// to align (Armv7-M Architecture Reference Manual, B1.5.6 and B1.5.7).
const EXCEPTION_FRAME: u32 = 4 * 26 + 4;

/// The reset handler's place in the vector table.
const RESET: u32 = 1;
/// The place of the chip's first interrupt in the vector table.
const FIRST_INTERRUPT: u32 = 16;

/// The table.
#[derive(Debug, Default)]
pub(crate) struct Table {
    pub(crate) rows: Vec<Row>,
    /// All rows and the exception frames between them.
    pub(crate) worst: u32,
    pub(crate) frames: u32,
    /// The size of the stack.
    pub(crate) room: u32,
    /// The use and the size of other stacks.
    pub(crate) elsewhere: Vec<(Row, u32)>,
    /// Errors: a call or priority that is not known.
    pub(crate) complaints: Vec<String>,
    /// Rules that no call has needed.
    pub(crate) idle: Vec<String>,
    /// The functions that can run at all.
    pub(crate) reached: BTreeSet<usize>,
}

/// One level of the nesting.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Row {
    pub(crate) what: String,
    pub(crate) bytes: u32,
    /// The deepest way, with what is on the stack below each of its functions.
    pub(crate) way: Vec<(String, u32)>,
}

/// The functions that the instruction at an address comes from, of which the last is known.
pub(crate) type Chain<'a> = dyn Fn(u32, &str) -> Vec<String> + 'a;

/// A handler, the numbers of the interrupts that it serves, and all its names: the linker makes one
/// of handlers that do the same.
struct Handler {
    function: usize,
    numbers: Vec<u32>,
    names: Vec<String>,
}

pub(crate) fn measure(
    elf: &Elf,
    program: &Program,
    chain: &Chain<'_>,
    rules: &Stack,
) -> Result<Table> {
    let mut table = Table::default();
    let top = elf.vectors.stack;
    let handlers = handlers(elf, program)?;
    let (edges, unknown) = resolve(program, rules, chain);
    let reached = edges.reach(handlers.iter().map(|handler| handler.function));
    complain(program, &edges, rules, &reached, &unknown, &mut table.complaints);

    let frames: Vec<u32> = program
        .functions
        .iter()
        .map(|function| function.flow.as_ref().map_or(0, |flow| flow.frame))
        .collect();
    let times = |i: usize| {
        let name = &program.functions[i].name;
        rules.recursion.iter().find(|rule| rule.function.matches(name)).map(|rule| rule.times)
    };
    let roots: Vec<usize> = handlers.iter().map(|handler| handler.function).collect();
    match edges.bounds(&roots, &frames, &times) {
        Ok(bounds) => {
            let nesting = Nesting { program, edges: &edges, bounds: &bounds, rules };
            nesting.rows(&handlers, &mut table);
            nesting.elsewhere(elf, &reached, &mut table);
        }
        Err(circle) => {
            let names: Vec<&str> =
                circle.iter().map(|i| program.functions[*i].name.as_str()).collect();
            table.complaints.push(format!(
                "these call each other in a circle, and stack.toml has no recursion rule for one: {}",
                names.join(", ")
            ));
        }
    }
    table.worst = table.frames + table.rows.iter().map(|row| row.bytes).sum::<u32>();
    table.room = top.saturating_sub(bottom(elf, top));
    table.idle = idle(rules);
    table.reached = reached;
    Ok(table)
}

/// The end of the stack below `top`: above the memory that is reserved there, or the end of the
/// RAM.
fn bottom(elf: &Elf, top: u32) -> u32 {
    elf.sections
        .iter()
        .filter(|section| (image::RAM.start..top).contains(&section.address))
        .map(|section| section.address + section.size)
        .max()
        .unwrap_or(image::RAM.start)
}

fn handlers(elf: &Elf, program: &Program) -> Result<Vec<Handler>> {
    let mut numbers = BTreeMap::<usize, Vec<u32>>::new();
    for (number, address) in &elf.vectors.handlers {
        let function = program.at(*address).ok_or_else(|| {
            format!("vector {number} leads to {address:#010x}, where no function begins")
        })?;
        numbers.entry(function).or_default().push(*number);
    }
    let names = |function: usize| elf.names[&program.functions[function].address].clone();
    Ok(numbers
        .into_iter()
        .map(|(function, numbers)| Handler { function, numbers, names: names(function) })
        .collect())
}

/// Calls whose targets are not known, by caller.
type Unknown = BTreeMap<usize, Vec<String>>;

/// All calls, those through pointers by the rules.
fn resolve(program: &Program, rules: &Stack, chain: &Chain<'_>) -> (Edges, Unknown) {
    let mut edges = program.direct_calls();
    let mut unknown = Unknown::new();
    for (i, function) in program.functions.iter().enumerate() {
        for call in function.flow.iter().flat_map(|flow| &flow.calls) {
            match call.to {
                Target::At(address) if program.at(address).is_some() => {}
                Target::At(address) => {
                    let why =
                        format!("{:#010x} calls {address:#010x}, no function's beginning", call.at);
                    unknown.entry(i).or_default().push(why);
                }
                Target::Unknown => {
                    let chain = chain(call.at, &function.name);
                    let targets = targets(program, &rules.indirect, &chain);
                    if targets.is_empty() {
                        let why = format!(
                            "a call through a pointer, of which stack.toml knows no target, in {}",
                            places(&chain)
                        );
                        unknown.entry(i).or_default().push(why);
                    }
                    edges.0[i].extend(targets.into_iter().map(|to| call.edge(to)));
                }
            }
        }
    }
    (edges, unknown)
}

/// The names by which a rule can match: the innermost function that is not the standard library's,
/// those of it within, and the one that all was inlined into.
fn places(chain: &[String]) -> String {
    let inner = chain.iter().position(|name| !is_core(name)).unwrap_or(0);
    let mut names: Vec<&str> = chain.iter().take(inner + 1).map(String::as_str).collect();
    names.extend(chain.last().map(String::as_str).filter(|_| inner + 1 < chain.len()));
    names.join(", in ")
}

/// The functions that the first rule for such a call names.
fn targets(program: &Program, rules: &[Indirect], chain: &[String]) -> Vec<usize> {
    let rule = rules.iter().find(|rule| {
        let within = |pattern: &Pattern| chain.iter().any(|name| pattern.matches(name));
        rule.within.as_ref().is_none_or(within) && within(&rule.at)
    });
    let Some(rule) = rule else { return vec![] };
    let named = |name: &str| rule.calls.iter().filter(|pattern| pattern.matches(name)).count() > 0;
    program.functions.iter().enumerate().filter(|(_, f)| named(&f.name)).map(|(i, _)| i).collect()
}

fn complain(
    program: &Program,
    edges: &Edges,
    rules: &Stack,
    reached: &BTreeSet<usize>,
    unknown: &Unknown,
    complaints: &mut Vec<String>,
) {
    let mut calls = BTreeMap::<&String, u32>::new();
    for i in reached {
        let function = &program.functions[*i];
        if let Err(why) = &function.flow {
            complaints.push(format!("{}: {why}", function.name));
        }
        for why in unknown.get(i).into_iter().flatten() {
            *calls.entry(why).or_default() += 1;
        }
    }
    complaints.extend(calls.into_iter().map(|(why, times)| match times {
        1 => why.clone(),
        _ => format!("{why} ({times} times)"),
    }));
    // Of functions that are not reached, those that no other of them calls.
    let not_reached = || (0..program.functions.len()).filter(|i| !reached.contains(i));
    let called: BTreeSet<usize> = not_reached()
        .flat_map(|i| edges.0[i].iter().map(move |edge| (i, edge.to)))
        .filter(|(from, to)| from != to)
        .map(|(_, to)| to)
        .collect();
    for i in not_reached().filter(|i| !called.contains(i)) {
        let name = &program.functions[i].name;
        if !rules.unreached.iter().any(|rule| rule.function.matches(name)) {
            complaints.push(format!(
                "{name} is linked, but no call of it is known: a rule for a call through a \
                 pointer lacks it, or stack.toml should list it as unreached"
            ));
        }
    }
}

/// The data from which the rows are computed.
struct Nesting<'a> {
    program: &'a Program,
    edges: &'a Edges,
    bounds: &'a [Bound],
    rules: &'a Stack,
}

impl Nesting<'_> {
    fn rows(&self, handlers: &[Handler], table: &mut Table) {
        let mut levels = BTreeMap::<u8, BTreeSet<usize>>::new();
        let mut fatal = vec![];
        for handler in handlers {
            let function = &self.program.functions[handler.function];
            if handler.numbers.contains(&RESET) {
                table.rows.push(self.row("thread", &[handler.function]));
            } else if function.diverges() {
                fatal.push(handler.function);
            } else {
                for name in &handler.names {
                    if let Some(priority) = self.priority(name) {
                        levels.entry(priority).or_default().insert(handler.function);
                        continue;
                    }
                    let numbers: Vec<String> = handler.numbers.iter().map(|n| number(*n)).collect();
                    table.complaints.push(format!(
                        "{name} handles {}, and stack.toml does not tell its priority",
                        numbers.join(", ")
                    ));
                    // As if it could interrupt all others.
                    table.rows.push(self.row("priority unknown", &[handler.function]));
                }
            }
        }
        // The least urgent first, as they nest.
        for (priority, of_level) in levels.iter().rev() {
            let of_level: Vec<usize> = of_level.iter().copied().collect();
            table.rows.push(self.row(&format!("priority {priority}"), &of_level));
        }
        if !fatal.is_empty() {
            table.rows.push(self.row("fault", &fatal));
        }
        // The thread's row is where the handler comes in the table of functions.
        table.rows.sort_by_key(|row| row.what != "thread" && !row.what.starts_with("thread,"));
        table.frames = EXCEPTION_FRAME * (table.rows.len() as u32).saturating_sub(1);
    }

    /// Adds the stacks that functions change over to.
    fn elsewhere(&self, elf: &Elf, reached: &BTreeSet<usize>, table: &mut Table) {
        for i in reached {
            let function = &self.program.functions[*i];
            for (top, frame) in function.flow.iter().flat_map(|flow| &flow.elsewhere) {
                let calls = self.edges.0[*i].iter().filter(|edge| edge.stack == Some(*top));
                let deepest = calls.max_by_key(|edge| edge.depth + self.bounds[edge.to].bytes);
                let below = deepest.map_or(0, |edge| edge.depth + self.bounds[edge.to].bytes);
                let what = format!("{}, on a stack of its own", function.name);
                let way = deepest.map_or(vec![], |edge| self.way(edge.to));
                let row = Row { what, bytes: below.max(*frame), way };
                let holds = elf.sections.iter().find(|section| {
                    (section.address + 1..=section.address + section.size).contains(top)
                });
                let room = holds.map_or(0, |section| top - section.address);
                table.elsewhere.push((row, room));
            }
        }
    }

    /// The deepest way from a function on, with what is on the stack below each.
    fn way(&self, from: usize) -> Vec<(String, u32)> {
        let mut way = vec![];
        let mut seen = BTreeSet::new();
        let mut next = Some(from);
        while let Some(i) = next.filter(|i| seen.insert(*i)) {
            way.push((self.program.functions[i].name.clone(), self.bounds[i].bytes));
            next = self.bounds[i].through;
        }
        way
    }

    fn row(&self, what: &str, functions: &[usize]) -> Row {
        let deepest = functions.iter().copied().max_by_key(|i| self.bounds[*i].bytes);
        let way = deepest.map_or(vec![], |i| self.way(i));
        let executor = functions.iter().any(|i| self.is_executor(*i));
        Row {
            what: if executor { format!("{what}, an executor") } else { what.to_owned() },
            bytes: deepest.map_or(0, |i| self.bounds[i].bytes),
            way,
        }
    }

    /// Whether tasks are polled below this function.
    fn is_executor(&self, function: usize) -> bool {
        self.edges.reach([function]).iter().any(|i| is_task(&self.program.functions[*i].name))
    }

    fn priority(&self, handler: &str) -> Option<u8> {
        let level = self
            .rules
            .level
            .iter()
            .find(|level| level.handlers.iter().any(|pattern| pattern.matches(handler)));
        level.map(|level| level.priority)
    }
}

fn is_task(name: &str) -> bool {
    name.contains("embassy_executor::raw::TaskStorage<") && name.ends_with("::poll")
}

fn number(of_vector: u32) -> String {
    match of_vector.checked_sub(FIRST_INTERRUPT) {
        Some(interrupt) => format!("interrupt {interrupt}"),
        None => format!("exception {of_vector}"),
    }
}

fn idle(rules: &Stack) -> Vec<String> {
    let indirect = rules.indirect.iter().map(|rule| &rule.at);
    let called = rules.indirect.iter().flat_map(|rule| {
        // Behind a rule without use they cannot have any.
        rule.calls.iter().filter(|_| rule.at.was_used())
    });
    let recursion = rules.recursion.iter().map(|rule| &rule.function);
    let unreached = rules.unreached.iter().map(|rule| &rule.function);
    let levels = rules.level.iter().flat_map(|level| &level.handlers);
    indirect
        .chain(called)
        .chain(recursion)
        .chain(unreached)
        .chain(levels)
        .filter(|pattern| !pattern.was_used())
        .map(ToString::to_string)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::Vectors;
    use crate::synthetic::{self, FLASH, call_register, jump, pop_pc, push, ret, take};

    const SLOW: &str = "<embassy_executor::raw::TaskStorage<slow>>::poll";
    const FAST: &str = "<embassy_executor::raw::TaskStorage<fast>>::poll";

    const RULES: &str = r#"
        [[indirect]]
        at = "SyncExecutor::poll"
        within = "CAN"
        calls = ["*TaskStorage<fast>>::poll"]
        why = ""
        [[indirect]]
        at = "SyncExecutor::poll"
        calls = ["*TaskStorage<*>>::poll"]
        why = ""
        [[level]]
        priority = 1
        handlers = ["TIM"]
        why = ""
        [[level]]
        priority = 2
        handlers = ["CAN"]
        why = ""
    "#;

    fn measured(rules: &str) -> Table {
        // Reset polls two tasks through a pointer; TIM returns, CAN is an executor of one task, and
        // DEFAULT never returns.
        let functions = vec![
            ("reset", 0x100, vec![push(8), take(8), call_register(1), jump(FLASH + 0x106)]),
            ("TIM", 0x200, vec![push(20), pop_pc(20)]),
            ("CAN", 0x300, vec![push(8), call_register(1), pop_pc(8)]),
            ("DEFAULT", 0x400, vec![take(16), jump(FLASH + 0x402)]),
            (SLOW, 0x500, vec![take(0x100), take(-0x100), ret()]),
            (FAST, 0x600, vec![take(0x80), take(-0x80), ret()]),
        ];
        let handler = |number, distance| (number, FLASH + distance);
        let handlers =
            vec![handler(1, 0x100), handler(2, 0x400), handler(3, 0x200), handler(4, 0x300)];
        let vectors = Vectors { stack: 0x2000_6000, handlers };
        let elf = synthetic::elf(vectors, functions, &[(".bss", 0x2000_6000, 0x1000)]);
        let program = Program::new(&elf);
        let chain = |_, name: &str| vec!["SyncExecutor::poll".to_owned(), name.to_owned()];
        let rules: Stack = toml::from_str(rules).unwrap();
        measure(&elf, &program, &chain, &rules).unwrap()
    }

    #[test]
    fn levels_nest_from_the_thread_to_the_fault() {
        let table = measured(RULES);
        let rows: Vec<_> = table.rows.iter().map(|row| (row.what.as_str(), row.bytes)).collect();
        let expected = [
            ("thread, an executor", 16 + 256),
            ("priority 2, an executor", 8 + 128),
            ("priority 1", 20),
            ("fault", 16),
        ];
        assert_eq!(rows, expected);
        assert_eq!(table.frames, 3 * EXCEPTION_FRAME);
        assert_eq!(table.worst, 272 + 136 + 20 + 16 + 3 * EXCEPTION_FRAME);
        assert_eq!(table.rows[0].way, [("reset".into(), 272), (SLOW.into(), 256)]);
        assert_eq!((table.complaints.len(), table.idle.len()), (0, 0), "{table:?}");
        // The statics lie above the stack, not below.
        assert_eq!(table.room, 0x6000);
    }

    #[test]
    fn a_call_or_priority_without_a_rule_is_a_complaint() {
        let table = measured("");
        let complaints = table.complaints.join("\n");
        for part in [
            "in SyncExecutor::poll, in reset",
            "in SyncExecutor::poll, in CAN",
            "TIM handles exception 3",
            "CAN handles exception 4",
            &format!("{SLOW} is linked, but no call of it is known"),
        ] {
            assert!(complaints.contains(part), "{part} in {complaints}");
        }
        // A handler of unknown priority is charged as if it interrupted all others.
        assert_eq!(table.rows.len(), 4);
    }

    #[test]
    fn a_task_that_no_rule_gives_to_an_executor_is_missed() {
        let narrow = RULES.replace("*TaskStorage<*>>::poll", "*TaskStorage<fast>>::poll");
        let complaints = measured(&narrow).complaints;
        assert!(complaints.len() == 1 && complaints[0].starts_with(SLOW), "{complaints:?}");
    }

    #[test]
    fn unused_rules_are_reported() {
        let more = format!("{RULES}\n[[unreached]]\nfunction = \"absent\"\nwhy = \"\"");
        assert_eq!(measured(&more).idle, ["absent"]);
    }
}
