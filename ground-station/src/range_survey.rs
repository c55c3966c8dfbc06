//! Surveys how far a link reaches in a place, and proposes the limits of a chain there.
//!
//! A person carries a relay, its motors off, away from the base, and the operator marks how far in it
//! is. Between two marks the relay is taken to have moved evenly. Each report of the relay's link to
//! the base is a sample: strength against place.
//!
//! # The limits
//! **Retreat**: the least strength at which a link still works, and a margin for fades. The least
//! strength is the sensitivity of the radio chip at the data rate ([`Reception`]). What a drone
//! reports has passed its filter, which averages fades out; where no direct wave dominates, the power
//! at a place is distributed exponentially about its mean (Rayleigh), and is weaker than the mean by
//! 12.9 dB or more at one place in twenty.
//!
//! **Launch**: above it by as much as a link may fall until the next relay has come. That is the 4 dB
//! in which the head is slowed down and the 1 dB by which both limits must differ; or the steepest
//! fall that the survey has found over the 2 m that the head flies while a call for a relay may wait
//! for the chain to settle, if that is more.

use agent::AgentConfig;
use radio_model::Reception;
use serde::Serialize;
use units::{Db, Dbm, Instant, NodeId};

/// The fade that a Rayleigh channel exceeds at one place in twenty: −10·log₁₀(−ln 0.95) = 12.9 dB.
const FADE: Db = Db(12.9);
/// The least difference between the limits that a drone accepts (`AgentConfig::check`).
const LEAST_GAP: Db = Db(1.0);
/// The launch and retreat limits that a drone accepts (the book, "Parameters").
const STRONGEST: Dbm = Dbm(-20.0);
/// The fewest samples from which limits are proposed: with one a second, half a minute's walk.
const FEWEST: usize = 30;

/// The way that the head flies at the speed of its retreat while a call for a relay may wait for the
/// chain to settle, m.
fn reaction_m() -> f32 {
    let config = AgentConfig::DEFAULT;
    config.retreat.speed.0 * config.launch.patience.as_secs_f32()
}

/// One report of the relay that is carried.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heard {
    at: Instant,
    rssi: Dbm,
}

/// The strength of the link to the base at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When the relay said it.
    pub at: Instant,
    /// How far from the base the relay was, in metres.
    pub place_m: f32,
    /// The strength by the relay's filter.
    pub rssi: Dbm,
}

/// A survey with a relay that is carried.
#[derive(Clone, Debug)]
pub struct RangeSurvey {
    /// The relay.
    pub node: NodeId,
    heard: Vec<Heard>,
    /// When the relay was how far from the base, in metres.
    marks: Vec<(Instant, f32)>,
}

/// What a survey has found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proposal {
    /// The proposed retreat limit, a whole number.
    pub retreat_dbm: f32,
    /// The proposed launch limit, a whole number.
    pub launch_dbm: f32,
    /// How far from the base every sample is stronger than that launch limit.
    pub reach_m: f32,
    /// Whether the survey has come to the launch limit at all; else the link reaches farther.
    pub reached_limit: bool,
}

impl RangeSurvey {
    /// A survey that begins at the base.
    #[must_use]
    pub fn begin(now: Instant, node: NodeId) -> Self {
        Self { node, heard: Vec::new(), marks: vec![(now, 0.0)] }
    }

    /// Takes a report of the relay about its link to the base.
    pub fn hear(&mut self, said: Instant, rssi: Dbm) {
        self.heard.push(Heard { at: said, rssi });
    }

    /// Notes that the relay is so far from the base now. A number that is none is not noted.
    pub fn mark(&mut self, now: Instant, place_m: f32) {
        if place_m.is_finite() && place_m >= 0.0 {
            self.marks.push((now, place_m));
        }
    }

    /// The last mark, in metres.
    #[must_use]
    pub fn place_m(&self) -> f32 {
        self.marks.last().map_or(0.0, |(_, place)| *place)
    }

    /// The samples whose place is known: those before the last mark.
    #[must_use]
    pub fn samples(&self) -> Vec<Sample> {
        let place = |at: Instant| {
            let pairs = self.marks.iter().zip(self.marks.iter().skip(1));
            let mut around = pairs.filter(|((from, _), (to, _))| *from <= at && at <= *to);
            let ((from, near), (to, far)) = around.next()?;
            let span = to.since(*from).as_secs_f32();
            let part = if span > 0.0 { at.since(*from).as_secs_f32() / span } else { 1.0 };
            Some(near + part * (far - near))
        };
        let heard = self.heard.iter();
        heard
            .filter_map(|&Heard { at, rssi }| Some(Sample { at, place_m: place(at)?, rssi }))
            .collect()
    }

