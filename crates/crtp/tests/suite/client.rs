//! A client connects, looks, sets and flies, byte for byte as cflib 0.1.34 does.

use crate::common::{Line, port};
use crtp::{Access, Event, Notice, OperatorTask, Outcome, ParameterId, Setpoint};
use flight::{Mode, StopCause};
use units::{Dbm, Duration, Instant, Metres, MetresPerSecond, NodeId, Role, Volts};

/// What cflib does on connect, in its order (`cflib/crazyflie/__init__.py`).
#[test]
fn a_client_connects_and_reads_everything() {
    let mut line = Line::new();
    line.access = Access::Read;
    assert!(line.ask(port::SOURCE, &[0]).starts_with(b"Bitcraze Crazyflie"));
    assert_eq!(line.ask(port::VERSION, &[0])[..2], [0, 12]);
    assert_eq!(line.ask(port::LOG_CONTROL, &[5]), [5, 0, 0]);
    let variables = line.table(port::LOG_TABLE);
    assert_eq!(line.ask(port::MEMORY, &[1]), [1, 0]);
    let parameters = line.table(port::PARAM_TABLE);
    for (id, (kind, ..)) in (0_u16..).zip(&parameters) {
        let answer = line.ask(port::PARAM_READ, &id.to_le_bytes());
        assert_eq!(answer[..2], id.to_le_bytes());
        assert_eq!(answer[2], 0);
        // The lowest two bits are the binary logarithm of the size (`param.h`).
        assert_eq!(answer.len() - 3, 1 << (kind & 3));
    }
    for rows in [&variables, &parameters] {
        for (n, (_, group, name)) in rows.iter().enumerate() {
            assert!(group.len() + name.len() <= 24, "{group}.{name} is too long for a packet");
            let twice = rows[..n].iter().any(|(_, g, n)| (g, n) == (group, name));
            assert!(!twice, "{group}.{name} is there twice");
            // A group that is in two pieces is one to cflib, but not to the vendor's firmware.
            let apart = rows[..n].iter().any(|(_, g, _)| g == group) && rows[n - 1].1 != *group;
            assert!(!apart, "{group} is in two pieces");
        }
    }
    // What cfclient 2026.8 asks for without looking whether it is there.
    let wanted = [
        "pm.vbat",
        "pm.state",
        "stabilizer.thrust",
        "motor.m1",
        "motor.m4",
        "sys.canfly",
        "supervisor.info",
        "stateEstimate.x",
        "stateEstimate.y",
        "stateEstimate.z",
        "stateEstimate.roll",
        "stateEstimate.pitch",
        "stateEstimate.yaw",
    ];
    for wanted in wanted {
        assert!(variables.iter().any(|(_, g, n)| format!("{g}.{n}") == wanted), "{wanted}");
    }
    let wanted = [
        "deck.bcFlow",
        "deck.bcFlow2",
        "deck.bcZRanger",
        "deck.bcZRanger2",
        "deck.bcLighthouse4",
        "deck.bcLoco",
        "deck.bcDWM1000",
        "commander.enHighLevel",
        "flightmode.althold",
        "firmware.revision0",
        "firmware.revision1",
        "firmware.modified",
    ];
    for wanted in wanted {
        assert!(parameters.iter().any(|(_, g, n)| format!("{g}.{n}") == wanted), "{wanted}");
    }
}

#[test]
fn the_link_says_the_same_again() {
    let mut line = Line::new();
    assert_eq!(line.ask(port::ECHO, &[0, 1, 2, 3]), [0, 1, 2, 3]);
    line.send(0xFE, &[1]);
    line.send(0xFF, &[]);
    assert_eq!(line.all(), []);
    assert_eq!(line.ask(port::VERSION, &[2]), b"\x02CF21");
    assert!(line.ask(port::VERSION, &[1]).starts_with(b"\x01uchain "));
}

#[test]
fn there_are_no_memories_but_each_question_is_answered() {
    let mut line = Line::new();
    assert_eq!(line.ask(port::MEMORY, &[2, 5]), [2, 5]);
    assert_eq!(line.ask(0x4D, &[5, 1, 2, 3, 4, 20]), [5, 1, 2, 3, 4, 5]);
    assert_eq!(line.ask(0x4E, &[5, 1, 2, 3, 4, 9, 9]), [5, 1, 2, 3, 4, 5]);
}

