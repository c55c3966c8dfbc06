//! Arguments that several verbs and benchmarks take.

use clap::ValueEnum;
use explorers::{Network, Sensor};
use input::InputError;

use scenario::Fidelity;

/// The sensor by which an explorer maps.
#[derive(Clone, Copy, ValueEnum)]
pub enum SensorArg {
    /// A camera of 60° that sees 4 m far, with rangers to the other three sides
    Camera,
    /// The four beams of the Multi-ranger deck, 4 m at most, on a robot that turns all the time
    Rangers,
}

impl SensorArg {
    /// The sensor.
    pub const fn sensor(self) -> Sensor {
        match self {
            Self::Camera => Sensor::Camera,
            Self::Rangers => Sensor::Rangers,
        }
    }
}

/// How packets come from explorer to explorer.
#[derive(Clone, Copy, ValueEnum)]
pub enum NetworkArg {
    /// Robots send each other's packets on
    Mesh,
    /// Robots hear each other directly alone
    AdHoc,
    /// All packets go through an access point at the start, which leads
    AccessPoint,
}

impl NetworkArg {
    /// The network.
    pub const fn network(self) -> Network {
        match self {
            Self::Mesh => Network::Mesh,
            Self::AdHoc => Network::AdHoc,
            Self::AccessPoint => Network::AccessPoint,
        }
    }
}

/// How closely a drone is simulated.
#[derive(Clone, Copy, ValueEnum)]
pub enum FidelityArg {
    /// A point on the floor plan that follows velocity commands with a lag
    Point,
    /// A rigid body with motors, battery and sensors, and the flight code in the loop
    Flight,
    /// The same body, flown by the firmware's ELF on an emulated Crazyflie
    Virtual,
    /// The former name of `point`, refused with a line that says so
    #[value(hide = true)]
    Policy,
}

impl FidelityArg {
    /// The level, for a command whose drones fly on the host.
    pub fn of_the_host(self) -> Result<Fidelity, InputError> {
        match self.fidelity()? {
            Fidelity::Virtual => {
                let wrong = "--fidelity virtual: this benchmark has no virtual drones";
                Err(InputError::new(wrong, "give --fidelity point or flight"))
            }
            level => Ok(level),
        }
    }

    /// The level.
    ///
    /// # Errors
    /// [`InputError`] for a level's former name.
    pub fn fidelity(self) -> Result<Fidelity, InputError> {
        match self {
            Self::Point => Ok(Fidelity::Point),
            Self::Flight => Ok(Fidelity::Flight),
            Self::Virtual => Ok(Fidelity::Virtual),
            Self::Policy => {
                let wrong = "--fidelity policy is now called point";
                Err(InputError::new(wrong, "give --fidelity point"))
            }
        }
    }
}

/// A number of runs that makes sense.
pub fn runs(count: usize) -> Result<usize, InputError> {
    counted("--runs", count)
}

/// A number of missions that makes sense, by the option that gives it.
pub fn counted(option: &str, count: usize) -> Result<usize, InputError> {
    if (1..=1_000_000).contains(&count) {
        return Ok(count);
    }
    Err(InputError::new(format!("{option} {count} is out of range"), "give 1 to 1000000"))
}
