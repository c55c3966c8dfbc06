//! Prints the rows of the book's table of surveys, 600 seeds for each number of drones:
//! `cargo run --release -p swarms --example survey`.

use swarms::survey;
use virtual_forces::Config;

const SEEDS: std::ops::Range<u64> = 200_000..200_600;

fn main() {
    println!(
        "| rule | drones | rounds | stuck | links lost | closest, m |\n|---|---|---|---|---|---|"
    );
    for (name, config) in [("paper", Config::PAPER), ("barrier", Config::BARRIER)] {
        for drones in 1..=6 {
            let flown: Vec<_> = SEEDS.map(|seed| survey(&config, drones, seed)).collect();
            let done: Vec<_> = flown.iter().filter_map(|one| one.rounds).collect();
            let mean = done.iter().sum::<u32>() as f32 / done.len() as f32;
            let stuck = flown.len() - done.len();
            let lost = flown.iter().map(|one| one.links_lost).sum::<u32>() as f32;
            let lost = lost / flown.len() as f32;
            let closest = flown.iter().fold(f32::INFINITY, |least, one| least.min(one.closest.0));
            println!("| {name} | {drones} | {mean:.0} | {stuck} | {lost:.2} | {closest:.2} |");
        }
    }
}
