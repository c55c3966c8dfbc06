//! What a mission depends on, story by story.

use agent::{ChainDuty, Duty, LandReason, State};
use units::{Instant, Metres, MetresPerSecond, NodeId, Order, Phase, Role, Setpoint};

use super::rig::{BASE, CONFIG, EXPLORE, Rig, Scene, flown, heard};

fn air() -> Scene {
    Scene::quiet().order(EXPLORE).at_height(Some(0.3))
}

#[test]
fn stop_latches() {
    for role in [Role::Head, Role::Relay] {
        let mut rig = Rig::on_duty(role);
        let outputs = rig.step(&air().order(Order::Stop));
        assert_eq!(outputs.setpoint, Setpoint::Stop, "in the same step");
        assert_eq!(outputs.report.phase, Phase::Out);
        for task in [Order::Wait, EXPLORE, Order::Return, Order::Land, Order::Wait, EXPLORE] {
            let outputs = rig.during(15.0, &Scene::quiet().order(task));
            assert_eq!(outputs.status.state, State::Stopped);
            assert_eq!(outputs.setpoint, Setpoint::Stop);
        }
    }
}

/// The base keeps speaking as the base, whatever happens to it: the chain hangs on it.
#[test]
fn the_base_never_flies() {
    let mut rig = Rig::new(Role::Base);
    for task in [Order::Wait, EXPLORE, Order::Return, Order::Land] {
        let outputs = rig.during(2.0, &Scene::quiet().without(BASE).order(task));
        assert_eq!(outputs.setpoint, Setpoint::Off);
        assert_eq!(outputs.report.phase, Phase::Base);
    }
}

/// What was ordered last holds, for as long as nothing else is ordered; reports order nothing.
#[test]
fn the_last_order_holds_until_the_next() {
    let mut rig = Rig::on_duty(Role::Relay);
    let silent = Scene { task: None, ..air() };
    rig.during(60.0, &silent);
    assert_eq!(rig.state().name(), "relaying");
    rig.step(&air().order(Order::Return));
    let outputs = rig.during(2.4, &silent.clone().without(0));
    let home = -CONFIG.flight.return_speed.0;
    assert_eq!(flown(outputs.setpoint), Some((home, 0.3)), "long after the only word of it");
    rig.step(&air().order(EXPLORE));
    rig.step(&air().order(Order::Land));
    assert_eq!(rig.state().name(), "landing");
}

#[test]
fn the_head_flies_as_the_pilot_says_and_stops_a_second_after_the_last_word() {
    let mut rig = Rig::on_duty(Role::Head);
    let good = air().without(0).link(BASE, -50.0);
    assert_eq!(flown(rig.step(&good).setpoint), Some((0.2, 0.3)));
    let faster = good.clone().order(Order::explore(MetresPerSecond(3.0)));
    assert_eq!(flown(rig.step(&faster).setpoint), Some((0.4, 0.3)), "but no faster than it may");
    rig.step(&good);
    let silent = Scene { task: None, ..good.clone() };
    for round in 1..=10 {
        let (speed, height) = flown(rig.step(&silent).setpoint).unwrap();
        let expected = if round <= 5 { 0.2 } else { 0.0 };
        assert_eq!((speed, height), (expected, 0.3), "{round} rounds after the last order");
    }
    assert_eq!(flown(rig.step(&good).setpoint), Some((0.2, 0.3)), "the pilot is back");
}

/// A weaker link takes the speed from the head before it has to turn back.
#[test]
fn the_head_slows_down_before_its_link_breaks() {
    let mut last = f32::INFINITY;
    let speeds = [-50.0, -60.5, -62.0, -63.0, -64.0, -65.0].map(|rssi| {
        let mut rig = Rig::on_duty(Role::Head);
        let (speed, _) = flown(rig.step(&air().link(BASE, rssi)).setpoint).unwrap();
        assert!(speed <= last && speed >= 0.0, "{speed} at {rssi} dBm");
        last = speed;
        speed
    });
    assert_eq!((speeds[0], speeds[5]), (0.2, 0.0));
    let backward = Order::explore(MetresPerSecond(-0.2));
    let mut rig = Rig::on_duty(Role::Head);
    let (speed, _) = flown(rig.step(&air().link(BASE, -65.0).order(backward)).setpoint).unwrap();
    assert_eq!(speed, -0.2, "home is always free");
}

