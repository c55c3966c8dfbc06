//! Keeps a table of the other drones that one drone receives, and finds its neighbours in front and
//! behind.
//!
//! The order is given by [`NodeId`], so it needs no negotiation: a drone's front neighbour is the
//! nearest smaller number that is heard and is a link of the chain, its back neighbour the nearest
//! larger one. A neighbour that falls silent is skipped as soon as it counts as lost, so the chain
//! closes a gap by itself wherever the next drone can be received. The skipped drone may fly on in
//! a fade: for a while this drone comes no nearer to it than both can without a collision.

use heapless::Vec;
use units::{Dbm, Duration, Instant, Metres, MetresPerSecond, NodeId, Phase};

use crate::chain_wide::FOLD_DB;
use crate::filter::{LinkEstimate, LinkFilter, LinkState, Separation, Smoothing};
use crate::policy::PAPER_SLOPE;
use crate::report::{Report, newer};

/// The most other drones that one drone keeps track of. With itself that is a chain of 16, the
/// number of identities in the authors' firmware.
pub const MAX_NEIGHBOURS: usize = 15;

/// A report as it was received.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Heard {
    /// The report.
    pub report: Report,
    /// The strength with which it was received; `None` where that tells nothing of the link: the packet
    /// came later than the sender's packets do, so that it may have been held back and sent again.
    pub rssi: Option<Dbm>,
    /// The strength with which its sender received this drone's last packet, if one came since the
    /// sender's report before.
    pub reverse: Option<Dbm>,
}

/// Another drone from which this one has received a report.
#[derive(Clone, Copy, Debug)]
pub struct Neighbour {
    /// The last report of the drone.
    pub report: Report,
    /// The strength of its last packet that was measured.
    pub raw: Dbm,
    heard_at: Instant,
    /// What this drone has flown towards it since then.
    approached: Metres,
    /// How many of its reports have come without a strength since the last one with one.
    unmeasured: u8,
    filter: LinkFilter,
}

/// A drone of the chain that has been silent for longer is taken to be gone: of fades that last 3 s on
/// average, the longest that are drawn, one in 800 lasts longer. Our own number.
const GONE_AFTER: Duration = Duration::from_secs(20);
/// Reports without a strength, one after the other, after which the strength of a link is taken to be
/// reckoned only: a second's. Our own number.
const RECKONED: u8 = 5;
/// The part of the distance to a silent drone that this drone may fly towards it: if the silent drone does
/// the same, two fifths of the distance are left between them, for what the distance is wrong by.
const APPROACH: f32 = 0.3;

impl Neighbour {
    /// The filtered strength of the link to it.
    #[must_use]
    pub fn rssi(&self) -> Dbm {
        self.filter.rssi().unwrap_or(self.raw)
    }

    /// Whether the strength of the link is only reckoned by what both drones have flown: so many
    /// reports in a row have come without one.
    #[must_use]
    pub const fn is_reckoned(&self) -> bool {
        self.unmeasured >= RECKONED
    }

    /// Whether this drone has flown so far towards it, since it was last heard, that the two might
    /// collide. The distance is that at which a log-distance law with an exponent of 2.5 has the slope
    /// of the link, or that the strength of the link stands for, if that is less: round a corner, where
    /// a link is steeper and weaker, the first is less than the true one.
    fn is_near(&self) -> bool {
        let by_law = PAPER_SLOPE.at(self.rssi().loss()).0;
        let slope = self.state().map_or(by_law, |link| link.slopes[0].0.max(by_law));
        self.approached.0 > APPROACH * FOLD_DB / slope
    }

    /// The loss and the slopes of the link to it, where the smoothing estimates slopes.
    #[must_use]
    pub fn state(&self) -> Option<LinkState> {
        self.filter.state()
    }
}

/// The places of a drone's two links in its table of neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends {
    front: Option<usize>,
    back: Option<usize>,
}

impl Ends {
    /// No link in either direction.
    pub const NONE: Self = Self { front: None, back: None };
}

/// The table of all drones from which this one has received reports.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    all: Vec<Neighbour, MAX_NEIGHBOURS>,
}

impl Neighbours {
    /// A table without any drone.
    #[must_use]
    pub const fn new() -> Self {
        Self { all: Vec::new() }
    }

