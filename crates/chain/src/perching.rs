//! The rule by which a drone of the chain perches: it lands at its place and goes on relaying from the ground.
//!
//! A drone on the ground uses next to no battery, but its antenna lies on the floor. So it lands only
//! where both of its links bear that loss, at this end and, where the neighbour is a drone too, at the
//! other. Links are told as they would be if both ends were in the air, so that a landing changes
//! neither the estimates of links nor the sums over the chain.

use units::{Db, Dbm, Phase};

/// The constants of perching.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerchConfig {
    /// The loss of an antenna on the ground: the penalty for it in the authors' firmware
    /// (`tunnel_config.h`).
    pub ground_loss: Db,
    /// By so much may a link between drones on the ground be weaker than the limit of the retreat:
    /// nothing moves there, so that less is kept in reserve. Our own number; with the authors' limit
    /// it leaves 10 dB above the sensitivity of the nRF51 at 2 Mbit/s.
    pub concession: Db,
    /// By so much more than it has to be at its landing is a link to be where a drone looks for a spot:
    /// neither the filter of a link nor its neighbour stands still meanwhile. Our own number, three
    /// times the deviation of a filtered strength in the simulator.
    pub reserve: Db,
}

impl PerchConfig {
    /// The constants.
    pub const DEFAULT: Self =
        Self { ground_loss: Db(10.0), concession: Db(10.0), reserve: Db(2.0) };

    /// What a drone in `own` phase adds to the strength of a packet from a drone in `other` phase,
    /// for the strength that it would have if both were in the air.
    #[must_use]
    pub fn lift(&self, own: Phase, other: Phase) -> Db {
        let ends = [own, other].into_iter().filter(|phase| *phase == Phase::Perched);
        ends.fold(Db(0.0), |lift, _| lift + self.ground_loss)
    }

    /// By how much a link of this strength in the air, to a neighbour in `other` phase, is stronger than
    /// it has to be to stay a link when the drones at its ends are on the ground, with this limit of the
    /// retreat.
    #[must_use]
    pub fn over(&self, link: Dbm, other: Phase, retreat: Dbm) -> Db {
        let here = link - self.ground_loss;
        let both = if other == Phase::Base { here } else { here - self.ground_loss };
        both - (retreat - self.concession)
    }
}

impl Default for PerchConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: PerchConfig = PerchConfig::DEFAULT;

    fn bears(link: f32, other: Phase) -> bool {
        CONFIG.over(Dbm(link), other, Dbm(-65.0)) >= Db(0.0)
    }

    #[test]
    fn a_link_bears_the_loss_at_each_end_that_is_a_drone() {
        assert!(bears(-55.0, Phase::Linked));
        assert!(!bears(-55.1, Phase::Linked));
        assert!(!bears(-55.1, Phase::Perched), "it is told as in the air");
        assert!(bears(-65.0, Phase::Base));
        assert!(!bears(-65.1, Phase::Base));
        assert!(!bears(f32::NAN, Phase::Base));
    }

    #[test]
    fn the_lift_is_the_loss_of_each_end_on_the_ground() {
        assert_eq!(CONFIG.lift(Phase::Linked, Phase::Base), Db(0.0));
        assert_eq!(CONFIG.lift(Phase::Perched, Phase::Base), Db(10.0));
        assert_eq!(CONFIG.lift(Phase::Linked, Phase::Perched), Db(10.0));
        assert_eq!(CONFIG.lift(Phase::Perched, Phase::Perched), Db(20.0));
    }
}
