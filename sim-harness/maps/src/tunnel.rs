//! Reads the section `[tunnel]` of a scenario file, and the places that other sections name.

use std::fmt;

use input::InputError;
use input::reader::{At, Pair, Reader};
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use units::Point2;
use world::layout::{FARTHEST, GeometryError, LEAST_WIDTH, Layout, Room};
use world::{Gallery, Polyline, SkeletonPlace, Spot, Tunnel};

use crate::{Ends, MapChoice, Route};

/// The table `[tunnel]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TunnelTable {
    map: Option<At<String>>,
    within: Option<String>,
    from: Option<String>,
    to: Option<String>,
    around_m: Option<At<f32>>,
    width_m: Option<At<f32>>,
    widths_m: Option<At<Vec<f32>>>,
    centre_line_m: Option<At<Vec<Pair>>>,
    winding: Option<At<WindingTable>>,
    #[serde(default)]
    branch: Vec<At<BranchTable>>,
    #[serde(default)]
    room: Vec<At<RoomTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WindingTable {
    length_m: At<f32>,
    amplitude_m: At<f32>,
    wavelength_m: At<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BranchTable {
    name: Option<String>,
    width_m: Option<f32>,
    widths_m: Option<Vec<f32>>,
    centre_line_m: Vec<Pair>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RoomTable {
    centre_m: Pair,
    size_m: Pair,
}

fn points(pairs: &[Pair]) -> Vec<Point2> {
    pairs.iter().copied().map(Point2::from).collect()
}

/// A place of the tunnel, as a file may give it.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceKey {
    /// Metres along the main gallery.
    Main(f32),
    /// A point of the floor plan.
    Point(Point2),
    /// Metres along the gallery of that name.
    Edge {
        /// The gallery's name.
        name: String,
        /// How far along it, m.
        along: f32,
    },
}

impl<'de> Deserialize<'de> for PlaceKey {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(PlaceVisitor)
    }
}

struct PlaceVisitor;

/// The table that names a gallery.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EdgePlace {
    edge: String,
    along_m: f32,
}

