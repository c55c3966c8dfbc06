//! A mission that Python steps, looks at and steers.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use world::World;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use self_cell::self_cell;
use sim_harness::mission::trace::{DroneFrame, LinkFrame, order_words};
use sim_harness::mission::{Mission, with_called_law};
use sim_harness::scenario::Scenario;
use units::{Branch, Course, MetresPerSecond, Order};

use crate::mission::{asks_a_policy, on_the_host};
use crate::policy::{Laws, Raised};
use crate::wake::Wakeable;
use crate::{keys, open, value_error};

type Held<'a> = Mission<'a>;

self_cell!(
    struct Flight {
        owner: (Scenario, World),
        #[not_covariant]
        dependent: Held,
    }
);

/// A mission under way.
#[pyclass(frozen, subclass, module = "uchain")]
pub(crate) struct Simulation {
    flight: Mutex<Flight>,
    raised: Option<Raised>,
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scenario, seed = 1, *, policy = None, live = false, timeout_s = 10.0, **keys))]
    fn new(
        py: Python<'_>,
        scenario: &str,
        seed: u64,
        policy: Option<Py<PyAny>>,
        live: bool,
        timeout_s: f64,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let settings = keys.map_or(Ok(Vec::new()), keys::settings)?;
        let laws = policy.map(|policy| Laws::new(py, policy, timeout_s)).transpose()?;
        let called = laws.map(|laws| (laws.law(String::new()), laws.raised()));
        let scenario = py.detach(|| open(scenario, settings)).map_err(value_error)?;
        on_the_host(&scenario)?;
        if let Some((_, raised)) = &called {
            asks_a_policy(&scenario)?;
            // What the constructor of a class has raised.
            raised.take()?;
        }
        let scenario = if called.is_some() { with_called_law(&scenario) } else { scenario };
        let world = py.detach(|| scenario.world());
        let (law, raised) = called.unzip();
        let flight = Flight::new((scenario, world), |(scenario, world)| {
            let mission = match live {
                true => Mission::live(scenario, world, seed),
                false => Mission::new(scenario, world, seed),
            };
            match law {
                Some(law) => mission.by_law(law),
                None => mission,
            }
        });
        Ok(Self { flight: Mutex::new(flight), raised })
    }

    /// Flies so many rounds of 0.2 s, or to the end; returns whether the mission goes on.
    #[pyo3(signature = (rounds = 1))]
    fn step(&self, py: Python<'_>, rounds: u32) -> PyResult<bool> {
        let _wakeable = self.raised.as_ref().map(|_| Wakeable::new(py));
        let mut goes_on = true;
        for _ in 0..rounds {
            let round = || -> PyResult<bool> {
                Ok(self.held()?.with_dependent_mut(|_, mission| {
                    if !mission.is_over() {
                        mission.round();
                    }
                    !mission.is_over()
                }))
            };
            goes_on = if self.raised.is_some() { round()? } else { py.detach(round)? };
            self.raised.as_ref().map_or(Ok(()), Raised::take)?;
            py.check_signals()?;
            if !goes_on {
                break;
            }
        }
        Ok(goes_on)
    }

    fn __repr__(&self) -> PyResult<String> {
        let flight = self.held()?;
        let name = flight.borrow_owner().0.name.clone();
        let (time, is_over) =
            flight.with_dependent(|_, mission| (mission.time_us() as f64 / 1e6, mission.is_over()));
        let end = if is_over { ", over" } else { "" };
        Ok(format!("<uchain.Simulation {name} at {time} s{end}>"))
    }

    /// Seconds since the start.
    #[getter]
    fn time_s(&self) -> PyResult<f64> {
        Ok(self.held()?.with_dependent(|_, mission| mission.time_us() as f64 / 1e6))
    }

    /// Whether the mission is over.
    #[getter]
    fn is_over(&self) -> PyResult<bool> {
        Ok(self.held()?.with_dependent(|_, mission| mission.is_over()))
    }

    /// The operator's order, in words.
    #[getter]
    fn order_now(&self) -> PyResult<String> {
        Ok(self.held()?.with_dependent(|_, mission| order_words(mission.task())))
    }

    /// The drones as they are now, the head first and the base last.
    fn look<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let (members, frame) = self.held()?.with_dependent(|_, mission| {
            let members = (0..mission.count()).filter_map(|n| mission.view(n));
            (members.map(|member| (member.id, member.role)).collect::<Vec<_>>(), mission.frame())
        });
        let drones = members.iter().zip(&frame.drones).map(|((id, role), drone)| {
            let dict = drone_dict(py, drone)?;
            dict.set_item("node", id.0)?;
            dict.set_item("role", format!("{role:?}").to_lowercase())?;
            Ok(dict)
        });
        PyList::new(py, drones.collect::<PyResult<Vec<_>>>()?)
    }

    /// Gives the operator's order in a live mission.
    #[pyo3(signature = (order, *, speed_mps = None, branch = None))]
    fn order(&self, order: &str, speed_mps: Option<f32>, branch: Option<&str>) -> PyResult<()> {
        let order = order_of(order, speed_mps, branch)?;
        self.held()?.with_dependent_mut(|_, mission| match mission.is_live() {
            true => {
                mission.order(order);
                Ok(())
            }
            false => Err(PyValueError::new_err(
                "the scenario's pilot gives the orders; make the simulation with live=True",
            )),
        })
    }
}

