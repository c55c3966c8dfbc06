//! The places of a swarm's missions: two areas, and a passage between them.

use std::fmt::Write;

use scenario::Fidelity;
use units::Point2;

/// The extent of each area to the north, m: the paper's.
const AREA_NORTH_M: f32 = 7.5;
/// The extent of each area to the east for each drone, m, and for six drones and more: with the paper's 9 m for
/// six of them one battery lasts for both areas, and in smaller swarms each drone surveys as much.
const AREA_EAST_M: f32 = 1.5;
const LARGEST_EAST_M: f32 = 9.0;
/// An area ends so far before the wall in which the passage begins, m: D_int of the paper.
const FORECOURT_M: f32 = 0.75;
/// The rooms reach so far beyond the outer ends of the areas, m: D_int of the paper, and some more where the
/// drones stand. To the sides it is D_int.
const AROUND_M: f32 = 0.95;
/// The base stands so far within its room, m.
const BASE_M: f32 = 0.5;
/// The length of every passage, m. The paper does not state it.
const LENGTH_M: f32 = 6.0;
/// The widths of the paper's passages a, b and c, m (section 6.2).
const WIDTHS_M: [f32; 3] = [0.95, 1.51, 2.26];
/// How far the middle of passage d lies beside the straight line between its ends, m.
const BEND_M: f32 = 1.5;
/// Half the length of what narrows a passage, m: the wedges of e, and the blunt narrowing.
const HALF_NARROWING_M: f32 = 0.5;
/// A step in the width of a gallery is a slope so long, m.
const STEP_M: f32 = 0.01;
/// A mission lasts so long, s: a battery, and the time to land.
const DURATION_S: f32 = 420.0;
/// The gallery through rooms, and through passages that rooms make, is so narrow, m, that it adds no space.
const THIN_M: f32 = 0.5;
/// Where a drone is lost, it is this one, and then, s.
const LOST: (usize, f32) = (1, 40.0);

/// A passage between two areas. It begins at x = 0.
pub(super) struct Place {
    /// Its name on the command line.
    pub(super) name: &'static str,
    /// What it is.
    pub(super) about: &'static str,
    /// The width of its entrance from south to north, m.
    width_m: f32,
    shape: Shape,
}

