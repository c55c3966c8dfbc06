//! Checks what every route of a survey and every refusal must keep, without a mission: the true length
//! across the whole width, one level, and a leg for each refusal.

use cave_survey::Survey;
use maps::{Ends, Hindrance, Route, RouteError};
use units::Point2;
use world::{SkeletonPlace, Tunnel};

/// Two places of a route that differ by more than this in height may not overlap, m: as in
/// `maps`, with a tenth for what heights between stations differ by.
const LEVEL_M: f32 = 3.3;
/// Places of a route that are so near along it are parts of the same passage, m.
const SAME_M: f32 = 4.0;
/// Places that are so near in the plan overlap, m.
const NEAR_M: f32 = 1.5;
/// The end of a centre-line is the middle of the last wall, and a gallery may be so wide there, m.
const END_M: f32 = 1.5;
/// The offsets from the middle at which a drone flies along a route, by the distance to the wall.
const ACROSS: [f32; 5] = [-0.7, -0.35, 0.0, 0.35, 0.7];

/// The invariants that the route between these ends, or its refusal, does not keep, one line each.
#[must_use]
pub fn broken(survey: &Survey, ends: &Ends, what: &str) -> Vec<String> {
    let found = match Route::find(survey, ends) {
        Ok((route, tunnel)) => {
            let legs = unnamed(survey, &route.hindrances);
            [true_length(&tunnel), one_level(&route, &tunnel), legs]
        }
        Err(error) => [leg_of(survey, &error), None, None],
    };
    let from = ends.from.as_deref().unwrap_or("its longest route");
    found.into_iter().flatten().map(|wrong| format!("{what}, from {from}: {wrong}")).collect()
}

/// Says by how much a drone that flies along a route, at some place across the passage, misses the
/// route's length at its end.
#[must_use]
pub fn true_length(tunnel: &Tunnel) -> Option<String> {
    let line = tunnel.skeleton().edge(0).line();
    ACROSS.into_iter().find_map(|part| {
        let (mut last, mut shift) = (SkeletonPlace::main(0.0), 0.0);
        for n in 0..=(line.length() / 0.1) as usize {
            let (middle, [x, y]) = line.at(0.1 * n as f32);
            let side = [-y * part.signum(), x * part.signum()];
            shift = part.abs() * tunnel.range(middle, side, 8.0).min(8.0);
            let at = Point2::new(middle.x + side[0] * shift, middle.y + side[1] * shift);
            last = tunnel.place(at, Some(last));
        }
        let missing = (line.length() - last.along).abs();
        let is_kept = last.edge == 0 && missing < END_M + 0.5 * shift;
        (!is_kept).then(|| format!("its length is {missing:.2} m off at {part} of the width"))
    })
}

/// Says where a route passes above or below itself.
#[must_use]
pub fn one_level(route: &Route, tunnel: &Tunnel) -> Option<String> {
    let line = tunnel.skeleton().edge(0).line();
    let count = (line.length() / 0.25) as usize;
    let places: Vec<(f32, Point2, f32)> = (0..=count)
        .map(|n| 0.25 * n as f32)
        .map(|along| (along, line.at(along).0, height(route, along)))
        .collect();
    places.iter().enumerate().find_map(|(n, (along, at, height))| {
        let before = places[..n].iter().filter(|(other, ..)| along - other > SAME_M);
        let mut over = before.filter(|(_, there, above)| {
            at.distance(*there).0 < NEAR_M && (height - above).abs() > LEVEL_M
        });
        let (other, _, above) = over.next()?;
        Some(format!("{along:.1} m of it is {:.1} m above {other:.1} m", height - above))
    })
}

/// The height of a route above its first station, m.
fn height(route: &Route, along: f32) -> f32 {
    let next = route.marks.partition_point(|mark| mark.along_m < along).max(1);
    let Some([a, b]) = route.marks.get(next - 1..=next).and_then(|pair| pair.first_chunk::<2>())
    else {
        return route.marks.last().map_or(0.0, |mark| mark.height_m);
    };
    let part = (along - a.along_m) / (b.along_m - a.along_m).max(1e-3);
    a.height_m + part.clamp(0.0, 1.0) * (b.height_m - a.height_m)
}

/// Says what is missing where a refusal names no leg of the survey.
#[must_use]
pub fn leg_of(survey: &Survey, error: &RouteError) -> Option<String> {
    let nothing = || Some(format!("its refusal names no leg: {error}"));
    let (hindrances, crossing) = match error {
        RouteError::Hindered(_, _, hindrances) => (&**hindrances, None),
        RouteError::TooShort(short) => (&*short.hindrances, short.crossing.as_ref()),
        RouteError::Crosses(_, _, crossing) => (&[][..], Some(&**crossing)),
        _ => return nothing(),
    };
    match crossing {
        Some(crossing) => {
            let legs = [&crossing.leg, &crossing.other];
            let wrong = legs.into_iter().find(|[from, to]| !is_leg(survey, from, to));
            wrong.map(|[from, to]| format!("{from} to {to}, which it names, is no leg"))
        }
        None if hindrances.is_empty() && !is_whole(survey, error) => nothing(),
        None => unnamed(survey, hindrances),
    }
}

/// Whether a survey is refused because all of it is shorter than a route: no leg hinders that.
fn is_whole(survey: &Survey, error: &RouteError) -> bool {
    let RouteError::TooShort(short) = error else { return false };
    let legs = survey.legs.iter().filter(|leg| !leg.flags.splay && !leg.flags.surface);
    let whole_m: f64 = legs.map(|leg| cave_survey::norm(survey.vector(leg))).sum();
    whole_m < f64::from(maps::SHORTEST_ROUTE) || short.longest.is_some()
}

/// Says which of these is no leg of the survey. Stations without names cannot be told.
fn unnamed(survey: &Survey, hindrances: &[Hindrance]) -> Option<String> {
    let named = hindrances.iter().filter(|it| !it.to.starts_with('(') && !it.from.starts_with('('));
    let mut wrong = named.filter(|it| !is_leg(survey, &it.from, &it.to));
    wrong.next().map(|it| format!("{} to {}, which it names, is no leg", it.from, it.to))
}

fn is_leg(survey: &Survey, from: &str, to: &str) -> bool {
    let point = |name: &str| Some(survey.stations[survey.station_named(name)?].point);
    let (Some(a), Some(b)) = (point(from), point(to)) else { return false };
    survey.legs.iter().any(|leg| {
        let ends = [survey.stations[leg.from].point, survey.stations[leg.to].point];
        ends == [a, b] || ends == [b, a]
    })
}
