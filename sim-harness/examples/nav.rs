//! scratch
use sim_harness::{mission::*, scenario::*};
fn main() {
    let name = std::env::args().nth(1).unwrap();
    let pol = std::env::args().nth(2).unwrap();
    let seed: u64 = std::env::args().nth(3).unwrap().parse().unwrap();
    let s = Scenario::open(&name).unwrap_or_else(|e| panic!("{e}")).with_policy(&pol).unwrap();
    let w = World::of(&s);
    let mut m = Mission::new(&s, &w, seed);
    let mut bad = vec![0; s.relays + 2];
    while !m.is_over() {
        m.round();
        let f = m.frame();
        for (i, d) in f.drones.iter().enumerate().take(s.relays + 1) {
            let (_, t) = w.tunnel.centre_line().at(d.abscissa);
            let err = (d.yaw - t[1].atan2(t[0])).sin().atan2((d.yaw - t[1].atan2(t[0])).cos()).to_degrees();
            if err.abs() > 115.0 || bad[i] > 0 { bad[i] += 1; }
            let show = std::env::args().nth(4).map_or(false, |a| a.parse::<usize>().unwrap() == i);
            if bad[i] == 1 || show {
                println!("t {:.1} drone {i} s {:.2} xy {:.2} {:.2} yaw {:.0} err {err:.0} cmd {:.2} {:.2} w {:.2} ranges {:.2?} {:?}", f.time_us as f32 * 1e-6, d.abscissa, d.position[0], d.position[1], d.yaw.to_degrees(), d.commanded[0], d.commanded[1], d.yaw_rate, d.ranges, d.state.name());
            }
        }
    }
}
