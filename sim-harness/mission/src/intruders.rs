//! Simulates an intruder with radios beside the chain: the packets that they receive and send, and
//! how many of them a drone takes for packets of the chain.

use std::collections::VecDeque;

use units::Dbm;
use world::SkeletonPlace;

use super::begin::medium_of;
use super::{Mission, Strengths, World};
use medium::{Medium, Repeater};
use scenario::Scenario;

/// A packet that the intruder has received.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overheard {
    /// The moment of its arrival, by the mission's clock, µs.
    pub at_us: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// The most packets that are kept, the newest ones.
const REMEMBERED: usize = 4_096;

/// The intruder's radios are the stations after the last member; the first of them listens.
#[derive(Default)]
pub(super) struct Intruders {
    overheard: VecDeque<Overheard>,
    sent: u64,
    accepted: u64,
    /// Whether the intruder keeps the members from hearing each other.
    jams: bool,
}

impl Intruders {
    pub(super) fn overhear(&mut self, at_us: u64, data: &[u8]) {
        if self.overheard.len() == REMEMBERED {
            self.overheard.pop_front();
        }
        self.overheard.push_back(Overheard { at_us, data: data.to_vec() });
    }

    pub(super) const fn accept(&mut self) {
        self.accepted += 1;
    }

    pub(super) const fn jams(&self) -> bool {
        self.jams
    }
}

impl<'a> Mission<'a> {
    /// A mission with an intruder's radios at these places.
    #[must_use]
    pub fn besieged(
        scenario: &'a Scenario,
        world: &'a World,
        seed: u64,
        at: &[SkeletonPlace],
    ) -> Self {
        let mut mission = Self::new(scenario, world, seed);
        let members = mission.members.len();
        mission.medium = Medium::new(medium_of(scenario), members + at.len(), seed)
            .through(scenario.radio.trace.as_ref(), seed);
        let members = (0..members).map(|n| mission.track.place(n));
        let places = members.chain(at.iter().copied());
        mission.strengths = Strengths::new(&world.radio, &scenario.radio, seed, places);
        mission.intruders = Some(Intruders::default());
        mission
    }

    /// Has one of the intruder's radios send these bytes, `in_us` from now.
    pub fn intrude(&mut self, radio: usize, in_us: u64, data: &[u8]) {
        if let Some(intruders) = &mut self.intruders {
            intruders.sent += 1;
            self.medium.inject(self.members.len() + radio, self.now_us + in_us, data);
        }
    }

    /// Has the intruder jam every packet of a member at all other members, and receive it nevertheless,
    /// or stop doing so.
    pub const fn jam_and_listen(&mut self, jams: bool) {
        if let Some(intruders) = &mut self.intruders {
            intruders.jams = jams;
        }
    }

    /// Has these repeaters of the intruder, whose stations are counted from its first radio on, send
    /// what they hear, and no others.
    pub fn repeat(&mut self, repeaters: &[Repeater]) {
        let first = self.members.len();
        let placed = |one: &Repeater| {
            let (ear, mouth) = (first + one.ear, first + one.mouth);
            Repeater { ear, mouth, ..*one }
        };
        self.medium.repeat(&repeaters.iter().map(placed).collect::<Vec<_>>());
    }

    /// The strength of one member's signal at another, without noise.
    pub fn strength(&mut self, from: usize, to: usize) -> Dbm {
        self.strengths.between(&self.world.radio, from, to)
    }

    /// The packets that the intruder has received, the oldest first.
    pub fn overheard(&self) -> impl ExactSizeIterator<Item = &Overheard> {
        const NOTHING: &VecDeque<Overheard> = &VecDeque::new();
        let heard = self.intruders.as_ref().map_or(NOTHING, |intruders| &intruders.overheard);
        heard.iter()
    }

    /// The number of packets that the intruder has sent.
    #[must_use]
    pub fn intruded(&self) -> u64 {
        self.intruders.as_ref().map_or(0, |intruders| intruders.sent)
    }

    /// How often a member took one of the intruder's packets for one of the chain's.
    #[must_use]
    pub fn accepted(&self) -> u64 {
        self.intruders.as_ref().map_or(0, |intruders| intruders.accepted)
    }
}