/// A radio between head and base that repeats their packets is as strong as a near drone. The head flew
/// on for as long as it heard it.
#[test]
fn a_head_makes_no_link_longer_than_the_longest() {
    let mut rig = Rig::on_duty(Role::Head);
    let forward = air().without(0).link(BASE, -50.0).flow(Some(0.4));
    rig.during(60.0, &forward);
    assert_eq!(flown(rig.step(&forward).setpoint), Some((0.2, 0.3)), "24 m in");
    rig.during(20.0, &forward);
    assert_eq!(flown(rig.step(&forward).setpoint), Some((0.0, 0.3)), "32 m in");
    let backward = forward.order(Order::explore(MetresPerSecond(-0.2)));
    assert_eq!(flown(rig.step(&backward).setpoint), Some((-0.2, 0.3)));
}

/// Packets that were held back tell what they say, but not how strong the link is.
#[test]
fn a_head_stands_while_its_link_is_not_measured() {
    let mut rig = Rig::on_duty(Role::Head);
    let good = air().without(0).link(BASE, -50.0);
    let held = good.clone().link(BASE, f32::NAN);
    rig.during(0.8, &held);
    assert_eq!(flown(rig.step(&good).setpoint), Some((0.2, 0.3)), "a packet or two may be late");
    rig.during(1.0, &held);
    assert_eq!(flown(rig.step(&held).setpoint), Some((0.0, 0.3)));
    let backward = held.order(Order::explore(MetresPerSecond(-0.2)));
    assert_eq!(flown(rig.step(&backward).setpoint), Some((-0.2, 0.3)));
    assert_eq!(flown(rig.step(&good).setpoint), Some((0.2, 0.3)));
}

/// Whether head or relay does its ordinary part.
fn is_at_place(state: State) -> bool {
    use ChainDuty::{Leading, Relaying};
    matches!(state, State::OnMission(Duty::Chain(Leading { .. } | Relaying { .. })))
}

/// A drone that has flown 8 m: it retreats no farther than to where it took off.
fn out(role: Role) -> Rig {
    let mut rig = Rig::on_duty(role);
    rig.during(20.0, &air().flow(Some(0.4)));
    rig.during(2.0, &air());
    rig
}

/// Flies back at the retreat's speed until it ends, and says for how long and how far.
fn retreat(rig: &mut Rig, scene: &Scene, flow: Option<f32>) -> (f32, f32) {
    rig.until("backing-up", scene);
    let (since, from) = match rig.state() {
        State::OnMission(Duty::Chain(ChainDuty::BackingUp { since, from })) => (since, from),
        other => panic!("{other:?}"),
    };
    for _ in 0..1_000 {
        let outputs = rig.step(&scene.clone().flow(flow));
        if outputs.status.state.name() != "backing-up" {
            let way = from - outputs.status.here.odometer;
            return (rig.now.since(since).as_secs_f32(), way.0);
        }
        assert_eq!(flown(outputs.setpoint), Some((-CONFIG.retreat.speed.0, 0.3)));
    }
    panic!("a retreat without end");
}

#[test]
fn a_retreat_is_bounded_in_time_and_in_distance() {
    let bounds = &CONFIG.retreat;
    for role in [Role::Head, Role::Relay] {
        for gone in [true, false] {
            let scene = if gone { air().without(BASE) } else { air().link(BASE, -70.0) };
            let scene = scene.link(0, -52.0);
            // The flow sees nothing: time.
            let (seconds, _) = retreat(&mut out(role), &scene, None);
            assert!((seconds - bounds.max_time.as_secs_f32()).abs() < 0.21, "{seconds} s");
            // It flies faster than it was told: distance.
            let mut rig = out(role);
            let (seconds, way) = retreat(&mut rig, &scene, Some(-0.4));
            let metres = bounds.max_distance.0;
            assert!(way >= metres && way < metres + 0.1, "{way} m");
            assert!(seconds < 17.0, "{seconds} s");
            if gone {
                assert_eq!(rig.state().name(), "homing", "nobody can fetch a drone from the cave");
            } else {
                // Weak but alive: it bears with it for a while, then tries again.
                assert!(is_at_place(rig.state()));
                let rest = bounds.rest.as_secs_f32();
                rig.during(rest - 0.4, &scene);
                assert!(is_at_place(rig.state()));
                rig.during(0.6, &scene);
                assert_eq!(rig.state().name(), "backing-up");
            }
        }
    }
}