#[test]
fn an_operator_gives_orders() {
    let mut line = Line::new();
    let [a, b] = line.id_of(port::PARAM_TABLE, "uchain.task");
    let answer = |line: &mut Line, task| {
        let event = line.send(port::PARAM_WRITE, &[a, b, task]);
        (event, line.next().unwrap().1)
    };
    for (code, task) in [
        (1, OperatorTask::Explore),
        (2, OperatorTask::Return),
        (3, OperatorTask::Land),
        (4, OperatorTask::Stop),
        (5, OperatorTask::Perch),
        (0, OperatorTask::Wait),
    ] {
        let set = Some(Event::ParameterSet(ParameterId::TASK));
        assert_eq!(answer(&mut line, code), (set, vec![a, b, code]));
        assert_eq!(line.parameters.task, task);
    }
    // What cannot be is answered with what is.
    assert_eq!(answer(&mut line, 6), (None, vec![a, b, 0]));
    assert_eq!(line.server.counters().refused, 1);

    let [a, b] = line.id_of(port::PARAM_TABLE, "uchain.speed");
    let set = |line: &mut Line, speed: f32| {
        let event = line.send(port::PARAM_WRITE, &[&[a, b][..], &speed.to_le_bytes()].concat());
        let answers = line.all();
        let (_, answer) = answers.iter().find(|(port, _)| *port == port::PARAM_WRITE).unwrap();
        (event.is_some(), f32::from_le_bytes(answer[2..].try_into().unwrap()))
    };
    assert_eq!(set(&mut line, 0.4), (true, 0.4));
    assert_eq!(line.parameters.speed, MetresPerSecond(0.4));
    for nonsense in [0.41, -0.41, f32::NAN, f32::INFINITY, 1e30] {
        assert_eq!(set(&mut line, nonsense), (false, 0.4));
    }
}

/// The numbers of C's `errno.h` that the vendor's firmware gives (`param_logic.c`).
#[test]
fn limits_that_contradict_each_other_are_not_set() {
    let mut line = Line::new();
    let mut set = |name: &str, limit: f32| {
        let [a, b] = line.id_of(port::PARAM_TABLE, name);
        line.send(port::PARAM_WRITE, &[&[a, b][..], &limit.to_le_bytes()].concat());
        line.next().unwrap();
        (line.parameters.launch_limit, line.parameters.retreat_limit)
    };
    assert_eq!(set("uchain.launchLimit", -66.0), (Dbm(-60.0), Dbm(-65.0)));
    assert_eq!(set("uchain.retreatLimit", -70.0), (Dbm(-60.0), Dbm(-70.0)));
    assert_eq!(set("uchain.launchLimit", -66.0), (Dbm(-66.0), Dbm(-70.0)));
    assert_eq!(set("uchain.launchLimit", f32::NAN), (Dbm(-66.0), Dbm(-70.0)));
}

#[test]
fn who_knows_no_table_sets_by_name() {
    let mut line = Line::new();
    let mut by_name = |name: &[u8], rest: &[u8]| {
        let answer = line.ask(port::PARAM_MISC, &[&[0], name, rest].concat());
        assert_eq!(answer[..=name.len()], [&[0], name].concat());
        assert_eq!(answer.len(), name.len() + 2);
        answer[name.len() + 1]
    };
    assert_eq!(by_name(b"uchain\0task\0", &[8, 3]), 0);
    assert_eq!(by_name(b"uchain\0nobody\0", &[8, 3]), 2, "ENOENT");
    assert_eq!(by_name(b"nobody\0task\0", &[8, 3]), 2, "ENOENT");
    assert_eq!(by_name(b"uchain\0task\0", &[9, 3, 0]), 22, "EINVAL: of another type");
    assert_eq!(by_name(b"uchain\0task\0", &[8]), 22, "EINVAL: without a value");
    assert_eq!(by_name(b"uchain\0task\0", &[8, 9]), 22, "EINVAL: out of range");
    assert_eq!(by_name(b"uchain\0node\0", &[8, 3]), 13, "EACCES: read-only");
    assert_eq!(line.parameters.task, OperatorTask::Land);
    line.access = Access::Read;
    let mut answer = line.ask(port::PARAM_MISC, b"\0uchain\0task\0\x08\x02");
    assert_eq!(answer.pop(), Some(13), "EACCES: may only look");
    assert_eq!(line.parameters.task, OperatorTask::Land);
}

