//! The book's tables of bytes tell the truth: messages are encoded by the code and read back by the
//! tables of `docs/src/air.md`, row by row. And the tables beside the code are the same.

use crate::messages;
use crate::messages::Numbers;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use units::{Branch, Course, LinkSum, MissionKind, NodeId, Order, Payload, Phase, Role, Signpost};
use wire::p2p::{
    Beacon, Capsule, Commands, Counter, Epoch, HEADER, Header, Heard, Kind, MAX_BODY, Membership,
    Message, MissionMessage, PORT, Report, TAG, Telemetry, Wave,
};
use wire::syslink::MAX_P2P;

const BOOK: &str = include_str!("../../../../docs/src/air.md");

/// The fields of a message with their values.
type Fields = Vec<(&'static str, Value)>;

enum Value {
    /// This number, in steps.
    Steps(i64),
    /// This number, which the table says as well.
    Constant(i64),
    /// This number in the unit without its prefix, to half a step.
    Measured(f32),
    /// The name that the table gives the value.
    Called(&'static str),
    /// These bytes.
    Bytes(Vec<u8>),
}

use Value::{Bytes, Called, Constant, Measured, Steps};

/// A row of a table.
#[derive(Clone, Debug)]
struct Row {
    /// From which bit to which, counted from the beginning.
    bits: std::ops::Range<usize>,
    signed: bool,
    /// Of the field; `None` where all bits are zero.
    field: Option<String>,
    what: String,
    unit: String,
}

impl Row {
    /// `None` where it is of bytes that this message has not.
    fn read(line: &str, letters: usize, length: usize) -> Result<Option<Self>, String> {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [byte, kind, field, what, unit] = cells[..] else {
            return Err(format!("{line} has not five cells"));
        };
        let kind = kind.replace(['`'], "");
        let byte = number(&byte.replace('`', "").replace('N', &letters.to_string()))?;
        if byte >= length {
            return Ok(None);
        }
        let (from, to) = match kind.rsplit_once(' ') {
            Some(("bit", bit)) => (number(bit)?, number(bit)? + 1),
            Some(("bits", bits)) => {
                let (from, to) = bits.split_once('–').ok_or("bits from where to where?")?;
                (number(from)?, number(to)? + 1)
            }
            Some(("0 to 24" | "0 to 43", "bytes")) => (0, 8 * (length - byte)),
            Some((count, "bytes")) => (0, 8 * number(&count.replace('N', &letters.to_string()))?),
            None => (0, number(kind.get(1..).unwrap_or_default())?),
            _ => return Err(format!("what is a {kind}?")),
        };
        Ok(Some(Self {
            bits: 8 * byte + from..8 * byte + to,
            signed: kind.starts_with('i'),
            field: match field {
                "zero" => None,
                field => Some(field.trim_matches('`').to_owned()),
            },
            what: what.to_owned(),
            unit: unit.to_owned(),
        }))
    }

    /// The value that the row reads from these bytes, in steps.
    fn steps(&self, bytes: &[u8]) -> i64 {
        let bits = self.bits.clone().rev();
        let sum = bits.fold(0, |sum, bit| sum << 1 | i64::from(bytes[bit / 8] >> (bit % 8) & 1));
        let width = self.bits.len();
        if self.signed && sum >> (width - 1) == 1 { sum - (1 << width) } else { sum }
    }

    fn agrees(&self, bytes: &[u8], value: &Value) -> bool {
        match value {
            Steps(steps) => self.steps(bytes) == *steps,
            Constant(steps) => self.steps(bytes) == *steps && self.what == steps.to_string(),
            Measured(measured) => {
                let step = step(&self.unit);
                let said = self.steps(bytes) as f64 * step;
                // And a little: f32s are rounded too.
                let little = 1e-6 * f64::from(measured.abs()) + 1e-6;
                (said - f64::from(*measured)).abs() <= 0.5 * step.abs() + little
            }
            Called(name) => {
                let called = format!("{} {name}", self.steps(bytes));
                self.what.split(',').any(|choice| choice.trim() == called)
            }
            Bytes(expected) => bytes[self.bits.start / 8..self.bits.end / 8] == expected[..],
        }
    }
}

fn number(text: &str) -> Result<usize, String> {
    let sum = text.split('+').map(|part| part.trim().parse::<usize>());
    sum.sum::<Result<_, _>>().map_err(|_| format!("{text} is no number"))
}

/// A step, in the unit without its prefix.
fn step(unit: &str) -> f64 {
    match unit {
        "1 mm/s" => 0.001,
        "4 mm/s" => 0.004,
        "1 cm/s" => 0.01,
        "2 cm" => 0.02,
        "0.1 m" => 0.1,
        "1/16 m" => 1.0 / 16.0,
        "1/512 m" => 1.0 / 512.0,
        "1/4 dBm" => 0.25,
        "−1 dBm" => -1.0,
        "1/1024 m/dB" => 1.0 / 1024.0,
        "20 mV" => 0.02,
        "4 s" => 4.0,
        _ => f64::NAN,
    }
}

/// The lines of the table under this heading of the book.
fn table(heading: &str) -> Vec<&'static str> {
    let mut lines = BOOK.lines().skip_while(|line| line.trim_start_matches('#').trim() != heading);
    assert!(lines.next().is_some(), "the book has no heading {heading}");
    let section = lines.take_while(|line| !line.starts_with('#'));
    section.filter(|line| line.starts_with("| ")).skip(1).collect()
}

/// Whether the table has a row for each field of the message and each bit, and all of them are
/// true.
fn check(
    lines: &[&str],
    letters: usize,
    bytes: &[u8],
    fields: &[(&'static str, Value)],
) -> Result<(), String> {
    let rows = lines.iter().filter_map(|line| Row::read(line, letters, bytes.len()).transpose());
    let rows = rows.collect::<Result<Vec<Row>, _>>()?;
    let end = rows.iter().try_fold(0, |end, row| match row.bits.start == end {
        true => Ok(row.bits.end),
        false => Err(format!("a gap or an overlap before {row:?}")),
    })?;
    if end != 8 * bytes.len() {
        return Err(format!("the table ends after {end} bits of {}", 8 * bytes.len()));
    }
    let mut fields: Vec<_> = fields.iter().collect();
    for row in rows {
        let value = match &row.field {
            None => &Steps(0),
            Some(name) => {
                let at = fields.iter().position(|(field, _)| field == name);
                &fields.swap_remove(at.ok_or(format!("there is no field {name}"))?).1
            }
        };
        if !row.agrees(bytes, value) {
            return Err(format!("{row:?} is not what {bytes:02x?} say"));
        }
    }
    match fields.first() {
        Some((field, _)) => Err(format!("{field} has no row")),
        None => Ok(()),
    }
}

fn body(message: &Message) -> Vec<u8> {
    let mut out = [0; MAX_BODY];
    let length = message.encode(&mut out);
    out[..length].to_vec()
}

fn node(node: NodeId) -> Value {
    Steps(node.0.into())
}

fn flag(set: bool) -> Value {
    Steps(set.into())
}

fn measured(value: Option<f32>, none: i64) -> Value {
    value.map_or(Steps(none), Measured)
}

fn count(counter: Counter) -> [(&'static str, Value); 2] {
    let epoch = counter.epoch().get();
    [("count", Steps(counter.count().into())), ("epoch", Steps(epoch.into()))]
}

fn of_header(header: &Header) -> Fields {
    let kind = match header.kind {
        Kind::Beacon => "beacon",
        Kind::Report => "report",
        Kind::Command => "command",
        Kind::Telemetry => "telemetry",
        Kind::Membership => "membership",
        Kind::Mission => "mission",
    };
    let wave = match header.wave {
        Wave::Outward => "outward",
        Wave::Inward => "inward",
    };
    let mut fields = vec![
        ("kind", Called(kind)),
        ("version", Constant(6)),
        ("from", node(header.from)),
        ("wave", Called(wave)),
        ("place", Steps(header.place.into())),
        ("turn", Steps((header.owner.0 / 6).into())),
    ];
    fields.extend(count(header.counter));
    fields
}

fn of_beacon(beacon: &Beacon) -> Fields {
    let role = match beacon.role {
        Role::Head => "head",
        Role::Relay => "relay",
        Role::Base => "base",
    };
    vec![
        ("role", Called(role)),
        ("state", Steps(beacon.state.into())),
        ("battery", measured(beacon.battery.map(|battery| battery.0), 0)),
    ]
}

fn of_heard(heard: &Heard) -> Fields {
    vec![
        ("node", node(heard.node)),
        ("rssi", Measured(heard.rssi.0)),
        ("is_new", flag(heard.is_new)),
        ("epoch", Steps(heard.epoch.get().into())),
    ]
}

/// The bytes after the first 20 are the entries, by [`of_signpost`] and [`of_heard`].
fn of_report(report: &Report, bytes: &[u8]) -> Fields {
    let phase = match report.phase {
        Phase::Waiting => "waiting",
        Phase::Transit => "transit",
        Phase::Linked if report.is_uneven => "linked and `is_uneven`",
        Phase::Linked => "linked",
        Phase::Base => "base",
        Phase::Out => "out",
        Phase::Searching => "searching",
        Phase::Perched => "perched",
    };
    let [front, back] = report.sums;
    let links = |sum: LinkSum| Steps(sum.links.into());
    let mut fields = vec![
        ("phase", Called(phase)),
        ("recall", flag(report.recall)),
        ("calls", flag(report.calls)),
        ("has_signpost", flag(report.signpost.is_some())),
        ("velocity", Measured(report.velocity.0)),
        ("odometer", Measured(report.odometer.0)),
        ("weakest", measured(report.links.map(|links| links.weakest.0), 0)),
        ("strongest", measured(report.links.map(|links| links.strongest.0), 0)),
        ("front_surplus", Measured(front.surplus.0)),
        ("front_compliance", Measured(front.compliance.0)),
        ("front_links", links(front)),
        ("back_surplus", Measured(back.surplus.0)),
        ("back_compliance", Measured(back.compliance.0)),
        ("back_links", links(back)),
        ("waiting", Steps(report.waiting.into())),
        ("head_velocity", Measured(report.head_velocity.0)),
    ];
    if bytes.len() > 20 {
        fields.push(("entries", Bytes(bytes[20..].to_vec())));
    }
    fields
}

fn of_capsule<const N: usize>(capsule: &Capsule<N>) -> Fields {
    let mut fields = vec![
        ("node", node(capsule.node)),
        ("sealed", Bytes(capsule.sealed.to_vec())),
        ("tag", Bytes(capsule.tag.to_vec())),
    ];
    fields.extend(count(capsule.counter));
    fields
}

const fn of_branch(branch: Option<Branch>) -> Value {
    Called(match branch {
        None => "none",
        Some(Branch::Left) => "left",
        Some(Branch::Right) => "right",
        Some(Branch::Straight) => "straight",
    })
}

fn of_signpost(post: &Signpost) -> Fields {
    vec![
        ("revision", Steps(post.revision.into())),
        ("index", Steps(post.index.into())),
        ("last", Steps((post.count - 1).into())),
        ("branch", of_branch(post.branch)),
        ("from", Measured(post.from.0)),
    ]
}

fn of_task(task: &Order) -> Fields {
    let (name, speed, branch) = match task {
        Order::Wait => ("wait", None, None),
        Order::Explore(Course { speed, branch }) => ("explore", Some(speed.0), *branch),
        Order::Return => ("return", None, None),
        Order::Land => ("land", None, None),
        Order::Stop => ("stop", None, None),
        Order::Perch => ("perch", None, None),
    };
    vec![("order", Called(name)), ("speed", measured(speed, 0)), ("branch", of_branch(branch))]
}

fn of_telemetry(telemetry: &Telemetry) -> Fields {
    let Telemetry { front, back, .. } = telemetry;
    let who = |there: bool| Called(if there { "present" } else { "absent" });
    vec![
        ("state", Steps(telemetry.state.into())),
        ("fault", Steps(telemetry.fault.into())),
        ("battery", measured(telemetry.battery.map(|battery| battery.0), 0)),
        ("endurance", measured(telemetry.endurance.map(|time| time.as_secs_f32()), 255)),
        ("front", who(front.is_some())),
        ("front_node", front.map_or(Steps(0), |(front, _)| node(front))),
        ("front_link", measured(front.map(|(_, link)| link.0), 0)),
        ("back", who(back.is_some())),
        ("back_node", back.map_or(Steps(0), |(back, _)| node(back))),
        ("back_link", measured(back.map(|(_, link)| link.0), 0)),
        ("odometer", Measured(telemetry.odometer.0)),
        ("velocity", Measured(telemetry.velocity.0)),
        ("height", measured(telemetry.height.map(|height| height.0), 255)),
        ("heeded", Steps(telemetry.heeded.into())),
    ]
}

fn of_membership(membership: &Membership) -> Fields {
    match membership {
        Membership::Join => vec![("change", Called("join"))],
        Membership::Leave => vec![("change", Called("leave"))],
        Membership::Refused { node: who, epoch } => vec![
            ("change", Called("refused")),
            ("node", node(*who)),
            ("epoch", Steps(epoch.get().into())),
        ],
    }
}

fn of_mission(message: &MissionMessage) -> Fields {
    let mut fields = vec![("mission", Called(message.mission.name()))];
    let payload = message.payload.as_bytes();
    if !payload.is_empty() {
        fields.push(("payload", Bytes(payload.to_vec())));
    }
    fields
}

/// A message's bytes and what they say; and the `N` of the table.
type Sample = (usize, Vec<u8>, Fields);

fn samples<T: std::fmt::Debug>(
    strategy: impl Strategy<Value = T>,
    sample: impl Fn(&T) -> Sample,
) -> Vec<Sample> {
    let seeded = Config { rng_seed: RngSeed::Fixed(1), ..Config::default() };
    let mut runner = TestRunner::new(seeded);
    (0..500).map(|_| sample(&strategy.new_tree(&mut runner).unwrap().current())).collect()
}

/// Each table of the book by its heading, the file and type beside which it stands in the code, and
/// 500 messages to read with it.
fn tables() -> Vec<(&'static str, &'static str, &'static str, Vec<Sample>)> {
    const NUMBERS: Numbers = Numbers::Flying;
    let header = include_str!("../../src/p2p/header.rs");
    let capsule = include_str!("../../src/p2p/capsule.rs");
    let report = include_str!("../../src/p2p/report.rs");
    let order = include_str!("../../src/p2p/order.rs");
    let mut capsules = samples(messages::capsules(NUMBERS), |capsule| {
        (4, body(&Message::Command((*capsule).into())), of_capsule(capsule))
    });
    capsules.extend(samples(messages::capsules(NUMBERS), |capsule| {
        (14, body(&Message::Telemetry(*capsule)), of_capsule(capsule))
    }));
    let heard = samples(messages::heard(NUMBERS), |heard| {
        let heard_alone = Report { heard: heapless::Vec::from_iter([*heard]), ..messages::SILENT };
        (0, body(&Message::Report(heard_alone))[20..].to_vec(), of_heard(heard))
    });
    vec![
        (
            "Header",
            header,
            "struct Header",
            samples(messages::headers(NUMBERS), |header| {
                (0, header.encode().to_vec(), of_header(header))
            }),
        ),
        (
            "Beacon",
            include_str!("../../src/p2p/beacon.rs"),
            "struct Beacon",
            samples(messages::beacons(NUMBERS), |beacon| {
                (0, body(&Message::Beacon(*beacon)), of_beacon(beacon))
            }),
        ),
        (
            "Report",
            report,
            "struct Report",
            samples(messages::reports(NUMBERS), |report| {
                let bytes = body(&Message::Report(report.clone()));
                let fields = of_report(report, &bytes);
                (0, bytes, fields)
            }),
        ),
        ("Heard", report, "struct Heard", heard),
        (
            "Signpost",
            include_str!("../../src/p2p/signpost.rs"),
            "fn encode_signpost",
            samples(messages::signposts(NUMBERS), |post| {
                (0, wire::p2p::encode_signpost(*post).unwrap().to_vec(), of_signpost(post))
            }),
        ),
        ("Capsule", capsule, "struct Capsule", capsules),
        (
            "Command",
            order,
            "fn encode_order",
            samples(messages::tasks(NUMBERS), |task| {
                (0, wire::p2p::encode_order(*task).to_vec(), of_task(task))
            }),
        ),
        (
            "Telemetry",
            capsule,
            "struct Telemetry",
            samples(messages::telemetry(NUMBERS), |telemetry| {
                (0, telemetry.encode().to_vec(), of_telemetry(telemetry))
            }),
        ),
        (
            "Membership",
            include_str!("../../src/p2p/membership.rs"),
            "enum Membership",
            samples(messages::memberships(NUMBERS), |membership| {
                (0, body(&Message::Membership(*membership)), of_membership(membership))
            }),
        ),
        (
            "Mission",
            include_str!("../../src/p2p/mission.rs"),
            "struct MissionMessage",
            samples(messages::missions(), |message| {
                (0, body(&Message::Mission(*message)), of_mission(message))
            }),
        ),
    ]
}

#[test]
fn the_tables_of_the_book_are_true_row_by_row() {
    for (heading, _, _, samples) in tables() {
        let lines = table(heading);
        for (letters, bytes, fields) in samples {
            if let Err(error) = check(&lines, letters, &bytes, &fields) {
                panic!("docs/src/air.md, {heading}: {error}");
            }
        }
    }
}

/// Another byte, type, field, code or unit, or a row too few, is found.
#[test]
fn a_row_that_lies_is_found() {
    let lies = [
        ("| 0 |", "| 1 |"),
        ("| 3 |", "| 2 |"),
        ("`u8`", "`u16`"),
        ("`i16`", "`u16`"),
        ("`i24`", "`u24`"),
        ("`i8`", "`u8`"),
        ("bits 0–", "bits 1–"),
        ("bit 4", "bit 3"),
        ("_node`", "_link`"),
        ("`epoch`", "`count`"),
        ("`weakest`", "`strongest`"),
        ("`front`", "`back`"),
        ("`front_", "`back_"),
        ("_surplus`", "_compliance`"),
        ("`is_new`", "`is_old`"),
        ("`head_velocity`", "`velocity`"),
        ("zero", "`spare`"),
        ("1 wait, 2 explore", "2 wait, 1 explore"),
        ("1 wait, 2 explore", "1 wait"),
        ("1 left, 2 right", "2 left, 1 right"),
        ("`calls`", "`recall`"),
        ("7 linked", "2 linked"),
        ("2 linked", "7 linked"),
        ("`has_signpost`", "`calls`"),
        ("0 head", "0 tail"),
        ("4 telemetry", "6 telemetry"),
        ("1 mm/s", "1 cm/s"),
        ("1 cm/s", "1 mm/s"),
        ("2 cm", "1 cm/s"),
        ("1/512 m", "0.1 m"),
        ("1/16 m", "1/512 m"),
        ("1/1024 m/dB", "1/512 m"),
        ("4 mm/s", "1 mm/s"),
        ("1/4 dBm", "−1 dBm"),
        ("−1 dBm", "1/4 dBm"),
        ("20 mV", "4 s"),
        ("4 s", "2 cm"),
    ];
    let mut untold = Vec::from(lies);
    for (heading, _, _, samples) in tables() {
        let lines = table(heading);
        let found = |lines: &[&str]| {
            samples.iter().any(|(n, bytes, fields)| check(lines, *n, bytes, fields).is_err())
        };
        assert!(!found(&lines), "{heading}");
        for (at, line) in lines.iter().enumerate() {
            let without = [&lines[..at], &lines[at + 1..]].concat();
            assert!(found(&without), "{heading} without {line}");
            for (truth, lie) in lies {
                if !line.contains(truth) {
                    continue;
                }
                untold.retain(|other| *other != (truth, lie));
                let lied = line.replacen(truth, lie, 1);
                let mut with = lines.clone();
                with[at] = &lied;
                assert!(found(&with), "{heading} with {lied}");
            }
        }
    }
    assert!(untold.is_empty(), "not in any table: {untold:?}");
}

#[test]
fn the_tables_beside_the_code_are_those_of_the_book() {
    for (heading, source, item, _) in tables() {
        let before = source.split(&format!("pub {item}")).next().unwrap();
        let comment: Vec<&str> =
            before.lines().rev().skip_while(|line| !line.starts_with("///")).collect();
        let comment = comment.into_iter().take_while(|line| line.starts_with("///"));
        let mut rows: Vec<&str> = comment
            .filter_map(|line| line.strip_prefix("/// "))
            .filter(|line| line.starts_with("| "))
            .collect();
        rows.reverse();
        assert_eq!(rows[1..], table(heading), "{item} and {heading} of docs/src/air.md");
    }
}

/// The sizes, from messages of every kind.
#[test]
fn the_sizes_in_the_book_are_those_of_the_code() {
    let heard = |count: u8| {
        let one = |node| Heard {
            node: NodeId(node),
            rssi: units::Dbm(-60.0),
            is_new: true,
            epoch: Epoch::FIRST,
        };
        Message::Report(Report { heard: (0..count).map(one).collect(), ..messages::SILENT })
    };
    let (node, counter) = (NodeId(1), Counter::new(wire::p2p::Epoch::FIRST, 0).unwrap());
    let refused = Membership::Refused { node, epoch: Epoch::FIRST };
    let payload = Payload::new(&[0; Payload::MOST]).unwrap();
    let full = MissionMessage { mission: MissionKind::Swarm, payload };
    let command = Capsule { node, counter, sealed: [0; 4], tag: [0; TAG] };
    let second = Some(Capsule { node: NodeId(2), ..command });
    let telemetry = Capsule { node, counter, sealed: [0; 14], tag: [0; TAG] };
    let post = Signpost { revision: 0, index: 0, count: 1, from: units::Metres(0.0), branch: None };
    let Message::Report(report) = heard(4) else { panic!() };
    let posted = Message::Report(Report { signpost: Some(post), ..report });
    let sizes = [
        (
            1,
            "[beacon](#beacon)",
            Message::Beacon(Beacon { role: Role::Base, state: 0, battery: None }),
        ),
        (2, "[report](#report), no node heard", heard(0)),
        (2, "[report](#report), four nodes heard", heard(4)),
        (2, "[report](#report), four nodes heard, with a signpost", posted),
        (3, "[command](#command)", Message::Command(command.into())),
        (3, "[command](#command), two", Message::Command(Commands { first: command, second })),
        (4, "[telemetry](#telemetry)", Message::Telemetry(telemetry)),
        (5, "[membership](#membership), join or leave", Message::Membership(Membership::Join)),
        (5, "[membership](#membership), refused", Message::Membership(refused)),
        (6, "[mission](#mission), full", Message::Mission(full)),
    ];
    let rows: Vec<String> = sizes
        .iter()
        .map(|(kind, name, message)| {
            let (body, packet) = (body(message).len(), HEADER + body(message).len() + TAG);
            let share = (100.0 * packet as f64 / MAX_P2P as f64).round();
            format!("| {kind} | {name} | {body} | {packet} | {share} % |")
        })
        .collect();
    let in_book: Vec<&str> = table("A packet")
        .iter()
        .map(|line| &line[..line.rfind(" %").unwrap() + " % |".len()])
        .collect();
    assert_eq!(in_book, rows);
    assert!(BOOK.contains(&format!("carries at most {MAX_P2P} bytes")));
    assert!(BOOK.contains(&format!("go through port {PORT}.")));
    assert!(
        BOOK.contains(&format!("header, {HEADER}  ")) && BOOK.contains(&format!("tag, {TAG}  "))
    );
    assert!(BOOK.contains(&format!("body, 1 to {MAX_BODY}  ")));
}
