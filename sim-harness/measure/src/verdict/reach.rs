//! Computes where a head could have come.

use units::NodeId;
use world::{Leg, SkeletonPlace, World};

use crate::metrics::Reference;
use mission::Linked;

/// A head ends its way in a dead end so far before the rock, m: it slows down at 0.45 m
/// (`NavConfig::slow_below` of `tunnel-nav`), and a centre-line may end half a metre off.
pub(super) const END_M: f32 = 1.0;

/// The farthest distance from the base along a way, but no more than `most_m`, such that at every
/// place before it the best chain of all relays has no link weaker than `limit`, a loss in dB, m.
///
/// It supposes that every relay is at once where the best chain has it: the bound is for a head with
/// all the time that it needs.
pub(super) fn reachable_m(
    world: &World,
    reference: &Reference,
    way: &[Leg],
    limit: f32,
    most_m: f32,
) -> f32 {
    /// The distance between the places that are asked for, m.
    const STEP: f32 = 0.1;
    let length: f32 = way.iter().map(|leg| (leg.to - leg.from).abs()).sum();
    let most = (length - END_M).min(most_m);
    let mut reached = 0.0;
    for n in 1.. {
        let at = n as f32 * STEP;
        let Some(place) = place(way, at).filter(|_| at <= most) else { break };
        let head = Linked { id: NodeId::HEAD, place, way: world.way(place) };
        if reference.worst(reference.links(), &head) > limit {
            return reached;
        }
        reached = at;
    }
    most.max(0.0)
}

/// The place at this distance along a way, m.
fn place(way: &[Leg], mut rest: f32) -> Option<SkeletonPlace> {
    for leg in way {
        let length = (leg.to - leg.from).abs();
        if rest <= length {
            let along = if leg.to >= leg.from { leg.from + rest } else { leg.from - rest };
            return Some(SkeletonPlace { edge: leg.edge, along });
        }
        rest -= length;
    }
    None
}
