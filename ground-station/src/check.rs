//! Checks the drones of a fleet before a flight, one after the other, each by its own address, and
//! says in words what is not as the fleet file has it.

use std::fmt::Write as _;
use std::time::Duration;

use units::{Instant, NodeId, Role};

use crate::address::Way;
use crate::fleet::{Deck, Fleet, FleetDrone, Limits};
use crate::inspection::{Inspection, Told};
use crate::link::{Link, UdpLink};

/// The time after which a drone that has said nothing is taken for switched off.
const SILENT: Duration = Duration::from_secs(5);
/// The time between two looks at what is to be asked.
const TICK: Duration = Duration::from_millis(10);

/// The bits of `supervisor.info` (the book, "Log variables").
const CAN_FLY: u16 = 1 << 3;
const FLIES: u16 = 1 << 4;
const LOCKED: u16 = 1 << 6;

/// The step in which a drone stores and tells its limits is finer than this, dB and m.
const SAME: f32 = 0.05;

/// Checks all drones of a fleet. `print` is given the lines about each drone as soon as it was
/// asked. Returns the number of drones that are not as they must be.
pub async fn check(fleet: &Fleet, mut print: impl FnMut(&str)) -> usize {
    let mut wrong = 0;
    for (node, drone) in &fleet.drones {
        let (facts, deviations) = match ask(drone).await {
            Ok(told) => (facts(&told), deviations(*node, drone, &fleet.limits, &told)),
            Err(why) => (String::new(), vec![why]),
        };
        wrong += usize::from(!deviations.is_empty());
        print(&lines(*node, drone, &facts, &deviations));
    }
    wrong
}

/// Asks one drone; else says why it could not be asked.
async fn ask(drone: &FleetDrone) -> Result<Told, String> {
    let way: Way = drone.address.open().map_err(|error| error.to_string())?;
    let mut link = UdpLink::open(way.port)
        .await
        .map_err(|error| format!("there is no way to {} ({error})", drone.address))?;
    let began = std::time::Instant::now();
    let mut heard = began;
    let mut inspection = Inspection::default();
    loop {
        let micros = u64::try_from(began.elapsed().as_micros()).unwrap_or(u64::MAX);
        while let Some(packet) = inspection.poll(Instant::from_micros(micros)) {
            link.send(&packet).await;
        }
        if let Ok(packet) = tokio::time::timeout(TICK, link.receive()).await {
            heard = std::time::Instant::now();
            inspection.receive(&packet);
        }
        if let Some(told) = inspection.done() {
            return Ok(told.clone());
        }
        if heard.elapsed() > SILENT {
            return Err("it does not answer: switch it on, and check its address".to_owned());
        }
    }
}

/// What the drone is, in one line.
fn facts(told: &Told) -> String {
    let deck = |name| told.byte(name) == Some(1);
    let decks: Vec<&str> =
        [("deck.bcFlow2", Deck::Flow), ("deck.bcMultiranger", Deck::Multiranger)]
            .into_iter()
            .filter(|(name, _)| deck(name))
            .map(|(_, deck)| deck.name())
            .collect();
    let decks = if decks.is_empty() { "no decks".to_owned() } else { decks.join(", ") };
    let battery = match told.battery_v {
        volts if volts > 0.0 => format!("battery {volts:.2} V"),
        _ => "battery unknown".to_owned(),
    };
    let revision = told.revision().unwrap_or_else(|| "unknown".to_owned());
    let radio = told.radio().unwrap_or_else(|| "of no known release".to_owned());
    format!("{}, revision {revision}; radio chip {radio}; {decks}; {battery}", told.version)
}

