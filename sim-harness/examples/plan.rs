//! scratch
use sim_harness::{mission::*, scenario::*, world::*};
fn main() {
    for name in std::env::args().skip(1) {
        let s = Scenario::open(&name).unwrap_or_else(|e| panic!("{e}"));
        let w = World::of(&s);
        let l = w.tunnel.centre_line().length();
        println!("{name} length {l:.2} limit {}", s.agent.launch.limit);
        let mut x = 2.0f32;
        while x <= l + 0.01 {
            print!("head {x:5.1}:");
            for n in 1..=(s.relays + 1).max(2) { let b = best_chain(&w.radio, n, x.min(l)); print!(" {:.1}", b.worst.0); if x + 2.0 > l { print!("{:.1?}", b.positions); } }
            println!();
            x += 2.0;
        }
    }
}
