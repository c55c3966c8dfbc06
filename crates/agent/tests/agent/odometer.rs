//! The odometer follows the drone and not the noise of its optic flow: a steep link makes decibels
//! of every centimetre that the odometer is wrong.

use units::{Metres, MetresPerSecond, Order, Role, Setpoint};

use super::rig::{BASE, EXPLORE, Rig, Scene};

/// The length of a round, s.
const DT: f32 = 0.2;
/// The standard deviation of one velocity by optic flow (`sim-harness/bodies/src/point.rs`), m/s.
const FLOW_NOISE: f32 = 0.02;
/// The lag of the velocity loop, s.
const LAG: f32 = 0.3;
/// A drift that is slower than this is taken for noise, m/s.
const UNSEEN: f32 = 0.015;

fn air() -> Scene {
    Scene::quiet().order(EXPLORE).at_height(Some(0.3))
}

/// Numbers of mean 0 and standard deviation 1, from a linear congruential generator.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn next(&mut self) -> f32 {
        (0..12).map(|_| self.uniform()).sum::<f32>() - 6.0
    }
}

/// A drone that flies as it is told, with the lag of its velocity loop, and is blown along at
/// `drift` besides.
struct Body {
    rig: Rig,
    noise: Option<Noise>,
    drift: f32,
    velocity: f32,
    way: f32,
    flow: f32,
}

impl Body {
    fn new(role: Role, noise: Option<u64>) -> Self {
        let rig = Rig::on_duty(role);
        let noise = noise.map(Noise);
        Self { rig, noise, drift: 0.0, velocity: 0.0, way: 0.0, flow: 0.0 }
    }

    /// Flies for so many seconds, and returns by how far the odometer has moved.
    fn fly(&mut self, seconds: f32, scene: &Scene) -> f32 {
        let mut first = None;
        let mut last = Metres::ZERO;
        self.way = 0.0;
        for _ in 0..(seconds / DT).round() as u32 {
            let outputs = self.rig.step(&scene.clone().flow(Some(self.flow)));
            last = outputs.report.odometer;
            first.get_or_insert(last);
            let Setpoint::Fly { forward, .. } = outputs.setpoint else { panic!("{outputs:?}") };
            let kept = (-DT / LAG).exp();
            let away = self.velocity - forward.0;
            let mean = forward.0 + away * (1.0 - kept) * LAG / DT + self.drift;
            self.velocity = forward.0 + away * kept;
            let noise = self.noise.as_mut().map_or(0.0, Noise::next);
            self.flow = mean + FLOW_NOISE * noise;
            self.way += mean * DT;
        }
        (last - first.unwrap()).0
    }
}

/// Noise of the flow alone would walk the odometer by σ·√(t·dt): 0.2 m in ten minutes.
#[test]
fn the_odometer_of_a_hovering_drone_stands_still() {
    for seed in 1..=10 {
        let mut body = Body::new(Role::Relay, Some(seed));
        body.fly(10.0, &air());
        let walked = body.fly(600.0, &air());
        assert!(walked.abs() < 0.02, "{walked} m with seed {seed}");
    }
}

#[test]
fn the_odometer_of_a_drone_that_drifts_follows_it() {
    for drift in [-0.2, -0.05, 0.05, 0.2f32] {
        let mut body = Body::new(Role::Relay, Some(1));
        body.drift = drift;
        let (seconds, noticed_after) = (30.0, 1.3);
        let walked = body.fly(seconds, &air());
        let missed = (body.way - walked).abs();
        let allowed = UNSEEN * seconds + noticed_after * drift.abs() + 0.05;
        assert!(missed < allowed, "{walked} m of {} m", body.way);
        assert!(walked * drift > 0.0);
    }
}

/// The model of the velocity loop has the loop's lag: starts and stops cost no way.
#[test]
fn the_odometer_of_a_drone_that_flies_as_told_follows_it_to_centimetres() {
    let good = air().without(0).link(BASE, -50.0);
    for seed in [None, Some(1), Some(2)] {
        let mut body = Body::new(Role::Head, seed);
        body.fly(10.0, &good.clone().order(Order::explore(MetresPerSecond::ZERO)));
        let (mut walked, mut way) = (0.0, 0.0);
        for leg in 0..20 {
            let speed = [0.4, 0.0, -0.4, 0.1][leg % 4];
            let scene = good.clone().order(Order::explore(MetresPerSecond(speed)));
            walked += body.fly(3.0, &scene);
            way += body.way;
        }
        assert!((walked - way).abs() < 0.3, "{walked} m of {way} m with seed {seed:?}");
    }
}

/// No flow is no measurement of a drone that stands still: the odometer goes by the commands, or
/// stops; it does not do the first for a second and then the second.
#[test]
fn a_drone_without_flow_is_not_taken_for_one_that_stands_still() {
    let good = air().without(0).link(BASE, -50.0);
    let mut rig = Rig::on_duty(Role::Head);
    let blind = good.order(Order::explore(MetresPerSecond(0.4))).flow(None);
    let before = rig.step(&blind).report.odometer;
    let flown = rig.during(8.0, &blind).report.odometer - before;
    let told = 8.0 * 0.4;
    assert!(flown.0.abs() < 0.05 || (flown.0 - told).abs() < 0.2 * told, "{flown} of {told} m");
}

/// A drone on the ground stands still, whatever it was told last in the air.
#[test]
fn the_odometer_of_a_drone_that_has_landed_stands_still() {
    let good = air().without(0).link(BASE, -50.0);
    let mut rig = Rig::on_duty(Role::Head);
    rig.during(5.0, &good.clone().order(Order::explore(MetresPerSecond(0.4))).flow(Some(0.4)));
    let low = good.order(Order::Land).at_height(Some(0.02)).flow(Some(0.0));
    rig.until("landed", &low);
    let landed = rig.step(&low).report.odometer;
    let later = rig.during(600.0, &low).report.odometer;
    assert!((later - landed).abs() < Metres(0.05), "{} in ten minutes", later - landed);
}
