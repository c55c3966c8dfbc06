//! Remembers the place behind which a drone's link to the drone behind it fell below the limit, and takes
//! the chain over it.
//!
//! Round a corner a link falls by 10 to 40 dB within a few decimetres, faster than its filter follows. A
//! head that knows only its present strength flies over such an *edge*, falls back, has a strong link
//! again and flies over it again. This watch holds the head before the edge instead, and tells the chain
//! by how much it is too short ([`EdgeWatch::lacks`]): the relays come nearer, as if the head already
//! had the link that it will have behind the edge, until that link can be borne or no relay is left. A
//! fade looks like an edge, so the head tries again after a while as well.
//!
//! A relay that its law sends over an edge does the same with its link to the drone behind: without the
//! watch it crosses, comes back and crosses again while the drone behind follows it to and fro.

use units::{Db, DbPerMetre, Dbm, Duration, Metres, MetresPerSecond};

use crate::chain_wide::lengthening;
use crate::filter::LinkState;
use crate::launch::LaunchConfig;

/// A drone has passed an edge where its link is strong enough so far behind it, and has left it so far
/// before it, m: the length of a corner and the width of a gallery. Our own numbers.
const PASSED: Metres = Metres(0.5);
const LEFT: Metres = Metres(2.0);
/// A drone keeps so far before an edge, m: what it trembles by.
const MARGIN: Metres = Metres(0.1);
/// The link was weak so long before the filter knew, s.
const LAG_S: f32 = 1.0;
/// A link that is weaker than the limit by so much has fallen, dB: five standard deviations of a filtered
/// link at rest.
const FALL: f32 = 1.5;
/// A drone that fell back tries again after so long, s, and after twice as long each time. Our own number,
/// longer than nearly all fades.
const AGAIN_S: f32 = 8.0;
/// It tries again before where the link has become stronger by this part of the fall: with equation (19)
/// the link behind a corner gains twice as much as the one before it. Chosen of 0.3, 0.5 and 0.7 by
/// drawn places.
const GAINED: f32 = 0.5;

/// The watch of one drone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdgeWatch {
    /// The last place at which the link was no weaker than the limit, and its strength there.
    sound: Option<(Metres, Dbm)>,
    edge: Option<Edge>,
    /// Whether the pilot, or a relay's law, asks for forward speed.
    is_pushed: bool,
}

/// A place behind which the link fell below the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    /// Where the link still was strong enough.
    way: Metres,
    /// The strength of the link there.
    strength: Dbm,
    /// By how much the link became weaker than the limit.
    depth: Db,
    /// For how long the head is still held, s, and for how long it is after the next fall.
    wait_s: f32,
    again_s: f32,
}

impl Edge {
    /// The same edge after one more fall from it.
    const fn again(self, strength: Dbm, depth: Db) -> Self {
        let again_s = 2.0 * self.again_s;
        Self { strength, depth, wait_s: again_s, again_s, ..self }
    }

    const fn is_closed(&self) -> bool {
        self.wait_s > 0.0
    }
}

impl EdgeWatch {
    /// The watch of a drone whose link has never fallen.
    #[must_use]
    pub const fn new() -> Self {
        Self { sound: None, edge: None, is_pushed: false }
    }

    /// Notes that the link to the drone behind has the strength `own` at `way`, to which this drone has flown
    /// for `dt` at `velocity`, and whether its pilot or its law sends it forward. A link that falls while
    /// the drone stands has fallen because of the drone behind it.
    pub fn note(
        &mut self,
        config: &LaunchConfig,
        dt: Duration,
        (way, velocity): (Metres, MetresPerSecond),
        own: Dbm,
        is_pushed: bool,
    ) {
        let spare = own - config.limit;
        self.is_pushed = is_pushed;
        if spare.0 >= 0.0 {
            self.sound = Some((way, own));
            self.edge = self.edge.filter(|e| e.way - LEFT < way && way < e.way + PASSED);
            if let Some(edge) = &mut self.edge {
                let has_gained = (own - edge.strength).0 >= GAINED * edge.depth.0;
                edge.wait_s = if has_gained { 0.0 } else { edge.wait_s - dt.as_secs_f32() };
            }
        } else if spare.0 < -FALL
            && let Some((at, strength)) = self.sound
            && is_pushed
            && way > at
        {
            let depth = -spare;
            self.edge = Some(match self.edge {
                Some(edge) if edge.is_closed() => {
                    Edge { depth: Db(edge.depth.0.max(depth.0)), ..edge }
                }
                Some(edge) => edge.again(strength, depth),
                None => {
                    let way = at - Metres(velocity.0.max(0.0) * LAG_S);
                    Edge { way, strength, depth, wait_s: AGAIN_S, again_s: AGAIN_S }
                }
            });
        }
        // The wait ends also where the drone behind cannot make the link strong enough.
        if spare.0 < 0.0
            && let Some(edge) = self.edge.as_mut().filter(|edge| way <= edge.way)
        {
            edge.wait_s -= dt.as_secs_f32();
        }
    }

    /// The forward speed `asked` of a head at `way`, but not over an edge before it is time.
    #[must_use]
    pub fn speed(&self, way: Metres, asked: MetresPerSecond) -> MetresPerSecond {
        self.kept_before(way, asked, MetresPerSecond::ZERO)
    }

    /// The speed `asked` by the law of a relay at `way`, but not over an edge before it is time, and at `back`
    /// back from where it has passed one. A head comes back by its
    /// [`Governor`](crate::governor::Governor), and only until its links bear it: where heads flew back all
    /// the way, 0.03 to 0.04 fewer came deep in time (the book, "Edges").
    #[must_use]
    pub fn relay_speed(
        &self,
        way: Metres,
        asked: MetresPerSecond,
        back: MetresPerSecond,
    ) -> MetresPerSecond {
        self.kept_before(way, asked, -back)
    }

    /// The speed `asked` at `way`, at most what keeps the drone before a closed edge, but no less than
    /// `least` because of it.
    fn kept_before(
        &self,
        way: Metres,
        asked: MetresPerSecond,
        least: MetresPerSecond,
    ) -> MetresPerSecond {
        let Some(edge) = self.edge.filter(Edge::is_closed) else { return asked };
        // Within a second the drone flies no more than the room that is left.
        let room = edge.way - MARGIN - way;
        MetresPerSecond(asked.0.min(room.0.max(least.0)))
    }

    /// Notes that nothing sends the drone forward.
    pub const fn rest(&mut self) {
        self.is_pushed = false;
    }

    /// How far behind `way` the link was last strong enough; `None` where it never was.
    #[must_use]
    pub fn behind(&self, way: Metres) -> Option<Metres> {
        self.sound.map(|(sound, _)| way - sound)
    }

    /// The way by which a chain of this `level` is too short for the drone to go on: its link must be so
    /// strong before the edge that it is no weaker than the level once it has fallen. Only the drone
    /// behind can give it that, so that its slope counts.
    #[must_use]
    pub fn lacks(&self, config: &LaunchConfig, level: Dbm, own: &LinkState) -> Metres {
        let Some(edge) = self.edge.filter(|edge| edge.is_closed() && self.is_pushed) else {
            return Metres::ZERO;
        };
        let fall = (edge.strength - config.limit).0.max(0.0) + edge.depth.0;
        let [_, DbPerMetre(slope)] = own.slopes;
        let excess = (level.loss() - own.loss).0;
        lengthening(slope, excess) - lengthening(slope, excess - fall)
    }
}
