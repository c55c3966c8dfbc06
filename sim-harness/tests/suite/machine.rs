//! A drone whose propellers shake it, whose motors are worn or strong, or whose battery is old takes
//! off, hovers and lands like any other, and its motors are never cut in the air.

use flight::{FlightConfig, Mode};
use random::{Purpose, Stream};
use sim_harness::bodies::craft::vibration::Vibration;
use sim_harness::bodies::craft::{Craft, Surroundings};
use sim_harness::bodies::others::Others;
use sim_harness::scenario::Ground;
use sim_harness::scenario::VehicleSpec;
use units::{Metres, Point2, Setpoint};
use world::Tunnel;
use world::layout::Layout;

const HEIGHT: Metres = Metres(0.3);

/// A drone's take-off and hover of ten seconds in a room.
struct Hop {
    craft: Craft,
    highest: f32,
    /// The height at which it was when the flight code switched the motors off, if it did.
    cut_at: Option<f32>,
}

fn hop(vehicle: &VehicleSpec, seed: u64) -> Hop {
    let room = Tunnel::dig(&Layout::corridor(&[[-0.05, 0.0], [0.05, 0.0]], 3.0)).unwrap();
    let around =
        Surroundings { tunnel: &room, ground: Ground::GOOD, vehicle, others: Others::NONE };
    let random = Stream::new(seed, Purpose::Craft(0));
    let config = FlightConfig::CRAZYFLIE_2_1;
    let at = Point2::default();
    let craft = Craft::standing(config, at, [1.0, 0.0], vehicle, random);
    let mut hop = Hop { craft, highest: 0.0, cut_at: None };
    let mut flew = false;
    for ms in 0..12_000_u64 {
        if ms % 200 == 0 {
            hop.craft.command(Setpoint::hover(HEIGHT));
        }
        hop.craft.advance(around);
        let height = hop.craft.body().height();
        hop.highest = hop.highest.max(height);
        let flies = hop.craft.outputs().status.mode.is_airborne();
        if flew && !flies {
            hop.cut_at.get_or_insert(height);
        }
        flew = flies;
    }
    hop
}

/// Hops with ten seeds; all must hover at the end.
fn must_hover(vehicle: &VehicleSpec, highest: f32, of: &str) {
    for seed in 0..10 {
        let hop = hop(vehicle, seed);
        let (height, mode) = (hop.craft.body().height(), hop.craft.outputs().status.mode);
        assert_eq!(hop.cut_at, None, "{of}, seed {seed}: {mode:?}");
        assert!(matches!(mode, Mode::Flying { .. }), "{of}, seed {seed}: {mode:?}");
        assert!((height - HEIGHT.0).abs() < 0.06, "{of}, seed {seed}: {height} m");
        assert!(hop.highest < highest, "{of}, seed {seed}: rose to {} m", hop.highest);
    }
}

#[test]
fn propellers_that_shake_the_board_do_not_land_the_drone() {
    for vibration in [0.0, 0.1, 0.2, 0.3, 0.5] {
        let vehicle = VehicleSpec { vibration, ..VehicleSpec::DEFAULT };
        must_hover(&vehicle, 0.4, &format!("{vibration} g"));
    }
}

#[test]
fn a_drone_flies_with_a_quarter_more_or_less_thrust_than_it_believes() {
    for (thrust, highest) in [(0.75, 0.4), (0.78, 0.4), (0.9, 0.4), (1.1, 0.4), (1.25, 0.45)] {
        let vehicle = VehicleSpec { thrust, ..VehicleSpec::DEFAULT };
        must_hover(&vehicle, highest, &format!("thrust times {thrust}"));
    }
}

#[test]
fn a_drone_with_30_percent_too_little_or_too_much_thrust_flies_or_lands() {
    for thrust in [0.7, 1.3] {
        let vehicle = VehicleSpec { thrust, ..VehicleSpec::DEFAULT };
        for seed in 0..10 {
            let hop = hop(&vehicle, seed);
            assert!(hop.cut_at.is_none_or(|height| height < 0.06), "{thrust}: {:?}", hop.cut_at);
            assert!(hop.highest < 0.5, "{thrust}: rose to {} m", hop.highest);
        }
    }
}

#[test]
fn a_drone_flies_with_motors_that_differ_by_15_percent_either_way() {
    let vehicle = VehicleSpec { motor_error: 0.15, ..VehicleSpec::DEFAULT };
    must_hover(&vehicle, 0.4, "motors ±15 %");
}

#[test]
fn a_drone_flies_with_a_new_and_with_an_old_battery() {
    for battery_ohm in [0.1, 0.18, 0.25, 0.35] {
        for charge in [1.0, 0.5] {
            let vehicle = VehicleSpec { battery_ohm, charge, ..VehicleSpec::DEFAULT };
            must_hover(&vehicle, 0.45, &format!("{battery_ohm} Ω, {charge}"));
        }
    }
}

#[test]
fn the_vibration_is_as_strong_as_it_says_and_turns_with_the_propellers() {
    let airframe = FlightConfig::CRAZYFLIE_2_1.airframe;
    let mut random = Stream::new(3, Purpose::Craft(0));
    for _ in 0..4 {
        let mut vibration = Vibration::new(&airframe, 0.3, &mut random);
        let (mut squares, mut sums, mut turns) = (0.0_f64, [0.0_f64; 3], 0.0_f32);
        for _ in 0..10_000 {
            let (rates, force) = vibration.shake([airframe.hover_thrust(); 4], &mut random);
            squares += f64::from(force[0] * force[0] + force[1] * force[1]);
            for axis in 0..3 {
                sums[axis] += f64::from(force[axis]);
                turns = turns.max(rates[axis].abs());
            }
        }
        let rms = (squares / 10_000.0).sqrt() / f64::from(flight::GRAVITY);
        assert!((0.2..0.4).contains(&rms), "{rms} g");
        assert!(sums.iter().all(|sum| sum.abs() < 100.0), "{sums:?}");
        // 3 m/s² on 33 g at the end of an arm of 46 mm, about 29e-6 kg m², at 1,950 rad/s.
        assert!(turns < 0.3, "{turns} rad/s");
    }
}
