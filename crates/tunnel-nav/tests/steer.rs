//! Four beams and a speed in, a command for the body out: equations (17) and (18) as printed, the
//! ratio test at its 40 %, the symmetries that a rule made of geometry must have, and limits that
//! hold for any bits.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tunnel_nav::{Bearings, Diagonals, NavCommand, NavConfig, Navigator, Range, Side, Walls};
use units::{Metres, MetresPerSecond, Radians};

const CONFIG: NavConfig = NavConfig::DEFAULT;

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

fn at(metres: f32) -> Range {
    Range::At(Metres(metres))
}

fn beams(nw: Range, ne: Range, sw: Range, se: Range) -> Diagonals {
    Diagonals { nw, ne, sw, se }
}

/// The command of a drone that has seen no wall yet, with these beams.
fn first_look(ranges: &Diagonals, speed: f32) -> NavCommand {
    Navigator::new().step(&CONFIG, ranges, MetresPerSecond(speed), &Bearings::default())
}

fn assert_near(is: f32, wanted: f32) {
    assert!((is - wanted).abs() < 1e-5, "{is} for {wanted}");
}

/// v_y = C_l·(d_NW − d_NE), ω = C_r·((d_NW − d_SW) − (d_NE − d_SE)).
#[test]
fn two_walls_are_equation_17() {
    let command = first_look(&beams(at(0.9), at(0.8), at(0.85), at(0.95)), 0.2);
    assert_eq!(command.walls, Walls::Both);
    assert_near(command.lateral.0, CONFIG.lateral_gain * (0.9 - 0.8));
    assert_near(command.yaw_rate.0, CONFIG.yaw_gain * ((0.9 - 0.85) - (0.8 - 0.95)));
    assert_near(command.forward.0, 0.2);
}

/// v_y = C_l·(d_NW − D), ω = 2·C_r·(d_NW − d_SW) beside a wall on the left, D being 0.5 m for a
/// drone that is nearer than that; mirrored on the right.
#[test]
fn one_wall_is_equation_18() {
    let left = first_look(&beams(at(0.45), Range::Clear, at(0.40), Range::Clear), 0.2);
    assert_eq!(left.walls, Walls::One(Side::Left));
    assert_near(left.lateral.0, CONFIG.lateral_gain * (0.45 - 0.5));
    assert_near(left.yaw_rate.0, 2.0 * CONFIG.yaw_gain * (0.45 - 0.40));

    let right = first_look(&beams(Range::Clear, at(0.45), Range::Clear, at(0.40)), 0.2);
    assert_eq!(right.walls, Walls::One(Side::Right));
    assert_near(right.lateral.0, -CONFIG.lateral_gain * (0.45 - 0.5));
    assert_near(right.yaw_rate.0, -2.0 * CONFIG.yaw_gain * (0.45 - 0.40));
}

/// A drone that has come to the end of a gallery, both leading beams at the wall ahead, stands there with its
/// nose along the gallery, however little its beams differ. It turned, ever faster, and then faced back.
#[test]
fn a_drone_at_a_dead_end_does_not_turn() {
    for sign in [1.0, -1.0] {
        let mut navigator = Navigator::new();
        let mut fly = |way: f32, beams: &Diagonals| {
            let way = Metres(sign * way);
            let bearings = Bearings { way, heading: Some(Radians(0.3)), ..Bearings::default() };
            let ranges = if sign > 0.0 { *beams } else { turned_about(beams) };
            navigator.step(&CONFIG, &ranges, MetresPerSecond(0.2 * sign), &bearings)
        };
        for n in 0..50 {
            fly(0.04 * n as f32, &beams(at(0.7), at(0.7), at(0.7), at(0.7)));
        }
        let command = fly(2.0, &beams(at(0.26), at(0.21), at(0.72), at(0.74)));
        assert_eq!((command.lateral.0, command.yaw_rate.0), (0.0, 0.0), "{sign}");
    }
}

