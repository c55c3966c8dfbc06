//! The retreat of a drone, section IV-D: "all UAVs move automatically backwards while the
//! connection to its predecessor is too weak or lost".
//!
//! The predecessor is the neighbour towards the base. A retreat is bounded twice, in time and in
//! distance: the optic flow that measures the distance may fail in the dark.
//!
//! A relay retreats from a weak link only while that is the weaker one of its two. Where the front
//! link is weaker still, it is the drone in front that has to come back; a relay that backed away
//! from that drone would oscillate between the two rules, by more than a metre round a corner.

use units::{Db, Dbm, Duration, Metres, MetresPerSecond};

/// The constants of the retreat and of the search for a lost neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RetreatConfig {
    /// A drone whose back link is weaker than this flies back (RSSI_DANGER of the authors'
    /// firmware).
    pub limit: Dbm,
    /// The link is good again when it is this much stronger than the limit.
    pub hysteresis: Db,
    /// The range above the limit over which the head's forward speed is reduced to zero: the head
    /// stops before it has to turn back.
    pub ease: Db,
    /// A neighbour that was silent for longer than this counts as lost. With one packet in five
    /// lost at 5 Hz, 1 s of silence happens by chance every 13 minutes on each link, 2 s about once
    /// a month.
    pub lost_after: Duration,
    /// The speed of the retreat: DEFAULT_SPEED of the authors' firmware.
    pub speed: MetresPerSecond,
    /// The longest time of a retreat.
    pub max_time: Duration,
    /// The longest distance of a retreat.
    pub max_distance: Metres,
    /// The longest link by the odometers of both its ends: a drone does not fly to make one longer,
    /// however strong it is.
    pub longest: Metres,
    /// The time for which the drone goes on with its mission after a retreat that did not improve a
    /// weak link, before it retreats again.
    pub rest: Duration,
}

impl RetreatConfig {
    /// The constants: the limits are from the authors' firmware (`tunnel_config.h`). The bounds are
    /// half a minute and the longest hop that a 2.4 GHz link makes round one corner, about 6 m at
    /// 0.2 m/s. The longest link is the farthest hop of such a link underground, 30 m.
    pub const DEFAULT: Self = Self {
        limit: Dbm(-65.0),
        hysteresis: Db(2.0),
        ease: Db(4.0),
        lost_after: Duration::from_secs(2),
        speed: MetresPerSecond(0.2),
        max_time: Duration::from_secs(30),
        max_distance: Metres(6.0),
        longest: Metres(30.0),
        rest: Duration::from_secs(10),
    };

    /// Whether these links call for a retreat; `backing` says that one is under way. A back link
    /// that is lost always does; a weak one does unless the front link is weaker.
    #[must_use]
    pub fn wanted(&self, front: Option<Dbm>, back: Option<Dbm>, backing: bool) -> bool {
        let limit = if backing { self.limit + self.hysteresis } else { self.limit };
        back.is_none_or(|back| back < limit && front.is_none_or(|front| back <= front))
    }

    /// The part of the pilot's forward speed that the head still flies, 1 to 0, with a back link
    /// of this strength.
    #[must_use]
    pub fn freedom(&self, back: Option<Dbm>) -> f32 {
        let spare = back.map_or(0.0, |back| (back - self.limit).0);
        // Written so that NaN gives a speed of zero.
        if self.ease.0 > 0.0 && spare > 0.0 {
            (spare / self.ease.0).min(1.0)
        } else if spare > 0.0 {
            1.0
        } else {
            0.0
        }
    }
}

impl Default for RetreatConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}
