//! Governs the head: how fast it may fly by its links, and whether it calls for a relay.
//!
//! Both answers come from one number, the *spare*: by how much the weaker one of the head's own link
//! and of the level of the chain (the strength that all links would have if they were equal) is
//! stronger than the launch limit. The head slows down as the spare runs out, and **calls** for a
//! relay for as long as that leaves it less than half of the speed that the pilot asks for. So the
//! head and the relay on the ground can never wait for each other: the head is slow only while it
//! calls. The call counts the time for which the head was held and not the time since it last flew
//! freely, because near a corner a link may change by 10 dB within the tremble of a hovering drone.

use units::{Db, Dbm, Duration, Metres, MetresPerDb, MetresPerSecond};

use crate::filter::LinkState;
use crate::launch::LaunchConfig;

/// What the head knows of the links that bear it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadLinks {
    /// The strength that all links of the chain would have if they were equal.
    pub level: Dbm,
    /// By how much the chain may grow longer for each decibel of the level.
    pub compliance: MetresPerDb,
    /// The head's own link to the drone behind it, where one is heard and its slopes are estimated.
    pub own: Option<LinkState>,
}

impl HeadLinks {
    /// By how much the level is stronger than where the head stops, dB, or its own link with
    /// [`OWN_BEARS`], if that is less.
    fn spare(&self, config: &LaunchConfig) -> f32 {
        let own = self.own.map_or(self.level, |own| Dbm::after_loss(own.loss));
        let own = (own - config.limit).0 + OWN_BEARS;
        own.min((self.level - config.limit).0) - RESERVE
    }
}

/// The head's speed by its links, and its call for a relay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Governor {
    /// For how long the head has been held, s: less the time for which it flew freely since.
    held_s: f32,
    calls: bool,
}

/// A head is held that may fly at less than this part of the speed that the pilot asks for.
const HELD: f32 = 0.5;
/// A head that has been held for so long calls for a relay, s: five reports, which average the noise
/// of a link; and the longest time for which it goes on calling once it flies freely.
const CALLS_AFTER_S: f32 = 1.0;
/// However steeply its own link falls, the head slows down over no more than the last so many decibels:
/// the slope of a corner is remembered for some metres behind it. Chosen of 3 and 12 dB by drawn places.
const FARTHEST_FALL: f32 = 3.0;
/// The part of the pilot's speed at which a head comes back from where its links are too weak.
const BACK: f32 = 0.5;
/// The head stops so much above the limit, dB: the standard deviation of a filtered link at rest, so
/// that links at the limit are rarely below it. Our own number; in free space it is 3 % of a link.
const RESERVE: f32 = 0.3;
/// The head's own link holds it only so much later than the level, dB. The lesser of two values that err
/// by 0.4 dB each is 0.2 dB too small on average, and the relay behind evens the two out. Chosen of 0 and
/// 0.5 dB by drawn places (seeds from 500,000); a reserve of zero instead costs twice as many weak links
/// for the same depth.
const OWN_BEARS: f32 = 0.5;
/// A head without an order to fly that is at most so much below the limit has flown too far, dB, and
/// comes back; where its links are weaker still it stays, since the pilot has led it there, unless its own
/// was strong enough at most [`RETURNS`] behind it.
const OVERSHOT: f32 = 3.0;
/// How far a head without an order flies back to where its own link was strong enough, m: the length of a
/// corner, and of the way that it flies before the filter knows. Our own number.
const RETURNS: Metres = Metres(1.0);
/// Nearer than this it is there, m: half of what a head keeps before an edge. Our own number.
const TREMBLE: Metres = Metres(0.05);
/// The speed at which it comes back, m/s: it is a matter of decimetres.
const EASES_AT: f32 = 0.1;

impl Governor {
    /// The governor of a head that has not been held.
    #[must_use]
    pub const fn new() -> Self {
        Self { held_s: 0.0, calls: false }
    }

    /// Whether the head calls for a relay.
    #[must_use]
    pub const fn calls(&self) -> bool {
        self.calls
    }

    /// Whether a head that flies at `velocity` nears the limit: its motion takes the level there
    /// within [`LaunchConfig::lead`]. One that a wall stops does not, however near the limit is.
    #[must_use]
    pub fn nears_limit(
        config: &LaunchConfig,
        velocity: MetresPerSecond,
        links: &HeadLinks,
    ) -> bool {
        let way = velocity * config.lead;
        let fall = Db((way.0.max(0.0) / links.compliance.0).min(config.margin.0));
        links.level - config.limit < fall
    }

    /// The pilot's forward speed `asked` as far as the links can spare it. It falls in proportion to
    /// the spare over the last [`LaunchConfig::slows_from`], or earlier where the head's own link
    /// falls so steeply that the spare lasts for less than [`LaunchConfig::foresight`]. At the limit
    /// the head hovers, and from where its links are weaker it comes back.
    #[must_use]
    pub fn speed(
        config: &LaunchConfig,
        asked: MetresPerSecond,
        links: &HeadLinks,
    ) -> MetresPerSecond {
        let spare = links.spare(config);
        let fall = links.own.map_or(0.0, |link| {
            let [own, other] = link.slopes;
            own.0.max(other.0) * asked.0 * config.foresight.as_secs_f32()
        });
        let fall = fall.min(FARTHEST_FALL);
        asked * (spare / config.slows_from.0.max(fall)).clamp(-BACK, 1.0)
    }

    /// The speed of a head whose pilot asks for none, while no relay waits: back to where its links
    /// bear it, if it has flown a little too far. Its own link was strong enough `sound` behind it, where
    /// that is known.
    #[must_use]
    pub fn eased(
        config: &LaunchConfig,
        links: &HeadLinks,
        sound: Option<Metres>,
    ) -> MetresPerSecond {
        let spare = links.spare(config) + RESERVE;
        let is_near = sound.is_some_and(|way| (TREMBLE..=RETURNS).contains(&way));
        if spare < 0.0 && (spare >= -OVERSHOT || is_near) {
            MetresPerSecond(EASES_AT * spare / config.slows_from.0)
                .limited_to(MetresPerSecond(EASES_AT))
        } else {
            MetresPerSecond::ZERO
        }
    }

    /// Notes that for `dt` the pilot asked for the forward speed `asked`, that the links left the
    /// speed `left`, and whether the head flies on towards a limit that is near: then it calls before
    /// it is held. A pilot who asks for no speed ends the call.
    pub fn note(
        &mut self,
        dt: Duration,
        asked: MetresPerSecond,
        left: MetresPerSecond,
        nears_limit: bool,
    ) {
        if asked.0 <= 0.0 {
            *self = Self::new();
            return;
        }
        let seconds = dt.as_secs_f32();
        let is_held = left.0 < HELD * asked.0;
        let change = if is_held || nears_limit { seconds } else { -seconds };
        self.held_s = (self.held_s + change).clamp(0.0, CALLS_AFTER_S);
        self.calls = self.held_s >= CALLS_AFTER_S || self.calls && self.held_s > 0.0;
    }
}