    /// Processes a round: `dt` of flight at `own_velocity` along the tunnel, and the reports that
    /// came meanwhile.
    pub fn listen(
        &mut self,
        me: NodeId,
        now: Instant,
        (own_velocity, dt): (MetresPerSecond, Duration),
        heard: impl IntoIterator<Item = Heard>,
        smoothing: &Smoothing,
        lost_after: Duration,
    ) {
        for neighbour in &mut self.all {
            let is_ahead = neighbour.report.from < me;
            neighbour.approached += own_velocity * dt * if is_ahead { 1.0 } else { -1.0 };
        }
        let by_way = matches!(smoothing, Smoothing::Slopes(_));
        // The reports came at any time of the round: in the middle of it, on average.
        let half = own_velocity * dt * 0.5;
        if by_way {
            self.fly(me, half, smoothing);
        } else {
            self.predict(me, own_velocity, dt, smoothing);
        }
        heard.into_iter().for_each(|it| self.hear(me, now, &it, smoothing, lost_after));
        if by_way {
            self.fly(me, half, smoothing);
            for neighbour in &mut self.all {
                neighbour.filter.predict(smoothing, MetresPerSecond::ZERO, dt);
            }
        }
    }

    /// Moves every link on over a way of this drone.
    fn fly(&mut self, me: NodeId, way: Metres, smoothing: &Smoothing) {
        for neighbour in &mut self.all {
            let own = if neighbour.report.from < me { -way } else { way };
            neighbour.filter.separate(smoothing, Separation { own, peer: Metres::ZERO });
        }
    }

    /// Predicts every link over `dt`, in which this drone flew at `own_velocity` along the tunnel
    /// and the others at the velocities of their last reports.
    pub fn predict(
        &mut self,
        me: NodeId,
        own_velocity: MetresPerSecond,
        dt: Duration,
        smoothing: &Smoothing,
    ) {
        for neighbour in &mut self.all {
            let theirs = neighbour.report.velocity;
            let separating = if neighbour.report.from < me {
                theirs - own_velocity
            } else {
                own_velocity - theirs
            };
            neighbour.filter.predict(smoothing, separating, dt);
        }
    }

    /// Begins all estimates anew: this drone has left the ground.
    pub fn begin_anew(&mut self) {
        for neighbour in &mut self.all {
            neighbour.filter.reset();
        }
    }

    /// Processes one received report. A drone's own echo, a packet without a strength of a drone that
    /// is not known, and a report older than the last one of its sender change nothing;
    /// when the table is full, the drone that has been silent for longest is removed. The link of a
    /// report without a strength is moved on by what both drones have flown.
    pub fn hear(
        &mut self,
        me: NodeId,
        now: Instant,
        heard: &Heard,
        smoothing: &Smoothing,
        lost_after: Duration,
    ) {
        let Heard { report, rssi, reverse } = *heard;
        let measured = rssi.filter(|rssi| rssi.0.is_finite());
        if report.from == me || rssi.is_some() && measured.is_none() {
            return;
        }
        if let Some(known) = self.all.iter_mut().find(|n| n.report.from == report.from) {
            let was_lost = now.since(known.heard_at) > lost_after;
            if !was_lost && !newer(report.sequence, known.report.sequence) {
                return;
            }
            // An antenna on the ground loses some 10 dB, which are no sign of a way.
            let has_risen = known.report.phase.is_low() && !report.phase.is_low();
            if (was_lost || has_risen) && measured.is_some() {
                known.filter.reset();
            }
            let elapsed = now.since(known.heard_at);
            let peer = way_since(&known.report, &report, elapsed);
            let peer = if report.from < me { peer } else { -peer };
            known.filter.separate(smoothing, Separation { own: Metres::ZERO, peer });
            if let Some(rssi) = measured {
                known.filter.update(smoothing, rssi);
                known.raw = rssi;
            }
            if let (Smoothing::Slopes(config), Some(reverse)) = (smoothing, reverse)
                && config.hears_both_ends
            {
                known.filter.update(smoothing, reverse);
            }
            known.unmeasured = match measured.or(reverse) {
                Some(_) => 0,
                None => known.unmeasured.saturating_add(1),
            };
            known.report = report;
            known.heard_at = now;
            known.approached = Metres::ZERO;
            return;
        }
        let Some(raw) = measured else { return };
        let mut filter = LinkFilter::new();
        filter.update(smoothing, raw);
        let approached = Metres::ZERO;
        let newcomer = Neighbour { report, raw, heard_at: now, approached, unmeasured: 0, filter };
        if let Err(newcomer) = self.all.push(newcomer)
            && let Some(oldest) = self.all.iter_mut().min_by_key(|n| n.heard_at)
        {
            *oldest = newcomer;
        }
    }

