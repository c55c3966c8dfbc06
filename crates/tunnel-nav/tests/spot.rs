//! The search for a spot at which to land, in galleries with side mouths and rubble: it ends, and it
//! ends at a place of the kind that is asked for.

use core::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use proptest::prelude::*;
use tunnel_nav::{Diagonals, NavConfig, Range, SpotConfig, SpotSearch, SpotView};
use units::{Db, Duration, Instant, Metres, Point2, Pose2, Radians};

const CONFIG: SpotConfig = SpotConfig::DEFAULT;
const NAV: NavConfig = NavConfig::DEFAULT;
/// Seconds of a round.
const ROUND: f32 = 0.2;

/// A straight gallery along x, with its middle at y = 0.
#[derive(Clone, Debug)]
struct Gallery {
    width: f32,
    /// From where to where side galleries open in the left and the right wall.
    mouths: [Option<[f32; 2]>; 2],
    /// From where to where there is rubble on the floor.
    rubble: Option<[f32; 2]>,
    /// From where to where links are strong enough: that to the drone behind is up to the latter, that
    /// to the drone in front from the former on.
    linked: [f32; 2],
}

impl Gallery {
    fn straight(width: f32) -> Self {
        Self { width, mouths: [None; 2], rubble: None, linked: [-100.0, 100.0] }
    }

    /// The distance of the wall from a point in a direction; a side gallery is as long as a beam.
    fn wall(&self, [x, y]: [f32; 2], angle: f32) -> f32 {
        let (sin, cos) = angle.sin_cos();
        let half = 0.5 * self.width;
        let edge = if sin > 0.0 { half - y } else { half + y };
        let far = edge / sin.abs().max(1e-6);
        let mouth = self.mouths[usize::from(sin <= 0.0)];
        let Some([from, to]) = mouth.filter(|[from, to]| (*from..*to).contains(&(x + far * cos)))
        else {
            return far;
        };
        // Through the mouth, to the side wall of the gallery behind it.
        let side = if cos > 0.0 { to - x } else { x - from };
        side / cos.abs().max(1e-6)
    }

    fn ranges(&self, at: [f32; 2], yaw: f32) -> Diagonals {
        let beam = |off: f32| {
            let reach = Metres(2.0);
            Range::measured(Metres(self.wall(at, yaw + off)), reach)
        };
        let [nw, ne] = [FRAC_PI_4, -FRAC_PI_4].map(beam);
        let [sw, se] = [3.0 * FRAC_PI_4, -3.0 * FRAC_PI_4].map(beam);
        Diagonals { nw, ne, sw, se }
    }

    fn is_rough(&self, x: f32) -> bool {
        self.rubble.is_some_and(|[from, to]| (from..to).contains(&x))
    }

    /// By how much the links in front and behind are stronger than they have to be: 10 dB over a metre.
    fn over(&self, x: f32) -> [Option<Db>; 2] {
        [x - self.linked[0], self.linked[1] - x].map(|over| Some(Db(10.0 * over)))
    }

    /// The height over the stones, which lie a hand apart.
    fn height(&self, x: f32) -> f32 {
        let stone = (x * 10.0).floor() as i32 % 2 == 0;
        if self.is_rough(x) && stone { 0.2 } else { 0.3 }
    }
}

fn pose([x, y]: [f32; 2], yaw: f32) -> Pose2 {
    Pose2 { at: Point2 { x, y }, yaw: Radians(yaw) }
}

/// What became of a search.
#[derive(Debug)]
struct End {
    at: [f32; 2],
    seconds: f32,
    /// The smallest distance from a wall on the way.
    nearest: f32,
    /// The ways farthest behind and ahead.
    ways: [f32; 2],
}

impl End {
    /// How far the walls to the left and the right are.
    fn beside(&self, gallery: &Gallery) -> [f32; 2] {
        [FRAC_PI_2, -FRAC_PI_2].map(|angle| gallery.wall(self.at, angle))
    }
}

/// A drone that searches, whose velocity follows its command with a lag of 0.3 s.
struct Drone {
    at: [f32; 2],
    yaw: f32,
    velocity: [f32; 2],
    /// How far it has flown along its nose.
    way: f32,
    search: SpotSearch,
}

