//! The way home of a drone of a chain: nothing but home, the battery and an order ends it, and no drone
//! lands on another.

use agent::{LandReason, State};
use units::{Metres, Order, Phase, Role};

use super::rig::{BASE, CONFIG, EXPLORE, Rig, Scene, flown};

/// A drone in the air that hears nothing.
fn silence() -> Scene {
    Scene::quiet().without(0).without(BASE).at_height(Some(0.3))
}

/// A drone that is so far in, at its duty.
fn deep(role: Role, way: f32) -> Rig {
    let mut rig = Rig::on_duty(role);
    let out = Scene::quiet().order(EXPLORE).at_height(Some(0.3)).flow(Some(0.4));
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

/// Flies a relay out from a row and home again, with an odometer that is off by `off`, and returns how
/// far from the drone that is down behind it, at `behind`, it lands.
fn lands_beside(off: f32, behind: f32) -> f32 {
    const NEXT: u8 = 3;
    const FAR_BASE: u8 = 4;
    let mut rig = Rig::new(Role::Relay);
    let row = Scene::quiet()
        .order(EXPLORE)
        .without(BASE)
        .link(0, -62.0)
        .also(NEXT, Phase::Waiting, level(0.46))
        .also(FAR_BASE, Phase::Base, -50.0);
    rig.until("taking-off", &row);
    rig.until("relaying", &row.clone().at_height(Some(0.3)));
    let air = Scene::quiet().without(BASE).at_height(Some(0.3)).also(FAR_BASE, Phase::Base, -55.0);
    while rig.step(&air.clone().order(EXPLORE).flow(Some(0.4))).status.here.odometer < Metres(10.0)
    {
    }
    // True places from here on: the row's next is 0.35 m behind this drone's.
    let mut at = 10.35 + off;
    let mut last = rig.step(&air.clone().order(Order::Return).without(0));
    while last.status.state.name() == "homing" {
        let distance = (at - behind).hypot(0.3);
        let scene = air.clone().order(Order::Return).without(0);
        let speed = flown(last.setpoint).unwrap().0;
        at += 0.2 * speed;
        last = rig.step(&scene.also(NEXT, Phase::Out, level(distance)).flow(Some(speed)));
        assert!(last.status.here.odometer > Metres(-5.0), "for ever");
    }
    assert!(matches!(rig.state(), State::Landing { why: LandReason::Home, .. }));
    (at - behind).abs()
}

#[test]
fn a_drone_lands_before_the_one_that_is_down_behind_it() {
    for off in [-0.7, -0.4, 0.0, 0.4, 0.7] {
        for behind in [0.0, 0.3, 0.6, 1.0] {
            let apart = lands_beside(off, behind);
            assert!(apart >= 0.4, "{apart} m from the one at {behind}, odometer off by {off}");
        }
    }
}
