//! The wall on one side of the drone: whether there is one, and how long its beams are.
//!
//! The paper's ratio test uses the ranges of one moment: two beams that differ by more than 40 %
//! see no wall. At a right-angle bend that is not enough. Past the inner corner the front beam ends
//! at the *far* wall, for a while with just the length that a straight wall would give, and a drone
//! that centres itself by it flies into the corner, where all four beams are equal and no range
//! distinguishes forward from sideways. So a wall that opened stays lost, while the other side
//! still has one, until its beams have agreed while the drone flew some distance; and when the
//! front beam becomes *shorter*, the wall does not count as lost: the beam sees a wall ahead, from
//! which the drone turns away.

use units::Metres;

use crate::{NavConfig, Range};

/// The two beams of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beams {
    front: Range,
    rear: Range,
}

/// A wall that both beams see, in metres along them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wall {
    pub(crate) front: f32,
    pub(crate) rear: f32,
}

impl Wall {
    /// The difference of the front beam and the rear beam: positive when the nose points away.
    pub(crate) fn excess(&self) -> f32 {
        self.front - self.rear
    }

    fn mean(&self) -> f32 {
        0.5 * (self.front + self.rear)
    }

    /// Whether the front beam ends at a wall ahead, and not at this one: it is shorter than half of the rear
    /// beam, which no nose does that is turned to this wall by less than 18°.
    pub(crate) fn ends(&self) -> bool {
        self.front < 0.5 * self.rear
    }

    /// The ratio test of section IV-E.
    fn agrees(&self, ratio: f32) -> bool {
        self.excess().abs() <= ratio * self.mean()
    }
}

impl Beams {
    pub(crate) fn new(front: Range, rear: Range) -> Self {
        Self { front, rear }
    }

    /// Whether one of the beams is measured and sees no obstacle nearer than this, in metres.
    pub(crate) fn opens(&self, length: f32) -> bool {
        let open =
            |beam: Range| beam != Range::Invalid && beam.length().is_none_or(|beam| beam > length);
        open(self.front) || open(self.rear)
    }

    /// Whether one of the beams sees an obstacle nearer than this, in metres.
    pub(crate) fn is_nearer(&self, length: f32) -> bool {
        let near = |beam: Range| beam.length().is_some_and(|beam| beam < length);
        near(self.front) || near(self.rear)
    }

    /// Whether both see an obstacle, at distances that differ by no more than this part of their mean.
    pub(crate) fn agree(&self, ratio: f32) -> bool {
        self.wall().is_some_and(|wall| wall.agrees(ratio))
    }

    fn wall(&self) -> Option<Wall> {
        Some(Wall { front: self.front.length()?, rear: self.rear.length()? })
    }
}

/// A wall whose beams are longer than this many times the usual length is that of another gallery.
pub(crate) const SAME_GALLERY: f32 = 1.3;

/// The state of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Track {
    /// No wall was seen yet.
    #[default]
    Unknown,
    /// There is a wall.
    Seen {
        /// The length of its beams when they last agreed, in metres.
        length: f32,
    },
    /// There was a wall.
    Lost {
        /// The way flown since its beams agree again, forward positive; `None` while they do not.
        agreed: Option<f32>,
        /// Whether the other side had a wall then: the gallery opens or turns to this side.
        alone: bool,
    },
}

impl Track {
    /// The state of a side whose wall the drone leaves, though the tunnel does not open there.
    pub(crate) const LEFT_BEHIND: Self = Self::Lost { agreed: None, alone: false };

    /// Whether there is a wall whose beams are longer than this, in metres.
    pub(crate) fn is_longer(&self, length: f32) -> bool {
        matches!(self, Self::Seen { length: beams } if *beams > length)
    }

    pub(crate) const fn is_lost(&self) -> bool {
        matches!(self, Self::Lost { .. })
    }

    pub(crate) const fn is_seen(&self) -> bool {
        matches!(self, Self::Seen { .. })
    }

    /// The state of a side on which a wall was found that the beams look at.
    pub(crate) fn found(self, beams: Beams) -> Self {
        beams.wall().map_or(self, |wall| Self::Seen { length: wall.mean() })
    }

    /// The wall to steer by.
    pub(crate) fn wall(&self, beams: Beams) -> Option<Wall> {
        if self.is_seen() { beams.wall() } else { None }
    }

    /// The state after one more measurement; `other_seen` says whether the other side has a wall to
    /// go on with, `usual` is the length of the beams in this gallery.
    pub(crate) fn next(
        self,
        config: &NavConfig,
        beams: Beams,
        moved: Metres,
        other_seen: bool,
        usual: f32,
    ) -> Self {
        let alone = match self {
            Self::Lost { alone, .. } => alone,
            Self::Unknown | Self::Seen { .. } => other_seen && beams.opens(SAME_GALLERY * usual),
        };
        let Some(wall) = beams.wall() else {
            return Self::Lost { agreed: None, alone };
        };
        let agrees = wall.agrees(config.ratio);
        match self {
            Self::Seen { .. } if agrees => Self::Seen { length: wall.mean() },
            // Neither beam has opened: one of them has come nearer.
            Self::Seen { length } if wall.front.max(wall.rear) <= (1.0 + config.ratio) * length => {
                Self::Seen { length }
            }
            // With no wall left, the first one that could be of this gallery counts.
            Self::Lost { alone: false, .. }
                if agrees && !other_seen && wall.mean() <= SAME_GALLERY * usual =>
            {
                Self::Seen { length: wall.mean() }
            }
            Self::Unknown if agrees => Self::Seen { length: wall.mean() },
            Self::Lost { agreed, .. } if wall.agrees(0.5 * config.ratio) => {
                let way = agreed.map_or(0.0, |way| way + moved.0);
                // An opening beside no wall is over sooner.
                let confirm = if other_seen { config.confirm } else { 0.5 * config.confirm };
                if way.abs() >= confirm * wall.mean() {
                    Self::Seen { length: wall.mean() }
                } else {
                    Self::Lost { agreed: Some(way), alone }
                }
            }
            Self::Unknown | Self::Seen { .. } | Self::Lost { .. } => {
                Self::Lost { agreed: None, alone }
            }
        }
    }
}