/// The same surroundings as the other end of the drone sees them.
fn turned_about(ranges: &Diagonals) -> Diagonals {
    beams(ranges.se, ranges.sw, ranges.ne, ranges.nw)
}

/// Beside a wall at the distance that was kept in a wide gallery, with the other wall near: the drone flies
/// towards the middle of the gallery that is there now.
#[test]
fn a_drone_beside_one_wall_keeps_off_the_other() {
    let mut navigator = Navigator::new();
    let mut fly = |way: f32, beams: &Diagonals| {
        let bearings = Bearings { way: Metres(way), ..Bearings::default() };
        navigator.step(&CONFIG, beams, MetresPerSecond(0.2), &bearings)
    };
    for n in 0..5 {
        fly(0.04 * n as f32, &beams(at(1.4), at(1.4), at(1.4), at(1.4)));
    }
    fly(0.2, &beams(at(1.2), Range::Clear, at(1.2), Range::Clear));
    let command = fly(0.24, &beams(at(1.0), at(0.23), at(1.0), at(0.39)));
    assert_eq!(command.walls, Walls::One(Side::Left));
    assert!(command.lateral.0 > 0.0, "{command:?}");
}

/// The mean of the two beams is 1 m: a difference of 0.399 m is a wall, one of 0.401 m is none.
#[test]
fn the_ratio_test_is_at_forty_percent() {
    assert_eq!(CONFIG.ratio, 0.4);
    for (difference, walls) in [(0.399, Walls::Both), (0.401, Walls::One(Side::Left))] {
        let (far, near) = (1.0 + 0.5 * difference, 1.0 - 0.5 * difference);
        for (front, rear) in [(far, near), (near, far)] {
            let command = first_look(&beams(at(1.0), at(front), at(1.0), at(rear)), 0.2);
            assert_eq!(command.walls, walls, "{front} and {rear}");
        }
    }
}

/// A beam that was not measured makes no wall, and neither does one that sees nothing.
#[test]
fn a_wall_needs_both_its_beams() {
    for blind in [Range::Invalid, Range::Clear] {
        let command = first_look(&beams(blind, at(0.8), at(0.8), at(0.8)), 0.2);
        assert_eq!(command.walls, Walls::One(Side::Right), "{blind:?}");
    }
    let clear = Range::Clear;
    let command = first_look(&beams(clear, clear, clear, clear), 0.3);
    assert_eq!(command.walls, Walls::Neither);
    assert_eq!((command.lateral.0, command.yaw_rate.0), (0.0, 0.0));
    assert_near(command.forward.0, 0.3);
}

/// Nothing seen is open ground; nothing measured may be a wall.
#[test]
fn a_drone_does_not_fly_where_it_is_blind() {
    let (blind, seen) = (Range::Invalid, at(1.2));
    for (speed, front_blind, rear_blind) in [(0.3, 0.0, 0.3), (-0.3, -0.3, 0.0)] {
        let front = first_look(&beams(blind, blind, seen, seen), speed);
        let rear = first_look(&beams(seen, seen, blind, blind), speed);
        assert_near(front.forward.0, front_blind);
        assert_near(rear.forward.0, rear_blind);
    }
}

#[test]
fn a_range_is_checked_at_the_door() {
    let reach = Metres(2.0);
    for (metres, range) in [
        (1.0, at(1.0)),
        (2.0, at(2.0)),
        (2.1, Range::Clear),
        (f32::INFINITY, Range::Clear),
        (0.0, Range::Invalid),
        (-0.5, Range::Invalid),
        (f32::NAN, Range::Invalid),
        (f32::NEG_INFINITY, Range::Invalid),
    ] {
        assert_eq!(Range::measured(Metres(metres), reach), range, "{metres}");
    }
}

