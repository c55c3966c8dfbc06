//! Sets of robots, and the connected components of the radio graph.

/// The most robots that explore together.
pub const MOST_ROBOTS: usize = 64;

/// A set of robots' numbers, each below [`MOST_ROBOTS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RobotSet(u64);

impl RobotSet {
    /// The set without a robot.
    pub const EMPTY: Self = Self(0);

    /// The set of one robot; empty where the number is none of a robot.
    #[must_use]
    pub const fn of(robot: u8) -> Self {
        match 1_u64.checked_shl(robot as u32) {
            Some(bit) => Self(bit),
            None => Self::EMPTY,
        }
    }

    /// Whether the robot belongs to the set.
    #[must_use]
    pub const fn contains(self, robot: u8) -> bool {
        self.0 & Self::of(robot).0 != 0
    }

    /// Whether the set has no robot.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The set and one robot more.
    #[must_use]
    pub const fn with(self, robot: u8) -> Self {
        Self(self.0 | Self::of(robot).0)
    }

    /// The set without that robot.
    #[must_use]
    pub const fn without(self, robot: u8) -> Self {
        Self(self.0 & !Self::of(robot).0)
    }

    /// The set of that robot alone, where it belongs to this one; empty otherwise.
    #[must_use]
    pub const fn only(self, robot: u8) -> Self {
        Self(self.0 & Self::of(robot).0)
    }

    /// The robots of either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The robots of this set that do not belong to the other.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The lowest number of the set.
    #[must_use]
    pub const fn first(self) -> Option<u8> {
        if self.0 == 0 { None } else { Some(self.0.trailing_zeros() as u8) }
    }

    /// The numbers, in order.
    pub fn iter(self) -> impl Iterator<Item = u8> {
        let mut left = self;
        core::iter::from_fn(move || {
            let first = left.first()?;
            left = left.without(first);
            Some(first)
        })
    }

    /// How many robots belong to the set.
    #[must_use]
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }
}

impl FromIterator<u8> for RobotSet {
    fn from_iter<I: IntoIterator<Item = u8>>(robots: I) -> Self {
        robots.into_iter().fold(Self::EMPTY, Self::with)
    }
}

/// The robots of the connected component of the radio graph in which a robot is. `hears` says whom
/// a robot hears; a link counts where both ends hear each other.
#[must_use]
pub fn cluster(robot: u8, hears: impl Fn(u8) -> RobotSet) -> RobotSet {
    let mut members = RobotSet::of(robot);
    let mut fresh = members;
    while let Some(one) = fresh.first() {
        fresh = fresh.without(one);
        let linked = hears(one).iter().filter(|&other| hears(other).contains(one)).collect();
        let new = RobotSet::minus(linked, members);
        members = members.union(new);
        fresh = fresh.union(new);
    }
    members
}