impl Drone {
    fn new(at: [f32; 2], yaw: f32) -> Self {
        let search = SpotSearch::begin(Instant::ZERO, Metres(at[0]), pose(at, yaw));
        Self { at, yaw, velocity: [0.0; 2], way: at[0], search }
    }

    /// Flies a round; `false` where the drone is to land. It may land where its links are weaker by up
    /// to 1 dB than they have to be for a place to be taken.
    fn flies(&mut self, gallery: &Gallery, now: Instant, over: [Option<Db>; 2]) -> bool {
        let Self { at, yaw, way, .. } = *self;
        let view = SpotView {
            ranges: gallery.ranges(at, yaw),
            height: Some(Metres(gallery.height(at[0]))),
            way: Metres(way),
            pose: pose(at, yaw),
            over,
            may_land: over.iter().flatten().all(|over| over.0 >= -1.0),
            has_room: [true; 2],
        };
        let Some(next) = self.search.step(&CONFIG, now, &view) else { return false };
        self.search = next;
        let command = next.command(&CONFIG, &NAV, &view);
        let (sin, cos) = yaw.sin_cos();
        let [forward, lateral] = [command.forward.0, command.lateral.0];
        let wanted = [forward * cos - lateral * sin, forward * sin + lateral * cos];
        for ((at, velocity), wanted) in self.at.iter_mut().zip(&mut self.velocity).zip(wanted) {
            *velocity += (wanted - *velocity) * (ROUND / (ROUND + 0.3));
            *at += *velocity * ROUND;
        }
        self.way += (self.velocity[0] * cos + self.velocity[1] * sin) * ROUND;
        self.yaw += command.yaw_rate.0 * ROUND;
        true
    }
}

fn moment(round: u16) -> Instant {
    Instant::ZERO + Duration::from_millis(200 * u64::from(round))
}

/// Searches from x = 0.
fn search(gallery: &Gallery, aside: f32, skew: f32) -> End {
    let mut drone = Drone::new([0.0, aside], skew);
    let (mut nearest, mut ways) = (f32::INFINITY, [0.0_f32; 2]);
    for round in 0..1_000 {
        let over = gallery.over(drone.at[0]);
        let flies = drone.flies(gallery, moment(round), over);
        let at = drone.at;
        if !flies {
            return End { at, seconds: f32::from(round) * ROUND, nearest, ways };
        }
        let around = (0_u8..16).map(|n| gallery.wall(at, f32::from(n) * 0.5 * FRAC_PI_4));
        nearest = around.fold(nearest, f32::min);
        ways = [ways[0].min(at[0]), ways[1].max(at[0])];
    }
    panic!("the search goes on for ever at {:?}", drone.at);
}

prop_compose! {
    /// A gallery, and where the drone is across it.
    fn galleries()(
        width in 0.8_f32..3.5, across in -0.8_f32..0.8, skew in -0.15_f32..0.15,
    ) -> (Gallery, f32, f32) {
        let half = 0.5 * width - 0.15;
        (Gallery::straight(width), across * half, skew)
    }
}

prop_compose! {
    /// The same in a gallery in which every place beside a wall is a spot.
    fn wide_galleries()(
        width in 1.45_f32..2.0, across in -0.8_f32..0.8, skew in -0.15_f32..0.15,
    ) -> (Gallery, f32, f32) {
        let half = 0.5 * width - 0.15;
        (Gallery::straight(width), across * half, skew)
    }
}

prop_compose! {
    /// The same, for a drone near the middle of a gallery with a mouth on each side, or on one.
    fn with_mouths()(
        width in 1.1_f32..2.4, across in -0.15_f32..0.15, skew in -0.1_f32..0.1,
        starts in prop::array::uniform2(prop::option::of(-2.5_f32..1.5)), wide in 1.0_f32..2.0,
    ) -> (Gallery, f32, f32) {
        let mouths = starts.map(|start| start.map(|from| [from, from + wide]));
        (Gallery { mouths, ..Gallery::straight(width) }, across, skew)
    }
}

