//! scratch
use sim_harness::{metrics::*, mission::*, scenario::*};
use chain::{policy::*, filter::*};
use units::*;
fn main() {
    let runs = 40u64;
    let names: Vec<String> = std::env::args().skip(1).collect();
    for (gain, q, doubt, follow) in [(0.1, 0.02, 0.6, 0.8),(0.1, 0.02, 0.6, 1.0),(0.12, 0.02, 0.6, 0.9),(0.15, 0.02, 0.6, 0.8)] {
        println!("k {gain} q {q} doubt {doubt} follow {follow}: ");
        for name in &names {
            let mut s = Scenario::open(name).unwrap();
            let slope = Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) };
            s.agent.policy = PolicyConfig { smoothing: Smoothing::Kalman(Kalman { slope, process_variance: q, motion_doubt: doubt, measurement_variance: 3.0 }), law: SpeedLaw::Proportional { gain, slope, of: SlopeOf::SteeperLink, follow }, ..PolicyConfig::DEFAULT };
            let w = World::of(&s); let rf = Reference::of(&s, &w);
            let mut v: Vec<RunMetrics> = (0..runs).map(|seed| measure(&s, &w, &rf, seed)).collect();
            v.sort_by(|a, b| a.t3_s.total_cmp(&b.t3_s));
            let n = v.len() as f32; let m = |f: fn(&RunMetrics) -> f32| v.iter().map(f).sum::<f32>() / n;
            println!("   {name:12} c3 {:.2} c1 {:.2} t3 {:5.1} gap {:.2} D {:.2} sd {:.3} order {} drone {} wall {} launched {:.2}/{:.2} viol {:.2} far {:.1}", m(|r| f32::from(r.t3_s.is_finite())), m(|r| f32::from(r.t1_s.is_finite())), v[v.len()/2].t3_s, m(|r| r.gap_db), m(|r| r.difference_db), m(|r| r.position_sd_m), v.iter().map(|r| r.order_lost).sum::<u32>(), v.iter().map(|r| r.drone_contacts).sum::<u32>(), v.iter().map(|r| r.wall_contacts).sum::<u32>(), m(|r| r.launched as f32), m(|r| r.needed as f32), m(|r| r.violation), m(|r| r.farthest_m));
        }
    }
}