#[test]
fn a_retreat_ends_where_the_link_is_good_again_by_its_hysteresis() {
    for role in [Role::Head, Role::Relay] {
        let mut rig = Rig::on_duty(role);
        rig.until("backing-up", &air().link(BASE, -66.0));
        rig.during(2.0, &air().link(BASE, -64.0));
        assert_eq!(rig.state().name(), "backing-up", "above the limit is not enough");
        rig.step(&air().link(BASE, -62.0));
        assert!(is_at_place(rig.state()));
    }
}

#[test]
fn a_relay_without_a_front_advances_while_its_back_link_can_spare_it_and_within_bounds() {
    let alone = air().without(0).link(BASE, -50.0);
    let mut rig = Rig::on_duty(Role::Relay);
    rig.until("reconnecting", &alone);
    let speed = CONFIG.retreat.speed.0;
    assert_eq!(flown(rig.step(&alone).setpoint), Some((speed, 0.3)));
    // Nearly too weak for a retreat: waits.
    let strained = alone.clone().link(BASE, -64.0);
    assert_eq!(flown(rig.step(&strained).setpoint), Some((0.0, 0.3)));
    // Blind: by time.
    let mut blind = rig.clone();
    blind.during(30.0, &alone.clone().flow(None));
    assert_eq!(flown(blind.step(&alone).setpoint), Some((0.0, 0.3)));
    assert_eq!(blind.state().name(), "reconnecting", "and waits where it is");
    // By distance.
    rig.during(17.4, &alone.clone().flow(Some(0.4)));
    assert_eq!(flown(rig.step(&alone).setpoint), Some((0.0, 0.3)));
    // Found.
    rig.step(&air());
    assert_eq!(rig.state().name(), "relaying");
}

#[test]
fn a_drone_lands_on_order_and_can_fly_again() {
    for role in [Role::Head, Role::Relay] {
        let mut rig = Rig::on_duty(role);
        let mut height = 0.3;
        let outputs = rig.step(&air().order(Order::Land));
        assert_eq!(flown(outputs.setpoint), Some((0.0, 0.3)));
        assert_eq!(outputs.report.phase, Phase::Out);
        while let Some((speed, wanted)) = {
            let scene = air().order(Order::Land).at_height(Some(height));
            flown(rig.step(&scene).setpoint)
        } {
            assert!(speed == 0.0 && wanted <= height, "comes down where it is");
            height = wanted;
        }
        assert_eq!(rig.state(), State::Landed { why: LandReason::Ordered });
        let down = Scene::quiet();
        rig.during(5.0, &down.clone().order(EXPLORE));
        assert_eq!(rig.state().name(), "landed", "until it was told to wait");
        rig.step(&down.clone().order(Order::Wait));
        assert_eq!(rig.state(), State::Idle);
        rig.until("taking-off", &down.order(EXPLORE).link(0, -62.0));
    }
}

