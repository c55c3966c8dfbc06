//! A model is found again in packets that were made by it.

use radio_model::{Reception, Shadowing};
use units::{Db, Instant, Point2};

use super::*;
use crate::recording::{Ends, Recorder};

/// A walk past six receivers, with the packets of a known model.
fn walk(seed: u64) -> Recording {
    let mut random = Stream::new(seed, Purpose::Start);
    let mut draws = Stream::new(seed, Purpose::Place);
    let mut recorder = Recorder::default();
    let gains: Vec<f32> = (0..6).map(|_| 3.0 * random.normal()).collect();
    let fields: Vec<Shadowing> = (0..6)
        .map(|_| Shadowing::new(Db(4.0), Metres(1.5), || std::array::from_fn(|_| draws.uniform())))
        .collect();
    for step in 0..3000_u16 {
        let along = f32::from(step) * 0.05;
        // To and fro over 20 m, each time a little aside.
        let x = 20.0 - (10.0 - along % 20.0).abs() * 2.0;
        let at = Point2::new(x, along / 20.0);
        for (n, (field, gain)) in fields.iter().zip(&gains).enumerate() {
            let receiver = Point2::new(n as f32 * 4.0, -2.0);
            let distance = at.distance(receiver);
            let shadow = field.loss(receiver, at).0;
            let loss = 45.0 + 10.0 * 2.4 * distance.0.log10() + shadow;
            let rssi = Dbm(gain - loss + Reception::PAPER.noise_variance.sqrt() * random.normal());
            let link = recorder.link(&format!("{n}"));
            let ends = Ends { distance, moving: [f64::from(at.x), f64::from(at.y), 0.0] };
            let time = Instant::from_millis(u64::from(step) * 200);
            recorder.sample(usize::from(step) + 1, time, link, rssi, None, Some(ends));
        }
    }
    recorder.finish()
}

/// A walk of ten minutes tells the variance of the noise to 0.65 dB² (standard deviation over 40 walks),
/// so that a walk may be off by three of them; the mean of ten walks is held to three of its own.
#[test]
fn a_model_is_found_again_in_its_own_packets() {
    const WALKS: u64 = 10;
    let mut noise = 0.0;
    for seed in 1..=WALKS {
        let found = fit([walk(seed)].iter()).unwrap();
        let near = |what: &str, found: Estimate, wanted: f64, within: f64| {
            assert!((found.value - wanted).abs() < within, "seed {seed}: {what} {found:?}");
        };
        near("exponent", found.exponent, 2.4, 0.35);
        near("loss at 1 m", found.loss_at_1m_db, 45.0, 5.0);
        near("noise", found.noise_variance_db2, 3.0, 3.0 * 0.65);
        near("shadowing", found.shadowing_db, 4.0, 1.2);
        near("decorrelation", found.decorrelation_m, 1.5, 1.0);
        assert!(found.held_out.fitted_db < found.held_out.default_db, "{:?}", found.held_out);
        noise += found.noise_variance_db2.value / WALKS as f64;
    }
    assert!((noise - 3.0).abs() < 3.0 * 0.65 / (WALKS as f64).sqrt(), "{noise} dB² in the mean");
}

#[test]
fn packets_without_distances_cannot_be_fitted() {
    let mut recorder = Recorder::default();
    let link = recorder.link("a");
    for n in 0..100 {
        let time = Instant::from_millis(n * 200);
        recorder.sample(n as usize, time, link, Dbm(-60.0), None, None);
    }
    let error = fit([recorder.finish()].iter()).unwrap_err();
    assert!(error.to_string().contains("0 packets have a known distance"), "{error}");
}
