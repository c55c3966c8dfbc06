//! The pictures of single explorations and of what was watched in all of them: the thesis' figures 3.14 to
//! 3.17, 3.20 and 3.24.

use benchmarks::explore::figures::watched::{Targets, Watched, WatchedRow, mean_curve, united};
use benchmarks::explore::figures::{DRIFTS, Figures, OURS_DRIFTS, ROBOTS, growth};
use explorers::{Glance, World};
use grid_map::CellState;
use report::Folder;
use report::pictures::{
    Curve, ExploredChart, ExploredMap, GrowthChart, Growths, explored, growths,
};
use units::Point2;

use super::super::Trouble;
use super::exploration::{RULES, named};

/// The thesis' rule.
const THESIS: &str = "thesis";
/// Figure 3.24 ends after so long, s: later hardly anything is found, and some runs last for 900 s.
const SHOWN_S: usize = 240;
/// The moments of figure 3.14, in parts of the time to the last stop.
const MOMENTS: [f64; 4] = [0.1, 0.3, 0.6, 1.0];

/// Writes the pictures.
pub(super) fn put(folder: &mut Folder, figures: &Figures) -> Result<(), Trouble> {
    let Some(world) = World::plan("room") else { return Ok(()) };
    let of = |robots| of(figures, THESIS, robots);
    if let Some(pair) = of(2) {
        report::put_picture(folder, "figure-3-14", &explored(&evolution(&world, pair))?)?;
        if let Some(chart) = targets(pair) {
            report::put_picture(folder, "figure-3-17", &explored(&chart)?)?;
        }
    }
    report::put_picture(folder, "figure-3-15", &growths(&candidates(figures))?)?;
    report::put_picture(folder, "figure-3-16", &explored(&ways(&world, figures))?)?;
    report::put_picture(folder, "figure-3-20", &growths(&flown(figures))?)?;
    report::put_picture(folder, "figure-3-24", &growths(&localised(figures))?)?;
    Ok(())
}

fn of<'a>(figures: &'a Figures, rule: &str, robots: usize) -> Option<&'a WatchedRow> {
    figures.watched.iter().find(|row| row.rule == rule && row.robots == robots)
}

/// What the given robots know at one moment, and the ways to there.
fn map(world: &World, film: &[Glance], robots: &[usize], name: String) -> Option<ExploredMap> {
    let now = film.last()?;
    let maps: Vec<Vec<CellState>> =
        robots.iter().filter_map(|n| now.maps.get(*n)).cloned().collect();
    let union = united(world, &maps).ok()?;
    let frame = *world.frame();
    let way = |n: usize| -> Vec<Point2> {
        film.iter().filter_map(|glance| glance.poses.get(n)).map(|pose| pose.at).collect()
    };
    Some(ExploredMap {
        name,
        about: format!("after {:.0} s", now.at_s),
        frame,
        cells: frame.cells().map(|cell| union.state(cell)).collect(),
        ways: robots.iter().map(|n| (*n, way(*n))).collect(),
        candidates: Vec::new(),
        targets: Vec::new(),
    })
}

/// Figure 3.14: the maps of two robots, and of both together.
fn evolution(world: &World, pair: &WatchedRow) -> ExploredChart {
    let whose = [(&[0][..], "Robot 1"), (&[1][..], "Robot 2"), (&[0, 1][..], "Both")];
    let maps = whose.into_iter().flat_map(|(robots, name)| {
        MOMENTS.into_iter().filter_map(move |part| {
            let frames = ((part * pair.film.len() as f64) as usize).clamp(1, pair.film.len());
            map(world, pair.film.get(..frames)?, robots, name.to_owned())
        })
    });
    ExploredChart {
        title: "Thesis, figure 3.14 again: two robots".into(),
        subtitle: "The first run by the thesis' rule, from its start to the last stop; north is up"
            .into(),
        columns: MOMENTS.len(),
        maps: maps.collect(),
    }
}

/// Figure 3.16: the ways of one to three robots.
fn ways(world: &World, figures: &Figures) -> ExploredChart {
    let maps = RULES.iter().flat_map(|(rule, label)| {
        ROBOTS.iter().filter_map(move |robots| {
            let row = of(figures, rule, *robots)?;
            let all: Vec<usize> = (0..*robots).collect();
            let name = format!("{label}, {}", named(*robots));
            let shown = map(world, &row.film, &all, name)?;
            let first = figures.row(rule, *robots).and_then(|row| row.runs.first());
            let known = match first.and_then(|run| run.t99_s) {
                Some(at_s) => format!("99 % known after {at_s:.0} s"),
                None => "99 % never known".to_owned(),
            };
            Some(ExploredMap { about: format!("{}; {known}", shown.about), ..shown })
        })
    });
    ExploredChart {
        title: "Thesis, figure 3.16 again: ways".into(),
        subtitle: "The first run of each, to the last stop; north is up, the room is 8 by 8 m"
            .into(),
        columns: ROBOTS.len(),
        maps: maps.collect(),
    }
}

