//! The way home of a drone of a chain: nothing but home, the battery and an order ends it, and no drone
//! lands on another.

use agent::{LandReason, State};
use units::{Metres, Order, Phase, Role, Setpoint};

use super::rig::{BASE, CONFIG, EXPLORE, Rig, Scene, flown};

/// A drone in the air that hears nothing.
fn silence() -> Scene {
    Scene::quiet().without(0).without(BASE).at_height(Some(0.3))
}

/// A drone that is so far in, at its duty.
fn deep(role: Role, way: f32) -> Rig {
    let mut rig = Rig::on_duty(role);
    let out = Scene::quiet().link(BASE, -64.0).order(EXPLORE).at_height(Some(0.3)).flow(Some(0.4));
    while rig.step(&out).status.here.odometer < Metres(way) {}
    rig
}

/// What lay 46 m inside a cave: drones that lost the base's side for 6 m on their way home.
#[test]
fn a_drone_that_is_called_home_and_hears_nothing_flies_home() {
    for role in [Role::Head, Role::Relay] {
        let mut rig = deep(role, 40.0);
        let homeward = silence().order(Order::Return).flow(Some(-0.2));
        // Nothing is heard of the base at home either: it waits for it there, and lands.
        let mut last = rig.step(&homeward);
        let mut waits = 0;
        while last.status.state.name() == "homing" {
            let speed = flown(last.setpoint).unwrap().0;
            waits += u32::from(speed == 0.0);
            last = rig.step(&homeward.clone().flow(Some(speed)));
            assert!(last.status.here.odometer > Metres(-5.0), "for ever");
        }
        assert!(matches!(rig.state(), State::Landing { why: LandReason::Home, .. }));
        assert!(waits >= 90, "{waits} rounds");
        assert!(last.status.here.odometer > Metres(-0.1), "{}", last.status.here.odometer);
        let Setpoint::Fly { lateral, height, .. } = last.setpoint else { panic!("{last:?}") };
        // Both have even numbers.
        assert_eq!((lateral.0, height), (0.2, CONFIG.flight.height), "it steps aside");
        let last = rig.during(1.0, &homeward);
        let Setpoint::Fly { lateral, height, .. } = last.setpoint else { panic!("{last:?}") };
        assert_eq!((lateral.0, height), (0.0, CONFIG.flight.height), "and then descends");
        let last = rig.during(1.2, &homeward);
        assert!(flown(last.setpoint).is_none_or(|(_, height)| height < CONFIG.flight.height.0));
    }
}

#[test]
fn a_drone_whose_base_side_stays_silent_comes_home_by_itself() {
    for role in [Role::Head, Role::Relay] {
        let mut rig = deep(role, 15.0);
        let homeward = silence().order(EXPLORE).flow(Some(-0.2));
        rig.until("homing", &homeward);
        let mut last = rig.during(20.0, &homeward);
        assert_eq!(flown(last.setpoint), Some((-CONFIG.flight.return_speed.0, 0.3)));
        // The chain goes on where the base's side is heard again.
        let mut heard = rig.clone();
        heard.during(
            2.0,
            &homeward.clone().also(BASE, Phase::Base, -50.0).also(0, Phase::Linked, -50.0),
        );
        assert!(["leading", "relaying"].contains(&heard.state().name()), "{:?}", heard.state());
        while last.status.state.name() == "homing" {
            let speed = flown(last.setpoint).unwrap().0;
            last = rig.step(&homeward.clone().flow(Some(speed)));
            assert!(last.status.here.odometer > Metres(-5.0), "for ever");
        }
        assert!(matches!(rig.state(), State::Landing { why: LandReason::LinkLost, .. }));
    }
}

/// The signal of a drone that is down behind is 20 dB/decade strong in the row's 0.35 m.
fn level(distance: f32) -> f32 {
    -40.0 - 20.0 * distance.log10()
}

/// The number of the drone that stands behind in the row, and that of the base behind it.
const NEXT: u8 = 3;
const FAR_BASE: u8 = 4;

/// A way out of a row and home again.
#[derive(Clone, Copy)]
struct Way {
    /// By how much the odometer is off, m.
    off: f32,
    /// Where the next drone is down, from its own place in the row, m.
    behind: f32,
    /// The deviation of the noise of all packets, dB, and the part of them that is lost.
    noise: f32,
    loss: f32,
    seed: u32,
}

/// Numbers that are as good as random: Marsaglia's xorshift.
struct Luck(u32);

impl Luck {
    fn uniform(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    /// A number of mean 0 and variance 1, nearly normal.
    fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.uniform()).sum::<f32>() - 6.0
    }
}