#[test]
fn requests_for_parameters_that_are_not_are_answered_as_the_vendor_does() {
    let mut line = Line::new();
    let nobody = [0xFE, 0xFF];
    assert_eq!(line.ask(port::PARAM_TABLE, &[2, 0xFE, 0xFF]), [2]);
    assert_eq!(line.ask(port::PARAM_READ, &nobody), [0xFE, 0xFF, 2]);
    assert_eq!(line.ask(port::PARAM_WRITE, &[0xFE, 0xFF, 1]), [0xFE, 0xFF, 2]);
    for command in 2..=8 {
        assert_eq!(line.ask(port::PARAM_MISC, &[command, 0xFE, 0xFF]), [command, 0xFE, 0xFF, 2]);
    }
    // Nothing is kept, and what is read-only has no default.
    let [a, b] = line.id_of(port::PARAM_TABLE, "uchain.task");
    for command in [2, 3, 4, 5, 7] {
        assert_eq!(line.ask(port::PARAM_MISC, &[command, a, b]), [command, a, b, 2]);
    }
    assert_eq!(line.ask(port::PARAM_MISC, &[6, a, b]), [6, a, b, 0]);
    assert_eq!(line.ask(port::PARAM_MISC, &[8, a, b]), [8, a, b, 0, 0]);
    let [a, b] = line.id_of(port::PARAM_TABLE, "uchain.node");
    assert_eq!(line.ask(port::PARAM_MISC, &[8, a, b]), [8, a, b, 2]);
    // Neither a read-only parameter nor half a number changes a value, and the client gets the
    // value.
    assert_eq!(line.ask(port::PARAM_WRITE, &[a, b, 9]), [a, b, 1]);
    let [a, b] = line.id_of(port::PARAM_TABLE, "uchain.speed");
    assert_eq!(line.ask(port::PARAM_WRITE, &[a, b, 0, 0])[2..], 0.2_f32.to_le_bytes());
    // What is no request at all is not answered.
    for (header, data) in [
        (port::PARAM_TABLE, &[1][..]),
        (port::PARAM_TABLE, &[2, 0]),
        (port::PARAM_READ, &[0]),
        (port::PARAM_WRITE, &[0]),
        (port::PARAM_MISC, &[1, 0, 0]),
        (port::PARAM_MISC, &[0, b'a', 0, b'b']),
    ] {
        assert_eq!(line.send(header, data), None);
        assert_eq!(line.all(), []);
    }
}

#[test]
fn a_client_flies() {
    let mut line = Line::new();
    let hover = |line: &mut Line, kind: u8, numbers: [f32; 4]| {
        let numbers = numbers.map(f32::to_le_bytes).concat();
        line.send(port::SETPOINT, &[&[kind], &numbers[..]].concat())
    };
    let Some(Event::Setpoint(Setpoint::Hover { forward, lateral, yaw_rate, height })) =
        hover(&mut line, 10, [0.2, -0.1, 90.0, 0.3])
    else {
        panic!("no set-point");
    };
    assert_eq!(
        (forward, lateral, height),
        (MetresPerSecond(0.2), MetresPerSecond(-0.1), Metres(0.3))
    );
    assert!((yaw_rate.0 - core::f32::consts::FRAC_PI_2).abs() < 1e-5);
    assert_eq!(line.send(port::SETPOINT, &[0]), Some(Event::Setpoint(Setpoint::Stop)));
    assert_eq!(line.send(0x7D, &[0, 0, 0, 0, 0]), None);
    assert_eq!(line.all(), [], "set-points are not answered");
    // A client that goes sends zeros; they end nothing.
    assert_eq!(line.send(port::RPYT, &[0; 14]), None);
    assert_eq!(line.server.counters().unsupported, 0);
}

#[test]
fn what_is_not_flown_is_refused_counted_and_said_once() {
    let mut line = Line::new();
    let four = [0.0_f32; 4].map(f32::to_le_bytes).concat();
    for kind in [1, 2, 3, 4, 6, 7, 8, 9, 11, 200] {
        assert_eq!(line.send(port::SETPOINT, &[&[kind], &four[..]].concat()), None);
    }
    let mut thrust = vec![0; 12];
    thrust.extend(20_000_u16.to_le_bytes());
    assert_eq!(line.send(port::RPYT, &thrust), None);
    assert_eq!(line.server.counters().unsupported, 11);
    let said = line.console();
    assert_eq!(said.matches("set-point").count(), 1, "{said}");
    assert_eq!(line.console(), "");
    // The notice is printed again for the next client.
    line.ask(port::LOG_CONTROL, &[5]);
    line.send(port::RPYT, &thrust);
    assert!(line.console().contains("set-point"));
}

