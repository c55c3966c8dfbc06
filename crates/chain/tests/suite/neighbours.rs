//! The neighbours in front and behind: the table of neighbours through its public door. Shows the
//! rules one by one, and then that any run of packets leads to what a naive model says.

use chain::filter::Smoothing;
use chain::neighbours::{Ends, Heard, MAX_NEIGHBOURS, Neighbours};
use chain::policy::PolicyConfig;
use chain::report::Report;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Dbm, Duration, Instant, Metres, MetresPerSecond, NodeId, Phase};

const ME: NodeId = NodeId(5);
const LOST_AFTER: Duration = Duration::from_secs(2);
const RAW: Smoothing = Smoothing::Raw;

fn heard(from: u8, sequence: u16, phase: Phase, rssi: f32) -> Heard {
    let report = Report::plain(NodeId(from), sequence, phase);
    Heard { report, rssi: Some(Dbm(rssi)), reverse: None }
}

/// A table with a clock beside it.
#[derive(Default)]
struct Table {
    neighbours: Neighbours,
    now: Instant,
}

impl Table {
    fn at(&mut self, ms: u64) -> &mut Self {
        self.now = Instant::from_millis(ms);
        self
    }

    fn hear(&mut self, packet: Heard) -> &mut Self {
        self.neighbours.hear(ME, self.now, &packet, &RAW, LOST_AFTER);
        self
    }

    /// A packet of a link of the chain.
    fn link(&mut self, from: u8, sequence: u16, rssi: f32) -> &mut Self {
        self.hear(heard(from, sequence, Phase::Linked, rssi))
    }

    fn ends(&self) -> Ends {
        self.neighbours.ends(ME, self.now, LOST_AFTER)
    }

    fn front(&self) -> Option<u8> {
        self.neighbours.front(self.ends()).map(|n| n.report.from.0)
    }

    fn back(&self) -> Option<u8> {
        self.neighbours.back(self.ends()).map(|n| n.report.from.0)
    }

    fn front_rssi(&self) -> Option<f32> {
        self.neighbours.front(self.ends()).map(|n| n.rssi().0)
    }
}

#[test]
fn the_nearest_numbers_either_way_are_the_neighbours() {
    let mut table = Table::default();
    assert_eq!((table.front(), table.back()), (None, None));
    table.link(1, 0, -70.0).link(9, 0, -70.0);
    assert_eq!((table.front(), table.back()), (Some(1), Some(9)));
    // Not the strongest: the closest number.
    table.link(3, 0, -80.0).link(7, 0, -80.0);
    assert_eq!((table.front(), table.back()), (Some(3), Some(7)));
    table.link(4, 0, -90.0).link(6, 0, -90.0);
    assert_eq!((table.front(), table.back()), (Some(4), Some(6)));
}

#[test]
fn only_links_of_the_chain_count() {
    for (phase, counts) in [
        (Phase::Waiting, false),
        (Phase::Transit, false),
        (Phase::Linked, true),
        (Phase::Base, true),
        (Phase::Out, false),
    ] {
        let mut table = Table::default();
        table.hear(heard(6, 0, phase, -60.0));
        assert_eq!(table.back().is_some(), counts, "{phase:?}");
        let all = table.neighbours.heard(table.now, LOST_AFTER).count();
        assert_eq!(all, 1, "{phase:?} is heard all the same");
    }
}

#[test]
fn a_neighbour_that_falls_silent_is_skipped_and_found_again() {
    let mut table = Table::default();
    table.link(3, 0, -70.0).link(4, 0, -60.0);
    for ms in (0..=4_000).step_by(200) {
        table.at(ms).link(3, (ms / 200) as u16 + 1, -70.0);
    }
    assert_eq!(table.front(), Some(3));
    table.link(4, 1, -61.0);
    assert_eq!(table.front(), Some(4));
    // Exactly at the limit it is still there, a microsecond later it is not.
    let last = table.now;
    table.now = last + LOST_AFTER;
    assert_eq!(table.front(), Some(4));
    table.now = last + LOST_AFTER + Duration::from_micros(1);
    assert_eq!(table.front(), None);
}

