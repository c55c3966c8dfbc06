//! What a mission is: where, who, how long, and what the operator does.
//!
//! A scenario is a TOML file (`file` reads and checks it; the book's chapter "Scenarios" has
//! every key). The built-in ones are files of the same kind, compiled in ([`builtin`]).

pub mod builtin;
mod file;

use std::path::Path;
use units::Order;

use agent::AgentConfig;
use radio_model::{PathLoss, Reception};
use wire::radio::Datarate;

use crate::craft::flow::Ground;
use crate::input_error::InputError;
use crate::medium::{MediumConfig, Polling};
use crate::suggest;
use crate::vehicle::VehicleSpec;
use crate::world::layout::Layout;
use crate::world::{Tunnel, Walls};

/// How closely a drone is simulated: one ladder, from the fastest to the most faithful.
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

/// A checked scenario: everything in it is within its bounds and fits together.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The file's name without its ending.
    pub name: String,
    /// One line that says what it is for.
    pub title: String,
    /// How long it lasts.
    pub duration_us: u64,
    /// How closely the vehicle is simulated.
    pub fidelity: Fidelity,
    /// The floor plan.
    pub layout: Layout,
    /// Large-scale loss.
    pub path_loss: PathLoss,
    /// What the walls are to it.
    pub walls: Walls,
    /// What befalls a packet.
    pub reception: Reception,
    /// The rate at which the drones speak.
    pub datarate: Datarate,
    /// How often a second the operator's dongle asks the base for news; zero for no dongle.
    pub polling_hz: f32,
    /// How long a packet lies with its receiver, beside the time that it is on its way.
    pub latency_us: u64,
    /// The bodies.
    pub vehicle: VehicleSpec,
    /// What the floor looks like to a flow sensor; at flight level.
    pub ground: Ground,
    /// How full the batteries are, 0 to 1; at flight level.
    pub charge: f32,
    /// How many relays there are beside head and base.
    pub relays: usize,
    /// Where everybody starts.
    pub start: Start,
    /// The constants of the on-board code.
    pub agent: AgentConfig,
    /// What the drones believe their radios lose over the first metre.
    pub assumed_loss_at_1m: units::Db,
    /// The name of the movement policy in [`agent`](Self::agent).
    pub policy: String,
    /// What the operator does, in order of time.
    pub pilot: Vec<PilotStep>,
    /// What a mission must keep to, beside what every mission must.
    pub criteria: Criteria,
}

/// Bounds that a scenario sets. What is not set is not asked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Criteria {
    /// The most that the links of the chain differ at the end of the hold, dB.
    pub hold_spread_db: Option<f32>,
    /// The largest tilt in the air, degrees.
    pub tilt_deg: Option<f32>,
    /// How many relays must have flown.
    pub launched: Option<u32>,
}

/// Where everybody starts.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// On the ground at the base, in a row.
    Mouth,
    /// In the air: the head at this abscissa, the relays anywhere between it and the base.
    Random {
        /// In metres.
        head: f32,
    },
    /// In the air at these abscissae, head first.
    Placed(Vec<f32>),
}

impl Start {
    /// Distance between drones that stand in a row at the mouth, in metres: twice what their
    /// guards need.
    pub const SPACING: f32 = 0.35;
    /// The least distance between drones at random places, in metres.
    pub const APART: f32 = 0.5;
}

/// One thing that the operator does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PilotStep {
    /// From when on.
    pub at_us: u64,
    /// What.
    pub task: Order,
}

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// [`InputError`] with file and line, for anything that is not exactly right.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = std::fs::read_to_string(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::InvalidData => {
                InputError::new("this is not text in UTF-8", "give a TOML file, saved as UTF-8")
                    .in_file(path)
            }
            _ => InputError::new(format!("cannot be read: {error}"), "give a TOML file")
                .in_file(path),
        })?;
        file::parse(path, &text)
    }

    /// The built-in scenario of that name, or the file at that path.
    ///
    /// # Errors
    /// [`InputError`] where it is neither, or the file is wrong.
    pub fn open(name_or_path: &str) -> Result<Self, InputError> {
        if let Some(scenario) = builtin::find(name_or_path) {
            return scenario;
        }
        let path = Path::new(name_or_path);
        if path.exists() {
            return Self::read(path);
        }
        let names: Vec<_> = builtin::names().collect();
        let stem = path.file_stem().map_or_else(Default::default, |stem| stem.to_string_lossy());
        let meant = suggest::question(&stem, builtin::names());
        Err(InputError::new(
            format!("there is no scenario and no file called \"{name_or_path}\""),
            format!("{meant}give a TOML file or one of {}", names.join(", ")),
        ))
    }

    /// Digs the tunnel. The layout was checked when the scenario was read.
    #[must_use]
    pub(crate) fn tunnel(&self) -> Tunnel {
        Tunnel::dig(&self.layout).expect("a checked scenario has a layout that can be built")
    }

    /// What the air is like.
    #[must_use]
    pub(crate) fn medium(&self) -> MediumConfig {
        let base = self.relays + 1;
        let polling = (self.polling_hz > 0.0)
            .then(|| Polling { period_us: (1e6 / self.polling_hz) as u64, ..Polling::of(base) });
        MediumConfig { datarate: self.datarate, polling, ..MediumConfig::of(self.reception) }
    }

    /// The same scenario with another of the named movement policies; `None` for a name that is
    /// not known.
    #[must_use]
    pub fn with_policy(&self, name: &str) -> Option<Self> {
        let policy = file::policy_named(name)?.for_loss_at_1m(self.assumed_loss_at_1m);
        let agent = AgentConfig { policy, ..self.agent };
        Some(Self { policy: name.to_owned(), agent, ..self.clone() })
    }

    /// The same scenario, simulated as closely as this.
    #[must_use]
    pub fn at(&self, fidelity: Fidelity) -> Self {
        Self { fidelity, ..self.clone() }
    }

    /// From when until when the operator has the head stand still after having it explore: the
    /// longest such time, in microseconds.
    #[must_use]
    pub fn hold(&self) -> Option<(u64, u64)> {
        let ends = self.pilot.iter().skip(1).map(|step| step.at_us).chain([self.duration_us]);
        let still = Order::Explore(units::MetresPerSecond::ZERO);
        let holds = self.pilot.iter().zip(ends).skip(1).filter(|(step, _)| step.task == still);
        holds
            .map(|(step, end)| (step.at_us, end.min(self.duration_us)))
            .filter(|(from, until)| from < until)
            .max_by_key(|(from, until)| until - from)
    }

    /// How long it lasts, in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f32 {
        self.duration_us as f32 * 1e-6
    }
}

/// The names of the movement policies, as scenarios and benchmarks call them.
pub const POLICIES: [&str; 5] = ["t0", "t5", "k", "authors", "default"];
