//! A mission whose relays are steered from round to round, for environments of reinforcement learning.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use chain::policy::LinkEnd;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use self_cell::self_cell;
use sim_harness::mission::{Linked, Mission, ROUND_US, with_called_law};
use sim_harness::scenario::Scenario;
use units::MetresPerSecond;
use world::World;

use crate::mission::{asks_a_policy, on_the_host};
use crate::{keys, open, value_error};

/// The values that are observed of each relay: see `OBSERVED` in `uchain/env.py`, which names them.
const OBSERVED: usize = 8;

/// The strength of a link that is not heard, and of a chain of which no drone flies yet, dBm.
const SILENT_DBM: f32 = -127.0;

/// What a relay is told to do, and what it last heard.
#[derive(Clone, Copy, Default)]
struct Relay {
    speed: f32,
    /// The ends of its front link and its back link in the last round in which it heard both.
    heard: Option<[LinkEnd; 2]>,
    /// The same, in the step before.
    before: Option<[LinkEnd; 2]>,
}

type Relays = Arc<Mutex<Vec<Relay>>>;
type Ground = Arc<(Scenario, World)>;
type Held<'a> = Mission<'a>;

self_cell!(
    struct Flight {
        owner: Ground,
        #[not_covariant]
        dependent: Held,
    }
);

/// A mission whose relays fly with the velocities that each step is given.
#[pyclass(frozen, module = "uchain._uchain")]
pub(crate) struct Steered {
    ground: Ground,
    relays: Relays,
    flight: Mutex<Flight>,
    /// The largest speed of a relay, m/s.
    #[pyo3(get)]
    max_speed_mps: f32,
}

#[pymethods]
impl Steered {
    #[new]
    fn new(py: Python<'_>, scenario: &str, keys: &Bound<'_, PyDict>) -> PyResult<Self> {
        let settings = keys::settings(keys)?;
        let scenario = py.detach(|| open(scenario, settings)).map_err(value_error)?;
        on_the_host(&scenario)?;
        asks_a_policy(&scenario)?;
        let max_speed_mps = scenario.agent.policy.max_speed.0;
        let count = scenario.drones.relays;
        if count == 0 {
            let text = "drones.relays: the scenario has no relay to steer; give it one or more";
            return Err(PyValueError::new_err(text));
        }
        let relays: Relays = Arc::new(Mutex::new(vec![Relay::default(); count]));
        let scenario = with_called_law(&scenario);
        let world = py.detach(|| scenario.world());
        let ground = Arc::new((scenario, world));
        let flight = Mutex::new(begin(&ground, &relays, 1));
        Ok(Self { ground, relays, flight, max_speed_mps })
    }

    /// The numbers of the relays.
    #[getter]
    fn drones(&self) -> Vec<usize> {
        let drones = &self.ground.0.drones;
        (drones.explorers..drones.flying()).collect()
    }

    /// Begins the mission of this seed, and returns what the relays observe.
    fn restart<'py>(&self, py: Python<'py>, seed: u64) -> Bound<'py, PyBytes> {
        self.relays().fill(Relay::default());
        *self.held() = begin(&self.ground, &self.relays, seed);
        self.observed(py)
    }

    /// Flies so many rounds of 0.2 s with these velocities; returns what the relays observe, the strength
    /// of the chain's weakest link in dBm, and whether the mission goes on.
    fn step<'py>(
        &self,
        py: Python<'py>,
        speeds: Vec<f32>,
        rounds: u32,
    ) -> PyResult<(Bound<'py, PyBytes>, f32, bool)> {
        self.steer(&speeds)?;
        let (weakest, goes_on) = py.detach(|| {
            self.held().with_dependent_mut(|_, mission| {
                for _ in 0..rounds {
                    if mission.is_over() {
                        break;
                    }
                    self.relays().iter_mut().for_each(|relay| relay.heard = None);
                    mission.round();
                }
                (weakest_dbm(mission), !mission.is_over())
            })
        });
        let observed = self.observed_after(py, rounds);
        self.relays().iter_mut().for_each(|relay| relay.before = relay.heard);
        Ok((observed, weakest, goes_on))
    }

    /// Seconds since the start.
    #[getter]
    fn time_s(&self) -> f64 {
        self.held().with_dependent(|_, mission| mission.time_us() as f64 / 1e6)
    }
}

