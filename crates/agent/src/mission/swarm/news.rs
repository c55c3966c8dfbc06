//! What the drones of a swarm tell each other, and what one remembers of it.
//!
//! Each drone tells its own place and progress in every round, and passes on what it knows of the
//! others, so that news reach drones that do not hear each other. One message is:
//!
//! | byte | type | what | unit |
//! |---|---|---|---|
//! | 0 | 6 bytes | the sender's news | |
//! | 6 | `u8` | the largest error of the sender's place, 255 for more | 1/256 m |
//! | 7 | 0 to 5 times 7 bytes | the number of another drone, and its news | |
//!
//! News are:
//!
//! | byte | type | what | unit |
//! |---|---|---|---|
//! | 0 | `u8` | number of the news, one more each time, from 255 back to 0 | |
//! | 1 | `i16` | place to the east | 1/256 m |
//! | 3 | `i16` | place to the north | 1/256 m |
//! | 5 | `u8` | progress, 254 for more; 255 from a drone that lands or has landed | |
//!
//! News are passed on by their number, and only while they are young, so that no news of a drone that
//! was lost go round for ever.

use units::{Duration, Instant, Metres, NODES, NodeId, Payload, Point2};
use virtual_forces::{DOWN, Heard};

use super::SwarmConfig;
use crate::Told;
use crate::mission::Outbox;

/// Bytes of news.
const ONE: usize = 6;
/// Bytes of another drone's number and news.
const OTHER: usize = 1 + ONE;
/// Bytes of the sender's news and error.
const SENDER: usize = ONE + 1;
/// The most drones whose news one message passes on.
const PASSED_ON: usize = (Payload::MOST - SENDER) / OTHER;
/// News are passed on for so long.
const YOUNG: Duration = Duration::from_secs(3);
/// After so long any number of news is a new one. The numbers come round after 51 s.
const FORGOTTEN: Duration = Duration::from_secs(10);
/// What a beam hits within this of another drone is that drone: half its width, and how far it flies
/// until it is heard of again, m.
const DRONE: f32 = 0.25;
/// Steps of a place in a metre.
const STEPS: f32 = 256.0;

/// A drone's own news.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Own {
    /// Where it is.
    pub(super) at: Point2,
    /// The largest error of that place.
    pub(super) error: Metres,
    /// How far it is in the mission.
    pub(super) progress: u16,
}

/// The last news of one drone.
#[derive(Clone, Copy, Debug)]
struct Record {
    bytes: [u8; ONE],
    /// The error that the drone itself told last.
    error: Option<u8>,
    at: Instant,
    /// Whether the virtual forces have not been told of it yet.
    is_new: bool,
}

/// What a drone remembers of the others.
#[derive(Clone, Debug)]
pub(super) struct News {
    all: [Option<Record>; NODES],
    sequence: u8,
}

impl News {
    /// A drone that has heard nothing.
    pub(super) const fn new() -> Self {
        Self { all: [None; NODES], sequence: 0 }
    }

    /// Takes in messages, for the drone `me`.
    pub(super) fn listen(&mut self, now: Instant, me: NodeId, told: &[Told]) {
        for Told { from, at, payload, .. } in told {
            let Some((sender, others)) = payload.as_bytes().split_first_chunk::<SENDER>() else {
                continue;
            };
            let [own @ .., error] = sender;
            self.note(*at, *from, own, Some(*error));
            for other in others.as_chunks::<OTHER>().0 {
                let [number, bytes @ ..] = other;
                if NodeId(*number) != me {
                    self.note(*at, NodeId(*number), bytes, None);
                }
            }
        }
        for record in self
            .all
            .iter_mut()
            .filter(|record| record.is_some_and(|record| now.since(record.at) > FORGOTTEN))
        {
            *record = None;
        }
    }

    /// Takes in news of a drone that are later than the last, with its error where it tells them itself.
    /// An error changes slowly: it holds for later news that others pass on.
    fn note(&mut self, at: Instant, of: NodeId, bytes: &[u8; ONE], error: Option<u8>) {
        let Some(place) = self.all.get_mut(usize::from(of.0)) else { return };
        let [sequence, ..] = *bytes;
        let later = |known: &Record| {
            let [last, ..] = known.bytes;
            (1..128).contains(&sequence.wrapping_sub(last))
        };
        if place.as_ref().is_none_or(later) {
            let known = place.and_then(|known| known.error);
            *place = Some(Record { bytes: *bytes, error: error.or(known), at, is_new: true });
        }
    }

    /// Takes the news that came since the last call. A drone may have flown on since it told its place.
    pub(super) fn take(
        &mut self,
        now: Instant,
        config: &SwarmConfig,
    ) -> impl Iterator<Item = Heard> {
        let (speed, unknown) = (config.speed.0, config.error_of(None));
        (0..).zip(&mut self.all).filter_map(move |(number, record)| {
            let record = record.as_mut().filter(|record| record.is_new)?;
            record.is_new = false;
            let (position, progress) = decoded(&record.bytes);
            let error = record.error.map_or(unknown.0, |error| f32::from(error) / STEPS);
            let flown = speed * now.since(record.at).as_secs_f32();
            // The distance says whether it is a neighbour: a radio reaches farther than the links
            // that a swarm keeps.
            Some(Heard { number, position, error: Metres(error + flown), hops: 2, progress })
        })
    }

    /// Whether another drone was at this point a moment ago.
    pub(super) fn is_drone(&self, now: Instant, point: Point2) -> bool {
        let mut known = self.all.iter().flatten().filter(|record| now.since(record.at) <= YOUNG);
        known.any(|record| decoded(&record.bytes).0.distance(point).0 < DRONE)
    }

    /// Puts the drone's own news and those of the others into `outbox`.
    pub(super) fn tell(&mut self, now: Instant, own: Own, outbox: &mut Outbox) {
        self.sequence = self.sequence.wrapping_add(1);
        let own = encoded(self.sequence, &own);
        let young = |record: &&Record| now.since(record.at) <= YOUNG;
        let mut others = (0..)
            .zip(&self.all)
            .filter_map(|(number, record)| Some((number, record.as_ref().filter(young)?)))
            .peekable();
        loop {
            let mut bytes = heapless::Vec::<u8, { Payload::MOST }>::new();
            // There is room for so many.
            let _ = bytes.extend_from_slice(&own);
            for (number, record) in others.by_ref().take(PASSED_ON) {
                let _ = bytes.push(number);
                let _ = bytes.extend_from_slice(&record.bytes);
            }
            let Some(payload) = Payload::new(&bytes) else { return };
            if outbox.push(payload).is_err() || others.peek().is_none() {
                return;
            }
        }
    }
}

fn encoded(sequence: u8, Own { at, error, progress }: &Own) -> [u8; SENDER] {
    let steps = |metres: f32| (libm::roundf(metres * STEPS) as i16).to_le_bytes();
    let ([x0, x1], [y0, y1]) = (steps(at.x), steps(at.y));
    let progress = (*progress).min(DOWN) as u8;
    [sequence, x0, x1, y0, y1, progress, libm::ceilf(error.0 * STEPS) as u8]
}

fn decoded([_, x0, x1, y0, y1, progress]: &[u8; ONE]) -> (Point2, u16) {
    let metres = |low: &u8, high: &u8| f32::from(i16::from_le_bytes([*low, *high])) / STEPS;
    (Point2::new(metres(x0, x1), metres(y0, y1)), u16::from(*progress))
}
