//! Drones whose propellers are not alike, so that they twist the body to one side.

use flight::{FlightConfig, Mode};
use random::{Purpose, Stream};
use sim_harness::bodies::craft::{Craft, Surroundings};
use sim_harness::bodies::others::Others;
use sim_harness::scenario::Ground;
use sim_harness::scenario::VehicleSpec;
use units::{Metres, Point2, Setpoint};
use world::Tunnel;
use world::layout::Layout;

const HOVER: Setpoint = Setpoint::hover(Metres(0.3));

/// A drone and its tunnel.
struct Bench {
    tunnel: Tunnel,
    vehicle: VehicleSpec,
    craft: Craft,
}

impl Bench {
    /// A drone with a yaw torque in this range, N m, that has calibrated itself.
    fn with(yaw_torque: [f32; 2], seed: u64) -> Self {
        let tunnel = Tunnel::dig(&Layout::corridor(&[[0.0, 0.0], [20.0, 0.0]], 4.0)).unwrap();
        let vehicle = VehicleSpec { yaw_torque, ..VehicleSpec::DEFAULT };
        let random = Stream::new(seed, Purpose::Craft(0));
        let (config, at) = (FlightConfig::CRAZYFLIE_2_1, Point2::new(10.0, 0.0));
        let craft = Craft::standing(config, at, [1.0, 0.0], &vehicle, random);
        let mut bench = Self { tunnel, vehicle, craft };
        bench.fly(Setpoint::Off, 3_000);
        bench
    }

    fn advance(&mut self) {
        let Self { tunnel, vehicle, craft } = self;
        let (ground, others) = (Ground::GOOD, Others::NONE);
        craft.advance(Surroundings { tunnel, ground, vehicle, others });
    }

    /// Flies for so long; the largest swing of the nose, °, and the time after which it stays within
    /// 2°, s.
    fn fly(&mut self, setpoint: Setpoint, ms: u32) -> (f32, f32) {
        let [x, y] = self.craft.nose();
        let (mut most, mut beyond) = (0.0_f32, 0);
        for now in 0..ms {
            if now % 200 == 0 {
                self.craft.command(setpoint);
            }
            self.advance();
            let [u, v] = self.craft.nose();
            let swing = (x * v - y * u).atan2(x * u + y * v).to_degrees().abs();
            most = most.max(swing);
            beyond = if swing > 2.0 { now } else { beyond };
        }
        (most, beyond as f32 * 1e-3)
    }
}

/// Two of three Crazyflies whose flights were recorded need more yaw torque than the integral of the
/// vendor's yaw rate loop gives ([`VehicleSpec::MEASURED_YAW_TORQUE`]). With its limits the nose swung
/// here by 3, 9 and 15° at each take-off with the larger three torques, and was back within 2° after
/// 0.9, 3.8 and 8.4 s.
#[test]
fn a_drone_that_its_propellers_twist_swings_its_nose_briefly_and_in_its_first_flight_alone() {
    for torque in [0.24e-4, 1.6e-4, 3.3e-4, VehicleSpec::LARGEST_YAW_TORQUE] {
        let mut bench = Bench::with([torque; 2], 1);
        let [first, second] = [0, 1].map(|_| {
            let swung = bench.fly(HOVER, 12_000);
            bench.fly(Setpoint::hover(Metres(0.0)), 4_000);
            bench.fly(Setpoint::Off, 1_000);
            swung
        });
        let mode = bench.craft.outputs().status.mode;
        assert_eq!(mode, Mode::Grounded { waits_for: None });
        println!("{torque:e} N m: {first:?}, then {second:?} (degrees, s)");
        assert!(first.0 < 12.0 && first.1 < 1.5, "{torque:e} N m: {first:?}");
        assert!(second.0 < 1.0, "{torque:e} N m: {second:?}");
    }
}

#[test]
fn each_drone_is_twisted_to_the_left_and_in_its_own_way() {
    let rates = [1, 2, 3].map(|seed| {
        let mut bench = Bench::with([2e-4, 4e-4], seed);
        bench.craft.command(HOVER);
        while bench.craft.body().is_on_floor() {
            bench.advance();
        }
        (0..50).for_each(|_| bench.advance());
        bench.craft.body().rates()[2]
    });
    assert!(rates.iter().all(|rate| *rate > 0.05), "rad/s: {rates:?}");
    assert!(rates[0] != rates[1] && rates[1] != rates[2], "rad/s: {rates:?}");
}
