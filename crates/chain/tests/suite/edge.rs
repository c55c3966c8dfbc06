//! The edge behind which the head's own link falls: the head stays before it, and the chain comes nearer.

use chain::edge::EdgeWatch;
use chain::filter::LinkState;
use chain::launch::LaunchConfig;
use units::{Db, DbPerMetre, Dbm, Duration, Metres, MetresPerSecond};

const CONFIG: LaunchConfig = LaunchConfig::AT_ONCE;
const ROUND: Duration = Duration::from_millis(200);
const ASKED: MetresPerSecond = MetresPerSecond(0.3);
const BACK: MetresPerSecond = MetresPerSecond(0.2);

/// A head in a gallery whose link falls by 20 dB behind 10 m, and is `gain` stronger than at first.
struct Head {
    watch: EdgeWatch,
    way: Metres,
    falls: u32,
    was_weak: bool,
}

impl Head {
    fn new() -> Self {
        Self { watch: EdgeWatch::new(), way: Metres(8.0), falls: 0, was_weak: false }
    }

    fn own(&self, gain: f32) -> Dbm {
        let fall = if self.way > Metres(10.0) { 20.0 } else { 0.0 };
        CONFIG.limit + Db(3.0 + gain - fall)
    }

    /// Pushes the stick for so many seconds; a head with a weak link flies back.
    fn push(&mut self, seconds: u32, gain: f32) {
        for _ in 0..5 * seconds {
            let is_weak = self.own(gain) < CONFIG.limit;
            self.falls += u32::from(is_weak && !self.was_weak);
            self.was_weak = is_weak;
            let speed = if is_weak { -ASKED } else { self.watch.speed(self.way, ASKED) };
            self.way += speed * ROUND;
            self.watch.note(&CONFIG, ROUND, (self.way, speed), self.own(gain), true);
        }
    }

    fn lacks(&self) -> f32 {
        let slopes = [DbPerMetre(30.0), DbPerMetre(2.0)];
        let loss = self.own(0.0).loss();
        let own = LinkState { loss, slopes, variance: 0.1, step: None, hump: Db(0.0) };
        self.watch.lacks(&CONFIG, self.own(0.0), &own).0
    }
}

#[test]
fn a_head_falls_off_an_edge_ever_more_rarely() {
    let mut head = Head::new();
    head.push(15, 0.0);
    assert_eq!(head.falls, 1);
    assert!(head.way <= Metres(10.0), "{:?}", head.way);
    head.push(300, 0.0);
    assert!((3..=6).contains(&head.falls), "{} falls", head.falls);
}

#[test]
fn the_chain_is_told_what_it_lacks_while_the_head_is_held() {
    let mut head = Head::new();
    assert_eq!(head.lacks(), 0.0, "before the first fall");
    head.push(12, 0.0);
    // A link with 2 dB/m that is to be 20 dB stronger, by a log-distance law with an exponent of 2.5.
    let expected = 10.857 / 2.0 * (1.0 - (-20.0_f32 / 10.857).exp());
    assert!((head.lacks() - expected).abs() < 0.3, "{} m, not {expected}", head.lacks());
}

#[test]
fn a_head_flies_on_once_its_link_has_gained_enough_or_was_only_faded() {
    let mut head = Head::new();
    head.push(12, 0.0);
    head.push(5, 21.0);
    assert!(head.way > Metres(10.5), "it has gained, {:?}", head.way);
    assert_eq!(head.lacks(), 0.0, "the edge is behind it");
}

/// A relay that its law sends over an edge flies back by itself, and crosses no more often than a head.
#[test]
fn a_relay_comes_back_over_an_edge_and_stays_before_it() {
    let mut relay = Head::new();
    let mut farthest = Metres::ZERO;
    for _ in 0..5 * 60 {
        let is_weak = relay.own(0.0) < CONFIG.limit;
        relay.falls += u32::from(is_weak && !relay.was_weak);
        relay.was_weak = is_weak;
        let speed = relay.watch.relay_speed(relay.way, ASKED, BACK);
        relay.way += speed * ROUND;
        relay.watch.note(&CONFIG, ROUND, (relay.way, speed), relay.own(0.0), true);
        farthest = Metres(farthest.0.max(relay.way.0));
        let is_new = relay.watch.behind(relay.way) < Some(Metres(0.15));
        assert!(!is_weak || speed < MetresPerSecond::ZERO || is_new, "{speed:?} beyond the edge");
    }
    assert!((2..=4).contains(&relay.falls), "{} falls in a minute", relay.falls);
    assert!(farthest < Metres(10.3), "{farthest:?}");
}

/// The drone behind may be the base, which comes no nearer: then the relay tries again all the same.
#[test]
fn a_wait_ends_also_where_the_link_stays_weak() {
    let mut relay = Head::new();
    relay.push(12, 0.0);
    let waits = |watch: &EdgeWatch| watch.relay_speed(Metres(9.9), ASKED, BACK) < ASKED;
    assert!(waits(&relay.watch));
    let still = (Metres(9.5), MetresPerSecond::ZERO);
    for _ in 0..5 * 20 {
        relay.watch.note(&CONFIG, ROUND, still, CONFIG.limit - Db(1.0), true);
    }
    assert!(!waits(&relay.watch));
}

#[test]
fn a_drone_that_nothing_sends_forward_lacks_nothing() {
    let mut head = Head::new();
    head.push(12, 0.0);
    assert!(head.lacks() > 0.0);
    head.watch.rest();
    assert_eq!(head.lacks(), 0.0);
}

#[test]
fn a_watch_knows_how_far_behind_the_link_was_strong_enough() {
    let mut head = Head::new();
    assert_eq!(head.watch.behind(head.way), None);
    head.push(2, 0.0);
    assert_eq!(head.watch.behind(head.way), Some(Metres::ZERO));
    assert!((head.watch.behind(head.way + Metres(0.4)).unwrap().0 - 0.4).abs() < 1e-4);
}
