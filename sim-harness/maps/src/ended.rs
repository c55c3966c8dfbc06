//! Why a route ends where it does, and the piece of a way that becomes a route.

use std::fmt;

use super::levels::{self, Place};
use super::network::{self, Network};
use super::{Hindrance, LONGEST_ROUTE};

/// Why a route leads no farther.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RouteEnd {
    /// The user asked for this end.
    #[default]
    Asked,
    /// The route is as long as a route may be.
    Longest,
    /// The route would pass above or below itself.
    Level(Crossing),
    /// The next leg cannot be flown.
    Hindered(Hindrance),
    /// Nothing that was surveyed leads on.
    Survey,
}

impl RouteEnd {
    /// Why a route that was cut, asked for or not, ends at the station `last`.
    pub(super) fn of(
        is_cut: bool,
        is_asked: bool,
        crossing: Option<Crossing>,
        hindrances: &[Hindrance],
        last: &str,
    ) -> Self {
        let next = crossing.filter(|crossing| crossing.leg[0] == last);
        let hindrance = || hindrances.iter().find(|hindrance| hindrance.from == last).cloned();
        match (is_cut, is_asked, next) {
            (true, _, _) => Self::Longest,
            (_, true, _) => Self::Asked,
            (_, _, Some(crossing)) => Self::Level(crossing),
            _ => hindrance().map_or(Self::Survey, Self::Hindered),
        }
    }

    /// The reason in one word, for programs.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Asked => "asked",
            Self::Longest => "longest",
            Self::Level(_) => "level",
            Self::Hindered(hindrance) => hindrance.kind.name(),
            Self::Survey => "survey",
        }
    }
}

impl fmt::Display for RouteEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked => write!(f, "as asked for"),
            Self::Longest => write!(f, "a route is at most {LONGEST_ROUTE} m long"),
            Self::Level(crossing) => write!(f, "{crossing}"),
            Self::Hindered(hindrance) => write!(f, "{hindrance}"),
            Self::Survey => write!(f, "nothing that was surveyed leads on"),
        }
    }
}

/// Two legs of a way that lie above one another, by the names of their stations.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// The later leg.
    pub leg: [String; 2],
    /// The earlier leg.
    pub other: [String; 2],
    /// How much higher the later leg is, m.
    pub higher_m: f64,
}

impl fmt::Display for Crossing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { leg: [from, to], other: [a, b], higher_m } = self;
        let side = if *higher_m > 0.0 { "above" } else { "below" };
        let height = higher_m.abs();
        write!(f, "{from} to {to} passes {height:.1} m {side} {a} to {b}")?;
        write!(f, ", and a floor plan has one level")
    }
}

/// A piece of a way that can be dug.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) nodes: Vec<usize>,
    /// Whether it was cut at [`LONGEST_ROUTE`].
    pub(super) is_cut: bool,
    /// The two legs that lie above one another where the piece ends, if that is why it ends.
    pub(super) crossing: Option<Crossing>,
}

/// Which piece of a way is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// The piece at its beginning.
    Beginning,
    /// The longest.
    Longest,
}

impl Piece {
    /// The piece of a way that is no longer than a route may be and passes neither above nor below
    /// itself.
    pub(super) fn of(
        network: &impl Network,
        way: Vec<usize>,
        wanted: Wanted,
        name: impl Fn(usize) -> String,
    ) -> Self {
        let (mut nodes, is_cut) = network::cut(network, way, f64::from(LONGEST_ROUTE));
        let place = |(node, half): (&usize, f64)| Place { at: network.at(*node), half };
        let halves = network.halves(&nodes);
        let places: Vec<Place> = nodes.iter().zip(halves).map(place).collect();
        let level = match wanted {
            Wanted::Beginning => levels::beginning(&places),
            Wanted::Longest => levels::longest(&places),
        };
        let names = |leg: usize| {
            [leg, leg + 1].map(|n| nodes.get(n).map_or_else(String::new, |&it| name(it)))
        };
        let crossing = level.overlap.map(|overlap| Crossing {
            leg: names(overlap.leg),
            other: names(overlap.other),
            higher_m: overlap.higher,
        });
        let ends_early = level.kept.end < nodes.len();
        nodes = nodes.drain(level.kept).collect();
        Self { nodes, is_cut: is_cut && !ends_early, crossing }
    }

    /// The same piece the other way round.
    pub(super) fn reversed(mut self) -> Self {
        self.nodes.reverse();
        self
    }
}