/// Ahead of a wall the drone slows down, stops, and is pushed away from what is nearer still.
#[test]
fn what_is_near_stops_and_pushes() {
    // A little more room astern, and a wall on either hand by the ratio test.
    let ahead = |d: f32| {
        let astern = at(d + 0.05);
        first_look(&beams(at(d), at(d), astern, astern), 0.4).forward.0
    };
    assert_near(ahead(CONFIG.slow_below.0 + 0.01), 0.4);
    let halfway = 0.5 * (CONFIG.slow_below.0 + CONFIG.danger.0);
    assert_near(ahead(halfway), 0.2);
    assert_near(ahead(CONFIG.danger.0), 0.0);
    assert!(ahead(CONFIG.danger.0 - 0.05) < -0.05);
    let beside = first_look(&beams(at(0.1), at(0.8), at(0.1), at(0.8)), 0.0);
    assert!(beside.lateral.0 < -0.1, "away from the left: {}", beside.lateral);
}

/// With nothing beside it and rock ahead, every drone of a chain turns the same way; where one
/// way is open, it turns there.
#[test]
fn in_doubt_every_drone_turns_to_the_preferred_side() {
    let wall_ahead = beams(at(0.5), at(0.5), Range::Clear, Range::Clear);
    for (prefer, sign) in [(Side::Right, -1.0), (Side::Left, 1.0)] {
        let config = NavConfig { prefer, ..CONFIG };
        let speed = MetresPerSecond(0.2);
        let turn = Navigator::new().step(&config, &wall_ahead, speed, &Bearings::default());
        assert_eq!(turn.yaw_rate.0, sign * config.max_yaw_rate.0);
        let open_left = beams(at(1.5), at(0.5), Range::Clear, Range::Clear);
        let turn = Navigator::new().step(&config, &open_left, speed, &Bearings::default());
        assert_eq!(turn.yaw_rate.0, config.max_yaw_rate.0);
    }
}

/// A relay that flew a straight gallery and finds its nose across it turns to where it pointed.
#[test]
fn the_trail_turns_a_lost_nose_back() {
    let mut navigator = Navigator::new();
    let square = beams(at(0.7), at(0.7), at(0.7), at(0.7));
    let mut fly = |way: f32, speed: f32, heading: f32| {
        let heading = Some(Radians(heading));
        let bearings = Bearings { way: Metres(way), heading, ..Bearings::default() };
        navigator.step(&CONFIG, &square, MetresPerSecond(speed), &bearings).yaw_rate.0
    };
    for n in 0..=30 {
        assert_eq!(fly(0.1 * n as f32, 0.2, 0.1), 0.0);
    }
    // Four equal beams tell nothing; the gyro says 70° to the left of what was.
    let turn = fly(2.9, -0.2, 0.1 + 1.2);
    assert!(turn < -0.5, "{turn} rad/s");
    let turn = fly(2.9, -0.2, 0.1 - 1.2);
    assert!(turn > 0.5, "{turn} rad/s");
}

/// The drone's inputs of one round.
#[derive(Clone, Copy, Debug)]
struct Moment {
    ranges: Diagonals,
    speed: f32,
    step: f32,
    heading: Option<f32>,
}

/// A beam as a sensor gives it: mostly a wall of about this tunnel's width.
fn beam() -> impl Strategy<Value = Range> {
    prop_oneof![
        6 => (0.5f32..1.2).prop_map(at),
        2 => (0.02f32..2.0).prop_map(at),
        1 => Just(Range::Clear),
        1 => Just(Range::Invalid),
    ]
}

fn diagonals() -> impl Strategy<Value = Diagonals> {
    (beam(), beam(), beam(), beam()).prop_map(|(nw, ne, sw, se)| beams(nw, ne, sw, se))
}

fn flight() -> impl Strategy<Value = Vec<Moment>> {
    let heading = prop::option::of(-3.1f32..3.1);
    let moment = (diagonals(), -0.4f32..0.4, -0.1f32..0.1, heading)
        .prop_map(|(ranges, speed, step, heading)| Moment { ranges, speed, step, heading });
    prop::collection::vec(moment, 1..60)
}

