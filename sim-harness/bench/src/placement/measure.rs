//! Measures how much relays cover that are put down by each rule of `relay_placement`.
//!
//! The worlds are caves dug from seeds, and the maps that are given. The bounds are asked of
//! [`Rule::Ours`] alone; the other rules stand beside it.

use cave_worlds::{Chooses, Dropped, DroppedTogether, Knows, Row, World, measure};
use relay_placement::Rule;
use serde_json::{Value, json};

/// The numbers of relays that are put down in each world.
pub const NODES: [usize; 2] = [1, 8];
/// The least share of the best that our rule covers on average.
pub const LEAST_MEAN: f32 = 0.9;
/// The least share of the best that our rule covers in the worst world.
pub const LEAST_WORST: f32 = 0.75;
/// The most processor time that the selections of our rule take in one world, ms.
pub const MOST_MS: f32 = 20.0;
/// The most processor time with distances through the cave, ms: of all selections of our rule in one
/// world together, and of each of the paper's.
pub const MOST_GEODESIC_MS: f32 = 100.0;

/// The rows of one world, for each number of relays. `None` where no robot can begin at its base.
#[must_use]
pub fn run(world: &World, seed: u64) -> Option<Vec<Row>> {
    let rows = NODES.iter().map(|&nodes| measure(world, nodes, seed).ok());
    Some(rows.collect::<Option<Vec<_>>>()?.concat())
}

/// The rows of one rule and number of relays over all worlds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum {
    /// The rule.
    pub rule: Rule,
    /// The relays that were asked for in each world.
    pub asked: usize,
    /// The worlds.
    pub worlds: usize,
    /// The share of the best on average.
    pub mean: f32,
    /// The share of the best in the worst world.
    pub worst: f32,
    /// The share of the bound that no set of relays exceeds, on average.
    pub of_bound: f32,
    /// The area by the way through the cave on average, m².
    pub by_way_m2: f32,
    /// The worlds in which each relay has a link; one in which no relay was put down counts.
    pub linked: usize,
    /// The worlds in which each relay leaves a free width of 1 m.
    pub wide: usize,
    /// The longest processor time that all selections of a world took, ms.
    pub slowest_ms: f32,
}

/// Sums up the rows, for each rule and each number of relays.
#[must_use]
pub fn sums(rows: &[Row]) -> Vec<Sum> {
    let cases = NODES.iter().flat_map(|&asked| Rule::ALL.map(|rule| (asked, rule)));
    let of = |(asked, rule)| {
        let own: Vec<_> =
            rows.iter().filter(|row| row.asked == asked && row.rule == rule).collect();
        let shares: Vec<f32> = own.iter().filter_map(|row| row.of_best).collect();
        let bounds: Vec<f32> = own.iter().filter_map(|row| row.of_bound).collect();
        let by_way: Vec<f32> = own.iter().map(|row| row.by_way_m2).collect();
        let has = |value: Option<f32>, least: f32| value.is_none_or(|value| value >= least);
        Sum {
            rule,
            asked,
            worlds: own.len(),
            mean: mean(&shares),
            worst: shares.iter().copied().fold(f32::INFINITY, f32::min),
            of_bound: mean(&bounds),
            by_way_m2: mean(&by_way),
            linked: own.iter().filter(|row| has(row.link_margin_db, 0.0)).count(),
            wide: own.iter().filter(|row| has(row.free_width_m, 1.0)).count(),
            slowest_ms: own.iter().map(|row| row.ms).fold(0.0, f32::max),
        }
    };
    cases.map(of).filter(|sum| sum.worlds > 0).collect()
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

impl Sum {
    /// The bounds that are missed, each as one line.
    #[must_use]
    pub fn missed(&self) -> Vec<String> {
        let Self { rule, asked, worlds, mean, worst, linked, slowest_ms, .. } = self;
        let mut missed = Vec::new();
        let mut must = |is_met: bool, what: String| {
            if !is_met {
                missed.push(format!("placement: {}, {asked} relays: {what}", rule.name()));
            }
        };
        if *rule == Rule::Ours {
            // Where no world has anything left to cover, there is no share.
            must(
                mean.is_nan() || *mean >= LEAST_MEAN,
                format!("mean {mean:.3} of best, must be {LEAST_MEAN}"),
            );
            must(*worst >= LEAST_WORST, format!("worst {worst:.3} of best, must be {LEAST_WORST}"));
            must(linked == worlds, format!("linked in {linked} of {worlds} worlds"));
            must(*slowest_ms <= MOST_MS, format!("{slowest_ms:.1} ms, must be {MOST_MS}"));
        }
        let selections = match rule {
            Rule::OursGeodesic => 1,
            Rule::PaperGeodesic => *asked,
            _ => 0,
        };
        if selections > 0 {
            let most = MOST_GEODESIC_MS * selections as f32;
            must(*slowest_ms <= most, format!("{slowest_ms:.1} ms, must be {most}"));
        }
        missed
    }
}

/// The row as one JSON object.
#[must_use]
pub fn json(row: &Row) -> Value {
    json!({
        "world": row.world,
        "rule": row.rule.name(),
        "asked": row.asked,
        "nodes": row.nodes,
        "covered_m2": row.covered_m2,
        "by_way_m2": row.by_way_m2,
        "of_best": row.of_best,
        "of_bound": row.of_bound,
        "link_margin_db": row.link_margin_db,
        "free_width_m": row.free_width_m,
        "ms": row.ms,
    })
}

/// The relays that are dropped with each kind of knowledge in one world. `None` where no robot can
/// begin at its base.
#[must_use]
pub fn gather(world: &World, seed: u64) -> Option<Vec<Dropped>> {
    cave_worlds::gather(world, seed).ok()
}

/// The relays that are planned together in [`gather()`].
pub const TOGETHER: usize = 4;

/// The relays that are planned together and dropped in one world. `None` where no robot can begin at its
/// base.
#[must_use]
pub fn gather_together(world: &World, seed: u64) -> Option<Vec<DroppedTogether>> {
    cave_worlds::gather_for_several(world, seed, TOGETHER).ok()
}

/// The relays that were planned together with one kind of knowledge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SumOfTogether {
    /// What was known.
    pub knows: Knows,
    /// How they were planned.
    pub chooses: Chooses,
    /// The worlds.
    pub worlds: usize,
    /// The relays that were planned in all worlds.
    pub relays: usize,
    /// Those of them that have a link.
    pub linked: usize,
    /// The mean of the areas that the relays of a world truly cover anew, m², and its standard error.
    pub gained_m2: [f32; 2],
}

