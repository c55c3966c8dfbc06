//! One mission.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float32Array, Float64Array, StringArray, UInt32Array};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sim_harness::measure::metrics::{Reference, Watch};
use sim_harness::measure::verdict::Judgement;
use sim_harness::mission::trace::{DroneFrame, LinkFrame, Trace};
use sim_harness::mission::{Mission, with_called_law};
use sim_harness::report::{pictures, report, summary};
use sim_harness::scenario::{Fidelity, Scenario};
use units::MissionKind;

use crate::policy::Laws;
use crate::table::Table;
use crate::wake::Wakeable;
use crate::{keys, open, value_error};

/// A mission that was flown.
#[pyclass(frozen, module = "uchain._uchain")]
pub(crate) struct Flown {
    scenario: Scenario,
    trace: Trace,
    judgement: Judgement,
    failures: Vec<String>,
    summary: String,
}

/// Refuses virtual drones, which the package does not have.
pub(crate) fn on_the_host(scenario: &Scenario) -> PyResult<()> {
    if scenario.fidelity == Fidelity::Virtual {
        let text = "virtual drones fly with `uchain run` only; give fidelity=\"flight\"";
        return Err(pyo3::exceptions::PyValueError::new_err(text));
    }
    Ok(())
}

/// Refuses a policy of Python for a mission in which no relay asks one.
pub(crate) fn asks_a_policy(scenario: &Scenario) -> PyResult<()> {
    let mission = match scenario.mission {
        MissionKind::Chain => return Ok(()),
        MissionKind::Swarm => "swarm",
        MissionKind::Explore => "explore",
    };
    let text = format!(
        "the drones of mission=\"{mission}\" follow no movement policy; leave policy= out, or give a \
         scenario with a chain"
    );
    Err(pyo3::exceptions::PyValueError::new_err(text))
}

/// Rounds between two looks whether Python was interrupted.
const ROUNDS: usize = 64;

/// Flies a mission to its end.
#[pyfunction]
pub(crate) fn fly(
    py: Python<'_>,
    scenario: &str,
    seed: u64,
    policy: Option<Py<PyAny>>,
    timeout_s: f64,
    keys: &Bound<'_, PyDict>,
) -> PyResult<Flown> {
    let settings = keys::settings(keys)?;
    let scenario = py.detach(|| open(scenario, settings)).map_err(value_error)?;
    on_the_host(&scenario)?;
    let is_called = policy.is_some();
    if is_called {
        asks_a_policy(&scenario)?;
    }
    let scenario = if is_called { with_called_law(&scenario) } else { scenario };
    let (world, reference) = py.detach(|| {
        let world = scenario.world();
        let reference = Reference::of(&scenario, &world);
        (world, reference)
    });
    let mut mission = Mission::new(&scenario, &world, seed);
    let mut raised = None;
    if let Some(policy) = policy {
        let laws = Laws::new(py, policy, timeout_s)?;
        mission = mission.by_law(laws.law(String::new()));
        raised = Some(laws.raised());
    }
    let mut watch = Watch::new(&scenario, &world, &reference);
    let mut trace = mission.begin_trace(seed);
    let _wakeable = is_called.then(|| Wakeable::new(py));
    let mut rounds = || rounds(&mut mission, &mut watch, &mut trace);
    loop {
        // A policy of Python is called by this thread, which then keeps the interpreter.
        let goes_on = if is_called { rounds() } else { py.detach(&mut rounds) };
        py.check_signals()?;
        raised.as_ref().map_or(Ok(()), crate::policy::Raised::take)?;
        if !goes_on {
            break;
        }
    }
    let metrics = watch.verdict(&mission);
    let judgement = watch.judgement(&mission, &metrics);
    drop(watch);
    drop(mission);
    let failures: Vec<_> = judgement.failures.iter().map(ToString::to_string).collect();
    let summary = summary(&scenario, seed, &trace, &metrics, &judgement, &failures).to_string();
    drop(world);
    Ok(Flown { scenario, trace, judgement, failures, summary })
}

/// Flies some rounds; returns whether the mission goes on.
fn rounds(mission: &mut Mission<'_>, watch: &mut Watch<'_>, trace: &mut Trace) -> bool {
    for _ in 0..ROUNDS {
        if mission.is_over() {
            return false;
        }
        mission.round();
        watch.look(mission);
        trace.frames.push(mission.frame());
    }
    true
}

fn failed(error: &pictures::PictureError) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

#[pymethods]
impl Flown {
    /// Whether the mission succeeded.
    #[getter]
    fn success(&self) -> bool {
        self.judgement.is_success()
    }

