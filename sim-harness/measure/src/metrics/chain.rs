//! Computes the chain of one explorer at one moment, with the losses of its links.

use units::NodeId;
use world::World;

use mission::{Linked, Mission};

/// The chain of one explorer at one moment: the base, every relay that flies, and the explorer.
pub(super) struct Chain {
    /// Base first, explorer last.
    pub(super) members: Vec<Linked>,
    /// The large-scale losses of its links, the base's first, dB.
    pub(super) losses: Vec<f32>,
    /// The loss of the link that is received the weakest, in either direction, dB.
    pub(super) received: f32,
}

impl Chain {
    pub(super) fn of(mission: &Mission<'_>, trunk: &[Linked], explorer: Linked) -> Self {
        let members: Vec<_> = trunk.iter().copied().chain([explorer]).collect();
        let number = |linked: &Linked| usize::from(linked.id.0);
        let ends = |pair: &[Linked]| (number(&pair[0]), number(&pair[1]));
        let pairs = || members.windows(2).map(ends);
        let loss = |(back, front)| mission.large_scale_strength(back, front).loss().0;
        let losses = pairs().map(loss).collect();
        let directions = pairs().flat_map(|(back, front)| [(back, front), (front, back)]);
        let received = directions.map(|(to, from)| mission.true_strength(to, from).loss().0);
        let received = received.fold(f32::NEG_INFINITY, f32::max);
        Self { members, losses, received }
    }

    /// Its end, which explores.
    pub(super) fn explorer(&self) -> &Linked {
        &self.members[self.members.len() - 1]
    }

    /// The loss of its weakest link, dB.
    pub(super) fn weakest(&self) -> f32 {
        self.losses.iter().copied().fold(f32::NEG_INFINITY, f32::max)
    }

    /// The largest difference between adjacent links, dB.
    pub(super) fn difference(&self) -> f32 {
        let differences = self.losses.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        differences.fold(0.0, f32::max)
    }

    /// The ends and the loss of every link.
    pub(super) fn links(&self) -> impl Iterator<Item = ((NodeId, NodeId), f32)> {
        let ends = self.members.windows(2).map(|pair| (pair[0].id, pair[1].id));
        ends.zip(self.losses.iter().copied())
    }

    /// Whether two of its members have changed places.
    pub(super) fn is_out_of_order(&self, world: &World) -> bool {
        Self::is_disordered(world, &self.members)
    }

    /// Whether a member is farther out than the next one towards the explorer. Drones in different
    /// branches have no order.
    pub(super) fn is_disordered(world: &World, members: &[Linked]) -> bool {
        let (base, skeleton) = (world.base.on, world.skeleton());
        members.windows(2).any(|pair| {
            let (back, front) = (&pair[0], &pair[1]);
            front.way < back.way && skeleton.in_line(base, back.place, front.place)
        })
    }
}