/// The order to fly still stands when a drone comes back from a fault in the air. It must not take
/// off again before somebody who has seen it says so.
#[test]
fn a_drone_that_restarted_stays_down_until_told_to_wait() {
    for role in [Role::Head, Role::Relay] {
        let mut rig = Rig::restarted(role);
        let calls = Scene::quiet().order(EXPLORE).link(0, -62.0);
        let outputs = rig.during(60.0, &calls);
        assert_eq!(rig.state(), State::Landed { why: LandReason::Restarted });
        assert_eq!(outputs.setpoint, Setpoint::Off);
        assert_eq!(outputs.report.phase, Phase::Out, "the others do not wait for it");
        for task in [Order::Return, Order::Land] {
            rig.step(&calls.clone().order(task));
            assert_eq!(rig.state(), State::Landed { why: LandReason::Restarted });
        }
        rig.step(&calls.clone().order(Order::Wait));
        assert_eq!(rig.state(), State::Idle);
        rig.until("taking-off", &calls);
    }
    let mut base = Rig::restarted(Role::Base);
    assert_eq!(base.during(1.0, &Scene::quiet()).report.phase, Phase::Base, "a base does not fly");
}

/// A landing whose ground is never seen ends all the same, with the motors off.
#[test]
fn a_landing_that_sees_no_ground_ends() {
    let mut rig = Rig::on_duty(Role::Head);
    let blind = air().order(Order::Land).at_height(None);
    rig.during(10.0, &blind);
    assert_eq!(rig.state().name(), "landing");
    let outputs = rig.during(0.6, &blind);
    assert_eq!(outputs.setpoint, Setpoint::Off);
    assert_eq!(rig.state(), State::Landed { why: LandReason::Ordered });
}

#[test]
fn a_take_off_that_fails_is_given_up_and_makes_room_for_the_next() {
    for height in [None, Some(0.0), Some(0.2)] {
        let mut rig = Rig::new(Role::Relay);
        let called = Scene::quiet().order(EXPLORE).link(0, -62.0).at_height(height);
        rig.until("taking-off", &called);
        assert_eq!(rig.step(&called).report.phase, Phase::Transit);
        rig.during(9.6, &called);
        assert_eq!(rig.state().name(), "taking-off");
        rig.during(0.4, &called);
        assert!(matches!(rig.state(), State::Landing { why: LandReason::TakeOffFailed, .. }));
        assert_eq!(rig.step(&called).report.phase, Phase::Out);
        rig.during(11.0, &called);
        assert_eq!(rig.state(), State::Landed { why: LandReason::TakeOffFailed });
    }
}

/// A take-off climbs to its height in a ramp and hovers until it is a link.
#[test]
fn a_take_off_is_a_ramp() {
    let mut rig = Rig::new(Role::Head);
    let called = Scene::quiet().order(EXPLORE);
    rig.until("taking-off", &called);
    let mut before = 0.0;
    for _ in 0..12 {
        let (speed, height) = flown(rig.step(&called).setpoint).unwrap();
        assert_eq!(speed, 0.0);
        assert!(height >= before && height - before <= 0.15 && height <= 0.3, "{height}");
        before = height;
    }
    assert_eq!(before, 0.3);
    rig.step_after(400, &called.at_height(Some(0.3)));
    assert_eq!(rig.state().name(), "leading");
}

/// One at a time, in the order of their numbers: a relay waits for who stands before it.
#[test]
fn relays_take_off_one_by_one() {
    let weak = Scene::quiet().order(EXPLORE).link(0, -80.0);
    for before in [Phase::Waiting, Phase::Transit] {
        let mut rig = Rig::new(Role::Relay);
        rig.during(30.0, &weak.clone().also(1, before, -50.0));
        assert_eq!(rig.state(), State::Idle, "1 is {before:?}");
        // It has become the last link of the chain, and is good.
        rig.during(30.0, &weak.clone().also(1, Phase::Linked, -50.0));
        assert_eq!(rig.state().name(), "armed");
        rig.step(&weak.clone().also(1, Phase::Linked, -61.0));
        assert_eq!(rig.state().name(), "taking-off");
    }
    // One that is out of the mission is not waited for.
    let mut rig = Rig::new(Role::Relay);
    rig.during(10.0, &weak.also(1, Phase::Out, -50.0));
    assert_eq!(rig.state().name(), "taking-off");
}

