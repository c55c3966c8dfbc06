use ::measure::claim::Answer;

use super::*;

/// A row of made-up runs, of which each came to 99 % at a time, or never.
fn row(rule: &'static str, robots: usize, times: &[Option<f32>]) -> Row {
    let run = |t99_s: &Option<f32>| Outcome {
        t99_s: *t99_s,
        path_m: 10.0 / robots as f32,
        curve: vec![vec![0.2, 0.5], vec![0.4, 1.0]],
        ..Outcome::default()
    };
    Row { world: "room".to_owned(), rule, robots, runs: times.iter().map(run).collect() }
}

#[test]
fn a_run_that_never_ends_is_in_every_claim() {
    let one: Vec<_> = (0..30).map(|n| Some(100.0 + n as f32)).collect();
    let two: Vec<_> = (0..30).map(|n| (n > 5).then_some(20.0)).collect();
    let rows = vec![row(THESIS, 1, &one), row(THESIS, 2, &two)];
    let figures = Figures { rows, watched: Vec::new(), runs: 30 };
    let claims = figures.claims();
    let all = &claims[0];
    assert_eq!(all.found[1].answer, Answer::DoesNotHold, "24 of 30: {all}");
    let time = claims.iter().find(|claim| claim.source == "figure 3.22").unwrap();
    assert_eq!(time.answer(), Answer::Holds, "{time}");
    // Of our rule nothing was flown.
    assert!(claims.iter().any(|claim| claim.found.is_empty()));
}

#[test]
fn what_a_run_knew_at_its_end_it_knows_later() {
    let mut rows = row(OURS, 2, &[Some(1.0), Some(2.0)]);
    rows.runs[1].curve = vec![vec![0.1, 0.1], vec![0.2, 0.2], vec![0.5, 0.6]];
    let grown = growth(&rows);
    let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
    assert!(grown.len() == 3 && near(grown[0], 0.3) && near(grown[2], 0.8), "{grown:?}");
}

#[test]
fn each_claim_has_its_explorations() {
    let figures = make(1, 1, || ()).unwrap();
    assert_eq!(figures.rows.len(), explorations(1));
    assert!(figures.claims().iter().all(|claim| !claim.found.is_empty()));
}

#[test]
fn the_targets_of_figure_3_17_follow_the_three_rules() {
    let figures = make(2, 1, || ()).unwrap();
    let pair = figures.watched.iter().find(|row| (row.rule, row.robots) == (THESIS, 2)).unwrap();
    for targets in pair.runs.iter().map(|run| run.targets.as_ref().unwrap()) {
        let is_candidate = |at| targets.places.iter().any(|place| place.position == at);
        for at in [targets.first, targets.alike, targets.removed, targets.scheduled] {
            assert!(is_candidate(at), "{at:?}");
        }
        assert_ne!(targets.first, targets.removed);
        assert_ne!(targets.first, targets.scheduled);
    }
    // The film of the first run has a picture for each second, and its robots only ever know more.
    assert_eq!(pair.film.len(), pair.runs[0].candidates.len());
    let known = |glance: &explorers::Glance| {
        let is_known = |state: &&grid_map::CellState| **state != grid_map::CellState::Unknown;
        glance.maps.iter().flatten().filter(is_known).count()
    };
    assert!(known(&pair.film[0]) < known(pair.film.last().unwrap()));
}