impl Simulation {
    /// The flight. A step holds it while it calls a policy of Python: a wait for it by that policy, or by a
    /// thread that has the interpreter meanwhile, would never end.
    fn held(&self) -> PyResult<MutexGuard<'_, Flight>> {
        if self.raised.is_none() {
            return Ok(self.flight.lock().unwrap_or_else(PoisonError::into_inner));
        }
        match self.flight.try_lock() {
            Ok(flight) => Ok(flight),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "the simulation is in the middle of a step; use it between two steps",
            )),
        }
    }
}

fn order_of(name: &str, speed_mps: Option<f32>, branch: Option<&str>) -> PyResult<Order> {
    let wrong = |text: String| Err(PyValueError::new_err(text));
    let branch = match branch {
        None => None,
        Some("left") => Some(Branch::Left),
        Some("right") => Some(Branch::Right),
        Some("straight") => Some(Branch::Straight),
        Some(other) => {
            return wrong(format!("there is no branch \"{other}\"; give left, right or straight"));
        }
    };
    let order = match (name, speed_mps) {
        ("explore", Some(speed)) if (-1.0..=1.0).contains(&speed) => {
            return Ok(Order::Explore(Course { speed: MetresPerSecond(speed), branch }));
        }
        ("explore", _) => {
            return wrong("explore needs speed_mps; give a number from -1 to 1".into());
        }
        ("wait", None) => Order::Wait,
        ("return", None) => Order::Return,
        ("land", None) => Order::Land,
        ("perch", None) => Order::Perch,
        ("stop", None) => Order::Stop,
        ("wait" | "return" | "land" | "perch" | "stop", Some(_)) => {
            return wrong(format!("{name} takes no speed_mps; give it with explore alone"));
        }
        _ => {
            let names = ["wait", "explore", "return", "land", "perch", "stop"];
            let remedy = input::suggest::one_of(name, &names);
            return wrong(format!("there is no order \"{name}\"; {remedy}"));
        }
    };
    match branch {
        None => Ok(order),
        Some(_) => wrong(format!("{name} takes no branch; give it with explore alone")),
    }
}

fn drone_dict<'py>(py: Python<'py>, drone: &DroneFrame) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("state", drone.state.name())?;
    for (key, value) in [
        ("x_m", drone.pose.at.x),
        ("y_m", drone.pose.at.y),
        ("z_m", drone.height),
        ("yaw_rad", drone.pose.yaw.0),
        ("way_m", drone.way),
        ("forward_m_s", drone.commanded[0]),
        ("left_m_s", drone.commanded[1]),
        ("yaw_rate_rad_s", drone.yaw_rate),
        ("battery_v", drone.battery_v),
    ] {
        dict.set_item(key, Some(value).filter(|value| !value.is_nan()))?;
    }
    let ranges = drone.ranges.map(|range| Some(range).filter(|range| !range.is_nan()));
    dict.set_item("ranges_m", ranges.to_vec())?;
    for (key, side) in [("front", &drone.front), ("back", &drone.back)] {
        dict.set_item(key, side.as_ref().map(|link| link_dict(py, link)).transpose()?)?;
    }
    Ok(dict)
}

fn link_dict<'py>(py: Python<'py>, link: &LinkFrame) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("peer", link.peer.0)?;
    dict.set_item("raw_dbm", link.raw.0)?;
    dict.set_item("filtered_dbm", link.filtered.0)?;
    dict.set_item("true_dbm", link.truth.0)?;
    Ok(dict)
}
