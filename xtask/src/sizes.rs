//! The table of what the firmware takes, its budgets, and what must not be in it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use virtual_crazyflie::image::{Image, Sizes};

use crate::elf::Elf;
use crate::graph::Program;
use crate::inlining::Inlining;
use crate::panics::{self, Verdict};
use crate::rules::{self, Panics, Stack};
use crate::{Result, open, stack};

/// About a third of the flash, so that all that is still to come has room. Bytes. It was
/// 160,000 before the link (29 kB with its cipher) and the vendor's protocol (27 kB) came in, and
/// 200,000 before the chain-wide policy with its filter, and the trail of the navigator (13 kB), and
/// 220,000 before the ledger of keys, the refusal of held-back packets and the learnt thrust (5 kB), and
/// 240,000 before drones relayed from the ground (2 kB), and 250,000 before the swarm with its virtual
/// forces (17 kB), and 265,000 before drones explored, with their map, planner and packets (33 kB), and
/// 300,000 before drones looked for a spot to land at, kept off what their beams hit, and had the plan
/// of a swarm in their settings (11 kB), and 320,000 before explorers made way for each other and let go of
/// marks (6 kB), and 335,000 before drones landed by all that they hear of the one that is down, and stayed
/// before the edge of a link (6 kB), and 345,000 before drones looked round for the way on in sharp bends
/// (5 kB).
const FLASH_BUDGET: u32 = 352_000;
/// Half of the RAM, worst-case stack included. Bytes.
const RAM_BUDGET: u32 = 64_000;

/// One round of the agent, kept whole for this (`src/tasks/drone.rs`),
const CHAIN_STEP: &str = "uchain_firmware::tasks::mission::step";
/// and one of the flight code (`src/tasks/control.rs`).
const CONTROL_STEP: &str = "uchain_firmware::tasks::control::step";
/// The drone (`src/tasks/drone.rs`),
const DRONE: &str = "uchain_firmware::tasks::drone::DRONE";
/// and the flight code (`src/tasks/control.rs`).
const FLYER: &str = "uchain_firmware::tasks::control::FLYER";

/// Prints the table; false when a budget or a rule is broken.
pub(crate) fn report(path: &Path) -> Result<bool> {
    let in_file = |why: String| format!("{}: {why}", path.display());
    let image = open(path)?;
    let elf = Elf::of(&image).map_err(in_file)?;
    let panic_rules: Panics = rules::read("panics.toml", include_str!("../panics.toml"))?;
    let stack_rules: Stack = rules::read("stack.toml", include_str!("../stack.toml"))?;
    let program = Program::new(&elf);
    let inlining = Inlining::of(&image).map_err(in_file)?;
    let chain = |at: u32, name: &str| inlining.chain(at, name);
    let stack = stack::measure(&elf, &program, &chain, &stack_rules).map_err(in_file)?;

    let mut table = Table::default();
    table.memory(&image, stack.worst);
    table.step("a chain step", &program, CHAIN_STEP);
    table.step("a control step", &program, CONTROL_STEP);
    table.stack(&stack);
    table.panics(&panics::find(&program, &stack.reached, &inlining, &panic_rules));
    table.forbidden(&program);
    for (file, idle) in [("panics.toml", panics::idle(&panic_rules)), ("stack.toml", stack.idle)] {
        for rule in idle {
            println!("  unused in {file}: {rule}");
        }
    }
    for wrong in &table.wrong {
        println!("  NOT ALLOWED: {wrong}");
    }
    Ok(table.wrong.is_empty())
}

/// The printed table, and the broken rules.
#[derive(Default)]
struct Table {
    wrong: Vec<String>,
}

impl Table {
    fn row(&mut self, what: &str, bytes: u32, budget: Option<u32>) {
        match budget {
            None => println!("  {what:<52} {bytes:>8}"),
            Some(budget) => {
                let percent = u64::from(bytes) * 100 / u64::from(budget.max(1));
                println!("  {what:<52} {bytes:>8} {budget:>8} {percent:>4} %");
                if bytes > budget {
                    self.wrong.push(format!("{what} is over its budget"));
                }
            }
        }
    }

    fn memory(&mut self, image: &Image, worst_stack: u32) {
        println!("  {:<52} {:>8} {:>8}", "", "bytes", "budget");
        let Sizes { flash, ram, ccm } = image.sizes();
        self.row("flash", flash, Some(FLASH_BUDGET));
        self.row("RAM, static", ram, None);
        self.row("RAM, with the worst case of the stack", ram + worst_stack, Some(RAM_BUDGET));
        self.row("CCM", ccm, None);
        for (what, name) in [("drone", DRONE), ("flight code", FLYER)] {
            match image.variable(name) {
                Some(part) => {
                    let size = part.len() as u32;
                    self.row(&format!("the {what}, in RAM (part of the above)"), size, None);
                }
                None => self.wrong.push(format!("{name} is not to be found")),
            }
        }
    }

    /// The code of a step: what can be reached from it by direct calls.
    fn step(&mut self, what: &str, program: &Program, name: &str) {
        let edges = program.direct_calls();
        let reached = edges.reach(program.named(name));
        if reached.is_empty() {
            self.wrong.push(format!("{name} is not to be found"));
        }
        let mut parts: Vec<_> = reached.iter().map(|i| &program.functions[*i]).collect();
        parts.sort_by_key(|function| std::cmp::Reverse(function.size));
        let total = parts.iter().map(|function| function.size).sum();
        self.row(&format!("{what}, code (part of the flash)"), total, None);
        for part in parts {
            self.row(&format!("  {}", shortened(&part.name, 50)), part.size, None);
        }
        let panics = panics::handler(program).is_some_and(|handler| reached.contains(&handler));
        let hidden = reached
            .iter()
            .flat_map(|i| program.functions[*i].flow.iter().flat_map(|flow| &flow.calls))
            .filter(|call| call.to == crate::flow::Target::Unknown)
            .count();
        if panics {
            self.wrong.push(format!("{what} can panic"));
        }
        if hidden > 0 {
            self.wrong.push(format!("{what} calls through {hidden} pointers"));
        }
    }

