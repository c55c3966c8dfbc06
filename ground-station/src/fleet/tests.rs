//! Tests of both formats of fleet files: what is read, what is refused, and what a fleet that is
//! written as `crazyflies.yaml` is when it is read again.

use proptest::prelude::*;
use units::{Dbm, Metres, NodeId, Role, Volts};

use super::*;

fn parse(text: &str) -> Result<Fleet, String> {
    toml_file::parse(text, Path::new("fleet.toml")).map_err(|error| error.to_string())
}

fn yaml(text: &str) -> Result<Fleet, String> {
    crazyflies::parse(text, Path::new("crazyflies.yaml")).map_err(|error| error.to_string())
}

const BASE: &str = "[[drone]]\nnumber = 15\naddress = \"radio://0/80/2M/E7E7E7E70F\"\n";

#[test]
fn a_file_with_all_keys_is_read() {
    let text = format!(
        "[limits]\nlaunch_limit_dbm = -70.0\nretreat_limit_dbm = -76.0\nheight_m = 0.4\n\
         battery_v = 3.9\n[firmware]\nversion = \"uchain 0.1.0\"\nrevision = \"0A1b\"\n\
         [[drone]]\nnumber = 0\nname = \"Ada\"\naddress = \"udp://127.0.0.1:19850\"\n\
         role = \"head\"\ndecks = [\"flow\"]\n{BASE}"
    );
    let fleet = parse(&text).unwrap();
    assert_eq!(fleet.limits.launch, Some(Dbm(-70.0)));
    assert_eq!(fleet.limits.revision.as_deref(), Some("0a1b"));
    assert_eq!(fleet.drones[&NodeId(0)].decks, [Deck::Flow]);
    assert_eq!(fleet.drones[&NodeId(15)].decks, []);
    assert_eq!(fleet.name(NodeId(0)), "the head (Ada)");
    assert_eq!(fleet.name(NodeId(3)), "relay 3");
    assert_eq!(fleet.flying().collect::<Vec<_>>(), [NodeId(0)]);
}

/// The block of the book's chapter on the station that begins with this fence.
fn of_the_book(fence: &str) -> &'static str {
    let page = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/src/station.md"));
    let (_, block) = page.split_once(fence).unwrap();
    block.split_once("```").unwrap().0
}

#[test]
fn the_books_fleet_files_are_read() {
    let fleet = parse(of_the_book("```toml\n")).unwrap();
    assert_eq!(fleet.name(NodeId(0)), "the head (Ada)");
    assert_eq!(fleet.drones.len(), 3);
    assert_eq!(yaml(of_the_book("```yaml\n")).unwrap(), fleet);
}

#[test]
#[cfg(unix)]
fn a_file_that_never_ends_is_refused() {
    let error = Fleet::read(Path::new("/dev/zero")).unwrap_err().to_string();
    assert!(error.contains("more than 16 MiB") && error.contains("; give"), "{error}");
}

/// Each text is refused in one line that has all of these parts.
fn refuses(read: fn(&str) -> Result<Fleet, String>, cases: &[(String, &[&str])]) {
    for (text, parts) in cases {
        let error = read(text).unwrap_err();
        assert_eq!(error.lines().count(), 1, "{text}\n{error}");
        assert!(error.contains("; "), "there is no remedy: {error}");
        for part in *parts {
            assert!(error.contains(part), "no {part:?}:\n{text}\n{error}");
        }
    }
}

#[test]
fn what_is_wrong_in_toml_is_said_in_one_line() {
    let drone = |number: u8, rest: &str| {
        format!("[[drone]]\nnumber = {number}\naddress = \"udp://a:{}\"\n{rest}\n", number + 1)
    };
    let at = |address: &str| format!("{BASE}[[drone]]\nnumber = 1\naddress = \"{address}\"");
    let wrong: &[(String, &[&str])] = &[
        (String::new(), &["missing field"]),
        (drone(0, ""), &["no drone is the base"]),
        (drone(16, ""), &["fleet.toml:3: ", "there is no such number"]),
        (drone(1, "name = \"A\\u0007\""), &["control characters"]),
        (format!("[limits]\nheight_m = nan\n{BASE}"), &["height_m is NaN"]),
        (format!("{BASE}{BASE}"), &["two drones with the number 15"]),
        (format!("{BASE}{}", drone(3, "role = \"base\"")), &["both the base"]),
        (format!("{}{}", drone(1, "name = \"A\""), drone(2, "name = \"A\"")), &["the same name"]),
        (format!("{BASE}nmae = \"A\"\n"), &["fleet.toml:4: unknown field"]),
        (at("ten"), &["fleet.toml:6: ", "is no address"]),
        (at("radio://0/80/9M/E7E7E7E701"), &["fleet.toml:6: ", "\"9M\" for 250K, 1M or 2M"]),
        (at("radio://0/80/2M/E7E7E7E70F"), &["fleet.toml:6: ", "the same address"]),
        (at("radio://0/81/2M/E7E7E7E701"), &["fleet.toml:6: ", "the same channel"]),
    ];
    refuses(parse, wrong);
}