fn mirrored(ranges: &Diagonals) -> Diagonals {
    beams(ranges.ne, ranges.nw, ranges.se, ranges.sw)
}

fn mirrored_walls(walls: Walls) -> Walls {
    match walls {
        Walls::One(Side::Left) => Walls::One(Side::Right),
        Walls::One(Side::Right) => Walls::One(Side::Left),
        other => other,
    }
}

proptest! {
    #![proptest_config(seeded())]

    /// In a world seen in a mirror the same flight is flown in the mirror, all the way.
    #[test]
    fn left_and_right_are_alike(flight in flight()) {
        let other_config = NavConfig { prefer: Side::Left, ..CONFIG };
        let (mut here, mut there) = (Navigator::new(), Navigator::new());
        let (mut way, mut aside) = (Metres(0.0), 0.0);
        for Moment { ranges, speed, step, heading } in flight {
            way += Metres(step);
            aside += 0.5 * step * heading.unwrap_or(0.0);
            let speed = MetresPerSecond(speed);
            let here = here.step(
                &CONFIG, &ranges, speed, &Bearings { way, aside: Metres(aside), heading: heading.map(Radians) },
            );
            let there = there.step(
                &other_config, &mirrored(&ranges), speed,
                &Bearings { way, aside: Metres(-aside), heading: heading.map(|h| Radians(-h)) },
            );
            prop_assert!((here.forward - there.forward).abs().0 < 1e-5);
            prop_assert!((here.lateral + there.lateral).abs().0 < 1e-5, "{here:?} {there:?}");
            prop_assert!((here.yaw_rate + there.yaw_rate).abs().0 < 1e-5, "{here:?} {there:?}");
            prop_assert_eq!(here.walls, mirrored_walls(there.walls));
        }
    }

    /// Tail first the rear beams lead: the same walls seen from the other end give the same
    /// sideways motion and the opposite turn.
    #[test]
    fn front_and_rear_are_alike_between_walls(
        left in 0.5f32..1.2, right in 0.5f32..1.2, skew in -0.1f32..0.1, speed in 0.05f32..0.4,
    ) {
        let ahead = beams(at(left + skew), at(right - skew), at(left - skew), at(right + skew));
        let astern = beams(ahead.sw, ahead.se, ahead.nw, ahead.ne);
        let (forth, back) = (first_look(&ahead, speed), first_look(&astern, -speed));
        prop_assert!((forth.forward + back.forward).abs().0 < 1e-5);
        prop_assert!((forth.lateral - back.lateral).abs().0 < 1e-5);
        prop_assert!((forth.yaw_rate + back.yaw_rate).abs().0 < 1e-5);
    }

    /// In the middle and along the tunnel there is nothing to correct, however wide it is and
    /// however the drone flies.
    #[test]
    fn in_the_middle_there_is_nothing_to_correct(
        beam in 0.25f32..1.99, speed in -0.4f32..0.4, rounds in 1usize..20,
    ) {
        let mut navigator = Navigator::new();
        let ranges = beams(at(beam), at(beam), at(beam), at(beam));
        for n in 0..rounds {
            let way = Metres(speed * 0.2 * n as f32);
            let heading = Some(Radians(1.0));
            let bearings = Bearings { way, heading, ..Bearings::default() };
            let command = navigator.step(&CONFIG, &ranges, MetresPerSecond(speed), &bearings);
            prop_assert_eq!(command.walls, Walls::Both);
            // Walls that are nearer than 0.32 m hold it off on both sides, which is equal but for rounding.
            let rounding = if beam < 0.32 { 1e-5 } else { 0.0 };
            prop_assert!(command.lateral.0.abs() <= rounding);
            // The trail keeps headings to within 1e-4 rad.
            prop_assert!(command.yaw_rate.0.abs() < 1e-3);
            prop_assert!((command.forward.0 - speed).abs() < 1e-6 || beam < CONFIG.slow_below.0);
        }
    }

    /// Off the middle it goes to the middle; turned, it turns back.
    #[test]
    fn it_steers_to_the_middle_and_along(
        beam in 0.6f32..1.2, off in 0.01f32..0.1, speed in -0.4f32..0.4,
    ) {
        let to_the_right = beams(at(beam + off), at(beam - off), at(beam + off), at(beam - off));
        prop_assert!(first_look(&to_the_right, speed).lateral.0 > 0.0);
        // The nose to the right: the right wall is near in front, the left one behind.
        let clockwise = beams(at(beam + off), at(beam - off), at(beam - off), at(beam + off));
        prop_assert!(first_look(&clockwise, speed).yaw_rate.0 > 0.0);
    }

    /// Whatever comes through the checked door, the command is finite and limited, and never
    /// faster along the tunnel than asked for but for the push away from what is too near.
    #[test]
    fn a_command_is_finite_and_limited(
        flight in prop::collection::vec(
            ([any::<f32>(); 4], any::<f32>(), any::<f32>(), prop::option::of(any::<f32>())), 1..20,
        ),
        speed in -0.4f32..0.4,
    ) {
        let mut navigator = Navigator::new();
        for ([nw, ne, sw, se], way, other, heading) in flight {
            let beam = |d: f32| Range::measured(Metres(d), CONFIG.reach);
            let ranges = beams(beam(nw), beam(ne), beam(sw), beam(se));
            let way = if other > 0.0 { way } else { other };
            let heading = heading.map(Radians);
            let bearings = Bearings { way: Metres(way), aside: Metres(other), heading };
            let command = navigator.step(&CONFIG, &ranges, MetresPerSecond(speed), &bearings);
            check(&command, speed)?;
        }
    }

    /// The same where beams bypass the door: a beam of any bits is borne.
    #[test]
    fn beams_of_any_bits_are_borne(
        flight in prop::collection::vec([any::<f32>(); 4], 1..20), speed in -0.4f32..0.4,
    ) {
        let mut navigator = Navigator::new();
        for [nw, ne, sw, se] in flight {
            let ranges = beams(at(nw), at(ne), at(sw), at(se));
            let bearings = Bearings::default();
            let command = navigator.step(&CONFIG, &ranges, MetresPerSecond(speed), &bearings);
            prop_assert!(command.forward.0.is_finite(), "{ranges:?}: {command:?}");
            prop_assert!(command.lateral.abs() <= CONFIG.max_lateral);
            prop_assert!(command.yaw_rate.abs() <= CONFIG.max_yaw_rate);
        }
    }
}

