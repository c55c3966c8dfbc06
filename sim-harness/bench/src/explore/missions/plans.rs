//! The floor plans that drones explore: named ones, and the scenario that a plan makes.

use std::fmt::Write;

use scenario::Fidelity;

/// A rectangle of free space: its western, southern, eastern and northern side, m.
pub(super) type Room = [f32; 4];

/// A floor plan. Its free space is the union of its rooms and of an entrance, in which the drones stand
/// in a row to the west of the origin.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// The name.
    pub(super) name: String,
    /// The rooms, and the doors between them. The western side of one lies at x = 0 and spans the origin.
    pub(super) rooms: Vec<Room>,
}

/// The entrance reaches so far to the west of the origin, m: a row of six drones, 0.35 m apart, the base
/// behind them, and the clearance at both ends.
const ENTRANCE_M: f32 = 3.2;
/// It is so wide, m: twice the clearance of drones that explore.
const ENTRANCE_WIDTH_M: f32 = 1.2;
/// The head stands so far inside of the entrance's end, m.
const HEAD_M: f32 = -0.3;
/// The rock around a plan that belongs to the area, m: two cells of the drones' maps.
const MARGIN_M: f32 = 0.2;
/// A mission lasts so long, s: a battery, and the time to land.
const DURATION_S: f32 = 420.0;

/// The named plans, of our own: the issues of explorers were found in such.
const NAMED: [(&str, &[Room]); 10] = [
    ("room", &[[0.0, -3.0, 6.0, 3.0]]),
    (
        "three-rooms",
        &[
            [0.0, -1.5, 2.8, 1.5],
            [2.7, 0.2, 3.1, 1.1],
            [3.0, -0.7, 5.8, 2.3],
            [5.7, -0.4, 6.1, 0.5],
            [6.0, -2.1, 8.8, 1.0],
        ],
    ),
    (
        "office",
        &[
            [0.0, -0.8, 12.0, 0.8],
            [0.0, 1.0, 2.9, 4.0],
            [1.0, 0.7, 1.9, 1.1],
            [3.1, 1.0, 5.9, 4.0],
            [4.0, 0.7, 4.9, 1.1],
            [6.1, 1.0, 8.9, 4.0],
            [7.0, 0.7, 7.9, 1.1],
            [9.1, 1.0, 12.0, 4.0],
            [10.0, 0.7, 10.9, 1.1],
            [0.0, -4.0, 2.9, -1.0],
            [0.6, -1.1, 1.5, -0.7],
            [3.1, -4.0, 5.9, -1.0],
            [3.6, -1.1, 4.5, -0.7],
            [6.1, -4.0, 8.9, -1.0],
            [7.6, -1.1, 8.5, -0.7],
            [9.1, -4.0, 12.0, -1.0],
            [10.4, -1.1, 11.3, -0.7],
        ],
    ),
    (
        "maze",
        &[
            [0.0, -4.0, 1.3, 4.0],
            [0.0, 2.7, 4.0, 4.0],
            [2.7, -2.6, 4.0, 4.0],
            [2.7, -2.6, 6.7, -1.3],
            [5.4, -2.6, 6.7, 2.6],
            [5.4, 1.3, 8.0, 2.6],
            [0.0, -4.0, 8.0, -2.8],
            [7.0, -4.0, 8.0, 0.0],
        ],
    ),
    (
        "loop",
        &[
            [0.0, -1.0, 7.0, 0.6],
            [0.0, -1.0, 1.6, 5.0],
            [0.0, 3.4, 7.0, 5.0],
            [5.4, -1.0, 7.0, 5.0],
        ],
    ),
    (
        "pillars",
        &[
            [0.0, -3.5, 1.6, 3.5],
            [2.1, -3.5, 3.7, 3.5],
            [4.2, -3.5, 5.8, 3.5],
            [6.3, -3.5, 7.9, 3.5],
            [0.0, -3.5, 7.9, -1.9],
            [0.0, -1.4, 7.9, 0.2],
            [0.0, 0.7, 7.9, 1.4],
            [0.0, 1.9, 7.9, 3.5],
        ],
    ),
    (
        "corridor",
        &[[0.0, -0.6, 9.0, 0.6], [7.8, -0.6, 9.0, 5.0], [2.5, 3.8, 9.0, 5.0], [2.5, 2.0, 3.7, 5.0]],
    ),
    (
        "small-rooms",
        &[
            [0.0, -1.1, 2.2, 1.1],
            [2.1, -0.4, 2.5, 0.4],
            [2.4, -1.1, 4.6, 1.1],
            [4.5, 0.1, 4.9, 0.9],
            [4.8, -1.1, 7.0, 1.1],
            [0.6, 1.0, 1.4, 1.4],
            [0.0, 1.3, 2.2, 3.5],
            [3.0, 1.0, 3.8, 1.4],
            [2.4, 1.3, 4.6, 3.5],
            [4.5, 2.0, 4.9, 2.8],
            [4.8, 1.3, 7.0, 3.5],
            [5.4, -1.4, 6.2, -1.0],
            [4.8, -3.5, 7.0, -1.3],
            [4.5, -2.8, 4.9, -2.0],
            [2.4, -3.5, 4.6, -1.3],
            [2.1, -2.6, 2.5, -1.8],
            [0.0, -3.5, 2.2, -1.3],
        ],
    ),
    (
        "tree",
        &[
            [0.0, -0.6, 10.0, 0.6],
            [2.0, 0.5, 3.2, 4.0],
            [3.1, 2.8, 5.0, 4.0],
            [4.5, -4.0, 5.7, -0.5],
            [2.5, -4.0, 4.6, -2.8],
            [7.0, 0.5, 8.2, 3.0],
            [8.8, -3.5, 10.0, -0.5],
            [7.0, -3.5, 8.9, -2.3],
        ],
    ),
    ("halls", &[[0.0, -3.0, 5.5, 3.0], [5.4, -1.6, 6.1, -0.4], [6.0, -3.0, 11.5, 3.0]]),
];

