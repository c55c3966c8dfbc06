//! A law of the path loss that is a table: losses that were measured, or computed elsewhere.

use units::{Db, Metres};

use crate::path_loss::{Geometry, Obstruction};

/// The losses at some distances, for each number of walls on the straight line.
///
/// Between two distances the loss is interpolated over the logarithm of the distance, in which the
/// loss of free space is a straight line. Nearer than the first distance it is the loss there;
/// beyond the last one it rises as between the last two, and never falls. A link behind more walls than
/// there are rows has the loss of the last row.
///
/// The table is borrowed for the program's whole life, so that a law stays a plain value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tabulated {
    /// The distances along the tunnel, rising, m: at least two.
    pub distances: &'static [f32],
    /// The losses, dB: those without walls at all distances, then those behind one wall, and so on.
    pub losses: &'static [f32],
}

impl Tabulated {
    /// The number of walls, which chooses the row of the table.
    pub(crate) fn term(&self, between: Obstruction) -> f32 {
        f32::from(between.walls)
    }

    /// The loss over a link with so many walls on its straight line.
    pub(crate) fn loss(&self, link: Geometry, walls: f32) -> Db {
        let count = self.distances.len();
        let rows = self.losses.len() / count.max(1);
        let row = (walls.max(0.0) as usize).min(rows.saturating_sub(1)) * count;
        let along = link.along.0;
        let next = self.distances.partition_point(|distance| *distance < along);
        let next = next.clamp(1, count.saturating_sub(1).max(1));
        let at = |n: usize| Some((*self.distances.get(n)?, *self.losses.get(row + n)?));
        let (Some((near, low)), Some((far, high))) = (at(next - 1), at(next)) else {
            return Db(0.0);
        };
        let part = libm::log10f(along.max(near) / near) / libm::log10f(far / near);
        let beyond = (part - 1.0).max(0.0);
        Db(low + (part - beyond) * (high - low) + beyond * (high - low).max(0.0))
    }

    /// The loss over the first metre in sight, at most the 100 dB that a scenario file can say.
    pub(crate) fn loss_at_1m(&self) -> Db {
        Db(self.loss(Geometry::in_sight(Metres(1.0)), 0.0).0.min(100.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Tabulated =
        Tabulated { distances: &[1.0, 10.0, 20.0], losses: &[40.0, 60.0, 66.0, 50.0, 70.0, 80.0] };

    fn loss(distance: f32, walls: f32) -> f32 {
        LAW.loss(Geometry::in_sight(Metres(distance)), walls).0
    }

    #[test]
    fn the_table_is_met_and_between_its_distances_the_loss_is_logarithmic() {
        assert_eq!([1.0, 10.0, 20.0].map(|at| loss(at, 0.0)), [40.0, 60.0, 66.0]);
        assert_eq!([1.0, 10.0, 20.0].map(|at| loss(at, 1.0)), [50.0, 70.0, 80.0]);
        assert!((loss(libm::sqrtf(10.0), 0.0) - 50.0).abs() < 1e-4);
    }

    #[test]
    fn outside_the_table_its_edges_go_on() {
        assert_eq!(loss(0.2, 0.0), 40.0);
        assert!((loss(40.0, 0.0) - 72.0).abs() < 1e-4);
        assert_eq!(loss(10.0, 7.0), loss(10.0, 1.0));
        assert_eq!(LAW.loss_at_1m(), Db(40.0));
    }

    #[test]
    fn a_table_that_ends_in_a_fade_gets_no_stronger_beyond_it() {
        let law = Tabulated { distances: &[1.0, 10.0, 20.0], losses: &[140.0, 160.0, 150.0] };
        let loss = |distance: f32| law.loss(Geometry::in_sight(Metres(distance)), 0.0).0;
        assert!((loss(20.0) - 150.0).abs() < 1e-4 && (loss(2_000.0) - 150.0).abs() < 1e-4);
        assert_eq!(law.loss_at_1m(), Db(100.0), "more could not be written into a scenario");
    }
}
