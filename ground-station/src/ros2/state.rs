//! Reads, of the state that the station gives its pages, what the node needs.

use serde::Deserialize;

use crate::steering::PageId;

/// The state of the station.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct State {
    /// The time of the state in ms.
    pub(super) stamp: u64,
    /// The page that steers.
    steering: Option<u64>,
    pub(super) refused: Option<Refused>,
    pub(super) hears_base: bool,
    pub(super) base: Option<Base>,
    /// The order that the base gives.
    pub(super) task: Option<String>,
    /// The drones, head first.
    pub(super) drones: Vec<Drone>,
    pub(super) advice: Advice,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Refused {
    page: u64,
    seq: Option<u64>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Base {
    pub(super) node: u8,
    /// The state of its radio in words.
    pub(super) radio: String,
    pub(super) recalled: bool,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Advice {
    pub(super) text: String,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Drone {
    pub(super) node: u8,
    pub(super) name: String,
    pub(super) state: String,
    pub(super) fault: Option<String>,
    pub(super) airborne: bool,
    /// The time since the drone spoke last.
    pub(super) age_s: f32,
    pub(super) silent: bool,
    pub(super) battery_v: Option<f32>,
    pub(super) endurance_s: Option<f32>,
    /// The link towards the base.
    pub(super) link: Option<Link>,
    pub(super) odometer_m: f32,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Link {
    pub(super) to: u8,
    pub(super) dbm: f32,
    /// How good the link is by the base's limits.
    pub(super) grade: String,
}

/// Who steers, as programs see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Steering {
    Program,
    Page,
    Nobody,
}

impl State {
    /// The state that a page is given; `None` before the first.
    pub(super) fn read(json: &str) -> Option<Self> {
        serde_json::from_str(json).ok()
    }

    pub(super) const fn steering(&self) -> Steering {
        match self.steering {
            Some(page) if page == PageId::PROGRAM.0 => Steering::Program,
            Some(_) => Steering::Page,
            None => Steering::Nobody,
        }
    }

    /// The number of the last request of programs, if it was refused.
    pub(super) fn refused(&self) -> Option<u64> {
        self.refused.as_ref().filter(|it| it.page == PageId::PROGRAM.0)?.seq
    }
}
