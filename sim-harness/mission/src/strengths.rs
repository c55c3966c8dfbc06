//! The strengths of the links between the members of a mission, which change only when a member
//! moves or turns.

use radio_model::Antenna;
use random::{Purpose, Stream};
use units::{Db, Dbm, Metres, Point2, Radians};
use world::{Radio, SkeletonPlace, Spot, SurveyedPlace};

use recordings::recorded::LinkLevels;
use scenario::RadioSpec;

/// The strengths of all links.
pub(super) struct Strengths {
    stations: Vec<Station>,
    /// What each drone on the ground takes from the strength of its links.
    ground_loss: Db,
    antenna: Option<Antenna>,
    /// What a recorded channel adds to each link, where there is one.
    levels: Option<LinkLevels>,
    /// By sender and receiver, without antennas; `None` since one of them has moved.
    known: Vec<Option<Dbm>>,
}

/// The errors of one member's gain in sending and in receiving.
fn gains(spec: &RadioSpec, member: usize, seed: u64) -> [Db; 2] {
    let mut stream = Stream::new(seed, Purpose::Gain(member as u8));
    std::array::from_fn(|_| Db(spec.gain_error.0 * stream.normal()))
}

/// The errors of the gains of all members of a mission.
pub struct Gains(Vec<[Db; 2]>);

impl Gains {
    /// The gains in the mission of this seed.
    #[must_use]
    pub fn of(spec: &RadioSpec, members: usize, seed: u64) -> Self {
        Self((0..members).map(|member| gains(spec, member, seed)).collect())
    }

    /// By how much gains make the link of two members stronger, mean over both directions, in which
    /// drones measure it.
    #[must_use]
    pub fn of_link(&self, one: usize, other: usize) -> Db {
        let of = |member: usize| self.0.get(member).copied().unwrap_or([Db(0.0); 2]);
        let ([sends, hears], [answers, receives]) = (of(one), of(other));
        Db(0.5 * (sends.0 + receives.0 + answers.0 + hears.0))
    }
}

/// One end of the links.
struct Station {
    on: SurveyedPlace,
    /// Where the antenna is and where the drone's nose points; `None` for a station whose antenna
    /// has no preferred direction.
    nose: Option<(Point2, Radians)>,
    /// Whether it is a drone on the ground.
    is_low: bool,
    /// The errors of its gain in sending and in receiving.
    gains: [Db; 2],
}

impl Strengths {
    /// The strengths of links between stations at these places.
    pub(super) fn new(
        radio: &Radio,
        spec: &RadioSpec,
        seed: u64,
        places: impl Iterator<Item = SkeletonPlace>,
    ) -> Self {
        let station = |(n, place)| {
            let gains = gains(spec, n, seed);
            Station { on: radio.survey_place(place), nose: None, is_low: false, gains }
        };
        let stations: Vec<_> = places.enumerate().map(station).collect();
        let count = stations.len();
        let levels = spec.trace.as_ref().map(|channel| LinkLevels::new(channel, count, seed));
        let RadioSpec { ground_loss, antenna, .. } = *spec;
        Self { stations, ground_loss, antenna, levels, known: vec![None; count * count] }
    }

    /// Notes that a member is at this place of the skeleton, at this point with its nose in this
    /// direction, and whether it is a drone on the ground.
    pub(super) fn moved(
        &mut self,
        n: usize,
        place: SkeletonPlace,
        nose: (Point2, Radians),
        is_low: bool,
        radio: &Radio,
    ) {
        let count = self.stations.len();
        let station = &mut self.stations[n];
        station.nose = Some(nose);
        station.is_low = is_low;
        let spot = Spot { at: nose.0, on: place };
        if station.on.spot() == spot {
            return;
        }
        station.on = radio.survey_spot(spot);
        for other in 0..count {
            self.known[n * count + other] = None;
            self.known[other * count + n] = None;
        }
    }

    /// Where a station is.
    pub(super) fn on(&self, station: usize) -> Option<&SurveyedPlace> {
        self.stations.get(station).map(|station| &station.on)
    }

    /// By how much a recorded channel makes the link between two stations, whose length along the
    /// tunnel is `length`, stronger than the law.
    pub(super) fn level(&self, from: usize, to: usize, length: impl FnOnce() -> Metres) -> Db {
        self.levels.as_ref().map_or(Db(0.0), |levels| levels.at(from, to, length()))
    }

    /// The strength of one station's signal at another, without noise.
    #[inline]
    pub(super) fn between(&mut self, radio: &Radio, from: usize, to: usize) -> Dbm {
        let at = from * self.stations.len() + to;
        let strength = self.known[at].unwrap_or_else(|| self.undirected(radio, from, to));
        self.known[at] = Some(strength);
        self.received(strength, from, to)
    }

    /// The same without a note of it.
    pub(super) fn seen_between(&self, radio: &Radio, from: usize, to: usize) -> Dbm {
        let known = self.known[from * self.stations.len() + to];
        let strength = known.unwrap_or_else(|| self.undirected(radio, from, to));
        self.received(strength, from, to)
    }

    /// The strength without what changes as a drone turns, takes off and lands.
    fn undirected(&self, radio: &Radio, from: usize, to: usize) -> Dbm {
        let (sender, receiver) = (&self.stations[from], &self.stations[to]);
        let strength = radio.strength_at(&sender.on, &receiver.on);
        let length = || radio.distance(sender.on.place, receiver.on.place);
        strength + self.level(from, to, length) + sender.gains[0] + receiver.gains[1]
    }

    /// The strength that is left of `strength` behind the ground and both antennas.
    fn received(&self, strength: Dbm, from: usize, to: usize) -> Dbm {
        let (sender, receiver) = (&self.stations[from], &self.stations[to]);
        let low = [sender, receiver].into_iter().filter(|station| station.is_low).count();
        let strength = strength - Db(self.ground_loss.0 * low as f32);
        match &self.antenna {
            None => strength,
            Some(antenna) => strength + gain(antenna, sender, receiver),
        }
    }
}

/// The gain of both antennas towards each other, along the straight line.
fn gain(antenna: &Antenna, a: &Station, b: &Station) -> Db {
    let one = |this: &Station, other: &Station| {
        let ((at, nose), (to, _)) = this.nose.zip(other.nose)?;
        let bearing = libm::atan2f(to.y - at.y, to.x - at.x);
        Some(antenna.gain(Radians(bearing - nose.0)))
    };
    one(a, b).unwrap_or(Db(0.0)) + one(b, a).unwrap_or(Db(0.0))
}