/// The operator orders to land and to explore again at once: the head, or all that flew, have landed for good,
/// and a relay that was armed took off towards them.
#[test]
fn no_relay_takes_off_towards_a_chain_that_has_landed() {
    let seen = |one: Phase, head: Phase| {
        let scene = Scene::quiet().without(0).order(EXPLORE);
        scene.also(0, head, -52.0).also(1, one, -52.0)
    };
    let all = seen(Phase::Out, Phase::Out);
    // A head that flew when it was heard last calls for no relay beside one that has landed, either.
    for landed in [all.clone(), all.without(0)] {
        let mut rig = Rig::new(Role::Relay);
        rig.during(5.0, &seen(Phase::Linked, Phase::Linked));
        assert_eq!(rig.state().name(), "armed");
        rig.during(60.0, &landed);
        assert_eq!(rig.state().name(), "armed");
        if landed.heard.iter().any(|heard| heard.0 == 0) {
            rig.during(60.0, &landed.clone().without(0).without(1));
            assert_eq!(rig.state().name(), "armed", "landed, and not heard any more");
        }
        // A drone that flies again calls for a relay as before.
        rig.during(10.0, &landed.without(0).also(0, Phase::Linked, -75.0));
        assert_eq!(rig.state().name(), "taking-off");
    }
}

/// The head lands in the very round in which a relay takes off towards it, or while that one climbs: the relay
/// used to climb on and to hover at the base.
#[test]
fn a_relay_lands_again_where_the_chain_has_landed_while_it_climbed() {
    let seen =
        |head: Phase, rssi: f32| Scene::quiet().without(0).order(EXPLORE).also(0, head, rssi);
    let mut rig = Rig::new(Role::Relay);
    rig.during(5.0, &seen(Phase::Linked, -52.0));
    rig.until("taking-off", &seen(Phase::Linked, -75.0));
    let landed = seen(Phase::Out, -75.0);
    rig.during(0.4, &landed.clone().at_height(Some(0.1)));
    let is_retired = |state| matches!(state, State::Landing { why: LandReason::Retired, .. });
    assert!(is_retired(rig.state()), "{:?}", rig.state());
    rig.until("idle", &landed);
    for _ in 0..300 {
        rig.step(&landed);
        assert!(!rig.state().is_airborne());
    }
    rig.until("taking-off", &seen(Phase::Linked, -75.0));
}

#[test]
fn a_relay_called_home_lands_at_the_base() {
    let home = air().order(Order::Return).link(BASE, -52.0);
    let mut rig = Rig::on_duty(Role::Relay);
    rig.during(5.0, &home);
    assert_eq!(rig.state().name(), "homing", "the head is still out");
    let alone = home.without(0);
    rig.during(2.4, &alone);
    let outputs = rig.step(&alone);
    assert_eq!(flown(outputs.setpoint), Some((-CONFIG.flight.return_speed.0, 0.3)));
    // The base is 0.35 m behind where it took off, and there 0.46 m from its antenna in the air.
    let (mut apart, mut speed) = (0.85_f32, 0.0);
    while rig.state().name() == "homing" {
        let base = -38.0 - 20.0 * (apart.hypot(0.3) / 0.46).log10();
        let outputs = rig.step(&alone.clone().link(BASE, base).flow(Some(speed)));
        speed = flown(outputs.setpoint).map_or(0.0, |(speed, _)| speed);
        apart += 0.2 * speed;
        assert!(apart > 0.3, "it flies into the base");
    }
    assert!(matches!(rig.state(), State::Landing { why: LandReason::Home, .. }));
}

/// What a drone says is what it is: its number, its phase, a count that grows by one.
#[test]
fn a_report_says_who_and_what() {
    let mut rig = Rig::on_duty(Role::Relay);
    let first = rig.step(&air().flow(Some(0.1))).report;
    assert_eq!((first.from, first.phase), (NodeId(2), Phase::Linked));
    assert_eq!(first.velocity, MetresPerSecond(0.1));
    let second = rig.step(&air().flow(Some(0.1))).report;
    assert_eq!(second.sequence, first.sequence.wrapping_add(1));
    assert!(second.odometer > first.odometer);
    let span = second.links.unwrap();
    assert_eq!((span.weakest.0, span.strongest.0), (-52.0, -52.0));
    // With nobody in front it knows of no links.
    assert_eq!(rig.during(2.4, &air().without(0)).report.links, None);
}