/// Flies a relay out from a row and home again, and returns how far from the drone that is down behind
/// it, it lands, and the way that it reports there.
fn lands_beside(way: Way) -> (f32, f32) {
    let mut luck = Luck(way.seed * 7_919 + 1);
    let mut packet = |scene: Scene, phase, distance: f32| {
        let mut rssi = || level(distance.hypot(0.3)) + way.noise * luck.normal();
        let [here, there] = [rssi(), rssi()];
        let [is_lost, was_lost] = [luck.uniform(), luck.uniform()].map(|part| part < way.loss);
        match (is_lost, was_lost) {
            (true, _) => scene,
            (false, true) => scene.also(NEXT, phase, here),
            (false, false) => scene.also(NEXT, phase, here).reverse(NEXT, there),
        }
    };
    let mut rig = Rig::new(Role::Relay);
    let row = Scene::quiet().order(EXPLORE).without(BASE).link(0, -62.0);
    let row = row.also(FAR_BASE, Phase::Base, -50.0);
    rig.until("taking-off", &row);
    let up = row.at_height(Some(0.3));
    while rig.state().name() == "taking-off" {
        rig.step(&packet(up.clone(), Phase::Waiting, 0.35));
    }
    let air = Scene::quiet().without(BASE).at_height(Some(0.3)).also(FAR_BASE, Phase::Base, -60.0);
    while rig.step(&air.clone().order(EXPLORE).flow(Some(0.4))).status.here.odometer < Metres(10.0)
    {
    }
    // True places from here on: the row's next is 0.35 m behind this drone's.
    let mut at = 10.35 + way.off;
    let home = air.order(Order::Return).without(0);
    let mut last = rig.step(&home);
    while last.status.state.name() == "homing" {
        let speed = flown(last.setpoint).unwrap().0;
        at += 0.2 * speed;
        last = rig.step(&packet(home.clone(), Phase::Out, at - way.behind).flow(Some(speed)));
        assert!(at > -5.0, "for ever");
    }
    assert!(matches!(rig.state(), State::Landing { why: LandReason::Home, .. }));
    (at - way.behind, last.report.odometer.0)
}

const EXACT: Way = Way { off: 0.0, behind: 0.0, noise: 0.0, loss: 0.0, seed: 0 };

#[test]
fn a_drone_lands_before_the_one_that_is_down_behind_it() {
    for off in [-0.7, -0.4, 0.0, 0.4, 0.7] {
        for behind in [0.0, 0.3, 0.6, 1.0] {
            let (apart, _) = lands_beside(Way { off, behind, ..EXACT });
            assert!((0.4..1.0).contains(&apart), "{apart} m from {behind}, odometer off by {off}");
        }
    }
}

/// In winding galleries odometers are off by metres, most of them by as much too far out: once by 63 m.
#[test]
fn an_odometer_that_is_off_by_metres_does_not_lead_a_drone_astray() {
    for off in [-8.0, -5.0, -3.0, -1.5, 1.5, 3.0, 6.0] {
        let (apart, way) = lands_beside(Way { off, ..EXACT });
        assert!((0.4..1.2).contains(&apart), "{apart} m, odometer off by {off}");
        // It knows its place in the row then, for those that land before it.
        assert!((way - (apart - 0.35)).abs() < 0.5, "{way} m, odometer off by {off}");
    }
}

#[test]
fn a_drone_lands_apart_through_noise_and_losses() {
    let mut near = Vec::new();
    for seed in 0..300 {
        let off = [0.0, 0.3, -0.3, -1.0][seed as usize % 4];
        let (apart, _) = lands_beside(Way { off, behind: 0.0, noise: 3.0, loss: 0.4, seed });
        assert!(apart < 1.5, "seed {seed}: {apart} m");
        if apart < 0.25 {
            near.push((seed, apart));
        }
    }
    assert!(near.len() <= 1, "{near:?}");
}

/// Relays that made their links equal on the way home stood for ever behind a head that stood, until
/// their batteries were spent.
#[test]
fn a_relay_comes_home_whatever_the_drone_in_front_does() {
    let homeward = -CONFIG.flight.return_speed.0;
    let mut rig = Rig::new(Role::Relay);
    let row = Scene::quiet().order(EXPLORE).link(BASE, -30.0);
    rig.until("taking-off", &row.clone().link(0, -62.0));
    rig.until("relaying", &row.at_height(Some(0.3)));
    let equal = Scene::quiet().at_height(Some(0.3)).link(BASE, -52.0);
    rig.during(40.0, &equal.clone().order(EXPLORE).flow(Some(0.4)));
    let equal = equal.order(Order::Return);
    rig.until("homing", &equal);
    let last = rig.during(2.0, &equal.clone().flow(Some(homeward)));
    assert_eq!(flown(last.setpoint), Some((homeward, 0.3)));
    // It waits for one whose link is hardly one any more, but not for ever.
    let limit = CONFIG.retreat.limit.0;
    let weak = equal.link(0, limit + 1.0).flow(Some(0.0));
    let last = rig.during(20.0, &weak);
    assert_eq!(flown(last.setpoint), Some((0.0, 0.3)));
    let last = rig.during(25.0, &weak.flow(Some(homeward)));
    assert_eq!(flown(last.setpoint), Some((homeward, 0.3)));
}
