//! The simulator as WebAssembly: the side of the page in the browser that flies, plans and answers. The
//! other side is in `page/`.
//!
//! | module | what it holds |
//! |---|---|
//! | [`drawing`] | a cave that the user draws, as the text of a scenario |
//! | [`legs`] | the legs of drawn galleries, compared with each other |
//! | [`recipe`] | what the page asks for: a scenario, its changes, the pilot's orders, as one JSON value |
//! | [`flight`] | a mission under way, which the page steps, steers and looks at |
//! | [`look`] | what the page draws: the place, the drones, the figures |

pub mod drawing;
pub mod flight;
pub mod legs;
pub mod look;
pub mod recipe;

use std::sync::Arc;

use cave_survey::Memory;
use serde_json::{Value, json};
use sim_harness::cli::plan::answer;
use sim_harness::planning::plan::{Demand, relays};
use sim_harness::scenario::builtin;
use units::{Db, MetresPerSecond};
use wasm_bindgen::prelude::*;

use drawing::Drawing;
pub use flight::Flight;
use recipe::Recipe;

/// Makes a defect of the simulator an error of the page's JavaScript, with the words of the panic.
#[cfg(target_arch = "wasm32")]
#[wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|panic| wasm_bindgen::throw_str(&panic.to_string())));
}

/// The names and the titles of the built-in scenarios, as a JSON list of objects.
#[wasm_bindgen]
#[must_use]
pub fn scenarios() -> String {
    let titled = |(name, title): (&str, String)| json!({ "name": name, "title": title });
    Value::Array(builtin::titles().map(titled).collect()).to_string()
}

/// The files that a user has dropped on the page, by their paths.
#[wasm_bindgen]
#[derive(Clone, Default)]
pub struct Dropped {
    files: Arc<Memory>,
}

#[wasm_bindgen]
impl Dropped {
    /// Makes an empty set.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file.
    pub fn add(&mut self, path: &str, bytes: Vec<u8>) {
        let files = Arc::unwrap_or_clone(std::mem::take(&mut self.files));
        self.files = Arc::new(files.with(path, bytes));
    }
}

impl Dropped {
    /// The files.
    #[must_use]
    pub const fn memory(&self) -> &Arc<Memory> {
        &self.files
    }
}

/// The answer of `uchain plan relays` for a recipe, as JSON: the plan, the text for people, and the
/// floor plan of the place. Every link is to be stronger than the launch limit by `margin_db`.
///
/// # Errors
/// One line that says what of the recipe or of the files cannot be used.
#[wasm_bindgen]
pub fn plan_relays(recipe: &str, files: &Dropped, margin_db: f32) -> Result<String, String> {
    let scenario = Recipe::read(recipe)?.scenario(&files.files)?;
    let demand =
        Demand { margin: Db(margin_db), speed: MetresPerSecond(PLANNED_MPS), depth_m: None };
    let plan = relays(&scenario, demand);
    let answer = json!({
        "place": look::place(&scenario),
        "plan": answer::json(&scenario, &plan),
        "text": answer::table(&scenario, &plan),
    });
    Ok(answer.to_string())
}

/// The scenario of a drawn cave, as JSON: its `text`, or the `mistake` of the drawing.
///
/// # Errors
/// One line for JSON that is no drawing.
#[wasm_bindgen]
pub fn drawn_scenario(drawing: &str) -> Result<String, String> {
    let answer = match Drawing::read(drawing)?.scenario() {
        Ok(text) => json!({ "text": text }),
        Err(mistake) => json!({ "mistake": mistake }),
    };
    Ok(answer.to_string())
}

/// The head's speed on its way out of which a plan is made, m/s: the command's default.
const PLANNED_MPS: f32 = 0.2;
