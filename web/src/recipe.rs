//! Reads what the page asks for: a scenario with changes and a seed, as one JSON value, which the page's
//! link holds as well.

use std::sync::Arc;

use cave_survey::Memory;
use input::InputError;
use maps::{Ends, MapChoice};
use serde::{Deserialize, Serialize};
use sim_harness::scenario::{
    Changes, Fidelity, Loss, LossKind, PilotStep, Scenario, Setting, builtin,
};
use toml::{Table, Value};
use units::{Branch, Order};

/// A scenario, its changes and the seed of a mission.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recipe {
    /// The name of a built-in scenario; where left out, the mission of the map, or the demonstration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenario: Option<String>,
    /// The text of a scenario file, in place of a built-in one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// The path of a map among the dropped files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// The station, tile or point at which the base stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// The station, tile or point at which the route ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<String>,
    /// The number of relays, where it is not the scenario's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relays: Option<usize>,
    /// The seed of the mission; 1 where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Other values of single keys, each as `key=value`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The orders of the pilot, in place of the scenario's: entries of `[[pilot]]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pilot: Option<Vec<Table>>,
    /// The drones that are lost, in place of the scenario's: entries of `[[loss]]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loss: Option<Vec<Table>>,
}

impl Recipe {
    /// Reads the JSON value.
    ///
    /// # Errors
    /// One line that says what is wrong with it.
    pub fn read(json: &str) -> Result<Self, String> {
        serde_json::from_str(json)
            .map_err(|error| format!("the link is not one of this page: {error}"))
    }

    /// The seed of the mission.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// Reads and checks the scenario.
    ///
    /// # Errors
    /// The line that the command would print.
    pub fn scenario(&self, files: &Arc<Memory>) -> Result<Scenario, String> {
        let scenario = self.open(files).map_err(|error| error.to_string())?;
        if scenario.fidelity == Fidelity::Virtual {
            return Err(
                "virtual drones fly with `uchain run` only; give fidelity = \"flight\"".into()
            );
        }
        Ok(scenario)
    }

    fn open(&self, files: &Arc<Memory>) -> Result<Scenario, InputError> {
        let map = self.map.as_ref().map(|file| MapChoice {
            file: file.into(),
            within: None,
            ends: Ends { from: self.from.clone(), to: self.to.clone(), around_m: None },
            memory: Some(Arc::clone(files)),
        });
        let mut settings =
            self.set.iter().map(|text| Setting::parse(text)).collect::<Result<Vec<_>, _>>()?;
        match (&self.text, &self.scenario, map) {
            (None, None, Some(map)) => self.of_map(map, settings),
            (text, name, map) => {
                settings.extend(self.flown());
                let changes = Changes { map, suits_width: false, relays: self.relays, settings };
                match text {
                    Some(text) => Scenario::of_text_with("scenario", text, &changes),
                    None => {
                        let name = name.as_deref().unwrap_or(builtin::DEMONSTRATION);
                        Scenario::open_with(name, &changes)
                    }
                }
            }
        }
    }

    /// The mission of a map. Its pilot turns back where the route ends, which another pilot does not.
    fn of_map(&self, map: MapChoice, settings: Vec<Setting>) -> Result<Scenario, InputError> {
        let own = Scenario::of_map(map.clone(), self.relays, settings)?;
        let settings: Vec<_> = self.flown().collect();
        if settings.is_empty() {
            return Ok(own);
        }
        let changes = Changes { map: Some(map), settings, ..Changes::default() };
        Scenario::of_text_with(&own.name, &own.resolved(), &changes)
    }

    /// The orders and the losses as keys of the scenario.
    fn flown(&self) -> impl Iterator<Item = Setting> {
        let list = |tables: &Vec<Table>| tables.iter().cloned().map(Value::Table).collect();
        let keys = [("pilot", &self.pilot), ("loss", &self.loss)];
        let setting = move |(key, tables): (&str, &Option<Vec<Table>>)| {
            tables.as_ref().map(|tables| Setting::new(key, Value::Array(list(tables))))
        };
        keys.into_iter().filter_map(setting)
    }
}

/// A number by its shortest decimals, so that 0.1 stays 0.1.
fn number(value: f32) -> Value {
    Value::Float(value.to_string().parse().unwrap_or(f64::from(value)))
}

fn table<const N: usize>(keys: [(&str, Value); N]) -> Table {
    keys.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

fn at_s(at_us: u64) -> Value {
    number((at_us as f64 * 1e-6) as f32)
}

/// The orders of a pilot as entries of `[[pilot]]`.
#[must_use]
pub fn pilot(steps: &[PilotStep]) -> Vec<Table> {
    steps.iter().map(order).collect()
}

fn order(step: &PilotStep) -> Table {
    let at = ("at_s", at_s(step.at_us));
    let plain = |name: &str| table([at.clone(), ("order", name.into())]);
    match step.task {
        Order::Wait => plain("wait"),
        Order::Return => plain("return"),
        Order::Land => plain("land"),
        Order::Perch => plain("perch"),
        Order::Stop => plain("stop"),
        Order::Explore(course) => {
            let mut entry = plain("explore");
            entry.insert("speed_mps".into(), number(course.speed.0));
            let branch = course.branch.map(|branch| match branch {
                Branch::Left => "left",
                Branch::Right => "right",
                Branch::Straight => "straight",
            });
            entry.extend(branch.map(|branch| ("branch".to_owned(), branch.into())));
            entry
        }
    }
}

/// Lost drones as entries of `[[loss]]`.
#[must_use]
pub fn losses(losses: &[Loss]) -> Vec<Table> {
    let how = |how: LossKind| match how {
        LossKind::Lands => "lands",
        LossKind::Silent => "silent",
        LossKind::Gone => "gone",
    };
    let entry = |loss: &Loss| {
        let drone = Value::Integer(loss.drone as i64);
        table([("at_s", at_s(loss.at_us)), ("drone", drone), ("how", how(loss.how).into())])
    };
    losses.iter().map(entry).collect()
}
