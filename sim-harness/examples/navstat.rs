//! scratch
use sim_harness::{mission::*, scenario::*};
fn main() {
    for name in std::env::args().skip(2) {
    let pol = std::env::args().nth(1).unwrap();
    let s = Scenario::open(&name).unwrap_or_else(|e| panic!("{e}")).with_policy(&pol).unwrap();
    let w = World::of(&s);
    let (mut e2, mut o2, mut n, mut bad, mut lat, mut yaw) = (0.0f64, 0.0f64, 0.0f64, 0, 0.0f64, 0.0f64);
    for seed in 0..40 {
    let mut m = Mission::new(&s, &w, seed);
    let mut was_bad = vec![false; 20];
    while !m.is_over() {
        m.round();
        let f = m.frame();
        for (i, d) in f.drones.iter().enumerate().take(s.relays + 1) {
            let (c, t) = w.tunnel.centre_line().at(d.abscissa);
            let a = d.yaw - t[1].atan2(t[0]);
            let err = a.sin().atan2(a.cos());
            if err.abs().to_degrees() > 115.0 && !was_bad[i] { bad += 1; was_bad[i] = true; }
            e2 += (err * err) as f64; o2 += ((c[0]-d.position[0]).powi(2) + (c[1]-d.position[1]).powi(2)) as f64; n += 1.0;
            lat += d.commanded[1].powi(2) as f64; yaw += d.yaw_rate.powi(2) as f64;
        }
    }
    }
    println!("{name} {pol}: heading rms {:.1} deg, offset rms {:.3} m, lateral cmd rms {:.3}, yaw rate rms {:.3} lost-heading {bad}", (e2/n).sqrt().to_degrees(), (o2/n).sqrt(), (lat/n).sqrt(), (yaw/n).sqrt());
    }
}
