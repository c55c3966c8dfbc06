//! Measures the emulator, and makes the table and the JSON of it.

use std::fmt::Write;
use std::path::Path;

use input::InputError;
use serde_json::{Value, json};

use super::measure::{self, FOUR_AIM, MIPS_AIM, Measured, ONE_AIM};
use crate::{Outcome, Session, rounded};

/// A speed by its name, beside its aim.
type Speed = (&'static str, f64, f64);

pub(super) fn outcome(
    session: &Session<'_>,
    (elf, radio): (&Path, Option<&Path>),
) -> Result<Outcome, InputError> {
    let progress = session.busy();
    let measured = measure::run((elf, radio), session.seed)?;
    drop(progress);
    let speeds = [
        ("MIPS in a float loop", measured.mips, MIPS_AIM),
        ("one drone, times real time", measured.one, ONE_AIM),
        ("four drones, times real time", measured.four, FOUR_AIM),
    ];
    let (table, missed) = (table(&measured, &speeds), missed(&measured, &speeds));
    Ok(Outcome { table, json: json(&measured), missed, seeds: session.seed.to_string() })
}

fn table(measured: &Measured, speeds: &[Speed]) -> String {
    let mut table = format!("emulator: {}, {} threads\n\n", measure::SCENARIO, measured.threads);
    for (name, value, aim) in speeds {
        // Writing to a string cannot fail.
        let _ = writeln!(table, "  {name:30} {value:>9.1}, aim {aim}");
    }
    let _ = writeln!(table, "  compared with another core: {}", measured.compared);
    table
}

fn missed(measured: &Measured, speeds: &[Speed]) -> Vec<String> {
    let slow = speeds.iter().filter(|(_, value, aim)| value < aim);
    let mut missed: Vec<_> =
        slow.map(|(name, value, aim)| format!("{name}: {value:.1}, the aim is {aim}")).collect();
    let compared = &measured.compared;
    if compared.mismatches > 0 || compared.states == 0 {
        missed.push(format!("{} outcomes are not those of the other core", compared.mismatches));
    }
    if !measured.deterministic {
        missed.push("the same seed ended in two states".into());
    }
    missed
}

fn json(measured: &Measured) -> Value {
    let compared = &measured.compared;
    json!({
        "mips": rounded(measured.mips, 1),
        "flying_mips": rounded(measured.busy, 1),
        "one_drone_x_real_time": rounded(measured.one, 1),
        "four_drones_x_real_time": rounded(measured.four, 1),
        "threads": measured.threads,
        "deterministic": measured.deterministic,
        "differential": {
            "forms": compared.forms,
            "encodings": compared.encodings,
            "states": compared.states,
            "mismatches": compared.mismatches,
        },
    })
}
