//! The pictures of figure 3.

use measure::figures::{CORRIDORS, Cell, Explored, Figures, Place, RESTING_US, label};

use crate::pictures::{
    BoxChart, Corridor, Figure3, Picture, PictureError, RunGroup, RunValues, SurvivalChart,
    Variant, figure3,
};

/// The runs that the curves of convergence count.
const SETTLES: &str = "not settled to 3 dB yet";

/// The whole figure on one page.
///
/// # Errors
/// [`PictureError`] where a picture cannot be drawn.
pub fn picture(figures: &Figures, runs: usize) -> Result<Picture, PictureError> {
    let at_rest = figures.exploring.iter().map(|(policy, _)| *policy).find(|name| *name == "k");
    let first = figures.exploring.first().map(|(policy, _)| *policy);
    let rests = label(at_rest.or(first).unwrap_or_default());
    let subtitle = format!(
        "A to C: relays anywhere, head at rest, one run of {rests} above, {runs} of each policy \
         below. D: one exploration of the Z. E, F: {runs} explorations of each policy."
    );
    let corridors = CORRIDORS.iter().zip(&figures.resting);
    figure3(&Figure3 {
        title: "U-Chain, figure 3 again",
        subtitle: &subtitle,
        corridors: corridors.map(|(Place { name, .. }, trace)| Corridor { name, trace }).collect(),
        resting: resting_chart(figures),
        exploration: figures
            .exploring
            .iter()
            .map(|(policy, trace)| Variant { name: label(policy), trace })
            .collect(),
        convergence: convergence_chart(figures),
        variance: variance_chart(figures),
    })
}

/// Draws the convergence of panels A to C over all runs.
#[must_use]
pub fn resting_chart(figures: &Figures) -> SurvivalChart {
    SurvivalChart {
        title: "Relays anywhere, head at rest".into(),
        pending: SETTLES.into(),
        time_name: "Time since the start, s".into(),
        until: RESTING_US as f64 * 1e-6,
        groups: groups(figures, |cell| {
            cell.convergence.iter().map(|run| run.held(|hold| hold.t3_s)).collect()
        }),
    }
}

/// Draws panel E, the convergence after the head's stop.
#[must_use]
pub fn convergence_chart(figures: &Figures) -> SurvivalChart {
    SurvivalChart {
        title: "After the head's stop".into(),
        pending: SETTLES.into(),
        time_name: "Time since the head's stop, s".into(),
        until: figures.rest_us as f64 * 1e-6,
        groups: explorations(figures, |explored| explored.settled_s),
    }
}

/// Draws panel F, the variances of the positions.
#[must_use]
pub fn variance_chart(figures: &Figures) -> BoxChart {
    BoxChart {
        title: "How much the relays still move".into(),
        value_name: "Variance of the relays' places, m\u{b2}, logarithmic".into(),
        infinite_name: "never".into(),
        is_logarithmic: true,
        groups: explorations(figures, |explored| explored.variance_m2),
    }
}

fn explorations(figures: &Figures, of: fn(&Explored) -> f32) -> Vec<RunGroup> {
    groups(figures, |cell| cell.exploration.iter().map(of).collect())
}

fn groups(figures: &Figures, of: impl Fn(&Cell) -> Vec<f32>) -> Vec<RunGroup> {
    let series = |scenario: &str| {
        let cells = figures.cells.iter().filter(|cell| cell.scenario == scenario);
        cells.map(|cell| RunValues { name: label(cell.policy).into(), values: of(cell) }).collect()
    };
    CORRIDORS
        .iter()
        .map(|Place { scenario, name, .. }| RunGroup {
            label: (*name).into(),
            series: series(scenario),
            told: None,
        })
        .collect()
}
