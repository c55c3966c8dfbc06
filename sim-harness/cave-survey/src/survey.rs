//! Holds a survey whose stations have positions: what a route, a map or a summary is made from.

use std::sync::Arc;

use crate::error::{Place, Warning};
use crate::matrix::Vector;

/// A number of a station in [`Survey::stations`].
pub type StationId = usize;

/// A line of one of the files that were read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Source {
    pub(crate) file: u32,
    pub(crate) line: u32,
}

/// A survey station.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// The full name, levels separated by `.`; empty for an anonymous station.
    pub name: String,
    /// The position, metres east, north and up.
    pub position: Vector,
    /// The number of the point that the station is at: equated stations share it.
    pub point: usize,
    /// Whether the station is on the wall, at the end of a splay.
    pub is_wall: bool,
    /// Whether the file marks the station as an entrance.
    pub is_entrance: bool,
    /// The first line that names the station.
    pub source: Source,
}

/// What a leg is not, if it is no plain leg of the cave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LegFlags {
    /// The leg is over ground.
    pub surface: bool,
    /// The leg measures again what another leg measures.
    pub duplicate: bool,
    /// The leg goes from a station to the wall.
    pub splay: bool,
    /// The leg was measured with a depth gauge, which is to say by a diver: it lies under water.
    pub dived: bool,
    /// The comment of the leg calls something at it a squeeze.
    pub squeeze: bool,
}

/// Whether a comment has the word *squeeze* in it.
pub(crate) fn names_squeeze(comment: &str) -> bool {
    let mut words = comment.split(|letter: char| !letter.is_alphabetic());
    words.any(|word| word.eq_ignore_ascii_case("squeeze"))
}

impl LegFlags {
    /// The flag that Survex and Therion call by this name.
    pub(crate) fn named(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "duplicate" => &mut self.duplicate,
            "splay" => &mut self.splay,
            "surface" => &mut self.surface,
            _ => return None,
        })
    }

    /// Whether the leg counts into the cave's length, as Survex counts it.
    #[must_use]
    pub const fn counts(self) -> bool {
        !self.surface && !self.duplicate && !self.splay
    }
}

/// A leg between two stations.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// The station at which it begins.
    pub from: StationId,
    /// The station at which it ends.
    pub to: StationId,
    /// The flags.
    pub flags: LegFlags,
    /// The measured length, m; the adjusted one where the file has no other, and `None` where
    /// nothing was measured but that the stations see each other.
    pub length: Option<f64>,
    /// The line that gives it.
    pub source: Source,
}

/// The dimensions of the passage at a station, m; `None` where they were left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossSection {
    /// The station.
    pub station: StationId,
    /// The distance to the wall on the left.
    pub left: Option<f64>,
    /// The distance to the wall on the right.
    pub right: Option<f64>,
    /// The distance to the ceiling.
    pub up: Option<f64>,
    /// The distance to the floor.
    pub down: Option<f64>,
}

impl CrossSection {
    /// Whether any of the four dimensions was measured.
    #[must_use]
    pub const fn is_measured(&self) -> bool {
        self.left.is_some() || self.right.is_some() || self.up.is_some() || self.down.is_some()
    }
}

/// A loop that did not close.
#[derive(Clone, Debug, PartialEq)]
pub struct Misclosure {
    /// The distance by which the loop's legs fail to meet, m.
    pub error: f64,
    /// The length of the loop, m.
    pub length: f64,
    /// The name of the station at which the loop's last leg ends.
    pub station: String,
}

/// A survey with positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// The title, where the file gives one.
    pub title: Option<String>,
    /// The stations; every name counts, also where several are equated.
    pub stations: Vec<Station>,
    /// The legs.
    pub legs: Vec<Leg>,
    /// The passages: successive cross-sections of one tube each.
    pub passages: Vec<Vec<CrossSection>>,
    /// The number of independent loops.
    pub loops: usize,
    /// The loop whose closing error is the largest.
    pub misclosure: Option<Misclosure>,
    /// The remarks of the reader, in the order of the files.
    pub warnings: Vec<Warning>,
    pub(crate) files: Vec<Arc<str>>,
}

impl Survey {
    /// The place in the files that a source stands for.
    #[must_use]
    pub fn place(&self, source: Source) -> Option<Place> {
        let file = self.files.get(source.file as usize)?.clone();
        Some(Place { file, line: source.line, column: 0 })
    }

    /// The station of that name. Letters may differ in case where only one station is so called, and
    /// the name may be that of Therion, `1@inner.outer` for `outer.inner.1`.
    #[must_use]
    pub fn station_named(&self, name: &str) -> Option<StationId> {
        let called = |name: &str| self.stations.iter().position(|station| station.name == name);
        let exact = called(name).or_else(|| {
            let (station, surveys) = name.split_once('@')?;
            let levels = surveys.split('.').rev().chain([station]);
            called(&levels.collect::<Vec<_>>().join("."))
        });
        exact.or_else(|| {
            let alike = |station: &Station| station.name.eq_ignore_ascii_case(name);
            let mut found = (0..self.stations.len()).filter(|&n| alike(&self.stations[n]));
            let first = found.next()?;
            found.next().is_none().then_some(first)
        })
    }

    /// The vector of a leg after adjustment, m.
    #[must_use]
    pub fn vector(&self, leg: &Leg) -> Vector {
        crate::matrix::sub(self.stations[leg.to].position, self.stations[leg.from].position)
    }

    /// What `uchain map info` says of the survey.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let counted = || self.legs.iter().filter(|leg| leg.flags.counts());
        let measured = || counted().filter(|leg| leg.length.is_some());
        let adjusted = measured().map(|leg| crate::matrix::norm(self.vector(leg)));
        let dived = measured().filter(|leg| leg.flags.dived);
        let dived = dived.map(|leg| crate::matrix::norm(self.vector(leg)));
        let dimensioned = self.passages.iter().flatten().filter(|it| it.is_measured());
        Summary {
            legs: counted().count(),
            // A sum of nothing is −0.
            length_m: adjusted.sum::<f64>() + 0.0,
            measured_length_m: measured().filter_map(|leg| leg.length).sum::<f64>() + 0.0,
            splays: self.legs.iter().filter(|leg| leg.flags.splay).count(),
            stations: self.stations.len(),
            with_dimensions: dimensioned.count(),
            loops: self.loops,
            misclosure_m: self.misclosure.as_ref().map_or(0.0, |it| it.error),
            dived_m: dived.sum::<f64>() + 0.0,
        }
    }
}

/// The figures of a survey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The number of legs that are neither splays, nor duplicates, nor over ground.
    pub legs: usize,
    /// The length of these legs after adjustment, m.
    pub length_m: f64,
    /// The length of these legs as they were measured, m.
    pub measured_length_m: f64,
    /// The number of splays.
    pub splays: usize,
    /// The number of stations, anonymous ones included; equated names count each.
    pub stations: usize,
    /// The number of stations with passage dimensions; a station counts once for each passage that
    /// lists it, as `dump3d` prints it.
    pub with_dimensions: usize,
    /// The number of independent loops.
    pub loops: usize,
    /// The largest closing error of a loop, m.
    pub misclosure_m: f64,
    /// The length of the legs that were dived, m.
    pub dived_m: f64,
}
