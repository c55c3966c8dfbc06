//! Flights of simulated craft as logs: the fit finds what they were made with.

use bodies::craft::vibration::Vibration;
use bodies::craft::{Craft, Surroundings};
use bodies::others::Others;
use flight::{FlightConfig, GRAVITY};
use proptest::prelude::*;
use random::{Purpose, Stream};
use replay::flights::{DroneFit, FlightSummary, replay_flights};
use scenario::{Ground, Scenario, VehicleSpec};
use units::{Metres, Point2, Setpoint};
use world::Tunnel;
use world::layout::Layout;

use super::usd_log::UsdLog;

const CONFIG: FlightConfig = FlightConfig::CRAZYFLIE_2_1;
const NAMES: [&str; 10] = [
    "acc.x",
    "acc.y",
    "acc.z",
    "pwm.m1_pwm",
    "pwm.m2_pwm",
    "pwm.m3_pwm",
    "pwm.m4_pwm",
    "pm.vbatMV",
    "stateEstimate.z",
    "stateEstimate.vz",
];

/// The log of 16 s in which this vehicle stands for 4 s, rises, and changes its height each second.
fn flown(vehicle: &VehicleSpec, seed: u64) -> UsdLog {
    let tunnel = Tunnel::dig(&Layout::corridor(&[[0.0, 0.0], [20.0, 0.0]], 4.0)).unwrap();
    let around =
        Surroundings { tunnel: &tunnel, ground: Ground::GOOD, vehicle, others: Others::NONE };
    let random = Stream::new(seed, Purpose::Craft(0));
    let mut noise = Stream::new(seed, Purpose::Craft(1));
    let mut shaken =
        Vibration::new(&CONFIG.airframe, 0.0, &mut noise).blown_by(vehicle.lateral_noise);
    let mut craft = Craft::standing(CONFIG, Point2::new(10.0, 0.0), [1.0, 0.0], vehicle, random);
    let mut log = UsdLog::new(&NAMES);
    for ms in 0..16_000_u32 {
        if ms >= 4_000 && ms.is_multiple_of(200) {
            let high = if ms.is_multiple_of(2_000) { 0.5 } else { 0.4 };
            craft.command(Setpoint::hover(Metres(high)));
        }
        craft.advance(around);
        let duties = craft.outputs().duties.0;
        let thrusts =
            duties.map(|duty| if duty > 0.0 { CONFIG.airframe.hover_thrust() } else { 0.0 });
        let (_, slow) = shaken.shake(thrusts, &mut noise);
        let body = craft.body();
        let force = body.specific_force();
        let mut g = |axis: usize| (force[axis] + slow[axis] + 1e-3 * noise.gauss()) / GRAVITY;
        let [a, b, c, d] = duties.map(|duty| 65_535.0 * duty);
        let (height, climb) = (body.height(), body.velocity()[2]);
        let volts = 1e3 * craft.battery().volts();
        log.row(1e-3 * f64::from(ms), &[g(0), g(1), g(2), a, b, c, d, volts, height, climb]);
    }
    log
}

fn fitted(log: &UsdLog, name: &str) -> (FlightSummary, DroneFit) {
    let mut summary = replay_flights(&[log.write(name)]).unwrap();
    summary.fit_plant();
    let drone = summary.plant.as_ref().unwrap().drones[0].clone();
    (summary, drone)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn a_fit_finds_the_craft_that_flew(
        thrust in 0.9_f32..1.1,
        roll in -8e-4_f32..8e-4,
        pitch in -8e-4_f32..8e-4,
        yaw in -3e-4_f32..3e-4,
        noise in 0.05_f32..0.4,
        seed in 0..1_000_u64,
    ) {
        let vehicle = VehicleSpec {
            thrust,
            tilt_torque: [[roll; 2], [pitch; 2]],
            yaw_torque: [yaw; 2],
            lateral_noise: noise,
            ..VehicleSpec::DEFAULT
        };
        let (summary, fit) = fitted(&flown(&vehicle, seed), "simulated");
        prop_assert!(summary.logs[0].ends_in_flight().is_none(), "{:?}", summary.logs[0].ends);
        // The masses and the motors of simulated drones differ by some per cent.
        prop_assert!((fit.thrust.unwrap() / thrust - 1.0).abs() < 0.1, "{fit:?}");
        // The same drone, whose motors are unlike in the same way, without the torques.
        let still = VehicleSpec { tilt_torque: [[0.0; 2]; 2], yaw_torque: [0.0; 2], ..vehicle };
        let (_, still) = fitted(&flown(&still, seed), "still");
        let torques = fit.torque_nm.unwrap().into_iter().zip(still.torque_nm.unwrap());
        for ((found, still), truth) in torques.zip([roll, pitch, yaw]) {
            prop_assert!((found[0] - still[0] - truth).abs() < 5e-5, "{truth}: {fit:?} {still:?}");
        }
        let found = fit.lateral_noise_mps2.unwrap();
        prop_assert!((found / noise - 1.0).abs() < 0.1, "{noise}: {fit:?}");
        let ohm = fit.battery_ohm.unwrap();
        prop_assert!((ohm / vehicle.battery_ohm - 1.0).abs() < 0.25, "{ohm}: {fit:?}");
    }
}

#[test]
fn the_fitted_section_is_a_scenarios() {
    let drone = DroneFit {
        drone: "normal/E8".to_owned(),
        logs: 4,
        thrust: Some(1.094),
        torque_nm: Some([[-6.6e-4, -0.8e-4], [-0.9e-4, 0.9e-4], [2.7e-4, 3.5e-4]]),
        battery_ohm: Some(0.152),
        lateral_noise_mps2: Some(0.21),
    };
    let rest = "title = \"t\"\nduration_s = 10\n[tunnel]\nwidth_m = 1.2\n\
                centre_line_m = [[0, 0], [12, 0]]\n[drones]\nrelays = 2\n";
    let text = format!("{rest}{}", drone.scenario());
    let vehicle = Scenario::of_text("fitted.toml".as_ref(), &text).unwrap().vehicle;
    assert_eq!((vehicle.thrust, vehicle.battery_ohm, vehicle.lateral_noise), (1.094, 0.152, 0.21));
    assert_eq!(vehicle.tilt_torque, [[-6.6e-4, -0.8e-4], [-0.9e-4, 0.9e-4]]);
    assert_eq!(vehicle.yaw_torque, [2.7e-4, 3.5e-4]);
    assert_eq!(drone.file_name(), "normal-E8");
}

/// Without its keys the craft draws no number more than it did before there were any.
#[test]
fn drones_without_torques_draw_none() {
    let (mut drawn, mut fresh) = (Stream::new(1, Purpose::Start), Stream::new(1, Purpose::Start));
    assert_eq!(VehicleSpec::DEFAULT.draw_torques(&mut drawn), [0.0; 3]);
    let mut still = Vibration::new(&CONFIG.airframe, 0.0, &mut drawn).blown_by(0.0);
    let _ = Vibration::new(&CONFIG.airframe, 0.0, &mut fresh);
    still.shake([0.08; 4], &mut drawn);
    assert_eq!(drawn.gauss().to_bits(), fresh.gauss().to_bits());
}
