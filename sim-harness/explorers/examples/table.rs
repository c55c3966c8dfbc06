//! Prints one row of figures for each rule, world and number of robots, over some seeds:
//! `cargo run --release -p explorers --example table -- FIRST-SEED RUNS [RULE ...]`, of all rules where none is
//! named.

use explorers::{Air, Outcome, PLANS, Setup, World, run};
use frontier::RULES;

fn main() {
    let mut arguments = std::env::args().skip(1).filter_map(|word| word.parse::<u64>().ok());
    let first = arguments.next().unwrap_or(0);
    let runs = arguments.next().unwrap_or(4);
    let rules: Vec<String> = std::env::args().skip(3).collect();
    println!("world   rule          n  >=99%  t99_s  path_m overlap  early  stop      kB touch");
    for (name, _) in PLANS {
        let world = World::plan(name).expect("a built-in plan");
        for entry in RULES {
            if !rules.is_empty() && !rules.iter().any(|name| name == entry.name) {
                continue;
            }
            for robots in 2..=3 {
                let setup = Setup {
                    world: &world,
                    rule: entry.rule,
                    robots,
                    seed: 0,
                    air: Air::losing(0.1),
                    death_s: None,
                    apart_s: None,
                    longest_s: 600.0,
                };
                let all: Vec<Outcome> =
                    (first..first + runs).map(|seed| run(&Setup { seed, ..setup }).0).collect();
                print_row(name, entry.name, robots, &all);
            }
        }
    }
}

fn print_row(world: &str, rule: &str, robots: usize, all: &[Outcome]) {
    let mean = |f: fn(&Outcome) -> f32| all.iter().map(f).sum::<f32>() / all.len() as f32;
    let done: Vec<f32> = all.iter().filter_map(|one| one.t99_s).collect();
    println!(
        "{world:7} {rule:13} {robots} {:3}/{:2} {:6.0} {:7.1} {:7.2} {:6} {:5} {:7.1} {:5}",
        done.len(),
        all.len(),
        done.iter().sum::<f32>() / done.len() as f32,
        mean(|one| one.path_m),
        mean(|one| one.overlap),
        all.iter().filter(|one| one.premature_stop).count(),
        all.iter().filter(|one| one.stopped_s.is_some()).count(),
        mean(|one| one.kb_on_air),
        all.iter().map(|one| one.touches).sum::<u32>(),
    );
}
