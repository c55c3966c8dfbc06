//! Reduces a map to the few frontiers that are worth a flight.

use grid_map::{Frame, GridMap};
use heapless::Vec;
use units::{Metres, Point2};

/// The most candidates of one robot.
pub const MOST_CANDIDATES: usize = 64;
/// The least distance between two candidates of one robot (thesis, table 3.1).
pub const SPACING: Metres = Metres(0.3);

/// A frontier that a robot may be sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The place on the floor plan.
    pub position: Point2,
    /// How many of the 48 cells around it nothing is known of.
    pub gain: u8,
}

/// The candidates of one robot.
pub type Candidates = Vec<Candidate, MOST_CANDIDATES>;

/// The candidates of a map, in the order of its cells. Of frontiers that are nearer to each other
/// than `spacing`, the one with the larger gain stays. Where there are more than
/// [`MOST_CANDIDATES`], the one with the least gain gives way.
#[must_use]
pub fn extract<const BYTES: usize>(map: &GridMap<BYTES>, spacing: Metres) -> Candidates {
    let mut kept = Candidates::new();
    let frame: &Frame = map.frame();
    for cell in map.frontiers() {
        let found = Candidate { position: frame.centre(cell), gain: map.gain(cell) };
        insert(&mut kept, found, spacing);
    }
    kept
}

fn insert(kept: &mut Candidates, found: Candidate, spacing: Metres) {
    let is_near = |other: &Candidate| other.position.distance(found.position) < spacing;
    if kept.iter().any(|other| is_near(other) && other.gain >= found.gain) {
        return;
    }
    kept.retain(|other| !is_near(other));
    if let Err(found) = kept.push(found) {
        let least = kept.iter_mut().min_by_key(|candidate| candidate.gain);
        if let Some(least) = least.filter(|least| least.gain < found.gain) {
            *least = found;
        }
    }
}