/// The free space of a passage.
enum Shape {
    /// A gallery along a line, with its width at each point of it.
    Gallery(&'static [(f32, f32, f32)]),
    /// Rectangles, by their western, southern, eastern and northern side, and the line through them along
    /// which links are measured.
    Rooms(&'static [[f32; 4]], &'static [(f32, f32)]),
}

const A: f32 = WIDTHS_M[0];
const B: f32 = WIDTHS_M[1];
const C: f32 = WIDTHS_M[2];
const MIDDLE: f32 = 0.5 * LENGTH_M;
/// The width of d across its legs, whose walls are 1.51 m apart from south to north.
const ACROSS_D: f32 = B * 0.894_427_2;
/// How far the legs of d reach into the rooms, to the west or east and to the south, m.
const IN_ROOM_D: (f32, f32) = (1.0, 0.5);
const FROM: f32 = MIDDLE - HALF_NARROWING_M;
const TO: f32 = MIDDLE + HALF_NARROWING_M;

/// The passages. Those from `blunt` on are of this project: the paper speaks of obstacles in a passage,
/// and has no figure of one.
pub(super) const PLACES: [Place; 9] = [
    gallery("a", "straight, for a queue", A, &[(0.0, 0.0, A), (LENGTH_M, 0.0, A)]),
    gallery("b", "straight, for two rows", B, &[(0.0, 0.0, B), (LENGTH_M, 0.0, B)]),
    gallery("c", "straight, for three rows", C, &[(0.0, 0.0, C), (LENGTH_M, 0.0, C)]),
    gallery(
        "d",
        "as wide as b, with a corner in the middle",
        B,
        // Its legs begin in the rooms, so that nothing of their bends there is in the passage.
        &[
            (-IN_ROOM_D.0, -IN_ROOM_D.1, ACROSS_D),
            (MIDDLE, BEND_M, ACROSS_D),
            (LENGTH_M + IN_ROOM_D.0, -IN_ROOM_D.1, ACROSS_D),
        ],
    ),
    gallery(
        "e",
        "as wide as b, with wedges that leave the width of a",
        B,
        &[(0.0, 0.0, B), (FROM, 0.0, B), (MIDDLE, 0.0, A), (TO, 0.0, B), (LENGTH_M, 0.0, B)],
    ),
    gallery(
        "blunt",
        "as wide as b, with blocks that leave the width of a for a metre",
        B,
        &[
            (0.0, 0.0, B),
            (FROM - STEP_M, 0.0, B),
            (FROM, 0.0, A),
            (TO, 0.0, A),
            (TO + STEP_M, 0.0, B),
            (LENGTH_M, 0.0, B),
        ],
    ),
    Place {
        name: "pillar",
        about: "as wide as c, with a pillar of 0.5 m by 0.5 m in the middle",
        width_m: C,
        shape: Shape::Rooms(
            &[
                [0.0, -1.13, 2.75, 1.13],
                [3.25, -1.13, 6.0, 1.13],
                [2.7, 0.25, 3.3, 1.13],
                [2.7, -1.13, 3.3, -0.25],
            ],
            &[(0.0, 0.0), (1.0, 0.0), (2.0, 0.69), (4.0, 0.69), (5.0, 0.0), (6.0, 0.0)],
        ),
    },
    Place {
        name: "block",
        about: "as wide as c, with a block that leaves 1 m at one side for 2 m",
        width_m: C,
        shape: Shape::Rooms(
            &[[0.0, -1.13, 2.0, 1.13], [4.0, -1.13, 6.0, 1.13], [1.9, 0.13, 4.1, 1.13]],
            &[(0.0, 0.0), (0.5, 0.0), (1.5, 0.63), (4.5, 0.63), (5.5, 0.0), (6.0, 0.0)],
        ),
    },
    Place {
        name: "door",
        about: "as wide as c, with a wall of 0.2 m in the middle, and a door of 0.9 m in it",
        width_m: C,
        shape: Shape::Rooms(
            &[[0.0, -1.13, 2.9, 1.13], [3.1, -1.13, 6.0, 1.13], [2.8, -0.45, 3.2, 0.45]],
            &[(0.0, 0.0), (6.0, 0.0)],
        ),
    },
];

const fn gallery(
    name: &'static str,
    about: &'static str,
    width_m: f32,
    line: &'static [(f32, f32, f32)],
) -> Place {
    Place { name, about, width_m, shape: Shape::Gallery(line) }
}

impl Place {
    /// The scenario in which so many drones survey the area before this passage, cross it, and survey the
    /// area behind it. Where one is lost, it falls out of the swarm during the first survey.
    pub(super) fn text(&self, drones: usize, loses_one: bool, fidelity: Fidelity) -> String {
        let area_m = (AREA_EAST_M * drones as f32).min(LARGEST_EAST_M);
        let room_m = FORECOURT_M + area_m + AROUND_M;
        let mut text = format!(
            "title = \"{drones} drones survey two areas, with passage {} between them\"\n\
             duration_s = {DURATION_S:.0}\nmission = \"swarm\"\nfidelity = \"{}\"\n\n",
            self.name,
            fidelity.name(),
        );
        self.write_tunnel(&mut text, room_m);
        let mut rooms = vec![
            [-room_m, -0.5 * AREA_NORTH_M - FORECOURT_M, 0.0, 0.5 * AREA_NORTH_M + FORECOURT_M],
            [
                LENGTH_M,
                -0.5 * AREA_NORTH_M - FORECOURT_M,
                LENGTH_M + room_m,
                0.5 * AREA_NORTH_M + FORECOURT_M,
            ],
        ];
        if let Shape::Rooms(more, _) = self.shape {
            rooms.extend(more);
        }
        for room in &rooms {
            crate::missions::write_room(&mut text, room);
        }
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "[vehicle]\nposition_noise_m = 0.01\n\n[drones]\nfetched = true\nrelays = {}\n\n\
             [swarm]\ncorner_m = [{:.2}, {:.2}]\narea_m = [{area_m:.2}, {AREA_NORTH_M}]\n\
             entrance_m = [0.0, 0.0]\nwidth_m = {}\nlength_m = {LENGTH_M}\nboth_areas = true\n\n\
             [[pilot]]\nat_s = 1.0\norder = \"explore\"\nspeed_mps = 0.2\n",
            drones - 1,
            -FORECOURT_M - area_m,
            -0.5 * AREA_NORTH_M,
            self.width_m,
        );
        if loses_one {
            let (drone, at_s) = LOST;
            let _ = write!(text, "\n[[loss]]\nat_s = {at_s:.1}\ndrone = {drone}\nhow = \"gone\"\n");
        }
        text
    }

    /// Writes the main gallery, from the base to the far end of the second room.
    fn write_tunnel(&self, text: &mut String, room_m: f32) {
        let ends =
            [Point2::new(BASE_M - room_m, 0.0), Point2::new(LENGTH_M + room_m - BASE_M, 0.0)];
        let inner: Vec<(Point2, f32)> = match self.shape {
            Shape::Gallery(line) => {
                line.iter().map(|&(x, y, width)| (Point2::new(x, y), width)).collect()
            }
            Shape::Rooms(_, line) => {
                line.iter().map(|&(x, y)| (Point2::new(x, y), THIN_M)).collect()
            }
        };
        let [first, last] = ends.map(|end| (end, THIN_M));
        let points: Vec<(Point2, f32)> = [first].into_iter().chain(inner).chain([last]).collect();
        let widths: Vec<String> = points.iter().map(|(_, width)| width.to_string()).collect();
        let line: Vec<String> =
            points.iter().map(|(at, _)| format!("[{:.2}, {:.2}]", at.x, at.y)).collect();
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "[tunnel]\nwidths_m = [{}]\ncentre_line_m = [{}]\n\n",
            widths.join(", "),
            line.join(", ")
        );
    }
}
