//! The parameters that cfclient's tabs set of their own accord (cfclient 2026.8.1): it prints a
//! traceback, and the click does nothing, for each that is missing or that may not be set.

use crate::common::{Line, port};
use crtp::Access;

/// `ui/tabs/ConsoleTab.py` and `ui/tabs/FlightTab.py`.
const BUTTONS: [&str; 6] = [
    "system.taskDump",
    "system.storageStats",
    "health.startPropTest",
    "health.startBatTest",
    "commander.enHighLevel",
    "flightmode.althold",
];
const READ_ONLY: u8 = 0x40;

/// The sliders of `ui/tabs/TuningTab.py`: group, names before the gain, names of the gains.
fn sliders() -> Vec<String> {
    let groups: [(&str, &[&str], &[&str]); 6] = [
        ("pid_rate", &["roll", "pitch", "yaw"], &["_kp", "_ki", "_kd"]),
        ("pid_attitude", &["roll", "pitch", "yaw"], &["_kp", "_ki", "_kd"]),
        ("posCtlPid", &["x", "y", "z"], &["Kp", "Ki", "Kd"]),
        ("posCtlPid", &["thrustBase"], &[""]),
        ("velCtlPid", &["vx", "vy"], &["Kp", "Ki", "Kd", "KFF"]),
        ("velCtlPid", &["vz"], &["Kp", "Ki", "Kd"]),
    ];
    let mut names = Vec::new();
    for (group, loops, gains) in groups {
        for of in loops {
            names.extend(gains.iter().map(|gain| format!("{group}.{of}{gain}")));
        }
    }
    assert_eq!(names.len(), 39);
    names
}

#[test]
fn what_a_tab_sets_is_there_and_may_be_set() {
    let table = Line::new().table(port::PARAM_TABLE);
    for wanted in sliders().iter().map(String::as_str).chain(BUTTONS) {
        let row = table.iter().find(|(_, group, name)| format!("{group}.{name}") == wanted);
        let (kind, ..) = row.unwrap_or_else(|| panic!("{wanted} is missing"));
        assert_eq!(kind & READ_ONLY, 0, "{wanted} is read-only");
    }
}

/// The answer to a slider that was moved is the gain that flies; *Default values* waits for each
/// default.
#[test]
fn a_gain_stays_what_it_is_and_is_its_own_default() {
    for access in [Access::Full, Access::Read] {
        let mut line = Line::new();
        line.access = access;
        for name in sliders() {
            let id = line.id_of(port::PARAM_TABLE, &name);
            let value = line.ask(port::PARAM_READ, &id)[3..].to_vec();
            let other: Vec<_> = value.iter().map(|byte| byte ^ 1).collect();
            let answer = line.ask(port::PARAM_WRITE, &[&id[..], &other].concat());
            assert_eq!(answer, [&id[..], &value].concat(), "{name}");
            let default = line.ask(0x2F, &[&[8][..], &id].concat());
            assert_eq!(default, [&[8][..], &id, &[0], &value].concat(), "{name}");
        }
    }
}

#[test]
fn the_gains_are_those_of_the_flight_code_in_the_crazyflies_units() {
    let mut line = Line::new();
    for (name, gain) in [
        ("pid_rate.roll_kp", 250.0_f32),
        ("pid_rate.pitch_kd", 2.5),
        ("pid_rate.yaw_ki", 16.7),
        ("pid_attitude.yaw_kd", 0.35),
        ("posCtlPid.xKp", flight::ControlConfig::DEFAULT.way),
        ("posCtlPid.zKp", 2.0),
        ("velCtlPid.vyKp", 25.0),
        ("velCtlPid.vzKi", 15.0),
    ] {
        let id = line.id_of(port::PARAM_TABLE, name);
        assert_eq!(line.ask(port::PARAM_READ, &id)[3..], gain.to_le_bytes(), "{name}");
    }
}

/// A button of the *Console* tab sets a 1, and finds that it is a 0 still.
#[test]
fn a_button_does_nothing_and_the_console_says_so() {
    for name in &BUTTONS[..4] {
        let mut line = Line::new();
        let [a, b] = line.id_of(port::PARAM_TABLE, name);
        assert_eq!(line.send(port::PARAM_WRITE, &[a, b, 1]), None, "{name}");
        let (header, answer) = line.next().unwrap();
        assert_eq!((header, &*answer), (port::PARAM_WRITE, &[a, b, 0][..]), "{name}");
        assert!(line.console().contains("Refused: a parameter is read-only"), "{name}");
    }
}
