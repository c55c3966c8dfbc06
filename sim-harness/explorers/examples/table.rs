//! Prints one row of figures for each rule, world and number of robots, over some seeds:
//! `cargo run --release -p explorers --example table -- FIRST-SEED RUNS [RULE ...]`, of all rules where none is
//! named.

use explorers::{Outcome, Setup, WORLDS, run};
use frontier::RULES;

fn main() {
    let mut arguments = std::env::args().skip(1).filter_map(|word| word.parse::<u64>().ok());
    let first = arguments.next().unwrap_or(0);
    let runs = arguments.next().unwrap_or(4);
    let rules: Vec<String> = std::env::args().skip(3).collect();
    println!("world  rule          n  explored  >=99%  t99_s  path_m  overlap  premature  kB");
    for world in WORLDS {
        for entry in RULES {
            if !rules.is_empty() && !rules.iter().any(|name| name == entry.name) {
                continue;
            }
            for robots in 2..=3 {
                let fly = |seed| {
                    let rule = entry.rule;
                    run(&Setup {
                        world,
                        rule,
                        robots,
                        seed,
                        loss: 0.1,
                        death_s: None,
                        apart_s: None,
                    })
                };
                let all: Vec<Outcome> = (first..first + runs).map(fly).collect();
                let mean = |f: fn(&Outcome) -> f32| all.iter().map(f).sum::<f32>() / runs as f32;
                let done: Vec<f32> = all.iter().filter_map(|one| one.t99_s).collect();
                println!(
                    "{:6} {:13} {robots} {:9.3} {:3}/{runs:2} {:6.0} {:7.1} {:8.2} {:6} {:7.1}",
                    world.name,
                    entry.name,
                    mean(|one| one.explored),
                    done.len(),
                    done.iter().sum::<f32>() / done.len() as f32,
                    mean(|one| one.path_m),
                    mean(|one| one.overlap),
                    all.iter().filter(|one| one.premature_stop).count(),
                    mean(|one| one.kb_on_air),
                );
            }
        }
    }
}
