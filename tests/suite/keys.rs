//! From the key file to the air: a page decodes to the keys that the fleet's secret gives, drones
//! with such keys hear each other, and one that a rekeying has left out is not heard.

use std::fs;
use std::path::PathBuf;

use airlink::keys::{FleetSecret, Key, Keys, Own, node};
use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Sealed};
use fleet_keys::Request;
use storage::epoch;
use storage::keys::KeysRecord;
use storage::ledger::Ledger;
use storage::{Record, Slots};
use units::{Dbm, Duration, Instant, NodeId, Order, Phase, Role};
use wire::p2p::{Epoch, Telemetry};
use wire::radio::Datarate;

/// A folder with one fleet, gone when dropped.
struct Desk {
    folder: PathBuf,
    pages: u32,
}

impl Desk {
    fn new(name: &str) -> Self {
        let folder =
            std::env::temp_dir().join(format!("uchain-desk-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let desk = Self { folder, pages: 0 };
        fleet_keys::create(&desk.file(), 1).unwrap();
        desk
    }

    fn file(&self) -> PathBuf {
        self.folder.join("fleet.toml")
    }

    /// The page that a drone gets, as it would read it from its flash.
    fn page(&mut self, number: u8) -> KeysRecord {
        self.pages += 1;
        let out = self.folder.join(format!("{}.bin", self.pages));
        let request = Request {
            node: NodeId(number),
            role: None,
            may_fly: number == 15,
            policy: None,
            limits: None,
            mission: None,
        };
        fleet_keys::provision(&self.file(), &request, &out).unwrap();
        let bytes = fs::read(out).unwrap();
        assert_eq!(bytes.len(), storage::keys::LENGTH);
        let (keys, sequence) = KeysRecord::decode(&bytes).unwrap();
        assert_eq!(sequence, 0);
        keys
    }

    fn secret(&self) -> FleetSecret {
        let text = fs::read_to_string(self.file()).unwrap();
        let digits = text.split("secret = \"").nth(1).unwrap();
        FleetSecret::from_bytes(std::array::from_fn(|i| {
            u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).unwrap()
        }))
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[test]
fn a_page_holds_the_keys_that_follow_from_the_fleets_secret() {
    let mut desk = Desk::new("page");
    for generation in 1..=3 {
        let secret = desk.secret();
        for number in [0, 3, 15] {
            let page = desk.page(number);
            let base = secret.base(generation);
            let own = if number == 15 { base } else { node(&base, NodeId(number)) };
            assert_eq!(page.group.expose(), secret.group(generation).expose());
            assert_eq!(page.own.expose(), own.expose());
            assert_eq!((page.node, page.generation), (NodeId(number), generation));
            assert_eq!(page.may_fly, number == 15);
            let role = [Role::Head, Role::Relay, Role::Base][usize::from(number.div_ceil(8))];
            assert_eq!(page.role, role);
        }
        assert_eq!(fleet_keys::rekey(&desk.file(), &[]).unwrap().stale(), [0, 3, 15]);
    }
}

/// A drone that was switched on for the first time with this page.
fn switched_on(page: &KeysRecord) -> Airlink<Sealed> {
    link(page, first_epoch(page))
}

fn first_epoch(page: &KeysRecord) -> Epoch {
    let blank = [0xFF; epoch::LENGTH];
    let next = epoch::next(&Slots::read(&blank, &blank), page, &Ledger::EMPTY, 7).unwrap();
    next.kept([next.writes[0].bytes(), next.writes[1].bytes()]).unwrap()
}

fn link(page: &KeysRecord, epoch: Epoch) -> Airlink<Sealed> {
    let own = Key::from_bytes(*page.own.expose());
    let own = if page.role == Role::Base { Own::Base(own) } else { Own::Node(own) };
    let keys = Keys { group: Key::from_bytes(*page.group.expose()), own };
    let schedule = Schedule::new(Datarate::Mbit2, page.node).unwrap();
    let identity = Identity { node: page.node, role: page.role };
    let config = LinkConfig::DEFAULT;
    Airlink::new(config, identity, Sealed::new(keys), epoch, schedule, Instant::from_micros(0))
}

const TELEMETRY: Telemetry = Telemetry {
    state: 1,
    fault: 0,
    battery: None,
    endurance: None,
    front: None,
    back: None,
    odometer: units::Metres(0.0),
    velocity: units::MetresPerSecond(0.0),
    height: None,
    heeded: 0,
};

/// Some drones in one room for a few seconds: what each of them took in. The base orders all home.
fn together(links: &mut [Airlink<Sealed>]) -> Vec<Vec<Event>> {
    let mut events = vec![Vec::new(); links.len()];
    let mut air: Vec<(Instant, usize, Vec<u8>)> = Vec::new();
    for tick in 0..40_000_u64 {
        let now = Instant::from_micros(100 * tick);
        for (i, link) in links.iter_mut().enumerate() {
            if tick % 2_000 == 0 {
                link.report(report());
                link.telemeter(TELEMETRY);
                link.order(now, Order::Return);
            }
            let mut out = [0; 60];
            if link.due().is_some_and(|due| due <= now)
                && let Some(length) = link.transmit(now, &mut out)
            {
                air.push((now + Duration::from_micros(1_500), i, out[..length].to_vec()));
            }
        }
        air.retain(|(at, from, packet)| {
            if *at > now {
                return true;
            }
            for (i, link) in links.iter_mut().enumerate() {
                if i != *from {
                    events[i].extend(link.receive(now, Dbm(-50.0), packet));
                }
            }
            false
        });
    }
    events
}

fn report() -> wire::p2p::Report {
    wire::p2p::Report {
        phase: Phase::Waiting,
        recall: false,
        calls: false,
        is_uneven: false,
        velocity: units::MetresPerSecond(0.0),
        odometer: units::Metres(0.0),
        links: None,
        sums: [units::LinkSum::NONE; 2],
        waiting: 0,
        head_velocity: units::MetresPerSecond(0.0),
        signpost: None,
        heard: Default::default(),
    }
}

fn orders(events: &[Event]) -> usize {
    events.iter().filter(|event| matches!(event, Event::Order { task: Order::Return, .. })).count()
}

fn telemetry_from(events: &[Event], node: u8) -> usize {
    let from = |event: &&Event| matches!(event, Event::Telemetry { from, .. } if from.0 == node);
    events.iter().filter(from).count()
}

#[test]
fn drones_of_a_fleet_talk_and_what_goes_end_to_end_arrives() {
    let mut desk = Desk::new("talk");
    let mut links = [0, 3, 15].map(|number| switched_on(&desk.page(number)));
    let events = together(&mut links);
    assert!(orders(&events[0]) > 0 && orders(&events[1]) > 0);
    assert!(telemetry_from(&events[2], 0) > 0 && telemetry_from(&events[2], 3) > 0);
    for link in &links {
        assert_eq!(link.counters().refused.tag, 0);
    }
}

#[test]
fn a_drone_that_a_rekeying_left_out_is_not_heard_and_hears_nobody() {
    let mut desk = Desk::new("rekey");
    let stolen = desk.page(3);
    let _ = (desk.page(0), desk.page(15));
    fleet_keys::rekey(&desk.file(), &[NodeId(3)]).unwrap();
    let mut links = [switched_on(&desk.page(0)), switched_on(&desk.page(15)), switched_on(&stolen)];
    let events = together(&mut links);
    assert!(orders(&events[0]) > 0 && telemetry_from(&events[1], 0) > 0, "the others go on");
    assert!(events[2].is_empty(), "{:?}", events[2].first());
    let strange = |event: &Event| match event {
        Event::Report { from, .. }
        | Event::Beacon { from, .. }
        | Event::Telemetry { from, .. }
        | Event::Mission { from, .. }
        | Event::Membership { from, .. } => *from == NodeId(3),
        Event::Order { .. } => false,
    };
    assert!(!events.iter().flatten().any(strange));
    assert!(links.iter().all(|link| link.counters().refused.tag > 0), "each refused the others'");
}

#[test]
fn two_fleets_do_not_hear_each_other() {
    let (mut ours, mut theirs) = (Desk::new("ours"), Desk::new("theirs"));
    let mut links = [switched_on(&ours.page(0)), switched_on(&theirs.page(15))];
    let events = together(&mut links);
    assert!(events.iter().all(Vec::is_empty));
}

/// A drone provisioned anew takes nothing that was said to it as what it was before.
#[test]
fn an_order_from_before_a_provisioning_is_none_after_it() {
    let mut desk = Desk::new("anew");
    let (base, head) = (desk.page(15), desk.page(0));
    let mut links = [switched_on(&base), switched_on(&head)];
    assert!(orders(&together(&mut links)[1]) > 0);
    let again = desk.page(0);
    let supersedes = |new: &KeysRecord, old| new.supersedes(Some(old), &Ledger::EMPTY);
    assert!(supersedes(&again, &head) && !supersedes(&head, &again));
    assert!(again.issue > head.issue);
    let [before, after] = [head, again].map(|page| first_epoch(&page));
    assert!(after > before);
}
