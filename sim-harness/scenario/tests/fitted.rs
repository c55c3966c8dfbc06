//! The sections that a fit of a radio model writes are read as a scenario's.

use std::f64::consts::SQRT_2;

use radio_model::PathLoss;
use random::{Purpose, Stream};
use recordings::fit::fit;
use recordings::recording::{Ends, Recorder, Recording};
use scenario::Scenario;
use units::{Dbm, Instant, Metres};

/// A walk past six receivers, each with a gain of its own.
fn walk(seed: u64) -> Recording {
    let mut random = Stream::new(seed, Purpose::Start);
    let mut recorder = Recorder::default();
    let gains: Vec<f32> = (0..6).map(|_| 3.0 * random.normal()).collect();
    for step in 0..1000_u16 {
        let x = f32::from(step) * 0.02;
        for (n, gain) in gains.iter().enumerate() {
            let distance = Metres(1.0 + (x - n as f32 * 4.0).abs());
            let rssi = Dbm(gain - 45.0 - 24.0 * distance.0.log10() + 2.0 * random.normal());
            let link = recorder.link(&format!("{n}"));
            let ends = Ends { distance, moving: [f64::from(x), 0.0, 0.0] };
            let time = Instant::from_millis(u64::from(step) * 200);
            recorder.sample(usize::from(step) + 1, time, link, rssi, None, Some(ends));
        }
    }
    recorder.finish()
}

#[test]
fn the_fitted_sections_are_a_scenarios() {
    let found = fit([walk(1)].iter()).unwrap();
    let rest = "title = \"t\"\nduration_s = 10\n[tunnel]\nwidth_m = 1.2\n\
                centre_line_m = [[0, 0], [12, 0]]\n[drones]\nrelays = 2\n";
    let scenario =
        Scenario::of_text("fitted.toml".as_ref(), &format!("{rest}{}", found.scenario()));
    let radio = scenario.unwrap().radio;
    let PathLoss::LogDistance(law) = radio.place.path_loss else { panic!("another law") };
    assert!((f64::from(law.exponent) - found.exponent.value).abs() < 0.006);
    // The gains of a link's two drones scatter together as the links of the recording do.
    let of_a_link = f64::from(radio.gain_error.0) * SQRT_2;
    assert!((of_a_link - found.gain_error_db.value).abs() < 0.01, "{of_a_link}");
}