/// A packet that was held back brings the attacker's strength. The link went on with the strength of
/// the last one that was not, over and over, so that a drone that flew away kept its neighbour as near
/// as it had been.
#[test]
fn a_report_without_a_strength_moves_its_link_by_what_was_flown() {
    let smoothing = &PolicyConfig::CHAIN.smoothing;
    let mut neighbours = Neighbours::new();
    let mut now = Instant::ZERO;
    let mut hear = |odometer: f32, rssi: Option<f32>| {
        now = now + Duration::from_millis(200);
        let mut heard = heard(4, (now.as_micros() / 200_000) as u16, Phase::Linked, 0.0);
        heard.report.odometer = Metres(odometer);
        heard.rssi = rssi.map(Dbm);
        neighbours.hear(ME, now, &heard, smoothing, LOST_AFTER);
        let front = neighbours.front(neighbours.ends(ME, now, LOST_AFTER)).copied();
        front.map(|front| (front.rssi().0, front.is_reckoned()))
    };
    assert_eq!(hear(0.0, None), None, "a strength is the first that is known of a drone");
    for _ in 0..20 {
        let (rssi, is_reckoned) = hear(0.0, Some(-60.0)).unwrap();
        assert!((rssi + 60.0).abs() < 0.5 && !is_reckoned);
    }
    let mut last = (-60.0, false);
    for round in 1..=20_u8 {
        let next = hear(0.1 * f32::from(round), None).unwrap();
        assert!(next.0 < last.0, "{next:?} after {last:?}");
        assert_eq!(next.1, round >= 5, "after {round} reports");
        last = next;
    }
    assert!(last.0 < -63.0, "{} dBm, 2 m farther away", last.0);
    assert!(!hear(2.0, Some(-64.0)).unwrap().1);
}

/// A link that was lost is known by what was flown meanwhile, until a strength is measured.
#[test]
fn a_lost_neighbour_is_found_again_without_a_strength() {
    let smoothing = &PolicyConfig::CHAIN.smoothing;
    let mut neighbours = Neighbours::new();
    let packet = |sequence, rssi| Heard { rssi, ..heard(4, sequence, Phase::Linked, 0.0) };
    neighbours.hear(ME, Instant::ZERO, &packet(0, Some(Dbm(-60.0))), smoothing, LOST_AFTER);
    let now = Instant::from_millis(3_000);
    neighbours.hear(ME, now, &packet(15, None), smoothing, LOST_AFTER);
    let ends = neighbours.ends(ME, now, LOST_AFTER);
    assert_eq!(neighbours.front(ends).unwrap().rssi(), Dbm(-60.0));
}

#[test]
fn who_lands_is_skipped_at_once() {
    let mut table = Table::default();
    table.link(3, 0, -70.0).link(4, 0, -60.0);
    table.hear(heard(4, 1, Phase::Out, -60.0));
    assert_eq!(table.front(), Some(3));
}

#[test]
fn a_drones_own_echo_is_no_neighbour() {
    let mut table = Table::default();
    table.link(ME.0, 0, -20.0);
    assert_eq!(table.neighbours.heard(table.now, LOST_AFTER).count(), 0);
    assert_eq!((table.front(), table.back()), (None, None));
}

#[test]
fn duplicates_and_stragglers_change_nothing() {
    let mut table = Table::default();
    table.link(4, 100, -60.0);
    for late in [100, 99, 68, 100u16.wrapping_sub(0x7fff)] {
        table.link(4, late, -90.0);
        assert_eq!(table.front_rssi(), Some(-60.0), "{late}");
    }
    table.link(4, 101, -61.0);
    assert_eq!(table.front_rssi(), Some(-61.0));
    // A gap is no reason to doubt, nor is the wrap.
    table.link(4, 101 + 0x7fff, -62.0);
    assert_eq!(table.front_rssi(), Some(-62.0));
    table.link(4, 65_535, -63.0).link(4, 0, -64.0);
    assert_eq!(table.front_rssi(), Some(-64.0));
}

/// A duplicate keeps no neighbour alive: a repeater must not hide a loss.
#[test]
fn duplicates_do_not_keep_a_neighbour_alive() {
    let mut table = Table::default();
    for ms in (0..=3_000).step_by(200) {
        table.at(ms).link(4, 7, -60.0);
        if ms > 2_000 {
            break;
        }
        assert_eq!(table.front(), Some(4));
    }
    // At 2.2 s the first one is older than the limit; its duplicate counts as a new beginning.
    assert_eq!(table.front(), Some(4));
    table.at(2_300).link(4, 7, -61.0);
    assert_eq!(table.front_rssi(), Some(-60.0));
}