proptest! {
    /// In a gallery whose walls the beams reach the drone lands beside one of them.
    #[test]
    fn a_drone_never_lands_in_the_middle_where_there_is_a_wall((gallery, across, skew) in galleries()) {
        let end = search(&gallery, across, skew);
        let [left, right] = end.beside(&gallery);
        prop_assume!(gallery.width * 0.5 + across.abs() < 1.3 || gallery.width * 0.5 - across.abs() < 1.2);
        prop_assert!(left.min(right) <= CONFIG.beside.0, "{end:?}");
        prop_assert!(end.nearest > 0.15, "{end:?}");
        if gallery.width > 1.4 {
            prop_assert!(left.max(right) >= CONFIG.free_width.0 - 0.02, "{end:?}");
            prop_assert!(end.seconds < 20.0, "the first place is as good as any: {end:?}");
        }
    }

    /// The wall that the drone lands at is there: it is in no mouth.
    #[test]
    fn a_drone_does_not_land_in_a_mouth((gallery, across, skew) in with_mouths()) {
        let end = search(&gallery, across, skew);
        let [left, right] = end.beside(&gallery);
        let in_both = gallery.mouths.iter().all(|mouth| mouth.is_some());
        prop_assert!(in_both || left.min(right) <= CONFIG.beside.0 + 0.05, "{end:?}");
        prop_assert!(end.seconds <= CONFIG.most_time.as_secs_f32());
        prop_assert!(end.nearest > 0.1, "{end:?}");
    }

    /// Where there is an even stretch within the way that is looked at, the drone lands on it.
    #[test]
    fn a_drone_lands_on_even_floor(
        (gallery, across, skew) in galleries(), from in -1.2_f32..0.0, to in 0.0_f32..0.8,
    ) {
        prop_assume!((1.45..2.2).contains(&gallery.width));
        let gallery = Gallery { rubble: Some([from, to]), ..gallery };
        let end = search(&gallery, across, skew);
        prop_assert!(!gallery.is_rough(end.at[0] - 0.1) && !gallery.is_rough(end.at[0] + 0.1), "{end:?}");
    }

    /// The drone does not fly on from where its links are too weak, and comes back.
    #[test]
    fn a_drone_keeps_its_links(
        (gallery, across, skew) in galleries(), behind in 0.0_f32..2.0, ahead in 0.0_f32..2.0,
    ) {
        let linked = [-behind, ahead + 0.01];
        // Without a spot on the way, the drone looks as far as it may.
        let gallery = Gallery { linked, rubble: Some([-9.0, 9.0]), ..gallery };
        let end = search(&gallery, across, skew);
        let [least, most] = end.ways;
        prop_assert!(least > -behind - 0.15 && most < ahead + 0.16, "{end:?}");
        prop_assert!((-behind - 0.06..ahead + 0.07).contains(&end.at[0]), "{end:?}");
        prop_assert!(end.seconds <= CONFIG.most_time.as_secs_f32());
    }

    /// A drone whose link does not bear its landing where it began comes nearer to that neighbour, and
    /// lands at a spot there.
    #[test]
    fn a_drone_lands_where_its_links_bear_it(
        (gallery, across, skew) in wide_galleries(), off in 0.0_f32..0.8, is_ahead: bool,
    ) {
        let linked = if is_ahead { [off, 9.0] } else { [-9.0, -off] };
        let gallery = Gallery { linked, ..gallery };
        let end = search(&gallery, across, skew);
        prop_assert!((linked[0] - 0.1..linked[1] + 0.1).contains(&end.at[0]), "{end:?}");
        prop_assert!(end.seconds < 25.0, "{end:?}");
        let [left, right] = end.beside(&gallery);
        prop_assert!(left.min(right) <= CONFIG.beside.0, "{end:?}");
    }

    /// Two drones whose link bears their landing only just when they begin to look: neither waits for
    /// the other.
    #[test]
    fn two_neighbours_do_not_wait_for_each_other(
        (gallery, across, skew) in wide_galleries(), missing in -0.1_f32..1.5,
    ) {
        let mut drones = [Drone::new([0.0, across], skew), Drone::new([8.0, across], -skew)];
        let mut landed = [None; 2];
        for round in 0..300 {
            let over = Some(Db(10.0 * (8.0 - missing - (drones[1].at[0] - drones[0].at[0]))));
            for ((drone, landed), over) in
                drones.iter_mut().zip(&mut landed).zip([[over, None], [None, over]])
            {
                if landed.is_none() && !drone.flies(&gallery, moment(round), over) {
                    *landed = Some((f32::from(round) * ROUND, over));
                }
            }
        }
        for landed in landed {
            let Some((seconds, over)) = landed else { panic!("{landed:?} {:?}", drones.map(|d| d.at)) };
            prop_assert!(seconds < 30.0 && over.iter().flatten().all(|over| over.0 >= -1.0), "{landed:?}");
        }
    }

    /// Whatever the sensors say, the search ends in time, and its commands are velocities that a drone
    /// may fly at.
    #[test]
    fn a_search_ends_with_any_sensors(
        seen in prop::collection::vec((prop::array::uniform4(any::<f32>()), prop::num::f32::ANY, prop::num::f32::ANY, any::<bool>()), 75)
    ) {
        let mut search = SpotSearch::begin(Instant::ZERO, Metres::ZERO, pose([0.0; 2], 0.0));
        let mut rounds = 0_u64;
        for ([nw, ne, sw, se], height, way, is_linked) in seen {
            let beam = |range: f32| Range::measured(Metres(range), Metres(4.0));
            let view = SpotView {
                ranges: Diagonals { nw: beam(nw), ne: beam(ne), sw: beam(sw), se: beam(se) },
                height: Some(Metres(height)),
                way: Metres(way),
                pose: pose([nw, se], height),
                over: [Some(Db(way)), is_linked.then_some(Db(nw))],
                may_land: is_linked,
                has_room: [true; 2],
            };
            let command = search.command(&CONFIG, &NAV, &view);
            prop_assert!(command.forward.0.abs() < 2.0, "{command:?}");
            prop_assert!(command.lateral.0.abs() <= NAV.max_lateral.0, "{command:?}");
            rounds += 1;
            let now = Instant::ZERO + Duration::from_secs(rounds);
            match search.step(&CONFIG, now, &view) {
                Some(next) => search = next,
                None => return Ok(()),
            }
        }
        prop_assert!(false, "it goes on after {rounds} rounds");
    }
}

