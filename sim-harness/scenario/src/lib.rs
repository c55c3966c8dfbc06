//! Reads scenarios. A scenario says where a mission is flown, by which drones, for how long, and
//! what the operator does.
//!
//! A scenario is a TOML file; the book's chapter "Scenarios" has every key. Its sections are read
//! into plain data, which bodies, radios and agents are made of elsewhere. The built-in scenarios are files of the same
//! kind, compiled in ([`builtin`]).

pub mod builtin;
mod depth;
mod file;
mod presets;
mod resolved;
mod sections;
mod settings;

use std::path::Path;
use std::sync::Arc;

use agent::AgentConfig;
use chain::policy::Policy;
use input::InputError;
use maps::{MapChoice, Route, sites};
use units::{Course, MetresPerSecond, Order};
use world::{Tunnel, World};

pub use self::depth::SLOWER;
pub use self::file::DEPTHS;
pub use presets::{PRESETS, RadioPreset};
pub use sections::{
    Criteria, Drones, Ground, Loss, LossKind, MOST_DRONES, PilotStep, RadioSpec, Start, VehicleSpec,
};
pub use settings::{Setting, value_of};

/// The fidelity of a simulated drone, from the fastest to the most faithful.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fidelity {
    /// A point on the floor plan that follows velocity commands with a lag.
    Point,
    /// A rigid body with motors, battery and sensors, and the flight code in the loop.
    Flight,
    /// The same body, flown by the firmware's ELF on an emulated Crazyflie.
    Virtual,
}

impl Fidelity {
    /// The name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Flight => "flight",
            Self::Virtual => "virtual",
        }
    }

    /// The fidelity of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Point, Self::Flight, Self::Virtual].into_iter().find(|it| it.name() == name)
    }

    /// Whether drones are rigid bodies with motors and sensors.
    #[must_use]
    pub const fn is_rigid(self) -> bool {
        matches!(self, Self::Flight | Self::Virtual)
    }
}

/// The way in which reports and orders get from one drone to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinkModel {
    /// Reports and orders are sent in packets, byte by byte, in the drones' turns; the radio
    /// delivers or loses each packet.
    #[default]
    Exact,
    /// Reports and orders are delivered without packets, with a loss and a delay drawn from a
    /// table.
    Ideal,
}

impl LinkModel {
    /// The name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Ideal => "ideal",
        }
    }

    /// The link of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Exact, Self::Ideal].into_iter().find(|it| it.name() == name)
    }

    /// Whether drones of this fidelity can use this link: the ideal one is for points only.
    #[must_use]
    pub fn suits(self, fidelity: Fidelity) -> bool {
        self == Self::Exact || fidelity == Fidelity::Point
    }
}

/// A checked scenario: everything in it is within its bounds and fits together.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The file's name without its ending.
    pub name: String,
    /// One line that says what the scenario is for.
    pub title: String,
    /// The duration.
    pub duration_us: u64,
    /// The fidelity of the drones.
    pub fidelity: Fidelity,
    /// The way in which reports and orders get from drone to drone.
    pub link: LinkModel,
    /// The mission that the drones fly.
    pub mission: units::MissionKind,
    /// The walls and the skeleton, made when the scenario was read.
    pub tunnel: Arc<Tunnel>,
    /// The surveyed route that the tunnel is, if it is one.
    pub route: Option<Arc<Route>>,
    /// The channel and the radios.
    pub radio: RadioSpec,
    /// The bodies.
    pub vehicle: VehicleSpec,
    /// The light and the texture of the floor, which count at flight level only.
    pub ground: Ground,
    /// The members of the chain, and their places at the start.
    pub drones: Drones,
    /// The constants of the on-board code.
    pub agent: AgentConfig,
    /// The loss over the first metre that the drones assume.
    pub assumed_loss_at_1m: units::Db,
    /// The name of the movement policy in [`agent`](Self::agent).
    pub policy: String,
    /// The operator's orders, in order of time.
    pub pilot: Vec<PilotStep>,
    /// How far from the base the pilot lets the head fly, m: the [row](Drones::row_m) and the head's
    /// odometer, which counts from where it takes off.
    pub depth_m: Option<f32>,
    /// The drones that are lost, in order of time.
    pub losses: Vec<Loss>,
    /// The bounds that the mission must keep, beside those of every mission.
    pub criteria: Criteria,
    /// The tables and keys that it was read from, with the changes that a command line made.
    pub source: Arc<toml::Table>,
}

/// A stretch of a mission, in microseconds since its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// The time at which it begins.
    pub from_us: u64,
    /// The time at which it ends.
    pub until_us: u64,
}

/// What a command line changes of a scenario while it is read.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// A map, and a route in it, in place of the tunnel.
    pub map: Option<MapChoice>,
    /// Whether side rangers get the reach that they need in a wide passage of the map.
    pub suits_width: bool,
    /// Another number of relays.
    pub relays: Option<usize>,
    /// Other values of single keys.
    pub settings: Vec<Setting>,
}

impl Changes {
    fn is_empty(&self) -> bool {
        self.map.is_none() && self.relays.is_none() && self.settings.is_empty()
    }
}

/// The part of a route that the head flies into in the map's own mission: its end is where a
/// passage becomes too narrow, or is cluttered.
const EXPLORED: f32 = 0.5;