/// Sums up relays that were planned together, for each kind of knowledge and of plan.
#[must_use]
pub fn sum_of_together(dropped: &[DroppedTogether]) -> Vec<SumOfTogether> {
    let of = |(knows, chooses)| {
        let is_own = |it: &&DroppedTogether| it.knows == knows && it.chooses == chooses;
        let own: Vec<_> = dropped.iter().filter(is_own).collect();
        let gained: Vec<f32> = own.iter().map(|it| it.gained_m2).collect();
        let centre = mean(&gained);
        let squares: f32 = gained.iter().map(|gain| (gain - centre).powi(2)).sum();
        let count = gained.len() as f32;
        SumOfTogether {
            knows,
            chooses,
            worlds: own.len(),
            relays: own.iter().map(|it| it.relays).sum(),
            linked: own.iter().map(|it| it.linked).sum(),
            gained_m2: [centre, (squares / (count * (count - 1.0).max(1.0))).sqrt()],
        }
    };
    cases().map(of).filter(|sum| sum.worlds > 0).collect()
}

/// Each kind of knowledge with each kind of choice.
fn cases() -> impl Iterator<Item = (Knows, Chooses)> {
    Knows::ALL.into_iter().flat_map(|knows| Chooses::ALL.map(|chooses| (knows, chooses)))
}

/// Relays that were planned together as one JSON object.
#[must_use]
pub fn together_json(dropped: &DroppedTogether) -> Value {
    json!({
        "world": dropped.world,
        "knows": dropped.knows.name(),
        "chooses": dropped.chooses.name(),
        "relays": dropped.relays,
        "linked": dropped.linked,
        "gained_m2": dropped.gained_m2,
    })
}

/// The relays that were dropped with one kind of knowledge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SumOfDrops {
    /// What the robot knew.
    pub knows: Knows,
    /// How it chose.
    pub chooses: Chooses,
    /// The worlds.
    pub worlds: usize,
    /// The worlds in which the relay has a link.
    pub linked: usize,
    /// The mean of the areas that the relays truly cover anew, m².
    pub gained_m2: f32,
    /// The median of the true margins, dB.
    pub margin_db: f32,
    /// The mean error of the map of strength, dB.
    pub error_db: f32,
    /// The mean way on which readings were gathered, m.
    pub way_m: f32,
}

/// Sums up the relays, for each kind of knowledge and of choice.
#[must_use]
pub fn sum_of_drops(dropped: &[Dropped]) -> Vec<SumOfDrops> {
    let of = |(knows, chooses)| {
        let own = || {
            let is_own = move |it: &&Dropped| it.knows == knows && it.chooses == chooses;
            dropped.iter().filter(is_own)
        };
        let of = |value: fn(&Dropped) -> Option<f32>| own().filter_map(value).collect::<Vec<_>>();
        let mut margins = of(|dropped| dropped.margin_db);
        margins.sort_by(f32::total_cmp);
        SumOfDrops {
            knows,
            chooses,
            worlds: own().count(),
            linked: margins.iter().filter(|margin| **margin >= 0.0).count(),
            gained_m2: mean(&of(|dropped| Some(dropped.gained_m2))),
            margin_db: margins.get(margins.len() / 2).copied().unwrap_or(f32::NAN),
            error_db: mean(&of(|dropped| dropped.error_db)),
            way_m: mean(&of(|dropped| Some(dropped.way_m))),
        }
    };
    cases().map(of).filter(|sum| sum.worlds > 0).collect()
}

/// The relay as one JSON object.
#[must_use]
pub fn dropped_json(dropped: &Dropped) -> Value {
    json!({
        "world": dropped.world,
        "knows": dropped.knows.name(),
        "chooses": dropped.chooses.name(),
        "link_margin_db": dropped.margin_db,
        "gained_m2": dropped.gained_m2,
        "map_error_db": dropped.error_db,
        "way_m": dropped.way_m,
    })
}