#[test]
fn high_level_commands_are_answered_and_those_for_a_group_are_for_others() {
    let mut line = Line::new();
    let mut command = |data: &[u8]| {
        let event = line.send(port::HIGH_LEVEL, data);
        let (_, answer) = line.all().into_iter().find(|(port, _)| *port == 0x8C).unwrap();
        (event, answer)
    };
    assert_eq!(command(&[7, 0, 1, 9]), (Some(Event::TakeOff), vec![7, 0, 1, 0]));
    assert_eq!(command(&[8, 0, 1]), (Some(Event::Land), vec![8, 0, 1, 0]));
    assert_eq!(command(&[3, 0]), (Some(Event::Setpoint(Setpoint::Stop)), vec![3, 0, 0, 0]));
    assert_eq!(command(&[7, 4, 1]), (None, vec![7, 4, 1, 0]));
    assert_eq!(command(&[12, 0, 1]), (None, vec![12, 0, 1, 8]), "ENOEXEC");
}

#[test]
fn the_supervisor_is_asked_and_told() {
    let mut line = Line::new();
    let state = |line: &mut Line| {
        let answer = line.ask(port::SUPERVISOR, &[12]);
        assert_eq!(answer[0], 0x8C);
        u16::from_le_bytes([answer[1], answer[2]])
    };
    assert_eq!(state(&mut line), 0);
    line.snapshot.mode = Some(Mode::Grounded { waits_for: None });
    assert_eq!(state(&mut line), 0b0000_1110);
    assert_eq!(line.ask(port::SUPERVISOR, &[4]), [0x84, 1]);
    assert_eq!(line.ask(port::SUPERVISOR, &[5]), [0x85, 0]);
    line.snapshot.mode = Some(Mode::Flying { since: Instant::ZERO });
    assert_eq!(state(&mut line), 0b0001_1110);
    line.snapshot.mode = Some(Mode::Stopped { why: StopCause::Tumbled });
    assert_eq!(state(&mut line), 0b1110_0000);

    line.snapshot.mode = Some(Mode::Grounded { waits_for: None });
    assert_eq!(line.ask(port::COMMAND, &[1, 1]), [0x81, 1, 1]);
    assert_eq!(line.send(port::COMMAND, &[3]), Some(Event::EmergencyStop));
    assert_eq!(line.send(port::COMMAND, &[4]), Some(Event::EmergencyStopWatchdog));
    assert_eq!(line.send(port::COMMAND, &[2]), None);
    // As clients did before there was a port for it.
    assert_eq!(line.send(0x6D, &[3]), Some(Event::EmergencyStop));
}

/// No drone is ever disarmed, and no answer says that it was; see the console of the drone.
#[test]
fn a_client_is_not_told_that_a_drone_is_disarmed_that_is_not() {
    let mut line = Line::new();
    for mode in [Mode::Flying { since: Instant::ZERO }, Mode::Grounded { waits_for: None }] {
        line.snapshot.mode = Some(mode);
        assert_eq!(line.ask(port::COMMAND, &[1, 0]), [0x81, 0, 1]);
        // As clients asked before there was a port for it.
        assert_eq!(line.ask(port::PLATFORM, &[1, 0]), [1, 0, 1]);
        assert_eq!(line.ask(port::PLATFORM, &[1, 1]), [1, 1, 1]);
    }
    line.snapshot.mode = Some(Mode::Stopped { why: StopCause::Ordered });
    assert_eq!(line.ask(port::COMMAND, &[1, 0]), [0x81, 1, 0], "it is not armed");
    assert_eq!(line.ask(port::COMMAND, &[1, 1]), [0x81, 0, 0], "and does not get so");
    line.ask(port::LOG_CONTROL, &[5]);
    line.snapshot.mode = Some(Mode::Flying { since: Instant::ZERO });
    line.send(port::COMMAND, &[1, 0]);
    assert!(line.console().contains("Not disarmed"));
}