/// Lets the head hover as soon as it has flown `most` metres by the first order, and everything after
/// that happen so much earlier.
fn turn_back_before(pilot: &mut [PilotStep], most: f32) {
    let [first, rest @ ..] = pilot else { return };
    let (Order::Explore(course), Some(next)) = (first.task, rest.first()) else { return };
    let longest_us = (most / course.speed.0 * 1e6) as u64;
    let early_us = (next.at_us - first.at_us).saturating_sub(longest_us);
    for step in rest {
        step.at_us = as_in_a_file(step.at_us - early_us);
    }
}

/// The time nearest to this one that a number of seconds in a scenario file can be.
#[must_use]
pub fn as_in_a_file(us: u64) -> u64 {
    (f64::from((us as f64 * 1e-6) as f32) * 1e6).round() as u64
}

impl Scenario {
    /// The scenario for a map where none is named.
    ///
    /// # Errors
    /// [`InputError`] where the survey cannot be used.
    pub fn of_map(
        map: MapChoice,
        relays: Option<usize>,
        settings: Vec<Setting>,
    ) -> Result<Self, InputError> {
        let name = map.file.with_extension("toml");
        let changes = Changes { map: Some(map), suits_width: true, relays, settings };
        let mut scenario = file::parse_with(&name, include_str!("map.toml"), &changes)?;
        if let Some(route) = &scenario.route {
            turn_back_before(&mut scenario.pilot, EXPLORED * route.length_m as f32);
        }
        Ok(scenario)
    }

    /// The built-in scenario of that name, or the file at that path, with changes.
    ///
    /// # Errors
    /// [`InputError`] where it is neither, or the file or the changes are wrong.
    pub fn open_with(name_or_path: &str, changes: &Changes) -> Result<Self, InputError> {
        if changes.is_empty() {
            return Self::open(name_or_path);
        }
        let (path, text) = sites::open_text(name_or_path)?;
        file::parse_with(&path, &text, changes)
    }

    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// [`InputError`] with file and line, for the first mistake in the file.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::of_text(path, &sites::read_text(path)?)
    }

    /// Checks the text of a scenario whose errors name this path.
    ///
    /// # Errors
    /// [`InputError`] with file and line, for the first mistake in the text.
    pub fn of_text(path: &Path, text: &str) -> Result<Self, InputError> {
        file::parse(path, text)
    }

    /// Checks the text of a scenario of this name, with changes. A file that it names lies beside
    /// the working directory's.
    ///
    /// # Errors
    /// [`InputError`] with the line, for the first mistake in the text.
    pub fn of_text_with(name: &str, text: &str, changes: &Changes) -> Result<Self, InputError> {
        file::parse_with(&Path::new(name).with_extension("toml"), text, changes)
    }

    /// The scenario as the text of a file that has every key, and reads back to the same mission. Files
    /// that it names are given by whole paths.
    #[must_use]
    pub fn resolved(&self) -> String {
        resolved::text(self)
    }

    /// The built-in scenario of that name, or the file at that path.
    ///
    /// # Errors
    /// [`InputError`] where it is neither, or the file is wrong.
    pub fn open(name_or_path: &str) -> Result<Self, InputError> {
        let (path, text) = sites::open_text(name_or_path)?;
        file::parse(&path, &text)
    }

    /// The world in which the mission is flown.
    #[must_use]
    pub fn world(&self) -> World {
        World::new(Arc::clone(&self.tunnel), &self.radio.place, self.drones.base)
    }

    /// The same scenario with another of the named movement policies; `None` for a name that is
    /// not known.
    #[must_use]
    pub fn with_policy(&self, name: &str) -> Option<Self> {
        let policy = Policy::named(name)?.config.for_loss_at_1m(self.assumed_loss_at_1m);
        let agent = AgentConfig { policy, ..self.agent };
        Some(Self { policy: name.to_owned(), agent, ..self.clone() })
    }

    /// The same scenario at this fidelity.
    #[must_use]
    pub fn at(&self, fidelity: Fidelity) -> Self {
        Self { fidelity, ..self.clone() }
    }

    /// Returns the longest time for which the operator lets the head hover: `explore` at 0 m/s. It
    /// is the whole mission where that begins in the air and has no operator.
    #[must_use]
    pub fn hold(&self) -> Option<Stretch> {
        if self.pilot.is_empty() && !matches!(self.drones.start, Start::Mouth) {
            return Some(Stretch { from_us: 0, until_us: self.duration_us });
        }
        self.longest(|order| {
            matches!(order, Order::Explore(Course { speed, .. }) if speed == MetresPerSecond::ZERO)
        })
    }

    /// Returns the longest time for which the operator lets the head fly in at one speed.
    #[must_use]
    pub fn cruise(&self) -> Option<Stretch> {
        self.longest(|order| matches!(order, Order::Explore(Course { speed, .. }) if speed.0 > 0.0))
    }

    /// The longest time for which the operator's order is one that is `wanted`.
    fn longest(&self, wanted: impl Fn(Order) -> bool) -> Option<Stretch> {
        let ends = self.pilot.iter().skip(1).map(|step| step.at_us).chain([self.duration_us]);
        let steps = self.pilot.iter().zip(ends).filter(|(step, _)| wanted(step.task));
        steps
            .map(|(step, end)| Stretch { from_us: step.at_us, until_us: end.min(self.duration_us) })
            .filter(|stretch| stretch.from_us < stretch.until_us)
            .max_by_key(|stretch| stretch.until_us - stretch.from_us)
    }

    /// The duration in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f32 {
        self.duration_us as f32 * 1e-6
    }
}