/// A file as crazyswarm2 has them, with these robots.
fn laboratory(robots: &str) -> String {
    format!(
        "fileversion: 3\nrobots:\n{robots}robot_types:\n  cf21:\n    motion_capture:\n      \
         tracking: vendor\n    big_quad: false\n    battery:\n      voltage_warning: 3.8\n  \
         marker:\n    connection: none\nall:\n  firmware_params:\n    stabilizer:\n      \
         estimator: 2\n  broadcasts:\n    num_repeats: 15\n"
    )
}

fn robot(name: &str, uri: &str, rest: &str) -> String {
    format!(
        "  {name}:\n    enabled: true\n    uri: {uri}\n    initial_position: [0.0, 0.0, 0.0]\n    \
         type: cf21\n{rest}"
    )
}

const HEAD: &str = "radio://0/80/2M/E7E7E7E700";
const LAST: &str = "radio://0/80/2M/E7E7E7E70F";

#[test]
fn a_laboratorys_file_is_read() {
    let disabled = "  cf9:\n    enabled: false\n    uri: none\n    type: bolt\n";
    let obstacle = "  wall:\n    enabled: true\n    type: marker\n    id: 255\n";
    let own = "    uchain: {number: 1, decks: {flow: true, multiranger: false}}\n";
    let text = laboratory(
        &[
            &robot("cf0", HEAD, ""),
            &robot("cf231", "radio://0/80/2M/E7E7E7E7E7", own),
            &robot("desk", LAST, ""),
            disabled,
            obstacle,
        ]
        .concat(),
    );
    let fleet = yaml(&text).unwrap();
    let numbers: Vec<u8> = fleet.drones.keys().map(|node| node.0).collect();
    assert_eq!(numbers, [0, 1, 15], "by the address, or by the file's own key");
    assert_eq!(fleet.name(NodeId(1)), "relay 1 (cf231)");
    assert_eq!(fleet.drones[&NodeId(1)].decks, [Deck::Flow]);
    assert_eq!(fleet.base().unwrap().name, "desk");
    assert_eq!(fleet.limits, Limits::default());
    assert_eq!(yaml(&text.replace("fileversion: 3\n", "")).unwrap(), fleet);
}

#[test]
fn what_is_wrong_in_yaml_is_said_in_one_line() {
    let two = |uri: &str| laboratory(&[robot("a", uri, ""), robot("b", LAST, "")].concat());
    let one = |rest: &str| laboratory(&robot("b", LAST, rest));
    let wrong: &[(String, &[&str])] = &[
        (two(LAST), &["crazyflies.yaml:10: ", "two drones with the number 15"]),
        (
            laboratory(
                &[robot("a", LAST, "    uchain: {number: 1}\n"), robot("b", LAST, "")].concat(),
            ),
            &["crazyflies.yaml:11: ", "drones 1 and 15 have the same address"],
        ),
        (two("radio://0/90/2M/E7E7E7E700"), &["drones 0 and 15 cannot hear", "the same channel"]),
        (two("radio://0/80/1M/E7E7E7E700"), &["drones 0 and 15 cannot hear", "the same data rate"]),
        (two("radio://0/80"), &["crazyflies.yaml:5: ", "is not a dongle"]),
        (two("usb://0"), &["crazyflies.yaml:5: ", "\"usb://0\" is no address"]),
        (two("radio://0/80/2M/E7E7E7E7E7"), &["crazyflies.yaml:5: ", "robot a ends in no number"]),
        (one("").replace("type: cf21", "type: cf12"), &[":7: ", "\"cf12\"", "did you mean cf21"]),
        (one("").replace("    type: cf21\n", ""), &[":4: ", "the robot b has no type"]),
        (one("").replace(&format!("    uri: {LAST}\n"), ""), &[":4: ", "the robot b has no uri"]),
        (one("").replace("enabled: true", "enabled: false"), &["no robot is enabled"]),
        (one("").replace("enabled: true", "enabled: 3"), &["crazyflies.yaml:4: "]),
        (one("").replace("version: 3", "version: 4"), &[":1: ", "fileversion 4 is newer than 3"]),
        (one("    uchain: {nmae: A}\n"), &["crazyflies.yaml:8: ", "nmae"]),
        (one("    uchain: {number: 16}\n"), &[":5: ", "there is no such number"]),
        (one("    uchain: {role: relay}\n"), &["no drone is the base", "role: base"]),
        (robot("b", LAST, ""), &["robots"]),
        ("robots: [".to_owned(), &["crazyflies.yaml:"]),
        (String::new(), &["crazyflies.yaml:1: "]),
    ];
    refuses(yaml, wrong);
}