fn check(command: &NavCommand, speed: f32) -> Result<(), TestCaseError> {
    // Two beams inside the danger distance, each at 45°.
    let push = CONFIG.push_gain * CONFIG.danger.0 * core::f32::consts::SQRT_2;
    prop_assert!(command.forward.0.abs() <= speed.abs() + push + 1e-5, "{command:?}");
    prop_assert!(command.lateral.abs() <= CONFIG.max_lateral, "{command:?}");
    prop_assert!(command.yaw_rate.abs() <= CONFIG.max_yaw_rate, "{command:?}");
    Ok(())
}

#[test]
fn a_navigator_made_anew_is_a_new_one_whatever_it_was() {
    let mut navigator = Navigator::new();
    for round in 0..200 {
        let way = Metres(0.04 * round as f32);
        let length = if round % 50 < 25 { 0.5 } else { 1.2 };
        let ranges = beams(at(0.5), at(length), at(0.5), Range::Clear);
        let heading = Some(Radians(0.3 + 0.01 * round as f32));
        let bearings = Bearings { way, heading, ..Bearings::default() };
        navigator.step(&CONFIG, &ranges, MetresPerSecond(0.2), &bearings);
    }
    assert_ne!(navigator, Navigator::new());
    navigator.renew();
    assert_eq!(navigator, Navigator::new());
}
