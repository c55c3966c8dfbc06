//! A mission under way, which the page steps, steers and looks at.

use self_cell::self_cell;
use serde_json::{Value, json};
use sim_harness::measure::metrics::{Reference, Watch};
use sim_harness::mission::trace::Trace;
use sim_harness::mission::{Mission, ROUND_US};
use sim_harness::report::{csv, summary};
use sim_harness::scenario::{LossKind, Scenario};
use units::{Branch, Course, MetresPerSecond, Order};
use wasm_bindgen::prelude::*;
use world::World;

use crate::recipe::{self, Recipe};
use crate::{Dropped, look};

/// The scenario of a mission, its world, and the best chains with which it is compared.
struct Ground {
    scenario: Scenario,
    world: World,
    reference: Reference,
}

/// A mission, and its figures so far.
struct Flying<'a> {
    mission: Mission<'a>,
    watch: Watch<'a>,
}

self_cell!(
    struct Held {
        owner: Ground,
        #[not_covariant]
        dependent: Flying,
    }
);

/// A mission that the page flies.
#[wasm_bindgen]
pub struct Flight {
    held: Held,
    recipe: Recipe,
    /// The record, with every round.
    trace: Trace,
    /// Whether an order or a loss came from the page.
    is_steered: bool,
    /// The number of changes of the explorers' map that the page knows.
    told_changes: usize,
}

#[wasm_bindgen]
impl Flight {
    /// Begins the mission of a recipe.
    ///
    /// # Errors
    /// One line that says what of the recipe or of the files cannot be used.
    #[wasm_bindgen(constructor)]
    pub fn new(recipe: &str, files: &Dropped) -> Result<Self, String> {
        let recipe = Recipe::read(recipe)?;
        let scenario = recipe.scenario(&files.files)?;
        let world = scenario.world();
        let reference = Reference::of(&scenario, &world);
        let seed = recipe.seed();
        let held = Held::new(Ground { scenario, world, reference }, |ground| Flying {
            mission: Mission::new(&ground.scenario, &ground.world, seed),
            watch: Watch::new(&ground.scenario, &ground.world, &ground.reference),
        });
        let trace = held.with_dependent(|_, flying| flying.mission.begin_trace(seed));
        Ok(Self { held, recipe, trace, is_steered: false, told_changes: 0 })
    }

    /// What does not change during the mission, as JSON: the place, the members, the limits.
    #[must_use]
    pub fn setting(&self) -> String {
        let Ground { scenario, .. } = self.held.borrow_owner();
        look::setting(scenario, self.recipe.seed(), &self.trace).to_string()
    }

    /// Flies for so many microseconds, or to the end; returns whether the mission goes on.
    pub fn advance(&mut self, us: u32) -> bool {
        let Self { held, trace, .. } = self;
        held.with_dependent_mut(|_, Flying { mission, watch }| {
            if has_ended(mission) {
                return false;
            }
            let until_us = mission.time_us() + u64::from(us);
            while mission.time_us() < until_us {
                // The mission is judged between rounds alone, as the command does.
                let round_ends_us = (mission.time_us() / ROUND_US + 1) * ROUND_US;
                mission.advance(until_us.min(round_ends_us) - mission.time_us());
                if mission.time_us() == round_ends_us {
                    watch.look(mission);
                    trace.team_map.look(mission);
                    trace.frames.push(mission.frame());
                    if mission.is_over() {
                        return false;
                    }
                }
            }
            true
        })
    }

    /// The mission at this moment, as JSON.
    #[must_use]
    pub fn frame(&self) -> String {
        self.held.with_dependent(|_, flying| {
            look::frame(&flying.mission, has_ended(&flying.mission)).to_string()
        })
    }

    /// What explorers know of their area together, as JSON: what has changed since this was last asked.
    pub fn map_changes(&mut self) -> String {
        let known = std::mem::replace(&mut self.told_changes, self.trace.team_map.changes().len());
        look::team_map(&self.trace, known).to_string()
    }