impl Steered {
    fn held(&self) -> MutexGuard<'_, Flight> {
        self.flight.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn relays(&self) -> MutexGuard<'_, Vec<Relay>> {
        self.relays.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn steer(&self, speeds: &[f32]) -> PyResult<()> {
        let mut relays = self.relays();
        let count = relays.len();
        if speeds.len() != count {
            let text = format!("{} velocities for {count} relays; give one for each", speeds.len());
            return Err(PyValueError::new_err(text));
        }
        let first = self.ground.0.drones.explorers;
        for (n, speed) in speeds.iter().enumerate() {
            if !speed.is_finite() {
                let drone = first + n;
                let text =
                    format!("the velocity of drone {drone} is {speed}; give a number in m/s");
                return Err(PyValueError::new_err(text));
            }
        }
        relays.iter_mut().zip(speeds).for_each(|(relay, speed)| relay.speed = *speed);
        Ok(())
    }

    fn observed<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.observed_after(py, 1)
    }

    /// The values of all relays, as 32-bit numbers in the machine's order of bytes.
    fn observed_after<'py>(&self, py: Python<'py>, rounds: u32) -> Bound<'py, PyBytes> {
        let seconds = rounds.max(1) as f32 * ROUND_US as f32 * 1e-6;
        let first = self.ground.0.drones.explorers;
        let relays = self.relays().clone();
        let batteries: Vec<f32> = self.held().with_dependent(|_, mission| {
            let volts = |n| mission.view(n)?.body.craft().map(|craft| craft.battery().volts());
            (0..relays.len()).map(|n| volts(first + n).unwrap_or(0.0)).collect()
        });
        let each = relays.iter().zip(batteries);
        let values = each.flat_map(|(relay, battery)| values(relay, battery, seconds));
        let bytes: Vec<u8> = values.flat_map(f32::to_ne_bytes).collect();
        PyBytes::new(py, &bytes)
    }
}

fn values(relay: &Relay, battery_v: f32, seconds: f32) -> [f32; OBSERVED] {
    let Some(heard) = relay.heard else {
        return [SILENT_DBM, 0.0, 0.0, SILENT_DBM, 0.0, 0.0, battery_v, 0.0];
    };
    let rate = |side: usize| {
        let before = relay.before.map_or(heard[side].rssi, |before| before[side].rssi);
        (heard[side].rssi - before).0 / seconds
    };
    let [front, back] = heard;
    let (front_mps, back_mps) = (front.velocity.0, back.velocity.0);
    [front.rssi.0, rate(0), front_mps, back.rssi.0, rate(1), back_mps, battery_v, 1.0]
}

fn begin(ground: &Ground, relays: &Relays, seed: u64) -> Flight {
    let first = ground.0.drones.explorers;
    let relays = Arc::clone(relays);
    let law = move |drone: usize, front: LinkEnd, back: LinkEnd| {
        let mut relays = relays.lock().unwrap_or_else(PoisonError::into_inner);
        let relay = drone.checked_sub(first).and_then(|n| relays.get_mut(n));
        let Some(relay) = relay else { return MetresPerSecond::ZERO };
        relay.heard = Some([front, back]);
        MetresPerSecond(relay.speed)
    };
    Flight::new(Arc::clone(ground), |ground| {
        Mission::new(&ground.0, &ground.1, seed).by_law(Box::new(law))
    })
}

/// The large-scale strength of the weakest link of the chain as it is now.
fn weakest_dbm(mission: &Mission<'_>) -> f32 {
    let mut chain: Vec<Linked> = Vec::new();
    mission.chain(&mut chain);
    let links = chain
        .windows(2)
        .map(|pair| mission.large_scale_strength(pair[0].id.0.into(), pair[1].id.0.into()).0);
    links
        .fold(None, |least: Option<f32>, link| Some(least.map_or(link, |least| least.min(link))))
        .unwrap_or(SILENT_DBM)
        .max(SILENT_DBM)
}
