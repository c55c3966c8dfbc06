//! The oracle in corridors whose answers can be computed by hand.

use std::path::Path as File;

use super::*;

/// Line, radio, relays, limit and the pilot's speed and time.
#[derive(Clone, Copy)]
struct Case<'a> {
    line: &'a str,
    radio: &'a str,
    relays: usize,
    limit: f32,
    speed: f32,
    until_s: u32,
}

const STRAIGHT: Case<'_> =
    Case { line: "[0, 0], [60, 0]", radio: "", relays: 2, limit: -60.0, speed: 0.4, until_s: 300 };
const ANGLE: Case<'_> = Case { line: "[0, 0], [10, 0], [10, 30]", ..STRAIGHT };

impl Case<'_> {
    fn scenario(&self) -> Scenario {
        let Self { line, radio, relays, limit, speed, until_s } = self;
        let (ends, retreat) = (until_s + 60, limit - 6.0);
        let text = format!(
            "title = \"\"\nduration_s = {ends}\n[tunnel]\nwidth_m = 1.2\n\
             centre_line_m = [{line}]\n[radio]\n{radio}\n[drones]\nrelays = {relays}\n\
             [launch]\nlimit_dbm = {limit}\n[retreat]\nlimit_dbm = {retreat}\n\
             [[pilot]]\nat_s = 2\norder = \"explore\"\nspeed_mps = {speed}\n\
             [[pilot]]\nat_s = {until_s}\norder = \"return\"\n"
        );
        Scenario::of_text(File::new("case.toml"), &text).unwrap()
    }

    fn oracle(&self) -> Oracle {
        let scenario = self.scenario();
        let world = scenario.world();
        Oracle::of(&scenario, &world, &Commanded::along_main(&world), 1)
    }
}

/// Equation (19) in sight: 60 dB at 10 m.
#[test]
fn a_straight_gallery_takes_a_relay_every_ten_metres() {
    let oracle = STRAIGHT.oracle();
    assert!((oracle.reach_m - 30.0).abs() <= 0.2, "{oracle:?}");
    assert_eq!((oracle.ended, oracle.least_relays), (Ended::Relays, 2));
    assert_eq!([5.0, 15.0, 25.0].map(|at| oracle.least_relays_at(at)), [0, 1, 2]);
    // From the row, 1.05 m in, at 0.4 m/s, after the climb of 2.5 s. The relays, ahead of need, are
    // never late.
    let alone = 2.0 + 2.5 + (30.0 - 1.05) / 0.4;
    assert!((oracle.at_s - alone).abs() < 1.0, "{} for {alone}", oracle.at_s);
}

/// With a first link of 1.5 m the head waits for relays that take off 5.5 s after each other, fly 0.35 m
/// less far, and are needed 1.5 m behind it.
#[test]
fn a_head_waits_for_relays_that_have_to_come_first() {
    let limit = -40.0 - 20.0 * 1.5_f32.log10();
    let oracle = Case { relays: 2, limit, ..STRAIGHT }.oracle();
    assert!((oracle.reach_m - 4.5).abs() <= 0.3, "{oracle:?}");
    // The second relay, which starts at 0.35 m, is up at 2 + 2.5 + 2 · 5.5 s, and must be at 1.5 m.
    let second = 2.0 + 2.5 + 11.0 + 1.15 / 0.4;
    assert!((oracle.at_s - second).abs() < 1.0, "{} for {second}", oracle.at_s);
}

#[test]
fn a_pilot_or_a_wall_ends_it_as_well() {
    let short = Case { until_s: 17, ..STRAIGHT }.oracle();
    // 12.5 s at 0.4 m/s, from 1.05 m on.
    assert_eq!((short.ended, short.least_relays), (Ended::Pilot, 0));
    assert!((short.depth_m - 6.05).abs() < 0.3, "{short:?}");
    let walled = Case { line: "[0, 0], [12, 0]", ..STRAIGHT }.oracle();
    assert_eq!((walled.ended, walled.least_relays), (Ended::Gallery, 1));
    // The wall is 0.6 m beyond the line.
    assert!((walled.depth_m - 12.0).abs() < 0.2, "{walled:?}");
    let deaf = Case { limit: -25.0, ..STRAIGHT }.oracle();
    assert_eq!(deaf.ended, Ended::Radio);
}