/// What is not as it must be, each in words.
fn deviations(node: NodeId, drone: &FleetDrone, limits: &Limits, told: &Told) -> Vec<String> {
    let mut wrong = Vec::new();
    if told.byte("uchain.node") != Some(node.0) {
        let own = told.byte("uchain.node").map_or("none".to_owned(), |own| own.to_string());
        wrong.push(format!("its number is {own}: check the address, or provision it anew"));
    }
    let role = match drone.role {
        Role::Head => (0, "head"),
        Role::Relay => (1, "relay"),
        Role::Base => (2, "base"),
    };
    if told.byte("uchain.role") != Some(role.0) {
        wrong.push(format!("it is not the {}: provision it anew", role.1));
    }
    wrong.extend(firmware(limits, told));
    for (wanted, name, words, unit) in [
        (limits.launch.map(|limit| limit.0), "uchain.launchLimit", "launch limit", "dBm"),
        (limits.retreat.map(|limit| limit.0), "uchain.retreatLimit", "retreat limit", "dBm"),
        (limits.height.map(|height| height.0), "uchain.height", "height", "m"),
    ] {
        let Some(wanted) = wanted else { continue };
        match told.float(name) {
            Some(own) if (own - wanted).abs() <= SAME => {}
            Some(own) => wrong.push(format!(
                "its {words} is {own} {unit}, the file's {wanted} {unit}: {}",
                remedy(name)
            )),
            None => wrong.push(format!("it has no {name}")),
        }
    }
    for deck in &drone.decks {
        let name = match deck {
            Deck::Flow => "deck.bcFlow2",
            Deck::Multiranger => "deck.bcMultiranger",
        };
        if told.byte(name) != Some(1) {
            wrong.push(format!("the {} is missing: check its pins", deck.name()));
        }
    }
    wrong.extend(readiness(drone, limits, told));
    wrong
}

/// How a drone is given another limit or another height.
fn remedy(name: &str) -> String {
    let with_keys = match name {
        "uchain.height" => "",
        _ => ", and later by a page of `uchain keys provision --limits`",
    };
    format!("{name} can be set while it has no keys{with_keys}")
}

fn firmware(limits: &Limits, told: &Told) -> Vec<String> {
    let mut wrong = Vec::new();
    if let Some(version) = limits.version.as_ref().filter(|version| **version != told.version) {
        wrong.push(format!("its firmware is {:?}, the file's {version:?}", told.version));
    }
    let own = told.revision().unwrap_or_default();
    if let Some(revision) = limits.revision.as_ref().filter(|revision| !agree(&own, revision)) {
        wrong.push(format!("its revision is {own}, the file's {revision}"));
    }
    let own = told.radio().unwrap_or_else(|| "unknown".to_owned());
    if let Some(radio) = limits.radio.as_ref().filter(|radio| **radio != own) {
        wrong.push(format!("its radio chip's firmware is {own}, the file's {radio}"));
    }
    wrong
}

/// Whether a revision that a drone tells and one that may be longer or shorter begin alike.
fn agree(own: &str, wanted: &str) -> bool {
    own.starts_with(wanted) || (!own.is_empty() && wanted.starts_with(own))
}

/// Whether the drone would take off now. The base never does.
fn readiness(drone: &FleetDrone, limits: &Limits, told: &Told) -> Vec<String> {
    let mut wrong = Vec::new();
    let volts = told.battery_v;
    if let Some(least) = limits.battery.filter(|least| volts > 0.0 && volts < least.0) {
        wrong.push(format!("its battery has {volts:.2} V, less than {:.2} V: charge it", least.0));
    }
    if drone.role == Role::Base {
        return wrong;
    }
    match told.supervisor {
        info if info & LOCKED != 0 => {
            wrong.push("its motors are off for good: switch it off and on".to_owned());
        }
        info if info & FLIES != 0 => wrong.push("it flies".to_owned()),
        info if info & CAN_FLY == 0 => {
            wrong.push("it is not ready to fly: its green LED says why".to_owned());
        }
        _ => {}
    }
    // A board or a radio chip with which it does not fly.
    let complaint = told.console.lines().find(|line| line.contains("no flight"));
    wrong.extend(complaint.map(|line| format!("it says: {}", line.trim())));
    wrong
}

