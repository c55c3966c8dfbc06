//! scratch
use sim_harness::{metrics::*, mission::*, scenario::*};
use std::time::Instant;
fn main() {
    let runs: u64 = std::env::args().nth(1).map_or(50, |s| s.parse().unwrap());
    let names: Vec<String> = std::env::args().skip(2).collect();
    for name in names {
        let base = Scenario::open(&name).unwrap_or_else(|e| panic!("{e}"));
        let t = Instant::now();
        let world = World::of(&base);
        let reference = Reference::of(&base, &world);
        eprintln!("{name}: len {:.2} prep {:?}", world.tunnel.centre_line().length(), t.elapsed());
        for p in POLICIES {
            let s = base.with_policy(p).unwrap();
            let t = Instant::now();
            let mut v: Vec<RunMetrics> = (0..runs).map(|seed| measure(&s, &world, &reference, seed)).collect();
            let dt = t.elapsed().as_secs_f64();
            let n = v.len() as f32;
            v.sort_by(|a, b| a.t3_s.total_cmp(&b.t3_s));
            let m = |f: fn(&RunMetrics) -> f32| v.iter().map(f).sum::<f32>() / n;
            let mut g1: Vec<f32> = v.iter().map(|r| r.t_gap1_s).collect(); g1.sort_by(f32::total_cmp);
            let rounds = runs as f64 * s.duration_us as f64 / 2e5 * (s.relays as f64 + 2.0);
            println!("{name:16} {p:8} c3 {:.2} c1 {:.2} t3 {:6.1} tgap1 {:6.1} gap {:.2} D {:.2} sd {:.3} path {:.1} bound {:.1} wall {} drone {} order {} launched {:.2}/{:.2} viol {:.2} far {:.1} | {:.0} k/s",
                m(|r| f32::from(r.t3_s.is_finite())), m(|r| f32::from(r.t1_s.is_finite())),
                v[v.len() / 2].t3_s, g1[g1.len()/2], m(|r| r.gap_db), m(|r| r.difference_db), m(|r| r.position_sd_m), m(|r| r.path_m), m(|r| r.bound_s),
                v.iter().map(|r| r.wall_contacts).sum::<u32>(), v.iter().map(|r| r.drone_contacts).sum::<u32>(), v.iter().map(|r| r.order_lost).sum::<u32>(),
                m(|r| r.launched as f32), m(|r| r.needed as f32), m(|r| r.violation), m(|r| r.farthest_m), rounds / dt / 1e3);
        }
    }
}