    /// The figures of the mission so far, as JSON.
    #[must_use]
    pub fn figures(&self) -> String {
        let figures = |ground: &Ground, flying: &Flying<'_>| {
            look::figures(&ground.scenario, &flying.mission, &flying.watch.verdict(&flying.mission))
        };
        self.held.with_dependent(figures).to_string()
    }

    /// Gives the operator's order in place of the scenario's pilot: `wait`, `return`, `land`, `perch`,
    /// `stop`, or `explore` at this speed, m/s, with `left`, `right` or `straight` at junctions, or
    /// with no word for no choice. The order counts from the end of the round on; a mission that has
    /// ended takes none.
    ///
    /// # Errors
    /// One line for an order that is none.
    pub fn steer(&mut self, order: &str, speed_mps: f32, branch: &str) -> Result<(), String> {
        let order = order_of(order, speed_mps, branch)?;
        self.end_round();
        if !self.has_ended() {
            self.is_steered = true;
            self.held.with_dependent_mut(|_, flying| flying.mission.steer(order));
        }
        Ok(())
    }

    /// Takes a drone from the mission: its motors and its radio stop. A mission that has ended stays as
    /// it is.
    pub fn lose(&mut self, drone: usize) {
        self.end_round();
        if !self.has_ended() {
            self.is_steered = true;
            self.held.with_dependent_mut(|_, flying| flying.mission.lose(drone, LossKind::Gone));
        }
    }

    /// The recipe of this very flight, as JSON: with the orders and the losses that came from the page.
    #[must_use]
    pub fn flown(&self) -> String {
        let mut recipe = self.recipe.clone();
        if self.is_steered {
            self.held.with_dependent(|_, flying| {
                recipe.pilot = Some(recipe::pilot(flying.mission.pilot()));
                recipe.loss = Some(recipe::losses(flying.mission.losses()));
            });
        }
        serde_json::to_string(&recipe).unwrap_or_default()
    }

    /// The scenario of this very flight as a file for `uchain run`.
    ///
    /// # Errors
    /// One line that says why the flight has no file.
    pub fn scenario_toml(&self, files: &Dropped) -> Result<String, String> {
        let scenario = Recipe::read(&self.flown())?.scenario(&files.files)?;
        Ok(scenario.resolved())
    }

    /// The record so far: the text of `trace.csv`.
    #[must_use]
    pub fn trace_csv(&self) -> String {
        let mut bytes = Vec::new();
        // Memory takes all that is written.
        let _ = csv::write(&self.trace, &mut bytes);
        String::from_utf8(bytes).unwrap_or_default()
    }

    /// The summary of a mission that is over, as `uchain run` writes it.
    #[must_use]
    pub fn summary(&self) -> String {
        let value: Value = self.held.with_dependent(|ground, Flying { mission, watch }| {
            let metrics = watch.verdict(mission);
            let judgement = watch.judgement(mission, &metrics);
            let failures: Vec<_> = judgement.failures.iter().map(ToString::to_string).collect();
            let seed = self.recipe.seed();
            summary(&ground.scenario, seed, &self.trace, &metrics, &judgement, &failures)
        });
        json!(value).to_string()
    }
}

impl Flight {
    /// The record so far.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Flies to the end of the round, where orders and losses are taken.
    fn end_round(&mut self) {
        let past_us = self.held.with_dependent(|_, flying| flying.mission.time_us() % ROUND_US);
        if past_us > 0 {
            self.advance((ROUND_US - past_us) as u32);
        }
    }

    fn has_ended(&self) -> bool {
        self.held.with_dependent(|_, flying| has_ended(&flying.mission))
    }
}

/// Whether the mission is over, and the round in which its time was up has been flown and recorded whole.
fn has_ended(mission: &Mission<'_>) -> bool {
    mission.is_over() && mission.time_us().is_multiple_of(ROUND_US)
}

fn order_of(name: &str, speed_mps: f32, branch: &str) -> Result<Order, String> {
    let branch = match branch {
        "" => None,
        "left" => Some(Branch::Left),
        "right" => Some(Branch::Right),
        "straight" => Some(Branch::Straight),
        other => return Err(format!("there is no branch \"{other}\"")),
    };
    match name {
        "explore" if (-1.0..=1.0).contains(&speed_mps) => {
            Ok(Order::Explore(Course { speed: MetresPerSecond(speed_mps), branch }))
        }
        "wait" => Ok(Order::Wait),
        "return" => Ok(Order::Return),
        "land" => Ok(Order::Land),
        "perch" => Ok(Order::Perch),
        "stop" => Ok(Order::Stop),
        other => Err(format!("there is no order \"{other}\" at {speed_mps} m/s")),
    }
}