impl<'de> Visitor<'de> for PlaceVisitor {
    type Value = PlaceKey;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "metres along the main gallery, [x, y], or {{ edge = \"name\", along_m = metres }}"
        )
    }

    fn visit_f64<E: serde::de::Error>(self, along: f64) -> Result<PlaceKey, E> {
        Ok(PlaceKey::Main(along as f32))
    }

    fn visit_i64<E: serde::de::Error>(self, along: i64) -> Result<PlaceKey, E> {
        Ok(PlaceKey::Main(along as f32))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<PlaceKey, A::Error> {
        let pair = Pair::deserialize(SeqAccessDeserializer::new(sequence))?;
        Ok(PlaceKey::Point(pair.into()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PlaceKey, A::Error> {
        let EdgePlace { edge, along_m } = EdgePlace::deserialize(MapAccessDeserializer::new(map))?;
        Ok(PlaceKey::Edge { name: edge, along: along_m })
    }
}

impl TunnelTable {
    /// Checks the section and makes the tunnel; with it comes the route, where it is a surveyed one.
    pub fn dig(
        tunnel: &At<Self>,
        reader: &Reader<'_>,
    ) -> Result<(Tunnel, Option<Route>), InputError> {
        match &tunnel.as_ref().map {
            Some(map) => Self::survey(tunnel, map, reader),
            None => Ok((Self::draw(tunnel, reader)?, None)),
        }
    }

    /// The tunnel of a map, whose path is relative to the scenario's file.
    fn survey(
        tunnel: &At<Self>,
        map: &At<String>,
        reader: &Reader<'_>,
    ) -> Result<(Tunnel, Option<Route>), InputError> {
        let table = tunnel.as_ref();
        let is_drawn = table.width_m.is_some()
            || table.widths_m.is_some()
            || table.centre_line_m.is_some()
            || table.winding.is_some()
            || !table.branch.is_empty()
            || !table.room.is_empty();
        if is_drawn {
            let wrong = "the tunnel has a map and something drawn beside it".into();
            return Err(reader.wrong(map, wrong, "keep only map, within, from, to and around_m"));
        }
        let around_m = table.around_m.as_ref();
        let around_m =
            around_m.map(|key| reader.number(key, "around_m", 0.0..=FARTHEST)).transpose()?;
        let choice = MapChoice {
            file: reader.beside(map.as_ref()),
            within: table.within.as_deref().map(|within| reader.beside(within)),
            ends: Ends { from: table.from.clone(), to: table.to.clone(), around_m },
            memory: None,
        };
        choice.dig().map(|(tunnel, route)| (tunnel, Some(route)))
    }

    /// The tunnel that the section draws.
    fn draw(tunnel: &At<Self>, reader: &Reader<'_>) -> Result<Tunnel, InputError> {
        let table = tunnel.as_ref();
        let beyond: Option<&str> =
            table.within.as_deref().or(table.from.as_deref()).or(table.to.as_deref());
        if beyond.is_some() || table.around_m.is_some() {
            let wrong = "within, from, to and around_m belong to a map".into();
            return Err(reader.wrong(tunnel, wrong, "remove them, or give map"));
        }
        let (width, widths) = match (&table.width_m, &table.widths_m) {
            (Some(width), None) => {
                (reader.number(width, "width_m", LEAST_WIDTH..=50.0)?, Vec::new())
            }
            (None, Some(widths)) => (widest(widths.as_ref()), widths.as_ref().clone()),
            (None, None) => {
                let wrong = "missing key `width_m`".into();
                return Err(reader.wrong(tunnel, wrong, "give it, or a map"));
            }
            (Some(_), Some(widths)) => return Err(two_widths(widths, reader)),
        };
        let centre_line = match (&table.centre_line_m, &table.winding) {
            (Some(pairs), None) => points(pairs.as_ref()),
            (None, Some(table)) => winding(table.as_ref(), reader)?,
            _ => {
                return Err(reader.wrong(
                    tunnel,
                    "a tunnel needs a centre-line, and only one".into(),
                    "give either centre_line_m or winding",
                ));
            }
        };
        let place = table.centre_line_m.as_ref().map_or(tunnel.span().start, |p| p.span().start);
        let main = Gallery { name: MAIN.into(), centre_line, width };
        diggable(main.check(&widths), place, reader)?;
        let mut layout = Layout { galleries: vec![main], widths: vec![widths], rooms: Vec::new() };
        for branch in &table.branch {
            let (gallery, widths) = side_gallery(branch, &layout, reader)?;
            layout.galleries.push(gallery);
            layout.widths.push(widths);
        }
        for room in &table.room {
            let RoomTable { centre_m, size_m } = room.as_ref();
            let piece = Room { centre: (*centre_m).into(), size: size_m.0 };
            diggable(piece.check(), room.span().start, reader)?;
            layout.rooms.push(piece);
        }
        let lines = layout.galleries.iter().map(|g| Polyline::new(g.centre_line.clone()).length());
        let length: f32 = lines.sum();
        if length > LONGEST {
            let wrong = format!("the tunnel is {length} m long");
            let error = InputError::new(wrong, format!("make it at most {} m", LONGEST));
            return Err(reader.at_byte(place, error));
        }
        Tunnel::dig(&layout).map_err(|error| impossible(error, place, reader))
    }
}

/// The name of the main gallery.
const MAIN: &str = "main";
/// The radio survey of a tunnel grows with the square of its length, m.
const LONGEST: f32 = 500.0;

/// The width of a gallery as a whole where it has these at its points.
fn widest(widths: &[f32]) -> f32 {
    widths.iter().copied().fold(0.0, f32::max)
}

fn two_widths<T>(at: &At<T>, reader: &Reader<'_>) -> InputError {
    let wrong = "a gallery has width_m and widths_m".into();
    reader.wrong(at, wrong, "keep width_m where it is as wide everywhere, else widths_m")
}

/// A side gallery, and its widths at the points of its centre-line, where it has several.
fn side_gallery(
    branch: &At<BranchTable>,
    layout: &Layout,
    reader: &Reader<'_>,
) -> Result<(Gallery, Vec<f32>), InputError> {
    let BranchTable { name, width_m, widths_m, centre_line_m } = branch.as_ref();
    let numbered = || format!("branch-{}", layout.galleries.len());
    let name = name.clone().unwrap_or_else(numbered);
    if layout.galleries.iter().any(|gallery| gallery.name == name) {
        let wrong = format!("two galleries are called \"{name}\"");
        return Err(reader.wrong(branch, wrong, "give each a name of its own"));
    }
    let (width, widths) = match (width_m, widths_m) {
        (Some(width), None) => (*width, Vec::new()),
        (None, Some(widths)) => (widest(widths), widths.clone()),
        (None, None) => {
            return Err(reader.wrong(branch, "missing key `width_m`".into(), "give it"));
        }
        (Some(_), Some(_)) => return Err(two_widths(branch, reader)),
    };
    let gallery = Gallery { name, centre_line: points(centre_line_m), width };
    diggable(gallery.check(&widths), branch.span().start, reader)?;
    Ok((gallery, widths))
}

fn diggable(
    checked: Result<(), GeometryError>,
    byte: usize,
    reader: &Reader<'_>,
) -> Result<(), InputError> {
    checked.map_err(|error| impossible(error, byte, reader))
}

fn impossible(error: GeometryError, byte: usize, reader: &Reader<'_>) -> InputError {
    let remedy = match error {
        GeometryError::TooShort => "give at least two points",
        GeometryError::Repeated(_) => "remove one of them",
        GeometryError::TooSharp(_) => "make the corridor narrower or the bend wider",
        GeometryError::TooNarrow => "make it wider",
        GeometryError::TooLarge => "keep within that of the origin",
        GeometryError::NotANumber => "give finite coordinates and positive sizes",
        GeometryError::WidthsAndPoints => "give widths_m one number for each point",
    };
    reader.at_byte(byte, InputError::new(format!("impossible geometry: {error}"), remedy))
}

fn winding(table: &WindingTable, reader: &Reader<'_>) -> Result<Vec<Point2>, InputError> {
    let length = reader.number(&table.length_m, "length_m", 1.0..=LONGEST)?;
    let amplitude = reader.number(&table.amplitude_m, "amplitude_m", 0.0..=50.0)?;
    let wavelength = reader.number(&table.wavelength_m, "wavelength_m", 0.5..=LONGEST)?;
    let count = (length / 0.2).ceil().max(1.0) as usize;
    let point = |n: usize| {
        let x = length * n as f32 / count as f32;
        Point2::new(x, amplitude * libm::sinf(core::f32::consts::TAU * x / wavelength))
    };
    Ok((0..=count).map(point).collect())
}

impl PlaceKey {
    /// The point and the place on the skeleton that a key names, at least `least` metres along
    /// its gallery.
    pub fn spot<T>(
        &self,
        span: &At<T>,
        name: &str,
        least: f32,
        tunnel: &Tunnel,
        reader: &Reader<'_>,
    ) -> Result<Spot, InputError> {
        let skeleton = tunnel.skeleton();
        let (edge, along) = match self {
            Self::Point(at) if at.is_finite() && tunnel.is_free(*at) => {
                return Ok(Spot { at: *at, on: tunnel.place(*at, None) });
            }
            Self::Point(Point2 { x, y }) => {
                let wrong = format!("{name} = [{x}, {y}] is not in the tunnel");
                return Err(reader.wrong(span, wrong, "give a point between its walls"));
            }
            Self::Main(along) => (0, *along),
            Self::Edge { name: edge, along } => match skeleton.edge_named(edge) {
                Some(number) => (number, *along),
                None => {
                    let known: Vec<_> = skeleton.edges().iter().map(|edge| edge.name()).collect();
                    let wrong = format!("there is no gallery \"{edge}\"");
                    return Err(reader.wrong(
                        span,
                        wrong,
                        format!("give one of {}", known.join(", ")),
                    ));
                }
            },
        };
        let length = skeleton.edge(edge).line().length();
        if !(least..=length).contains(&along) {
            let remedy = format!("give a number from {least} to {length}");
            return Err(reader.wrong(span, format!("{name} = {along} is out of range"), remedy));
        }
        Ok(Spot::on(skeleton, SkeletonPlace { edge, along }))
    }
}
