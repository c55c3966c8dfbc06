//! The world of the drones: a tunnel on a floor plan, and the radio in it.
//!
//! The floor plan is a union of corridors and rooms ([`layout`]). A place is a point of the plan.
//! The [`Skeleton`], the graph of centre-lines, gives its position along the tunnel and its
//! distance from another place by the shortest way.

mod floor_plan;
pub mod layout;
mod optimum;
mod places;
mod polyline;
mod radio;
mod raster;
mod skeleton;
mod tunnel;
mod wall_index;

use std::sync::Arc;

use units::Point2;

pub use floor_plan::{CentreLine, FloorPlan};
pub use layout::GeometryError;
pub use optimum::{BestChains, Optimum, best_chain, best_chain_known};
pub use polyline::{Foot, Polyline};
pub use radio::{AntennaTable, FadingTable, ModelTable, ShadowingTable};
pub use radio::{Known, Radio, RadioPlace, SurveyedPlace};
pub use raster::MOST_CELLS;
pub use skeleton::forks;
pub use skeleton::{
    Edge, Gallery, Joint, Knot, Leg, Node, NodeKind, Path, Skeleton, SkeletonPlace,
};
pub use tunnel::Tunnel;

/// The distance between drones that stand in a row at the mouth before a mission, m: twice what their
/// guards need.
pub const ROW_SPACING_M: f32 = 0.35;

/// A point of the floor plan with its place on the skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The point.
    pub at: Point2,
    /// Its place on the skeleton.
    pub on: SkeletonPlace,
}

impl Spot {
    /// The point of the centre-line at this place.
    #[must_use]
    pub fn on(skeleton: &Skeleton, place: SkeletonPlace) -> Self {
        Self { at: skeleton.at(place).0, on: place }
    }
}

/// The surroundings of a mission, shared by all drones that fly in them.
pub struct World {
    /// The walls and the skeleton.
    pub tunnel: Arc<Tunnel>,
    /// The radio.
    pub radio: Arc<Radio>,
    /// The place of the base.
    pub base: Spot,
}

impl World {
    /// Makes the world of a tunnel, with this radio in it and the base at this place.
    #[must_use]
    pub fn new(tunnel: Arc<Tunnel>, radio: &RadioPlace, base: Spot) -> Self {
        let radio = Arc::new(Radio::of(&tunnel, radio));
        Self { tunnel, radio, base }
    }

    /// The graph of centre-lines.
    #[must_use]
    pub fn skeleton(&self) -> &Skeleton {
        self.tunnel.skeleton()
    }

    /// The geodesic distance of a place from the base, m.
    #[must_use]
    pub fn way(&self, place: SkeletonPlace) -> f32 {
        self.skeleton().distance(self.base.on, place).0
    }

    /// The shortest way from the base to a place.
    #[must_use]
    pub fn path_to(&self, place: SkeletonPlace) -> Path {
        self.skeleton().path(self.base.on, place)
    }
}