/// A drone that rebooted counts from zero again: it is believed once its old self is lost.
#[test]
fn a_rebooted_neighbour_comes_back() {
    let mut table = Table::default();
    table.link(4, 5_000, -60.0);
    table.at(1_000).link(4, 0, -65.0);
    assert_eq!(table.front_rssi(), Some(-60.0));
    table.at(2_200).link(4, 6, -66.0);
    assert_eq!((table.front(), table.front_rssi()), (Some(4), Some(-66.0)));
}

/// The estimate from before a link was lost does not weigh on the packets after.
#[test]
fn a_lost_link_begins_anew() {
    let slow = Smoothing::Average { weight: 0.1 };
    let mut neighbours = Neighbours::new();
    let hear = |neighbours: &mut Neighbours, ms, sequence, rssi| {
        let packet = heard(4, sequence, Phase::Linked, rssi);
        neighbours.hear(ME, Instant::from_millis(ms), &packet, &slow, LOST_AFTER);
    };
    hear(&mut neighbours, 0, 0, -50.0);
    hear(&mut neighbours, 200, 1, -60.0);
    let front = |neighbours: &Neighbours, ms| {
        let ends = neighbours.ends(ME, Instant::from_millis(ms), LOST_AFTER);
        neighbours.front(ends).unwrap().rssi().0
    };
    assert!((front(&neighbours, 200) - -51.0).abs() < 1e-3);
    hear(&mut neighbours, 10_000, 2, -80.0);
    assert_eq!(front(&neighbours, 10_000), -80.0);
}

#[test]
fn a_full_table_forgets_who_was_silent_longest() {
    let mut neighbours = Neighbours::new();
    let hear = |neighbours: &mut Neighbours, from: u8, ms: u64| {
        let packet = heard(from, 0, Phase::Linked, -60.0);
        neighbours.hear(NodeId(200), Instant::from_millis(ms), &packet, &RAW, LOST_AFTER);
    };
    for from in 0..MAX_NEIGHBOURS as u8 {
        // 3 has been silent longest.
        hear(&mut neighbours, from, if from == 3 { 0 } else { 100 });
    }
    hear(&mut neighbours, 77, 200);
    let mut known: Vec<_> =
        neighbours.heard(Instant::from_millis(200), LOST_AFTER).map(|n| n.report.from.0).collect();
    known.sort_unstable();
    let mut expected: Vec<_> = (0..MAX_NEIGHBOURS as u8).filter(|&n| n != 3).collect();
    expected.push(77);
    assert_eq!(known, expected);
}

/// The prediction takes the difference of velocities in the direction that separates: a neighbour
/// in front that flies on leaves, one behind that flies on comes nearer.
#[test]
fn separating_is_a_difference_with_the_right_sign() {
    let smoothing = &PolicyConfig::K.smoothing;
    let drift = |from: u8, theirs: f32, own: f32| {
        let mut packet = heard(from, 0, Phase::Linked, -60.0);
        packet.report.velocity = MetresPerSecond(theirs);
        let mut neighbours = Neighbours::new();
        neighbours.hear(ME, Instant::ZERO, &packet, smoothing, LOST_AFTER);
        let second = Duration::from_secs(1);
        neighbours.predict(ME, MetresPerSecond(own), second, smoothing);
        let link = neighbours.heard(Instant::ZERO, LOST_AFTER).next().unwrap();
        link.rssi().0 + 60.0
    };
    assert!(drift(4, 0.3, 0.0) < -0.5, "the one in front flies away");
    assert!(drift(4, 0.0, 0.3) > 0.5, "I close up to it");
    assert!(drift(6, 0.3, 0.0) > 0.5, "the one behind closes up");
    assert!(drift(6, 0.0, 0.3) < -0.5, "I leave it behind");
    for from in [4, 6] {
        assert!(drift(from, 0.3, 0.3).abs() < 1e-3, "flying as one changes nothing");
    }
}

/// One packet, or a pause.
#[derive(Clone, Debug)]
enum Event {
    Packet(Heard),
    Pause(u64),
}

