//! Flies the mishaps, and makes the table and the JSON of them.

use std::fmt::Write;
use std::path::Path;

use input::InputError;
use serde_json::{Value, json};

use super::measure::{self, Ending, Row};
use crate::{Outcome, Session, rounded};

/// Flies the mishaps that have `only` in their names.
pub(super) fn outcome(
    session: &Session<'_>,
    (elf, only): (&Path, &str),
) -> Result<Outcome, InputError> {
    let wanted = |name: &str| name.contains(only);
    let total = measure::count(wanted);
    if total == 0 {
        let wrong = format!("no mishap has \"{only}\" in its name");
        return Err(InputError::new(wrong, "leave --only out to see all their names"));
    }
    let progress = session.progress(total, "flights");
    let rows = measure::run(elf, session.seed, wanted, || progress.step())?;
    drop(progress);
    let fell = rows.iter().filter(|row| row.ending == Ending::Uncontrolled);
    let missed = fell.map(|row| format!("{}: uncontrolled", row.name)).collect();
    let json = rows.iter().map(json).collect();
    Ok(Outcome { table: table(&rows), json, missed, seeds: session.seed.to_string() })
}

fn table(rows: &[Row]) -> String {
    let mut table = format!("mishaps: {}, the head suffers\n\n", measure::SCENARIO);
    // Writing to a string cannot fail.
    let _ = writeln!(table, "  {:65} {:>8} {:>7} {:18} agent", "", "off, ms", "m/s", "reset");
    for row in rows {
        let off = row.motors_off_ms.map_or_else(|| "-".to_owned(), |ms| ms.to_string());
        let cause = row.cause.map_or_else(String::new, |cause| cause.to_string());
        let _ = writeln!(
            table,
            "  {:50} {:14} {off:>8} {:>7.2} {cause:18} {}",
            row.name,
            row.ending.name(),
            row.impact_mps,
            row.state
        );
    }
    table
}

fn json(row: &Row) -> Value {
    json!({
        "mishap": row.name,
        "ending": row.ending.name(),
        "motors_off_ms": row.motors_off_ms,
        "impact_mps": rounded(f64::from(row.impact_mps), 2),
        "resets": row.resets,
        "reset_cause": row.cause.map(|cause| cause.to_string()),
        "state": row.state,
    })
}
