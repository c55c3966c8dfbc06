//! The chain-wide movement policy: every relay computes from its neighbours' reports the loss that
//! all links of the chain would have if they were equal, and flies to the place where its own links
//! have that loss.
//!
//! With a rule that compares only a relay's two links, differences spread along the chain by
//! diffusion, in a time that grows with the square of the number of links. This policy uses two
//! sums in each report instead. Link j, with the loss r_j and the slope g_j, has the loss L once it
//! is longer by
//!
//! > Δ_j(L) = (d_j / g_j) · (exp((L − r_j) / d_j) − 1),  d_j = 10.9 dB,
//!
//! which is exact for the log-distance law with an exponent of 2.5, and (L − r_j)/g_j for small
//! differences under any law. The chain keeps its length, so all links are equal at the *level* L
//! at which the Δ_j add up to zero, and a relay is then at its place if it moves by
//!
//! > m = Σ Δ_j(L), over the links between it and the base.
//!
//! The sums Σ (L/g_j − Δ_j) and Σ 1/g_j over the links on either side of a report's sender are in
//! the report ([`LinkSum`]); a relay adds its own link to its neighbour's sums and passes the
//! result on. The quotient of both sums over the whole chain is the next L: this is Newton's method
//! on the equations "all links are equal", carried out by the chain itself, with as many numbers in
//! a packet for 15 links as for two. A neighbour that reports no sums counts as an end of the
//! chain.
//!
//! # Links that step
//! Where a corner interrupts the line of sight, the loss of a link steps by 10 to 20 dB. No chain
//! has equal links then, and a relay that seeks them oscillates across the step. The link filter
//! remembers the length at which a link steps ([`LinkStep`]). Such a link's Δ_j(L) is constant for
//! all levels between the losses on either side of the step: the link stays on the side with the
//! smaller loss for as long as that costs the other links less than the step would cost this one,
//! which makes the weakest link as strong as possible.
//!
//! # Noise
//! A link whose loss differs from the level by no more than the filter's own deviation counts as
//! equal to it, so that a chain that has settled stands still. The part of its gain that a relay uses
//! shrinks each time that its imbalance changes its sign, and grows again while an imbalance or a
//! missing way persists (M. Riedmiller and H. Braun, *A direct adaptive method for faster
//! backpropagation learning*, 1993, do so with the steps of a descent). A relay uses its whole gain
//! while the head flies, whose motion and not the noise then makes the links unequal, and while the head
//! calls for a relay, since its links hold it then until the chain is longer.

use units::{Db, DbPerMetre, Duration, LinkSum, Metres, MetresPerDb, MetresPerSecond};

use crate::filter::{LinkState, LinkStep};

/// The constants of the chain-wide policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainWide {
    /// The part of the distance to its place that a relay flies in a second, 1/s.
    pub gain: f32,
    /// The part of its own imbalance that a relay takes away in a second, 1/s.
    pub local_gain: f32,
    /// The part, 0 to 1, of the head's velocity with which a relay follows the head, in proportion
    /// to its place in the chain.
    pub follow: f32,
    /// A relay nearer to its place than this only evens out its own two links.
    pub near: Metres,
    /// A link counts as equal to the level when it differs by no more than this many of the
    /// filter's standard deviations.
    pub deviations: f32,
    /// The largest difference within which a link counts as equal to the level, whatever the
    /// filter's standard deviation.
    pub tolerance: Db,
    /// The distance that a link keeps from a length at which it steps.
    pub margin: Metres,
    /// The constants by which the part of the gain that a relay uses adapts.
    pub caution: Caution,
}

/// The constants by which the part of its gain that a relay uses adapts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caution {
    /// The least part of its gain that a relay uses.
    pub least: f32,
    /// The factor by which the part changes when the imbalance changes its sign.
    pub down: f32,
    /// The factor by which the part changes in each round in which the imbalance is larger than
    /// three standard deviations and has kept its sign.
    pub up: f32,
    /// A relay uses its whole gain while the head is at least this fast, or calls. While the head is
    /// slower, the unused part of the gain is used in proportion to the head's velocity.
    pub whole_gain_from: MetresPerSecond,
}