/// Walls are counted: a link round the corner has an exponent of 4 at least, and reaches 3.2 m.
#[test]
fn walls_that_count_hold_a_head_at_a_corner() {
    let counted = Case { radio: "attenuation = \"wall-count\"", ..ANGLE };
    let alone = Case { relays: 0, ..counted }.oracle();
    // The corner hides the head some centimetres behind it; before it, 10 m are in sight.
    assert!((9.8..10.8).contains(&alone.reach_m), "{alone:?}");
    let one = Case { relays: 1, ..counted }.oracle();
    assert!(one.reach_m > alone.reach_m + 8.0, "a relay in the corner sees both legs: {one:?}");
    assert!(one.reach_m < STRAIGHT.oracle().reach_m);
}

#[test]
fn more_relays_and_a_lower_limit_never_get_less_far_or_there_later() {
    for radio in ["", "attenuation = \"wall-count\"", "gain_error_db = 1.5"] {
        let case = Case { radio, ..ANGLE };
        let all: Vec<_> = (0..5).map(|relays| Case { relays, ..case }.oracle()).collect();
        for pair in all.windows(2) {
            // Each relay more has the head stand farther in when it takes off, and other gains: with
            // gains, only the reach with all of the same relays is compared.
            let is_same = radio.starts_with("gain");
            assert!(is_same || pair[0].reach_m <= pair[1].reach_m, "{radio}: {all:?}");
        }
        assert!(all[4].reaches.is_sorted(), "{:?}", all[4].reaches);
        let limits: Vec<_> =
            [-52.0, -56.0, -60.0, -64.0].map(|limit| Case { limit, ..case }.oracle()).into();
        assert!(limits.is_sorted_by(|a, b| a.reach_m <= b.reach_m), "{radio}: {limits:?}");
        let at = limits[0].depth_m;
        assert!(limits.is_sorted_by(|a, b| a.time_to(at) >= b.time_to(at)), "{radio}");
    }
}

/// A head turns back when its battery has left one and a half times the way home, at 0.2 m/s, and the
/// reserve of 20 s. One that is up at 4.5 s after a take-off of 2.5 s, and flies from 1.05 m on at 0.4 m/s,
/// has 100 s after its take-off: 102 s - t = 1.5 · x / 0.2 + 20 s with x = 1.05 + 0.4 (t - 4.5).
#[test]
fn a_battery_turns_the_head_back_with_what_carries_it_home() {
    let scenario = STRAIGHT.scenario();
    let world = scenario.world();
    let flight = &scenario.agent.flight;
    assert_eq!((flight.return_speed.0, flight.rise_s()), (0.2, 2.5));
    let within = |endurance_s| {
        let commanded = Commanded { endurance_s, ..Commanded::along_main(&world) };
        Oracle::of(&scenario, &world, &commanded, 1)
    };
    let turned = within(Some(100.0));
    let after_s = (102.0 - 4.5 - 20.0 - 1.5 * 1.05 / 0.2) / (1.0 + 1.5 * 0.4 / 0.2);
    let at_m = 1.05 + 0.4 * after_s;
    assert!((turned.depth_m - at_m).abs() <= 0.2, "{turned:?} for {at_m}");
    assert_eq!(turned.ended, Ended::Pilot);
    assert!((within(None).depth_m - 30.0).abs() <= 0.2, "without a battery the relays end it");
    assert_eq!(within(Some(1000.0)).ended, Ended::Relays);
}
