//! The benchmarks that fly the firmware's ELF.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};

use super::rounded;
use crate::cli::Trouble;
use crate::cli::bench::BenchArgs;
use crate::cli::progress::Progress;
use crate::measure::bench::{emulator, firmware, mishaps, stock};

/// Whether this build has them.
pub(in crate::cli) const PRESENT: bool = true;

pub(in crate::cli) fn firmware(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    let progress = Progress::busy("firmware", args.common.quiet);
    let measured = firmware::run(&args.elf, args.common.seed)?;
    drop(progress);
    missed.extend(measured.figures.missed());
    let firmware::Measured { flash_bytes, ram_bytes, figures, bound } = &measured;
    let mut table = format!(
        "firmware: {}, {flash_bytes} bytes of flash, {ram_bytes} of RAM without the stack\n\n  \
         {:34} {:>9} {:>9} {:>7}\n",
        firmware::SCENARIO,
        "",
        "measured",
        "bound",
        "aim"
    );
    type Figure = fn(&firmware::Figures) -> f64;
    let rows: [(&str, Figure, Option<f64>); 7] = [
        ("control step, half are shorter, us", |f| f.control_loop_us_p50, None),
        ("control step, longest, us", |f| f.control_loop_us_max, Some(firmware::CONTROL_AIM_US)),
        ("agent step, longest, us", |f| f.agent_step_own_us_max, Some(firmware::AGENT_AIM_US)),
        ("the same with what breaks in, us", |f| f.agent_step_us_max, None),
        ("processor busy, %", |f| 100.0 * f.cpu_load, Some(100.0 * firmware::LOAD_AIM)),
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
    let mut value = figures_json(figures);
    if let Some(value) = value.as_object_mut() {
        value.insert("flash_bytes".into(), json!(flash_bytes));
        value.insert("ram_bytes".into(), json!(ram_bytes));
        value.insert("bound".into(), figures_json(bound));
        value.insert("met".into(), json!(measured.figures.missed().is_empty()));
    }
    Ok((table, value))
}

fn figures_json(figures: &firmware::Figures) -> Value {
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

pub(in crate::cli) fn emulator(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    let progress = Progress::busy("emulator", args.common.quiet);
    let measured = emulator::run(&args.elf, args.common.seed)?;
    drop(progress);
    let compared = &measured.compared;
    let rows = [
        ("MIPS in a float loop", measured.mips, emulator::MIPS_AIM),
        ("one drone, times real time", measured.one, emulator::ONE_AIM),
        ("four drones, times real time", measured.four, emulator::FOUR_AIM),
    ];
    let mut table = format!("emulator: {}, {} threads\n\n", emulator::SCENARIO, measured.threads);
    for (name, value, aim) in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(table, "  {name:30} {value:>9.1}, aim {aim}");
        if value < aim {
            missed.push(format!("{name}: {value:.1}, the aim is {aim}"));
        }
    }
    let _ = writeln!(table, "  compared with another core: {compared}");
    if compared.mismatches > 0 || compared.states == 0 {
        missed.push(format!("{} outcomes are not those of the other core", compared.mismatches));
    }
    if !measured.deterministic {
        missed.push("the same seed ended in two states".into());
    }
    let value = json!({
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
    });
    Ok((table, value))
}

pub(in crate::cli) fn stock(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    let progress = Progress::busy("stock", args.common.quiet);
    let measured = stock::run(&args.elf, args.common.seed, args.python.as_deref())?;
    drop(progress);
    let (logged, parameters) = measured.contents;
    let mut table = format!("stock: {}\n\n", args.elf.display());
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
    missed.extend(measured.missed());
    let value = json!({
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
    });
    Ok((table, value))
}

pub(in crate::cli) fn mishaps(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    let wanted = |name: &str| name.contains(&args.only);
    let progress = Progress::new(mishaps::count(wanted) as u64, args.common.quiet);
    progress.say("flights");
    let rows = mishaps::run(&args.elf, args.common.seed, wanted, || progress.step())?;
    drop(progress);
    let mut table = format!("mishaps: {}, the head suffers\n\n", mishaps::SCENARIO);
    // Writing to a string cannot fail.
    let _ = writeln!(table, "  {:65} {:>8} {:>7} {:18} agent", "", "off, ms", "m/s", "reset");
    for row in &rows {
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
        if row.ending == mishaps::Ending::Uncontrolled {
            missed.push(format!("{}: uncontrolled", row.name));
        }
    }
    let value = rows.iter().map(|row| {
        json!({
            "mishap": row.name,
            "ending": row.ending.name(),
            "motors_off_ms": row.motors_off_ms,
            "impact_mps": (f64::from(row.impact_mps) * 100.0).round() / 100.0,
            "resets": row.resets,
            "reset_cause": row.cause.map(|cause| cause.to_string()),
            "state": row.state,
        })
    });
    Ok((table, value.collect()))
}