/// Figure 3.17: the second robot's target in three cases.
fn targets(pair: &WatchedRow) -> Option<ExploredChart> {
    let runs = || pair.runs.iter().filter_map(|run| run.targets.as_ref());
    let differ = |it: &&Targets| it.removed != it.alike || it.scheduled != it.alike;
    let targets = runs().find(differ).or_else(|| runs().next())?;
    let frame = *targets.map.frame();
    let case = |name: &str, about: &str, second: Option<Point2>| ExploredMap {
        name: name.to_owned(),
        about: about.to_owned(),
        frame,
        cells: frame.cells().map(|cell| targets.map.state(cell)).collect(),
        ways: targets.robots.iter().enumerate().map(|(n, at)| (n, vec![*at])).collect(),
        candidates: targets.places.iter().map(|place| (place.position, place.gain)).collect(),
        targets: second.map_or_else(Vec::new, |second| vec![(0, targets.first), (1, second)]),
    };
    Some(ExploredChart {
        title: "Thesis, figure 3.17 again: goal assignment".into(),
        subtitle: "Two robots by the thesis' rule, when half of the room is known, in the first run in which \
                   the cases differ, if they do in any"
            .into(),
        columns: 4,
        maps: vec![
            case("(a) Candidates", "none is assigned yet", None),
            case("(b) Case 1", "nothing else is done", Some(targets.alike)),
            case("(c) Case 2", "the first target is removed", Some(targets.removed)),
            case("(d) Case 3", "gains are scheduled", Some(targets.scheduled)),
        ],
    })
}

/// Figure 3.15: candidates, and frontiers of each robot's own map.
fn candidates(figures: &Figures) -> GrowthChart {
    let own = |n: usize| {
        move |run: &Watched| -> Vec<f32> {
            run.frontiers.iter().map(|all| all.get(n).map_or(0.0, |count| *count as f32)).collect()
        }
    };
    let all = |run: &Watched| run.candidates.iter().map(|count| *count as f32).collect();
    let groups = per_number(figures, |row| {
        let mut curves = vec![Curve::of("candidates".to_owned(), mean_curve(&row.runs, &all))];
        let robots = 0..row.robots;
        curves.extend(robots.map(|n| Curve::of_robot(n, mean_curve(&row.runs, &own(n)))));
        curves
    });
    chart("Thesis, figure 3.15 again: frontier points", "Frontier cells", figures.runs, groups)
}

/// Figure 3.20: the way of each robot.
fn flown(figures: &Figures) -> GrowthChart {
    let own = |n: usize| {
        move |run: &Watched| -> Vec<f32> {
            run.flown_m.iter().map(|all| all.get(n).copied().unwrap_or(0.0)).collect()
        }
    };
    let groups = per_number(figures, |row| {
        let robots = 0..row.robots;
        robots.map(|n| Curve::of_robot(n, mean_curve(&row.runs, &own(n)))).collect()
    });
    chart("Thesis, figure 3.20 again: the way of each robot", "Way, m", figures.runs, groups)
}

/// Charts of the thesis' rule with one to three robots.
fn per_number(figures: &Figures, curves: impl Fn(&WatchedRow) -> Vec<Curve>) -> Vec<Growths> {
    let rows = ROBOTS.iter().filter_map(|robots| of(figures, THESIS, *robots));
    rows.map(|row| Growths { label: named(row.robots), curves: curves(row) }).collect()
}

fn chart(title: &str, value_name: &str, runs: usize, groups: Vec<Growths>) -> GrowthChart {
    let values = groups.iter().flat_map(|group| &group.curves).flat_map(|curve| &curve.values);
    let most = values.fold(1.0_f32, |most, value| most.max(*value));
    GrowthChart {
        title: title.to_owned(),
        subtitle: format!(
            "The thesis' rule, mean of {runs} runs each; a run that has ended keeps its last value"
        ),
        value_name: value_name.to_owned(),
        most: f64::from(most) * 1.05,
        groups,
    }
}

/// Figure 3.24: what is known, with positions that drift.
fn localised(figures: &Figures) -> GrowthChart {
    let groups = [(DRIFTS, "The thesis' rule"), (OURS_DRIFTS, "Our rule")].map(|(rule, label)| {
        let rows = ROBOTS.iter().filter_map(|robots| figures.row(rule, *robots));
        let known = |row| growth(row).into_iter().take(SHOWN_S).collect();
        let curves = rows.map(|row| Curve::of(named(row.robots), known(row))).collect();
        Growths { label: label.to_owned(), curves }
    });
    GrowthChart {
        title: "Thesis, figure 3.24 again: robots that localise themselves".into(),
        subtitle: format!(
            "Positions drift as by optic flow, in place of ORB-SLAM2; mean of {} runs each, to {SHOWN_S} s",
            figures.runs
        ),
        value_name: "Part of the room that is known".into(),
        most: 1.03,
        groups: groups.into(),
    }
}