    /// The two links of a drone of this number: the nearest drones of the chain towards the head
    /// and towards the base among those that are heard. They are valid until the next call of
    /// [`Neighbours::hear`].
    #[must_use]
    pub fn ends(&self, me: NodeId, now: Instant, lost_after: Duration) -> Ends {
        let mut ends = Ends::NONE;
        for (index, n) in self.all.iter().enumerate() {
            let is_link = n.report.phase.is_link() && now.since(n.heard_at) <= lost_after;
            let from = n.report.from;
            if is_link && from < me && self.front(ends).is_none_or(|front| front.report.from < from)
            {
                ends.front = Some(index);
            } else if is_link
                && from > me
                && self.back(ends).is_none_or(|back| back.report.from > from)
            {
                ends.back = Some(index);
            }
        }
        ends
    }

    /// Whether a silent drone of the chain, between this one and its ends, may be so near in front or
    /// behind that this drone must not fly on towards it.
    #[must_use]
    pub fn may_collide(&self, me: NodeId, now: Instant, ends: Ends) -> [bool; 2] {
        let [front, back] = [self.front(ends), self.back(ends)].map(|n| n.map(|n| n.report.from));
        let silent = self
            .known(now)
            .filter(|n| matches!(n.report.phase, Phase::Linked | Phase::Searching) && n.is_near());
        silent.fold([false; 2], |[ahead, behind], n| {
            let from = n.report.from;
            let is_ahead = from < me && front.is_none_or(|front| front < from);
            let is_behind = from > me && back.is_none_or(|back| from < back);
            [ahead || is_ahead, behind || is_behind]
        })
    }

    /// The drone in front, or `None` while none is heard.
    #[must_use]
    pub fn front(&self, ends: Ends) -> Option<&Neighbour> {
        self.all.get(ends.front?)
    }

    /// The estimates of the links to all drones of the table, lost or not, in the order in which the
    /// drones were first heard.
    pub fn estimates(&self) -> impl Iterator<Item = (NodeId, LinkEstimate)> {
        self.all.iter().filter_map(|n| Some((n.report.from, n.filter.estimate()?)))
    }

    /// The states of the links to all drones of the table, lost or not, where the smoothing estimates
    /// slopes.
    pub fn states(&self) -> impl Iterator<Item = LinkState> {
        self.all.iter().filter_map(Neighbour::state)
    }

    /// The drone behind, or `None` while none is heard.
    #[must_use]
    pub fn back(&self, ends: Ends) -> Option<&Neighbour> {
        self.all.get(ends.back?)
    }

    /// All drones that were heard and are not taken to be gone, whether links of the chain or not.
    pub fn known(&self, now: Instant) -> impl Iterator<Item = &Neighbour> {
        self.heard(now, GONE_AFTER)
    }

    /// All drones heard within the last `lost_after`, whether links of the chain or not.
    pub fn heard(&self, now: Instant, lost_after: Duration) -> impl Iterator<Item = &Neighbour> {
        self.all.iter().filter(move |n| now.since(n.heard_at) <= lost_after)
    }
}

/// A neighbour's way between two of its reports; zero where its odometer has begun anew.
fn way_since(before: &Report, after: &Report, elapsed: Duration) -> Metres {
    /// Drones fly at half of this.
    const FASTEST: MetresPerSecond = MetresPerSecond(1.0);
    const ROUND: Duration = Duration::from_millis(400);
    let way = after.odometer - before.odometer;
    let most = FASTEST * (elapsed + ROUND);
    if way.0.abs() <= most.0 { way } else { Metres::ZERO }
}
