//! An access point: through it go all packets, and it assigns.

use frontier::{Config, Explorer, Ground, Inputs};
use units::{Instant, Point2, Pose2, Radians};

use crate::robot::TEAM;
use crate::run::{LIMITS, RECORDS, Setup};

/// The access point of a run.
pub(crate) struct AccessPoint<G> {
    pub(crate) at: Point2,
    mind: Box<Explorer<G, TEAM, RECORDS>>,
    pub(crate) inbox: Vec<Vec<u8>>,
}

impl<G: Ground> AccessPoint<G> {
    /// The number of the access point: the lowest, with which it leads.
    pub(crate) const NUMBER: u8 = 0;

    /// An access point where the first robot begins, with a map of which it will know nothing.
    pub(crate) fn new(setup: &Setup<'_>, ground: G) -> Self {
        let config = Config::unbounded(Self::NUMBER, setup.rule, LIMITS);
        let config = Config { forwards: false, stands: true, ..config };
        Self {
            at: setup.world.starts().first().copied().unwrap_or_default(),
            mind: Box::new(Explorer::new(config, ground)),
            inbox: Vec::new(),
        }
    }

    /// The packets that it sends of its own.
    pub(crate) fn step(&mut self, now: Instant) -> Vec<Vec<u8>> {
        let inbox = std::mem::take(&mut self.inbox);
        let packets: Vec<&[u8]> = inbox.iter().map(Vec::as_slice).collect();
        let pose = Pose2 { at: self.at, yaw: Radians::ZERO };
        let outputs = self.mind.step(now, &Inputs { pose, beams: &[], packets: &packets });
        outputs.packets.iter().map(|packet| packet.to_vec()).collect()
    }
}