#[test]
fn a_fleet_is_exported_into_a_new_file_only() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("crazyflies.yaml");
    let fleet = parse(BASE).unwrap();
    fleet.export(&file).unwrap();
    assert_eq!(Fleet::read(&file), Ok(fleet.clone()));
    let before = std::fs::read(&file).unwrap();
    let error = fleet.export(&file).unwrap_err().to_string();
    assert!(error.contains("there already") && error.lines().count() == 1, "{error}");
    assert_eq!(std::fs::read(&file).unwrap(), before);
    assert!(fleet.export(&folder.path().join("none/crazyflies.yaml")).is_err());
}

/// Names that YAML, ROS 2 or crazyswarm2 takes for something else.
const AWKWARD: [&str; 12] =
    ["", "all", "no", "~", "null", "1e3", "0x1F", "12:30", "- a", "a: b", "#1", "'\"\\"];

fn name() -> impl Strategy<Value = String> {
    let letters = prop::char::any().prop_filter("it is refused", |c| !c.is_control());
    prop_oneof![
        "[A-Za-z][A-Za-z0-9_]{0,10}",
        "cf[0-9]{1,2}x?",
        prop::sample::select(&AWKWARD[..]).prop_map(str::to_owned),
        prop::collection::vec(letters, 0..8).prop_map(String::from_iter),
    ]
}

fn limits() -> impl Strategy<Value = Limits> {
    let number = || prop::option::of(-100.0_f32..100.0);
    let text = || prop::option::of(prop_oneof!["[0-9]{4,12}", "[0-9]{4}\\.[0-9]{2}", "\\PC{0,9}"]);
    (number(), number(), number(), number(), text(), text(), text()).prop_map(
        |(launch, retreat, height, battery, version, revision, radio)| Limits {
            launch: launch.map(Dbm),
            retreat: retreat.map(Dbm),
            height: height.map(Metres),
            battery: battery.map(Volts),
            version,
            revision: revision.map(|digits| digits.to_lowercase()),
            radio,
        },
    )
}

/// A fleet whose drones have any numbers, of which the last is the base, and at most the first the
/// head.
fn fleet() -> impl Strategy<Value = Fleet> {
    let decks = prop::sample::subsequence(vec![Deck::Flow, Deck::Multiranger], 0..=2);
    let drones = prop::collection::btree_map(0_u8..16, (name(), decks, any::<bool>()), 1..16);
    (limits(), drones, any::<bool>()).prop_map(|(limits, drones, is_radio)| {
        let base = *drones.keys().next_back().unwrap();
        let mut fleet = Fleet { limits, ..Fleet::default() };
        for (number, (name, decks, is_usual)) in drones {
            let role = match number {
                _ if number == base => Role::Base,
                0 => Role::Head,
                _ => Role::Relay,
            };
            let address = match is_radio {
                true => format!("radio://0/80/2M/E7E7E7E7{:02X}", 200 - number),
                false => format!("udp://127.0.0.1:{}", 19_850 + u16::from(number)),
            };
            let decks = if is_usual { Deck::usual_of(role) } else { decks };
            let drone = FleetDrone { name, address: address.parse().unwrap(), role, decks };
            // Of drones with the same name the first belongs to the fleet, and the base always.
            let unnamed = FleetDrone { name: String::new(), ..drone.clone() };
            let node = NodeId(number);
            fleet.add(node, drone).or_else(|_| fleet.add(node, unnamed)).unwrap();
        }
        fleet
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_fleet_that_is_written_as_yaml_is_read_again_as_it_was(fleet in fleet()) {
        let text = export::text(&fleet).unwrap();
        prop_assert_eq!(yaml(&text), Ok(fleet), "{}", text);
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,60}") {
        let _ = yaml(&text);
        let _ = yaml(&laboratory(&text));
    }
}
