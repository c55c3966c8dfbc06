//! Follows every member of a mission along the skeleton.
//!
//! Bodies know their poses only. Each member's place on the skeleton is found anew once a round,
//! from its point and its last place; chain, radio and record ask here.

use units::{NodeId, Point2};
use world::{SkeletonPlace, Tunnel, World};

/// The members' places on the skeleton.
pub(super) struct Track {
    places: Vec<SkeletonPlace>,
}

/// A member that is a link of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linked {
    /// The member's number.
    pub id: NodeId,
    /// The member's place on the skeleton.
    pub place: SkeletonPlace,
    /// The length of the shortest way to it from the base, m.
    pub way: f32,
}

impl Track {
    pub(super) fn new(places: Vec<SkeletonPlace>) -> Self {
        Self { places }
    }

    /// Notes that a member is at this point now, and returns its place.
    pub(super) fn follow(&mut self, n: usize, at: Point2, tunnel: &Tunnel) -> SkeletonPlace {
        let place = &mut self.places[n];
        *place = tunnel.place(at, Some(*place));
        *place
    }

    /// A member's place.
    pub(super) fn place(&self, n: usize) -> SkeletonPlace {
        self.places.get(n).copied().unwrap_or_default()
    }

    /// A member as a link of the chain.
    pub(super) fn linked(&self, n: usize, world: &World) -> Linked {
        let place = self.place(n);
        Linked { id: NodeId(n as u8), place, way: world.way(place) }
    }
}