fn lines(node: NodeId, drone: &FleetDrone, facts: &str, deviations: &[String]) -> String {
    let part = match drone.role {
        Role::Head => "head",
        Role::Relay => "relay",
        Role::Base => "base",
    };
    let name = if drone.name.is_empty() { String::new() } else { format!(" {}", drone.name) };
    let mut text = format!("{node}{name}, {part}, {}", drone.address);
    // Writing to a string cannot fail.
    if !facts.is_empty() {
        let _ = write!(text, "\n  {facts}");
    }
    if deviations.is_empty() {
        text.push_str("\n  as the file has it");
    }
    for deviation in deviations {
        let _ = write!(text, "\n  WRONG: {deviation}");
    }
    text
}

#[cfg(test)]
mod tests {
    use crtp::Parameters;
    use units::{Dbm, Volts};
    use wire::syslink::Release;

    use super::*;
    use crate::inspection::tests::inspect;

    /// What a relay on the bench tells: number 3, with a Flow deck, launch limit −70 dBm.
    fn told(console: &str) -> Told {
        let mut parameters = Parameters::DEFAULT;
        (parameters.about.node, parameters.about.role) = (NodeId(3), Role::Relay);
        (parameters.launch_limit, parameters.retreat_limit) = (Dbm(-70.0), Dbm(-76.0));
        (parameters.about.has_flow, parameters.about.has_rangers) = (true, false);
        parameters.about.revision = 0x0123_4567_89AB;
        parameters.about.radio = Some(Release { year: 2025, month: 2 });
        let mut told = inspect(parameters);
        console.clone_into(&mut told.console);
        told
    }

    fn relay() -> FleetDrone {
        FleetDrone {
            name: "Ada".into(),
            address: "udp://127.0.0.1:1".parse().unwrap(),
            role: Role::Relay,
            decks: vec![Deck::Flow],
        }
    }

    #[test]
    fn a_drone_that_is_as_its_file_says_has_no_deviation() {
        let limits = Limits {
            launch: Some(Dbm(-70.0)),
            retreat: Some(Dbm(-76.0)),
            revision: Some("0123456789abcdef".into()),
            radio: Some("2025.02".into()),
            ..Limits::default()
        };
        assert_eq!(deviations(NodeId(3), &relay(), &limits, &told("")), [""; 0]);
    }

    #[test]
    fn each_deviation_is_said_in_words() {
        let all = [Deck::Flow, Deck::Multiranger];
        let decks = FleetDrone { decks: all.to_vec(), ..relay() };
        let base = FleetDrone { role: Role::Base, ..relay() };
        let none = Limits::default;
        let limit = Limits { launch: Some(Dbm(-72.0)), ..none() };
        let old = Limits { revision: Some("ffff".into()), ..none() };
        let chips = Limits { radio: Some("2025.09".into()), ..none() };
        let low = Limits { battery: Some(Volts(3.9)), ..none() };
        let chip = "The radio chip needs firmware 2022.01 or newer: no flight.\n";
        let (mut weak, mut locked) = (told(""), told(""));
        (weak.battery_v, locked.supervisor) = (3.6, LOCKED);
        let cases = [
            (deviations(NodeId(2), &relay(), &none(), &told("")), "its number is 3"),
            (deviations(NodeId(3), &base, &none(), &told("")), "it is not the base"),
            (deviations(NodeId(3), &decks, &none(), &told("")), "Multi-ranger deck is missing"),
            (deviations(NodeId(3), &relay(), &limit, &told("")), "launch limit is -70 dBm"),
            (deviations(NodeId(3), &relay(), &old, &told("")), "its revision is 0123456789ab"),
            (deviations(NodeId(3), &relay(), &chips, &told("")), "chip's firmware is 2025.02"),
            (deviations(NodeId(3), &relay(), &low, &weak), "its battery has 3.60 V"),
            (deviations(NodeId(3), &relay(), &none(), &locked), "motors are off for good"),
            (deviations(NodeId(3), &relay(), &none(), &told(chip)), "firmware 2022.01"),
        ];
        for (found, wanted) in cases {
            assert_eq!(found.len(), 1, "{wanted}: {found:?}");
            assert!(found[0].contains(wanted), "{wanted}: {found:?}");
        }
    }
}