impl Plan {
    /// The named plans.
    pub(super) fn named() -> Vec<Self> {
        let plan = |(name, rooms): &(&str, &[Room])| Self {
            name: (*name).to_owned(),
            rooms: rooms.to_vec(),
        };
        NAMED.iter().map(plan).collect()
    }

    /// The scenario in which so many drones explore this plan. Without fixes they know their places by
    /// their optic flow alone.
    pub(super) fn text(&self, drones: usize, has_fixes: bool, fidelity: Fidelity) -> String {
        let [west, south, east, north] = self.extent();
        let base_m = HEAD_M - world::ROW_SPACING_M * drones as f32;
        let middle = 0.5 * ENTRANCE_M;
        let mut text = format!(
            "title = \"{drones} drones explore the plan {}\"\nduration_s = {DURATION_S:.0}\n\
             mission = \"explore\"\nfidelity = \"{}\"\n\n\
             [tunnel]\nwidth_m = {ENTRANCE_WIDTH_M}\ncentre_line_m = [[{base_m:.2}, 0.0], [0.0, 0.0]]\n\n\
             [[tunnel.room]]\ncentre_m = [{:.2}, 0.0]\nsize_m = [{:.2}, {ENTRANCE_WIDTH_M}]\n\n",
            self.name,
            fidelity.name(),
            -middle + 0.05,
            ENTRANCE_M + 0.1,
        );
        for room in &self.rooms {
            crate::missions::write_room(&mut text, room);
        }
        if has_fixes {
            text.push_str("[vehicle]\nposition_noise_m = 0.01\n\n");
        }
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "[radio]\npacket_loss = 0.1\n\n[radio.model]\nlaw = \"log-distance\"\n\n[drones]\nrelays = {}\n\n\
             [explore]\ncorner_m = [{:.1}, {:.1}]\narea_m = [{:.1}, {:.1}]\nstart_m = [{HEAD_M}, 0.0]\n\n\
             [[pilot]]\nat_s = 1.0\norder = \"explore\"\nspeed_mps = 0.2\n",
            drones - 1,
            west,
            south,
            east - west,
            north - south,
        );
        text
    }

    /// The western, southern, eastern and northern side of the area, on whole cells of the drones' maps.
    fn extent(&self) -> Room {
        let half = 0.5 * ENTRANCE_WIDTH_M;
        let begin = [-ENTRANCE_M, -half, 0.0, half];
        let wider = |[w, s, e, n]: Room, room: &Room| {
            [w.min(room[0]), s.min(room[1]), e.max(room[2]), n.max(room[3])]
        };
        let [w, s, e, n] = self.rooms.iter().fold(begin, wider);
        let below = |side: f32| 0.1 * (10.0 * (side - MARGIN_M)).floor();
        let above = |side: f32| 0.1 * (10.0 * (side + MARGIN_M)).ceil();
        [below(w), below(s), above(e), above(n)]
    }
}