/// One side of a relay: the link to its neighbour, and the links beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// The link to the neighbour.
    pub link: LinkState,
    /// The sums over the links beyond the neighbour.
    pub beyond: LinkSum,
}

/// What the relays are told of the head.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadNews {
    /// The velocity of the head along the tunnel, smoothed.
    pub velocity: MetresPerSecond,
    /// Whether the head is held by its links and calls for a relay.
    pub calls: bool,
}

/// The change of a link's length that would give it the loss of the level.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wanted {
    /// Δ_j, negative where the link should grow shorter.
    lengthening: Metres,
    /// The slope of the link at that length.
    slope: DbPerMetre,
}

/// d_j for an exponent of 2.5: 10 · 2.5 / ln 10. Over so many decibels a link becomes longer by a
/// factor of e.
pub(crate) const FOLD_DB: f32 = 10.857;
/// The largest number of such factors that is used.
const MOST_FOLDS: f32 = 2.0;

/// The slope of a link at a step, dB/m: a step of 10 dB is a slope over the reach of an antenna.
const STEP_SLOPE: f32 = 50.0;

/// The factor by which a link is longer whose loss has grown by `excess` dB.
fn stretch(excess: f32) -> f32 {
    libm::expf((excess / FOLD_DB).clamp(-MOST_FOLDS, MOST_FOLDS))
}

/// By how much a link with this slope, dB/m, is longer when its loss has grown by `excess` dB.
pub(crate) fn lengthening(slope: f32, excess: f32) -> Metres {
    Metres(FOLD_DB / slope * (stretch(excess) - 1.0))
}

impl Wanted {
    /// What `link` should do for the loss `level`.
    fn of(config: &ChainWide, link: &LinkState, level: Db) -> Self {
        let slope = 0.5 * (link.slopes[0].0 + link.slopes[1].0);
        let equal = (config.deviations * libm::sqrtf(link.variance)).min(config.tolerance.0);
        let excess = outside((level - link.loss).0, equal);
        if let Some(step) = link.step {
            return Self::at_step(config, &step, slope, excess);
        }
        Self { lengthening: lengthening(slope, excess), slope: DbPerMetre(slope / stretch(excess)) }
    }

    /// The same near a step, with the level `excess` above the link's loss.
    fn at_step(config: &ChainWide, step: &LinkStep, slope: f32, excess: f32) -> Self {
        let room = step.room.0;
        let edge = room - config.margin.0;
        // The losses on either side of the step, over the link's present loss.
        let at_edge = slope * room;
        let (good, bad) = if step.is_beyond {
            (at_edge - step.height.0, at_edge)
        } else {
            (at_edge, at_edge + step.height.0)
        };
        let (lengthening, slope) = if excess <= good {
            (edge.min(room + (excess - good) / slope), slope)
        } else if excess < bad {
            (edge, STEP_SLOPE)
        } else {
            (room + (excess - bad) / slope, slope)
        };
        Self { lengthening: Metres(lengthening), slope: DbPerMetre(slope) }
    }

    /// The sums over this one link, for a level of `level` over the reference loss.
    fn sum(self, level: Db) -> LinkSum {
        let compliance = 1.0 / self.slope.0;
        LinkSum {
            surplus: Metres(level.0 * compliance - self.lengthening.0),
            compliance: MetresPerDb(compliance),
            links: 1,
        }
    }

    /// By how much the link's loss differs from the level, dB.
    fn difference(self) -> f32 {
        self.lengthening.0 * self.slope.0
    }
}

/// The state of one drone's chain-wide policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainWideState {
    /// The level, over the reference loss of [`LinkSum`]; `None` before the first sums.
    level: Option<Db>,
    /// The part of its gain that the relay uses.
    caution: f32,
    /// The sign of the last imbalance.
    sign: f32,
    /// For how many seconds the relay has been away from its place, negative where its place is
    /// behind it.
    away_s: f32,
}

/// A relay is away from its place at more than this, m.
const AWAY: f32 = 0.3;
/// After so many seconds away a relay uses its whole gain again, within about so many more.
const AWAY_S: f32 = 3.0;
const RECOVERY_S: f32 = 2.0;