/// What the drone refuses is answered with an error, and parameters are again what they were.
#[test]
fn a_client_is_not_told_done_of_what_the_drone_refuses() {
    let mut line = Line::new();
    line.outcome = Outcome::Refused(Notice::StopStands);
    let before = line.parameters;
    let [a, b] = line.id_of(port::PARAM_TABLE, "uchain.task");
    assert_eq!(line.ask(port::PARAM_WRITE, &[a, b, 1]), [a, b, 0], "the value that holds");
    let answer = line.ask(port::PARAM_MISC, b"\0uchain\0task\0\x08\x01");
    assert_eq!(answer.last(), Some(&13), "EACCES");
    assert_eq!(line.parameters, before);
    assert_eq!(line.ask(port::HIGH_LEVEL, &[7, 0, 1]), [7, 0, 1, 13]);
    assert_eq!(line.ask(port::COMMAND, &[3]), [0x83, 0, 0]);
    line.ask(port::LOG_CONTROL, &[5]);
    line.send(port::SETPOINT, &[0]);
    assert!(line.console().contains("a stop stands"));
}

/// Every client may stop a drone, whatever else it may.
#[test]
fn a_client_that_may_only_look_may_stop() {
    let mut line = Line::new();
    line.access = Access::Read;
    assert_eq!(line.send(port::COMMAND, &[3]), Some(Event::EmergencyStop));
    assert_eq!(line.next(), Some((port::COMMAND, vec![0x83, 1, 0])));
    assert_eq!(line.send(port::COMMAND, &[4]), Some(Event::EmergencyStopWatchdog));
    assert_eq!(line.send(0x6D, &[3]), Some(Event::EmergencyStop));
    assert_eq!(line.send(0x6D, &[4]), Some(Event::EmergencyStopWatchdog));
    assert_eq!(line.send(port::SETPOINT, &[0]), None, "which lands");
}

#[test]
fn the_console_says_what_is_said_in_order_and_in_pieces() {
    let mut line = Line::new();
    line.server.say("A line that is a good deal longer than the thirty bytes of a packet.");
    line.server.say("Größe");
    assert_eq!(
        line.console(),
        "A line that is a good deal longer than the thirty bytes of a packet.\nGr??e\n"
    );
    for n in 0..100 {
        line.server.say(&format!("line {n}"));
    }
    let said = line.console();
    assert!(said.starts_with("line 0\nline 1\n") && said.ends_with('\n') && said.len() <= 512);
    let lost = 100 - u32::try_from(said.lines().count()).unwrap();
    assert_eq!(line.server.counters().unsaid, lost);
}

/// Over the radio one packet may go out for each that comes in.
#[test]
fn answers_come_before_text_and_text_before_logs_however_slow_the_line() {
    let mut line = Line::new();
    line.snapshot.volts = Some(Volts(3.9));
    let [a, b] = line.id_of(port::LOG_TABLE, "pm.vbat");
    line.control(&[6, 1, 7, a, b]);
    line.control(&[8, 1, 10, 0]);
    line.server.say("text");
    line.pass(units::Duration::from_millis(10));
    line.send(port::ECHO, &[1]);
    let order: Vec<u8> = (0..4).filter_map(|_| Some(line.next()?.0)).collect();
    assert_eq!(order, [port::ECHO, 0x0C, port::LOG_DATA]);
}

#[test]
fn a_full_queue_keeps_no_stop_waiting_and_loses_nothing_half_done() {
    let mut line = Line::new();
    for n in 0..16 {
        line.send(port::ECHO, &[n]);
    }
    let before = line.parameters;
    line.send(port::PARAM_MISC, b"\0uchain\0task\0\x08\x02");
    assert_eq!(line.parameters, before, "what cannot be answered is not done");
    assert_eq!(line.server.counters().overrun, 1);
    assert_eq!(line.send(port::COMMAND, &[3]), Some(Event::EmergencyStop));
    assert_eq!(line.send(port::SETPOINT, &[0]), Some(Event::Setpoint(Setpoint::Stop)));
    assert_eq!(line.send(port::HIGH_LEVEL, &[8, 0]), Some(Event::Land));
    assert_eq!(line.all().len(), 16);
}