fn events() -> impl Strategy<Value = Vec<Event>> {
    let phase = prop::sample::select(&[
        Phase::Waiting,
        Phase::Transit,
        Phase::Linked,
        Phase::Linked,
        Phase::Base,
        Phase::Out,
    ]);
    let packet = (0u8..=MAX_NEIGHBOURS as u8, 0u16..20, phase, -95i8..-30)
        .prop_map(|(from, seq, phase, rssi)| Event::Packet(heard(from, seq, phase, rssi.into())));
    prop::collection::vec(
        prop_oneof![4 => packet, 1 => (0u64..2_500).prop_map(Event::Pause)],
        0..300,
    )
}

/// The same rules over a map of all that was ever heard.
#[derive(Default)]
struct Model(std::collections::BTreeMap<u8, (Heard, u64)>);

impl Model {
    fn hear(&mut self, packet: Heard, now: u64) {
        if packet.report.from == ME {
            return;
        }
        let lost = 2_000;
        match self.0.get(&packet.report.from.0) {
            Some((known, at)) if now - at <= lost => {
                let ahead = packet.report.sequence.wrapping_sub(known.report.sequence);
                if ahead == 0 || ahead >= 0x8000 {
                    return;
                }
            }
            _ => {}
        }
        self.0.insert(packet.report.from.0, (packet, now));
    }

    fn links(&self, now: u64) -> impl DoubleEndedIterator<Item = (u8, f32)> {
        self.0
            .values()
            .filter(move |(packet, at)| now - at <= 2_000 && packet.report.phase.is_link())
            .map(|(packet, _)| (packet.report.from.0, packet.rssi.unwrap().0))
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default()
    })]

    #[test]
    fn any_run_of_packets_leads_to_what_the_model_says(events in events()) {
        let (mut table, mut model, mut now) = (Table::default(), Model::default(), 0);
        for event in events {
            match event {
                Event::Pause(ms) => now += ms,
                Event::Packet(packet) => {
                    table.at(now).hear(packet);
                    model.hear(packet, now);
                }
            }
            table.at(now);
            let front = model.links(now).rfind(|&(from, _)| from < ME.0);
            let back = model.links(now).find(|&(from, _)| from > ME.0);
            prop_assert_eq!(table.front(), front.map(|link| link.0));
            prop_assert_eq!(table.back(), back.map(|link| link.0));
            prop_assert_eq!(table.front_rssi(), front.map(|link| link.1));
        }
    }

    /// Whichever drones send, the table stays within its bounds and lists each once.
    #[test]
    fn any_storm_is_borne(
        storm in prop::collection::vec((any::<u8>(), any::<u16>(), any::<f32>()), 0..1_000),
    ) {
        let mut table = Table::default();
        for (n, (from, sequence, rssi)) in storm.into_iter().enumerate() {
            table.at(n as u64).link(from, sequence, rssi);
        }
        let mut known: Vec<_> =
            table.neighbours.heard(table.now, LOST_AFTER).map(|n| n.report.from).collect();
        prop_assert!(known.len() <= MAX_NEIGHBOURS);
        known.sort_unstable();
        known.dedup();
        prop_assert_eq!(known.len(), table.neighbours.heard(table.now, LOST_AFTER).count());
    }
}

/// A drone that a fade hides is not flown into: each of the two may use up less than half of the way
/// between them, here 5 m by the log-distance law.
#[test]
fn a_hidden_neighbour_is_approached_by_less_than_half_of_the_way() {
    let mut table = Table::default();
    let rssi = -40.0 - 30.0 * 5.0_f32.log10();
    table.at(0).link(4, 1, rssi).link(3, 1, rssi - 9.0);
    let fly = |table: &mut Table, ms: u64, velocity: f32| {
        table.at(ms);
        let round = (MetresPerSecond(velocity), Duration::from_millis(200));
        let third = heard(3, (ms / 200) as u16 + 2, Phase::Linked, rssi - 9.0);
        table.neighbours.listen(ME, table.now, round, [third], &RAW, LOST_AFTER);
        table.neighbours.may_collide(ME, table.now, table.ends())
    };
    let mut flown = 0.0;
    let mut ms = 2_200;
    while fly(&mut table, ms, 0.3) == [false, false] {
        (flown, ms) = (flown + 0.06, ms + 200);
        assert!(flown < 2.5, "the two may have met");
    }
    assert_eq!(table.front(), Some(3), "the hidden one is skipped");
    assert!(flown > 0.5, "it does come nearer, {flown} m");
    assert_eq!(fly(&mut table, 30_000, 0.0), [false, false], "after a while it is gone");
}