impl Default for ChainWideState {
    fn default() -> Self {
        Self::new()
    }
}

impl ChainWideState {
    /// The state of a drone that has not received any sums yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { level: None, caution: 1.0, sign: 0.0, away_s: 0.0 }
    }

    /// The loss that all links of the chain would have if they were equal; `None` while no
    /// neighbour has reported sums.
    #[must_use]
    pub fn level(&self) -> Option<Db> {
        self.level.map(|level| LinkSum::REFERENCE + level)
    }

    /// Processes the sums over the links in front and behind, once a round.
    pub fn listen(&mut self, [ahead, behind]: [LinkSum; 2]) {
        self.level = ahead.and(behind).level();
    }

    /// The sums over one side of the drone, for its own report.
    #[must_use]
    pub fn sum(&self, config: &ChainWide, side: &Side) -> LinkSum {
        let reference = LinkSum::REFERENCE;
        let level = self.level.unwrap_or(side.link.loss - reference);
        Wanted::of(config, &side.link, reference + level).sum(level).and(side.beyond)
    }

    /// The velocity of a relay between these two sides over the next round of `dt`. Every relay
    /// follows the velocity of the `head` in proportion to its place in the chain, because the links show
    /// a motion of the head only after it has made them unequal.
    pub fn step(
        &mut self,
        config: &ChainWide,
        dt: Duration,
        [front, back]: [&Side; 2],
        head: HeadNews,
    ) -> MetresPerSecond {
        let (ahead, behind) = (self.sum(config, front), self.sum(config, back));
        let Some(level) = ahead.and(behind).level() else { return MetresPerSecond::ZERO };
        let missing = level.0 * behind.compliance.0 - behind.surplus.0;

        let wanted = |side: &Side| Wanted::of(config, &side.link, LinkSum::REFERENCE + level);
        let [in_front, in_back] = [wanted(front), wanted(back)];
        let imbalance = in_back.difference() - in_front.difference();
        // Only this relay's own motion counts here, and round a corner its slope may be a tenth of the
        // neighbour's.
        let own = |side: &Side, wanted: &Wanted| match side.link.step {
            None => side.link.slopes[0].0,
            Some(_) => wanted.slope.0,
        };
        let local = imbalance / (own(front, &in_front) + own(back, &in_back));

        let deviation = libm::sqrtf(front.link.variance + back.link.variance);
        self.adapt(&config.caution, dt, imbalance / deviation, missing);
        let feedback = config.gain * outside(missing, config.near.0) + config.local_gain * local;
        let share = behind.compliance.0 / (ahead.compliance.0 + behind.compliance.0);
        let under_way = match head.calls {
            true => 1.0,
            false => (head.velocity.0.abs() / config.caution.whole_gain_from.0).min(1.0),
        };
        let used = self.caution + (1.0 - self.caution) * under_way;
        MetresPerSecond(used * feedback) + head.velocity * (config.follow * share)
    }

    /// Adapts the part of the gain to an imbalance, in standard deviations, and a way that is
    /// missing, in metres.
    fn adapt(&mut self, caution: &Caution, dt: Duration, imbalance: f32, missing: f32) {
        let sign = if imbalance > 0.0 { 1.0 } else { -1.0 };
        if sign * self.sign < 0.0 {
            self.caution = (self.caution * caution.down).max(caution.least);
        } else if imbalance.abs() > 3.0 {
            self.caution = (self.caution * caution.up).min(1.0);
        }
        self.sign = sign;
        let seconds = dt.as_secs_f32();
        if missing.abs() <= AWAY {
            self.away_s = 0.0;
        } else if missing * self.away_s < 0.0 {
            self.away_s = seconds.copysign(missing);
        } else {
            self.away_s += seconds.copysign(missing);
        }
        if self.away_s.abs() > AWAY_S {
            self.caution += (1.0 - self.caution) * (seconds / RECOVERY_S).min(1.0);
        }
    }
}

/// The part of `value` that is farther from zero than `near`.
fn outside(value: f32, near: f32) -> f32 {
    value - value.max(-near).min(near)
}