    /// Why it failed, in words.
    #[getter]
    fn failures(&self) -> Vec<String> {
        self.failures.clone()
    }

    /// The summary as JSON.
    #[getter]
    fn summary_json(&self) -> &str {
        &self.summary
    }

    /// The whole scenario as a TOML file.
    #[getter]
    fn scenario_toml(&self) -> String {
        self.scenario.resolved()
    }

    /// The record as a table.
    fn trace(&self, py: Python<'_>) -> PyResult<Table> {
        py.detach(|| table(&self.trace))
    }

    /// The page that plays the mission.
    fn report_html(&self, py: Python<'_>) -> PyResult<String> {
        let summary = self.summary.parse().unwrap_or_default();
        py.detach(|| report::html(&self.trace, &summary)).map_err(|error| failed(&error))
    }

    /// The floor plan with the paths flown, as SVG.
    fn map_svg(&self, py: Python<'_>) -> PyResult<String> {
        let picture = py.detach(|| pictures::map(&self.trace)).map_err(|error| failed(&error))?;
        Ok(picture.svg().to_owned())
    }
}

/// The columns of the trace: those of `trace.csv`, and the voltage of the batteries.
fn table(trace: &Trace) -> PyResult<Table> {
    let rows = || {
        let each = |frame| {
            let frame: &sim_harness::mission::trace::Frame = frame;
            trace.nodes.iter().zip(&frame.drones).map(move |(node, drone)| (frame, node, drone))
        };
        trace.frames.iter().flat_map(each)
    };
    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let mut put = |name: &str, array: ArrayRef| columns.push((name.to_owned(), array));
    let times = rows().map(|(frame, ..)| frame.time_us as f64 / 1e6);
    put("time_s", Arc::new(Float64Array::from_iter_values(times)));
    put(
        "node",
        Arc::new(UInt32Array::from_iter_values(rows().map(|(_, node, _)| node.id.0.into()))),
    );
    let roles = rows().map(|(_, node, _)| Some(node.role.name()));
    put("role", Arc::new(StringArray::from_iter(roles)));
    let states = rows().map(|(_, _, drone)| Some(drone.state.name()));
    put("state", Arc::new(StringArray::from_iter(states)));
    let edges = rows().map(|(_, _, drone)| Some(trace.floor_plan.edge_name(drone.place)));
    put("edge", Arc::new(StringArray::from_iter(edges)));
    for (name, of) in NUMBERS {
        let values = rows().map(|(_, _, drone)| Some(of(drone)).filter(|value| !value.is_nan()));
        put(name, Arc::new(Float32Array::from_iter(values)));
    }
    for (side, of) in SIDES {
        let peers = rows().map(|(_, _, drone)| of(drone).map(|link| u32::from(link.peer.0)));
        put(&format!("{side}_peer"), Arc::new(UInt32Array::from_iter(peers)));
        for (name, strength) in STRENGTHS {
            let values = rows().map(|(_, _, drone)| of(drone).map(strength));
            let values = values.map(|value| value.filter(|value| !value.is_nan()));
            put(&format!("{side}_{name}_dbm"), Arc::new(Float32Array::from_iter(values)));
        }
    }
    Table::new(columns)
}

type Number = fn(&DroneFrame) -> f32;

const NUMBERS: [(&str, Number); 14] = [
    ("x_m", |drone| drone.pose.at.x),
    ("y_m", |drone| drone.pose.at.y),
    ("z_m", |drone| drone.height),
    ("yaw_rad", |drone| drone.pose.yaw.0),
    ("along_m", |drone| drone.place.along),
    ("way_m", |drone| drone.way),
    ("forward_m_s", |drone| drone.commanded[0]),
    ("left_m_s", |drone| drone.commanded[1]),
    ("yaw_rate_rad_s", |drone| drone.yaw_rate),
    ("range_nw_m", |drone| drone.ranges[0]),
    ("range_ne_m", |drone| drone.ranges[1]),
    ("range_sw_m", |drone| drone.ranges[2]),
    ("range_se_m", |drone| drone.ranges[3]),
    ("battery_v", |drone| drone.battery_v),
];

type Side = fn(&DroneFrame) -> Option<LinkFrame>;

const SIDES: [(&str, Side); 2] = [("front", |drone| drone.front), ("back", |drone| drone.back)];

type Strength = fn(LinkFrame) -> f32;

const STRENGTHS: [(&str, Strength); 3] = [
    ("raw", |link| link.raw.0),
    ("filtered", |link| link.filtered.0),
    ("true", |link| link.truth.0),
];
