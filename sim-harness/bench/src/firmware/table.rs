//! Measures the firmware, and makes the table and the JSON of it.

use std::fmt::Write;
use std::path::Path;

use input::InputError;
use serde_json::{Value, json};

use super::measure::{self, AGENT_AIM_US, CONTROL_AIM_US, Figures, LOAD_AIM, Measured};
use crate::{Outcome, Session, rounded};

pub(super) fn outcome(
    session: &Session<'_>,
    (elf, radio): (&Path, Option<&Path>),
) -> Result<Outcome, InputError> {
    let progress = session.busy();
    let measured = measure::run((elf, radio), session.seed)?;
    drop(progress);
    let missed = measured.figures.missed();
    let json = json(&measured, missed.is_empty());
    Ok(Outcome { table: table(&measured), json, missed, seeds: session.seed.to_string() })
}

fn table(measured: &Measured) -> String {
    let Measured { flash_bytes, ram_bytes, figures, bound } = measured;
    let mut table = format!(
        "firmware: {}, {flash_bytes} bytes of flash, {ram_bytes} of RAM without the stack\n\n  \
         {:34} {:>9} {:>9} {:>7}\n",
        measure::SCENARIO,
        "",
        "measured",
        "bound",
        "aim"
    );
    type Figure = fn(&Figures) -> f64;
    let rows: [(&str, Figure, Option<f64>); 7] = [
        ("control step, half are shorter, us", |f| f.control_loop_us_p50, None),
        ("control step, longest, us", |f| f.control_loop_us_max, Some(CONTROL_AIM_US)),
        ("agent step, longest, us", |f| f.agent_step_own_us_max, Some(AGENT_AIM_US)),
        ("the same with what breaks in, us", |f| f.agent_step_us_max, None),
        ("processor busy, %", |f| 100.0 * f.cpu_load, Some(100.0 * LOAD_AIM)),
        ("stack, bytes", |f| f64::from(f.stack_high_water_bytes), None),
        ("switched on to first step, ms", |f| f.boot_ms, None),
    ];
    for (name, of, aim) in rows {
        let aim = aim.map_or(String::new(), |aim| format!("{aim:.0}"));
        // Writing to a string cannot fail.
        let _ = writeln!(table, "  {name:34} {:>9.1} {:>9.1} {aim:>7}", of(figures), of(bound));
    }
    for (node, account) in &figures.accounts {
        let _ = write!(table, "\ndrone {}: {account}", node.0);
    }
    table
}

fn json(measured: &Measured, is_met: bool) -> Value {
    let mut value = figures_json(&measured.figures);
    if let Some(value) = value.as_object_mut() {
        value.insert("flash_bytes".into(), json!(measured.flash_bytes));
        value.insert("ram_bytes".into(), json!(measured.ram_bytes));
        value.insert("bound".into(), figures_json(&measured.bound));
        value.insert("met".into(), json!(is_met));
    }
    value
}

fn figures_json(figures: &Figures) -> Value {
    json!({
        "stack_high_water_bytes": figures.stack_high_water_bytes,
        "control_loop_us_p50": rounded(figures.control_loop_us_p50, 1),
        "control_loop_us_max": rounded(figures.control_loop_us_max, 1),
        "agent_step_us_max": rounded(figures.agent_step_own_us_max, 1),
        "agent_step_interrupted_us_max": rounded(figures.agent_step_us_max, 1),
        "cpu_load": rounded(figures.cpu_load, 4),
        "boot_ms": rounded(figures.boot_ms, 1),
    })
}
