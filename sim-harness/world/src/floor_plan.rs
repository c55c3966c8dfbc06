//! Defines the floor plan that pictures and recordings show.

use units::Point2;

use crate::SkeletonPlace;

/// The tunnel seen from above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorPlan {
    /// The outlines of the free space, each closed (the last point is not the first again): outer
    /// boundaries and the pillars within them.
    pub outlines: Vec<Vec<Point2>>,
    /// The edges of the skeleton, the main gallery first.
    pub centre_lines: Vec<CentreLine>,
}

impl FloorPlan {
    /// The name of the gallery in which a place lies; empty where there is none of that number.
    #[must_use]
    pub fn edge_name(&self, place: SkeletonPlace) -> &str {
        self.centre_lines.get(usize::from(place.edge)).map_or("", |line| &line.name)
    }
}

/// One edge of the skeleton.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CentreLine {
    /// The name of the gallery.
    pub name: String,
    /// The centre-line, from its beginning to its end.
    pub points: Vec<Point2>,
}
