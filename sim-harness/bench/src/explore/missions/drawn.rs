//! Draws a floor plan from a seed: a rectangle that is divided again and again into rooms, with doors
//! between them, and pillars in some.

use random::{Purpose, Stream};

use super::plans::{Plan, Room};

/// The walls between rooms are so thick, m.
const WALL_M: f32 = 0.2;
/// A room has no shorter side, m: a drone passes another in it.
const LEAST_SIDE_M: f32 = 1.6;
/// A room with a longer side is always divided, m.
const LONGEST_SIDE_M: f32 = 6.0;
/// Widths of doors, m. Drones explore doors of 0.8 m and wider: they fly no nearer to a wall than 0.35 m.
const DOORS_M: [f32; 2] = [0.8, 1.4];
/// A door is so far from the corners of both rooms, m.
const FROM_CORNER_M: f32 = 0.1;
/// Doors reach so far into both rooms, so that no gap is left between them, m.
const OVERLAP_M: f32 = 0.05;
/// The longest and shortest extent of a plan to the east and to the north, m: with the entrance it fits the
/// drones' map.
const EAST_M: [f32; 2] = [4.0, 12.0];
const NORTH_M: [f32; 2] = [3.5, 12.0];
/// The part of divisions with a second door, which makes a loop, and of rooms with a pillar, where one fits.
const SECOND_DOORS: f32 = 0.35;
const PILLARS: f32 = 0.3;
/// The side of a pillar, and the free width beside it, m.
const PILLAR_M: [f32; 2] = [0.3, 0.8];
const BESIDE_PILLAR_M: f32 = 1.0;

/// Draws the plan of a seed.
pub(super) fn plan(seed: u64) -> Plan {
    let mut random = Stream::new(seed, Purpose::Drawn);
    let (east, north) = (between(&mut random, EAST_M), between(&mut random, NORTH_M));
    // The entrance, 1.2 m wide, meets the western side somewhere.
    let below = 0.7 + (north - 1.4) * random.uniform();
    let whole = [0.0, -below, east, north - below];
    let mut drawing = Drawing { rooms: Vec::new(), doors: Vec::new() };
    drawing.divide(&mut random, whole);
    let pillared: Vec<Room> =
        drawing.rooms.iter().flat_map(|room| with_pillar(&mut random, *room)).collect();
    let rooms = pillared.into_iter().chain(drawing.doors).collect();
    Plan { name: format!("drawn-{seed}"), rooms }
}

fn between(random: &mut Stream, [least, most]: [f32; 2]) -> f32 {
    least + (most - least) * random.uniform()
}

struct Drawing {
    rooms: Vec<Room>,
    doors: Vec<Room>,
}

impl Drawing {
    /// Divides a rectangle into rooms, with doors between its two halves.
    fn divide(&mut self, random: &mut Stream, whole: Room) {
        let sides = [whole[2] - whole[0], whole[3] - whole[1]];
        let axis = usize::from(sides[1] > sides[0]);
        let room_for_two = 2.0 * LEAST_SIDE_M + WALL_M;
        let is_small = sides[axis] < room_for_two;
        let stays = sides[axis] < LONGEST_SIDE_M && random.uniform() < 0.35;
        if is_small || stays {
            self.rooms.push(whole);
            return;
        }
        let at =
            between(random, [whole[axis] + LEAST_SIDE_M, whole[axis + 2] - LEAST_SIDE_M - WALL_M]);
        let (mut first, mut second) = (whole, whole);
        first[axis + 2] = at;
        second[axis] = at + WALL_M;
        let begin = self.rooms.len();
        self.divide(random, first);
        let middle = self.rooms.len();
        self.divide(random, second);
        self.open(random, axis, at, begin, middle);
    }

    /// Opens one or two doors in the wall at this place between the rooms from `begin` on and those from
    /// `middle` on. The entrance leads into the wall at x = 0, which has no door.
    fn open(&mut self, random: &mut Stream, axis: usize, at: f32, begin: usize, middle: usize) {
        let other = 1 - axis;
        let mut pairs: Vec<[f32; 2]> = Vec::new();
        for a in self.rooms[begin..middle].iter().filter(|a| (a[axis + 2] - at).abs() < 1e-4) {
            for b in self.rooms[middle..].iter().filter(|b| (b[axis] - at - WALL_M).abs() < 1e-4) {
                let shared = [
                    a[other].max(b[other]) + FROM_CORNER_M,
                    a[other + 2].min(b[other + 2]) - FROM_CORNER_M,
                ];
                if shared[1] - shared[0] >= DOORS_M[0] {
                    pairs.push(shared);
                }
            }
        }
        let doors = 1 + usize::from(random.uniform() < SECOND_DOORS);
        for _ in 0..doors.min(pairs.len()) {
            let [from, to] = pairs.swap_remove(random.below(pairs.len() as u32) as usize);
            let width = between(random, [DOORS_M[0], DOORS_M[1].min(to - from)]);
            let begin = between(random, [from, to - width]);
            let mut door = [0.0; 4];
            (door[axis], door[axis + 2]) = (at - OVERLAP_M, at + WALL_M + OVERLAP_M);
            (door[other], door[other + 2]) = (begin, begin + width);
            self.doors.push(door);
        }
    }
}

/// A room as the four rectangles around a pillar, or as it is.
fn with_pillar(random: &mut Stream, room: Room) -> Vec<Room> {
    let [w, s, e, n] = room;
    let side = between(random, PILLAR_M);
    let needs = 2.0 * BESIDE_PILLAR_M + side;
    if random.uniform() > PILLARS || e - w < needs || n - s < needs {
        return vec![room];
    }
    let at = [
        between(random, [w + BESIDE_PILLAR_M, e - BESIDE_PILLAR_M - side]),
        between(random, [s + BESIDE_PILLAR_M, n - BESIDE_PILLAR_M - side]),
    ];
    vec![[w, s, at[0], n], [at[0] + side, s, e, n], [w, s, e, at[1]], [w, at[1] + side, e, n]]
}