    fn stack(&mut self, stack: &stack::Table) {
        self.row("stack, worst case", stack.worst, Some(stack.room));
        for row in &stack.rows {
            self.row(&format!("  {}", row.what), row.bytes, None);
            for (name, bytes) in &row.way {
                println!("    {bytes:>6}  {}", shortened(name, 90));
            }
        }
        self.row("  exception frames between them", stack.frames, None);
        for (row, room) in &stack.elsewhere {
            self.row(&shortened(&row.what, 50), row.bytes, Some(*room));
            for (name, bytes) in &row.way {
                println!("    {bytes:>6}  {}", shortened(name, 90));
            }
        }
        self.wrong.extend(stack.complaints.iter().cloned());
    }

    fn panics(&mut self, findings: &[panics::Finding]) {
        println!("  calls of panics, by who wrote them:");
        // A function is inlined in many places, and many have one reason.
        let mut excused = BTreeMap::<&str, BTreeMap<&str, u32>>::new();
        for finding in findings {
            match &finding.verdict {
                Verdict::Allowed { why } => {
                    let of_why = excused.entry(why).or_default();
                    *of_why.entry(&finding.function).or_default() += finding.calls;
                }
                Verdict::Generated { why } => {
                    let of_why = excused.entry(why).or_default();
                    *of_why.entry("(by the compiler)").or_default() += finding.calls;
                }
                Verdict::Ours => self.panic(finding, "and is ours"),
                Verdict::Unlisted => self.panic(finding, "and is in no list of panics.toml"),
            }
        }
        for (why, functions) in excused {
            for (function, calls) in functions {
                println!("  {calls:>6}  {}", shortened(function, 90));
            }
            println!("            {why}");
        }
    }

    fn panic(&mut self, finding: &panics::Finding, why: &str) {
        println!("  {:>6}  {}  NOT ALLOWED", finding.calls, shortened(&finding.function, 90));
        let within = finding.within.as_ref().map(|name| format!(", in {name},"));
        let panics: Vec<&str> = finding.panics.iter().map(String::as_str).collect();
        self.wrong.push(format!(
            "{}{} calls {}, {why}",
            finding.function,
            within.unwrap_or_default(),
            panics.join(", ")
        ));
    }

    fn forbidden(&mut self, program: &Program) {
        let edges = program.direct_calls();
        let mut forbid = |what: &str, is_one: fn(&str) -> bool| {
            let name = |i: usize| program.functions[i].name.as_str();
            let found: BTreeSet<usize> =
                (0..program.functions.len()).filter(|i| is_one(name(*i))).collect();
            let calls = |i: &usize| edges.0[*i].iter().any(|edge| found.contains(&edge.to));
            let callers = (0..program.functions.len()).filter(|i| calls(i) && !found.contains(i));
            let (found, callers): (Vec<&str>, Vec<&str>) =
                (found.iter().map(|i| name(*i)).collect(), callers.map(name).collect());
            println!("  {what}: {}", if found.is_empty() { "no" } else { "YES" });
            if !found.is_empty() {
                let (found, callers) = (found.join(", "), callers.join(", "));
                self.wrong.push(format!("{what}: {found}, called by {callers}"));
            }
        };
        forbid("double precision", is_double);
        forbid("an allocator", is_allocator);
    }
}

/// Whether this is a routine for 64-bit floating point, which the processor has no unit for
/// (Run-time ABI for the Arm Architecture, 5.1; libgcc's names).
fn is_double(name: &str) -> bool {
    let to_double = name.strip_prefix("__aeabi_").is_some_and(|rest| {
        rest.ends_with("2d") || rest.starts_with('d') && !rest.starts_with("div")
    });
    let converts = ["__fix", "__float", "__extend", "__trunc"];
    let libgcc = name.starts_with("__") && (name.ends_with("df2") || name.ends_with("df3"))
        || converts.iter().any(|prefix| name.starts_with(prefix)) && name.contains("df");
    to_double || libgcc
}

fn is_allocator(name: &str) -> bool {
    ["__rust_alloc", "__rust_realloc", "__rdl_alloc", "__rg_alloc"]
        .iter()
        .any(|allocator| name.ends_with(allocator))
}

/// The beginning and the end of a long name.
fn shortened(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let half = (most - 1) / 2;
    let (begin, end) = (&letters[..half], &letters[letters.len() - half..]);
    begin.iter().chain(&['…']).chain(end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_precision_is_told_from_the_rest() {
        for name in [
            "__aeabi_dadd",
            "__aeabi_f2d",
            "__aeabi_ul2d",
            "__muldf3",
            "__ltdf2",
            "__truncdfsf2",
            "__extendsfdf2",
            "__fixdfsi",
            "__aeabi_d2iz",
        ] {
            assert!(is_double(name), "{name}");
        }
        for name in ["__aeabi_ul2f", "__aeabi_memcpy", "__mulsf3", "__aeabi_div0", "main"] {
            assert!(!is_double(name), "{name}");
        }
    }

    #[test]
    fn a_long_name_keeps_both_ends() {
        assert_eq!(shortened("abcdefghij", 7), "abc…hij");
        assert_eq!(shortened("abc", 7), "abc");
    }
}
