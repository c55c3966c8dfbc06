//! One situation in one cave: what each rule chooses for the goal, and what that is worth.

use grid_map::Cell;
use relay_placement::{Demand, Rule};
use serde_json::{Value, json};

use super::{Cave, Criteria, Situation, square};

/// A relay that was put down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropped {
    /// The cell.
    pub cell: Cell,
    /// The area that it covers and the network does not, m².
    pub gain_m2: f32,
    /// What its link to the network has above 37 dB, dB; negative without a link.
    pub margin_db: f32,
    /// The free width that is left beside it, m.
    pub free_width_m: f32,
    /// The distance from the goal, m.
    pub off_goal_m: f32,
    /// Whether it stands beside a wall.
    pub is_beside_wall: bool,
}

/// What the rules choose for one goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The seed of the cave.
    pub seed: u64,
    /// Where the goal lies.
    pub situation: Situation,
    /// The goal itself.
    pub goal: Dropped,
    /// The place of the paper's rule.
    pub paper: Dropped,
    /// The place of our rule, which asks for a link and chooses none where there is none.
    pub ours: Option<Dropped>,
    /// A drop cell at random.
    pub random: Dropped,
    /// How far from the paper's place the places are that c1 alone and c2 alone choose, m.
    pub by_one_m: [f32; 2],
    /// The largest area that a relay in a drop cell covers and the network does not, m².
    pub most_m2: f32,
}

impl Trial {
    /// Lets each rule choose. `None` where no drop cell is beside a wall.
    pub(super) fn of(
        cave: &mut Cave,
        situation: Situation,
        goal: Cell,
        criteria: &Criteria,
    ) -> Option<Self> {
        let at = cave.ground.frame().centre(goal);
        let Cave { ground, network, planner, seed, .. } = cave;
        let seed = *seed;
        let mut choose = |rule: Rule| {
            let place = rule.choose(ground, network, at, &Demand::DEFAULT, seed, planner);
            place.map(|place| place.cell)
        };
        let [paper, ours, random] = [Rule::Paper, Rule::Ours, Rule::Random].map(&mut choose);
        let dropped = |cell| Dropped::at(cave, criteria, cell);
        let paper = dropped(paper?)?;
        let away =
            |cell: Option<Cell>| cell.map_or(f32::NAN, |cell| metres(cave, cell, paper.cell));
        Some(Self {
            seed,
            situation,
            goal: dropped(goal)?,
            paper,
            ours: ours.and_then(dropped),
            random: dropped(random?)?,
            by_one_m: criteria.by_one().map(away),
            most_m2: criteria
                .cells
                .iter()
                .map(|cell| cave.square_metres(cell.gain_cells))
                .fold(0.0, f32::max),
        })
    }

    /// What the places of [`places`](Self::places) are: the goal itself, and what the rules choose.
    pub const RULES: [&str; 4] = ["goal", "random", "paper", "ours"];

    /// The goal, and the places of the rules, in the order of [`RULES`](Self::RULES).
    #[must_use]
    pub const fn places(&self) -> [Option<Dropped>; 4] {
        [Some(self.goal), Some(self.random), Some(self.paper), self.ours]
    }

    /// The trial as JSON.
    pub(super) fn json(&self) -> Value {
        let mut value = json!({
            "cave": self.seed,
            "situation": self.situation.name(),
            "by_c1_alone_m": self.by_one_m[0],
            "by_c2_alone_m": self.by_one_m[1],
            "most_m2": self.most_m2,
        });
        for (name, dropped) in Self::RULES.into_iter().zip(self.places()) {
            value[name] = dropped.map_or(Value::Null, Dropped::json);
        }
        value
    }
}

impl Dropped {
    fn at(cave: &Cave, criteria: &Criteria, cell: Cell) -> Option<Self> {
        let scored = criteria.at(cell)?;
        Some(Self {
            cell,
            gain_m2: cave.square_metres(scored.gain_cells),
            margin_db: (cave.network.ratio(cell) - cave.network.curve().covered).0,
            free_width_m: cave.ground.free_width(cell).0,
            off_goal_m: metres(cave, cell, criteria.goal),
            is_beside_wall: scored.is_beside_wall,
        })
    }

    /// Whether the network hears it strongly enough.
    #[must_use]
    pub fn is_linked(&self) -> bool {
        self.margin_db >= 0.0
    }

    fn json(self) -> Value {
        json!({
            "gain_m2": self.gain_m2,
            "link_margin_db": self.margin_db,
            "free_width_m": self.free_width_m,
            "off_goal_m": self.off_goal_m,
            "is_beside_wall": self.is_beside_wall,
        })
    }
}

fn metres(cave: &Cave, a: Cell, b: Cell) -> f32 {
    (square(a, b) as f32).sqrt() * cave.ground.frame().resolution().0
}
