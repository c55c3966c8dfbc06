//! The table of `bench places`.

use std::fmt::Write;

use super::flown::Flight;
use super::row::{Row, Totals};

/// Rows, sums, causes and invariants as text.
pub(super) fn text(
    rows: &[Row],
    totals: &Totals,
    each: bool,
    broken: &[String],
    checked: usize,
) -> String {
    let level = rows.first().map_or("point", |row| row.fidelity.name());
    let mut text = format!("places: level {level}\n\n");
    put_rows(&mut text, rows, each);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\n  {} missions, {} refused", totals.missions, totals.refused);
    for (name, count) in &totals.counts {
        let share = totals.share(*count);
        let _ = writeln!(text, "    {name:26} {count:>6}  {share:.3}");
    }
    let stood = totals.stood.unwrap_or(0.0);
    let below = totals.below.unwrap_or(0.0);
    let _ = writeln!(text, "    {:26} {:>6}", "touches", totals.touches);
    let _ = writeln!(text, "    {:26} {:>6}", "lost place", totals.lost_place);
    let _ = writeln!(text, "    {:26} {stood:>6.3}", "stood, part of the time");
    let _ = writeln!(text, "    {:26} {below:>6.3}", "below the limit, the same");
    if !totals.causes.is_empty() {
        let _ = writeln!(text, "\n  what went wrong first");
    }
    for (cause, count) in &totals.causes {
        let _ = writeln!(text, "    {cause:26} {count:>6}");
    }
    let _ = writeln!(
        text,
        "\n  invariants of {checked} routes of surveys: {}",
        if broken.is_empty() { "all hold".to_owned() } else { format!("{} do not", broken.len()) }
    );
    for line in broken {
        let _ = writeln!(text, "    {line}");
    }
    text
}

fn put_rows(text: &mut String, rows: &[Row], each: bool) {
    let width = |of: fn(&Row) -> usize| rows.iter().map(of).max().unwrap_or(0).max(5);
    let (place, from) = (width(|row| row.place.len()), width(|row| row.from.len()));
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "  {:place$} {:from$} {:>5} {:>6} {:>4} {:>7} {:>4} {:>6} {:>5} {:>7} {:>5} {:>4} {:>5} \
         {:>5}  why",
        "place",
        "from",
        "depth",
        "relays",
        "runs",
        "arrived",
        "home",
        "linked",
        "below",
        "touches",
        "stood",
        "lost",
        "over",
        "time",
    );
    for row in rows {
        let _ = write!(text, "  {:place$} {:from$} ", row.place, row.from);
        let number = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
        };
        if row.refused.is_some() {
            let _ = writeln!(text, "{:>5} {:>6} {:>4} {:>60}  {}", "-", "-", 0, "", row.why());
            continue;
        }
        let _ = writeln!(
            text,
            "{:>5} {:>6} {:>4} {:>7} {:>4} {:>6} {:>5} {:>7} {:>5} {:>4} {:>5} {:>5}  {}",
            number(row.depth_m.map(f64::from), 0),
            row.relays.unwrap_or(0),
            row.flights.len(),
            row.count(Flight::has_arrived),
            row.count(|flight| flight.flown.is_home()),
            row.count(|flight| flight.is_linked),
            number(row.mean(|flight| Some(flight.flown.weak)), 2),
            row.touches(),
            number(row.mean(|flight| Some(flight.stood)), 2),
            row.count(|flight| flight.has_lost_place),
            number(row.mean(|flight| Some(flight.launched_over_need)), 1),
            number(row.mean(|flight| flight.time_over_way), 1),
            row.why(),
        );
        if each {
            put_missions(text, row);
        }
    }
}

/// One line for each mission of a row.
fn put_missions(text: &mut String, row: &Row) {
    for Flight { flown, ended, .. } in &row.flights {
        let wrong: Vec<_> =
            flown.wrong.iter().map(|(at, what)| format!("{} at {at:.0} s", what.name())).collect();
        let ended = ended.map_or_else(String::new, |(why, at)| format!("{why:?} at {at:.0} s"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "      seed {:>6}: {:.1} of {:.1} m, {} of {} relays, {ended}; {}",
            flown.seed,
            flown.depth_m,
            flown.oracle_m,
            flown.launched,
            flown.relays[0],
            if wrong.is_empty() { "nothing wrong".to_owned() } else { wrong.join(", ") },
        );
    }
}