#[test]
fn the_base_shows_what_each_node_told() {
    use crtp::Node;
    let mut line = Line::new();
    line.snapshot.nodes[11] = Some(Node {
        telemetry: wire::p2p::Telemetry {
            state: 4,
            fault: 0,
            battery: Some(Volts(3.5)),
            endurance: None,
            front: Some((NodeId(10), units::Dbm(-61.0))),
            back: None,
            odometer: Metres(7.5),
            velocity: MetresPerSecond(0.1),
            height: None,
            heeded: 77,
        },
        heard: line.now,
    });
    line.pass(units::Duration::from_millis(1_500));
    let names = ["state", "age", "frontPeer", "frontRssi", "odometer"];
    let mut entries = vec![6, 1];
    for name in names {
        let [a, b] = line.id_of(port::LOG_TABLE, &format!("node11.{name}"));
        entries.extend([7, a, b]);
    }
    let [a, b] = line.id_of(port::LOG_TABLE, "node12.age");
    entries.extend([7, a, b]);
    assert_eq!(line.control(&entries), 0);
    line.send(port::LOG_CONTROL, &[3, 1, 0]);
    assert_eq!(line.next(), Some((port::LOG_CONTROL, vec![3, 1, 0])));
    let (_, data) = line.next().unwrap();
    let numbers: Vec<f32> =
        data[4..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(numbers, [4.0, 1.5, 10.0, -61.0, 7.5, -1.0]);
    assert_eq!(line.next(), None, "a period of zero is once");
}

/// cflib's `MotionCommander` and `reset_estimator` set it to 1 and then to 0; it always reads 0.
#[test]
fn a_reset_of_the_estimate_is_asked_of_the_drone_by_every_client_and_reads_0() {
    let mut line = Line::new();
    let [a, b] = line.id_of(port::PARAM_TABLE, "kalman.resetEstimation");
    for access in [Access::Full, Access::Read] {
        line.access = access;
        assert_eq!(line.send(port::PARAM_WRITE, &[a, b, 1]), Some(Event::ResetEstimate));
        assert_eq!(line.next(), Some((port::PARAM_WRITE, vec![a, b, 0])));
        assert_eq!(line.send(port::PARAM_WRITE, &[a, b, 0]), None);
        assert_eq!(line.next(), Some((port::PARAM_WRITE, vec![a, b, 0])));
        assert_eq!(line.console(), "");
    }
    line.outcome = Outcome::Refused(Notice::EstimateFlies);
    let answer = line.ask(port::PARAM_MISC, b"\0kalman\0resetEstimation\0\x08\x01");
    assert_eq!(answer.last(), Some(&13), "EACCES");
    line.ask(port::LOG_CONTROL, &[5]);
    assert_eq!(line.ask(port::PARAM_WRITE, &[a, b, 2]), [a, b, 0], "no such value");
}

/// cflib's examples set and log these; a name that is missing ends a script with a `KeyError`.
#[test]
fn the_names_of_cflibs_examples_are_there() {
    let mut line = Line::new();
    for name in [
        "kalman.resetEstimation",
        "stabilizer.estimator",
        "stabilizer.controller",
        "led.bitmask",
        "deck.bcFlow2",
        "deck.bcMultiranger",
        "pid_attitude.pitch_kd",
        "commander.enHighLevel",
    ] {
        line.id_of(port::PARAM_TABLE, name);
    }
    for name in ["kalman.varPX", "kalman.varPY", "kalman.varPZ", "kalman.stateX", "kalman.stateZ"] {
        line.id_of(port::LOG_TABLE, name);
    }
}

#[test]
fn a_set_point_at_a_drone_that_takes_none_is_refused_by_one_line_in_ten_seconds_that_says_why() {
    for (role, why) in [
        (Role::Head, "give them at the base"),
        (Role::Relay, "give them at the base"),
        (Role::Base, "provisioned to take no orders"),
    ] {
        let mut line = Line::new();
        line.access = Access::Read;
        line.parameters.about.role = role;
        let hover = [&[10][..], &[0; 16]].concat();
        let mut said = String::new();
        for _ in 0..125 {
            assert_eq!(line.send(port::SETPOINT, &hover), None);
            line.pass(Duration::from_millis(200));
            said += &line.console();
        }
        assert_eq!(said.matches(why).count(), 3, "{said}");
        assert_eq!(said.lines().count(), 3, "{said}");
    }
}