    /// The limits for a radio of this sensitivity; `None` while there are too few samples.
    #[must_use]
    pub fn propose(&self, sensitivity: Dbm) -> Option<Proposal> {
        let mut samples = self.samples();
        if samples.len() < FEWEST {
            return None;
        }
        samples.sort_by(|a, b| a.place_m.total_cmp(&b.place_m));
        let retreat = (sensitivity.0 + FADE.0).ceil();
        let ease = AgentConfig::DEFAULT.retreat.ease;
        let gap = steepest_fall(&samples).max(ease.0 + LEAST_GAP.0).ceil();
        let launch = (retreat + gap).min(STRONGEST.0);
        let weak = samples.iter().find(|sample| sample.rssi.0 < launch);
        let farthest = samples.last().map_or(0.0, |sample| sample.place_m);
        Some(Proposal {
            retreat_dbm: retreat,
            launch_dbm: launch,
            reach_m: weak.map_or(farthest, |sample| sample.place_m),
            reached_limit: weak.is_some(),
        })
    }
}

/// The most by which the strength falls over [`reaction_m`], dB. The samples are in order of place.
fn steepest_fall(samples: &[Sample]) -> f32 {
    let way = reaction_m();
    let falls = samples.iter().enumerate().flat_map(|(index, from)| {
        let beyond = samples.iter().skip(index);
        beyond
            .take_while(move |to| to.place_m - from.place_m <= way)
            .map(move |to| from.rssi.0 - to.rssi.0)
    });
    falls.fold(0.0, f32::max)
}

/// The sensitivity of the drones' radio at the data rate of a base's address; 2 Mbit/s, the drones'
/// usual one, where the address has none.
#[must_use]
pub fn sensitivity(address: &str) -> Dbm {
    let has = |rate: &str| address.split(['/', '?']).any(|part| part == rate);
    if has("250K") {
        Reception::NRF51_AT_250_KBIT
    } else if has("1M") {
        Reception::NRF51_AT_1_MBIT
    } else {
        Reception::NRF51_AT_2_MBIT
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A walk of so many seconds at 0.5 m/s, a mark each 10 s, with the strength at each place.
    fn walk(seconds: u64, strength: impl Fn(f32) -> f32) -> RangeSurvey {
        let mut survey = RangeSurvey::begin(Instant::ZERO, NodeId(1));
        for second in 1..=seconds {
            let (now, place) = (Instant::from_millis(1_000 * second), 0.5 * second as f32);
            survey.hear(now, Dbm(strength(place)));
            if second % 10 == 0 {
                survey.mark(now, place);
            }
        }
        survey
    }

    #[test]
    fn a_gentle_place_has_the_limits_of_the_radio_chip() {
        assert!((reaction_m() - 2.0).abs() < 1e-6, "the book says 2 m");
        let proposal = walk(100, |place| -40.0 - place).propose(Dbm(-85.0)).unwrap();
        assert_eq!((proposal.retreat_dbm, proposal.launch_dbm), (-72.0, -67.0));
        assert!(proposal.reached_limit && (proposal.reach_m - 27.5).abs() < 0.01, "{proposal:?}");
    }

    #[test]
    fn where_the_link_falls_steeply_a_relay_is_called_earlier() {
        let corner = |place: f32| if place < 20.0 { -45.0 } else { -57.0 };
        let proposal = walk(100, corner).propose(Dbm(-85.0)).unwrap();
        assert_eq!((proposal.retreat_dbm, proposal.launch_dbm), (-72.0, -60.0));
        assert!(!proposal.reached_limit && (proposal.reach_m - 50.0).abs() < 0.01, "{proposal:?}");
    }

    #[test]
    fn too_few_samples_are_no_survey_and_what_follows_the_last_mark_has_no_place() {
        assert_eq!(walk(29, |_| -50.0).propose(Dbm(-85.0)), None);
        assert_eq!(walk(39, |_| -50.0).samples().len(), 30);
    }

    #[test]
    fn the_data_rate_stands_in_the_address() {
        assert_eq!(sensitivity("radio://0/80/2M/E7E7E7E70F"), Reception::NRF51_AT_2_MBIT);
        assert_eq!(sensitivity("radio://0/80/250K/E7E7E7E70F?rate_limit=50"), Dbm(-96.0));
        assert_eq!(sensitivity("udp://127.0.0.1:19854"), Reception::NRF51_AT_2_MBIT);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// Whatever was measured and marked, a drone takes the limits.
        #[test]
        fn the_limits_are_ones_that_a_drone_takes(
            walk in prop::collection::vec((-120.0_f32..0.0, 0.0_f32..200.0), 40..120),
        ) {
            let mut survey = RangeSurvey::begin(Instant::ZERO, NodeId(1));
            for (second, (rssi, place)) in (1..).zip(walk) {
                survey.hear(Instant::from_millis(1_000 * second), Dbm(rssi));
                survey.mark(Instant::from_millis(1_000 * second), place);
            }
            let Proposal { retreat_dbm, launch_dbm, .. } = survey.propose(Dbm(-96.0)).unwrap();
            prop_assert!((-96.0..=-20.0).contains(&launch_dbm) && retreat_dbm >= -96.0);
            prop_assert!(launch_dbm - retreat_dbm >= 1.0);
        }
    }
}