/// A clock that jumps a day moves no odometer by a day's way.
#[test]
fn a_jump_of_the_clock_is_a_second_at_most() {
    let mut rig = Rig::on_duty(Role::Relay);
    let before = rig.step(&air()).status.here.odometer;
    let after = rig.step_after(86_400_000, &air().flow(Some(0.4))).status.here.odometer;
    assert!((after - before).abs() <= Metres(0.4 + 1e-4), "{before} to {after}");
    rig.now = Instant::from_millis(5);
    let back = rig.step_after(0, &air().flow(Some(0.4))).status.here.odometer;
    assert_eq!(back, after, "backwards is no time at all");
}

/// No drone passes another in a tunnel: when one has to go home, all do.
#[test]
fn a_battery_that_is_needed_for_the_way_home_calls_the_chain_home() {
    let mut rig = Rig::on_duty(Role::Relay);
    let lasts = rig.step(&air().endurance(60));
    assert!(!lasts.report.recall, "half a metre from home a minute is plenty");
    let outputs = rig.step(&air().endurance(20));
    assert!(outputs.report.recall);
    let outputs = rig.step(&air().endurance(60));
    assert!(outputs.report.recall, "a battery that recovers without load is no fuller");
    let alone = air().without(0).endurance(20);
    let outputs = rig.during(3.0, &alone);
    assert!(flown(outputs.setpoint).is_some_and(|(speed, _)| speed < 0.0), "homeward");
}

#[test]
fn a_recall_that_is_heard_is_obeyed_and_passed_on_until_the_next_mission() {
    for role in [Role::Head, Role::Relay, Role::Base] {
        let mut rig = Rig::new(role);
        let mut packet = heard(1, 1, Phase::Linked, -50.0);
        packet.report.recall = true;
        let inputs = agent::Inputs {
            ranges: super::rig::gallery(),
            velocity: None,
            heading: None,
            height: Some(Metres(0.3)),
            heard: &[packet],
            located: None,
            told: &[],
            order: None,
            fitness: agent::Fitness::Fit,
            endurance: None,
        };
        let outputs = rig.agent.step(&CONFIG, rig.now, &inputs);
        assert!(outputs.report.recall);
        let outputs = rig.during(20.0, &Scene::quiet().order(EXPLORE));
        assert!(outputs.report.recall && !outputs.status.state.is_airborne(), "{outputs:?}");
        let outputs = rig.step(&Scene::quiet().order(Order::Wait));
        assert!(!outputs.report.recall);
    }
}

/// Else those behind it in the order would wait for it for ever.
#[test]
fn a_drone_that_cannot_take_off_is_passed_over() {
    let mut rig = Rig::new(Role::Relay);
    let unfit = Scene::quiet().order(EXPLORE).fitness(agent::Fitness::Unfit);
    let outputs = rig.during(5.0, &unfit);
    assert_eq!((outputs.status.state, outputs.report.phase), (State::Idle, Phase::Out));
    let outputs = rig.during(1.0, &Scene::quiet().order(EXPLORE));
    assert_eq!(outputs.report.phase, Phase::Waiting);
}

#[test]
fn what_the_flight_code_decides_is_obeyed_and_said() {
    let mut rig = Rig::on_duty(Role::Relay);
    let landing = air().fitness(agent::Fitness::Landing(flight::Cause::NoFlow));
    let outputs = rig.step(&landing);
    let why = LandReason::Unfit(flight::Cause::NoFlow);
    assert!(matches!(outputs.status.state, State::Landing { why: said, .. } if said == why));
    assert_eq!(outputs.report.phase, Phase::Out, "the chain closes over it at once");
    let landed = air().fitness(agent::Fitness::Landed(flight::Cause::NoFlow));
    let outputs = rig.step(&landed);
    assert_eq!(outputs.status.state, State::Landed { why });
    assert_eq!(outputs.setpoint, Setpoint::Off);
}
