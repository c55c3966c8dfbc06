//! Flies the vendor's firmware, and makes the table and the JSON of how far it got.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use input::InputError;
use serde_json::{Value, json};

use super::measure::{self, Measured};
use crate::{Outcome, Session, rounded};

/// Flies this ELF, with `python` a second time by cflib.
pub(super) fn outcome(
    session: &Session<'_>,
    (elf, radio, python): (&Path, Option<&Path>, Option<&Path>),
) -> Result<Outcome, InputError> {
    let progress = session.busy();
    let measured = measure::run((elf, radio), session.seed, python)?;
    drop(progress);
    let (table, json) = (table(elf, &measured), json(&measured));
    Ok(Outcome { table, json, missed: measured.missed(), seeds: session.seed.to_string() })
}

fn table(elf: &Path, measured: &Measured) -> String {
    let (logged, parameters) = measured.contents;
    let mut table = format!("stock: {}\n\n", elf.display());
    for (name, value) in [
        ("booted", measured.boot.to_string()),
        ("passed its self-test", measured.self_test.to_string()),
        ("flown by cflib", measured.cflib.map_or("not asked".into(), |flown| flown.to_string())),
        ("variables and parameters read", format!("{logged} and {parameters}")),
        ("hovered, s", format!("{:.1}", measured.hover_s)),
        ("from the point of hover, m rms", format!("{:.3}", measured.hover_rms_m)),
        ("height, estimate - truth, m rms", format!("{:.3}", measured.height_rms_m)),
        ("refused", measured.refused.len().to_string()),
    ] {
        // Writing to a string cannot fail.
        let _ = writeln!(table, "  {name:34} {value}");
    }
    for (name, rate) in &measured.streams {
        let _ = writeln!(table, "  {name:34} read {rate:.0} times a second");
    }
    table
}

fn json(measured: &Measured) -> Value {
    let (logged, parameters) = measured.contents;
    json!({
        "boot": measured.boot,
        "self_test": measured.self_test,
        "streams": measured.streams.iter().copied().collect::<BTreeMap<_, _>>(),
        "cflib": measured.cflib,
        "log_variables": logged,
        "parameters": parameters,
        "hover_s": rounded(measured.hover_s, 1),
        "height_rms_m": rounded(measured.height_rms_m, 3),
        "hover_rms_m": rounded(measured.hover_rms_m, 3),
        "refused": measured.refused,
    })
}