proptest! {
    /// A head that has come to the end of a gallery turns round there, and may stand across it when it is
    /// told to land: the walls that its side beams seem to see are none. Such heads, in 5 of 100 missions of
    /// `perch-40m`, flew from one side to the other for 70 s, until their batteries ended.
    #[test]
    fn a_drone_across_the_gallery_finds_its_wall(
        (gallery, across, off) in wide_galleries(), is_left: bool,
    ) {
        let skew = off + if is_left { FRAC_PI_2 } else { -FRAC_PI_2 };
        let end = search(&gallery, across, skew);
        prop_assert!(end.seconds < 40.0, "{end:?}");
        let [left, right] = end.beside(&gallery);
        prop_assert!(left.min(right) <= CONFIG.beside.0 + 0.05, "{end:?}");
        prop_assert!(end.nearest > 0.1, "{end:?}");
    }
}

/// Rubble everywhere, and a gallery that is too narrow: beside the wall all the same.
#[test]
fn without_a_good_spot_the_wall_decides() {
    let rough = Gallery { rubble: Some([-9.0, 9.0]), ..Gallery::straight(1.6) };
    for gallery in [rough, Gallery::straight(1.1)] {
        let end = search(&gallery, 0.0, 0.0);
        let [left, right] = end.beside(&gallery);
        assert!(left.min(right) <= CONFIG.beside.0, "{end:?}");
        assert!(end.at[0].abs() < CONFIG.most_way.0 && end.seconds > 30.0, "{end:?}");
    }
}

/// In a chamber whose walls no beam reaches, the drone lands where it began to look.
#[test]
fn without_a_wall_it_lands_where_it_began() {
    let end = search(&Gallery::straight(9.0), 0.0, 0.0);
    assert!(end.at[0].abs() < 0.1 && end.at[1].abs() < 0.1, "{end:?}");
}
