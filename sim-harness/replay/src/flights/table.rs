//! The results as text.

use std::fmt::{self, Write};

use flight::replay::End;

use super::airborne::Ending;
use super::report::{EndReport, LogReport};
use super::spread::Spread;
use super::summary::{FlightSummary, OverAll};

/// What stands for a figure that a log does not have.
const NONE: &str = "–";

impl fmt::Display for FlightSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.logs.iter().map(|log| short(log).chars().count()).max().unwrap_or(0);
        writeln!(f, "What happened, and what the flight code would have said:\n")?;
        writeln!(
            f,
            "{:width$} {:>7}  {:22} {:>7} {:>6} {:>8} {:>5}  supervisor",
            "log", "air s", "ended", "blow ms", "held s", "floor ms", "gyro"
        )?;
        self.logs.iter().try_for_each(|log| said(f, log, width))?;
        writeln!(f, "\nForces between take-off and landing, m/s² (p50 / p95 / p99 / most):\n")?;
        writeln!(
            f,
            "{:width$} {:>27} {:>27} {:>7} {:>6} {:>20}",
            "log", "lateral", "vertical residual", "excess", "aside", "thrust scale"
        )?;
        self.logs.iter().try_for_each(|log| forces(f, log, width))?;
        writeln!(f, "\nMean torques, 10⁻⁴ N m, and the battery:\n")?;
        let heads = ["N", "roll", "pitch", "yaw", "tilt", "yaw", "nose", "V", "least", "Ω", "V/N"];
        let widths = [7, 6, 6, 6, 5, 5, 12, 6, 6, 6, 6];
        write!(f, "{:width$}", "log")?;
        for (head, width) in heads.into_iter().zip(widths) {
            write!(f, " {head:>width$}")?;
        }
        writeln!(f, "  gauge")?;
        self.logs.iter().try_for_each(|log| torques(f, log, width))?;
        missing(f, &self.logs)?;
        over_all(f, &self.all)?;
        self.plant.as_ref().map_or(Ok(()), |plant| write!(f, "\n{plant}"))
    }
}

/// The file's name with its folder.
fn short(log: &LogReport) -> String {
    let parts: Vec<&str> = log.file.rsplit(['/', '\\']).take(2).collect();
    parts.into_iter().rev().collect::<Vec<_>>().join("/")
}

fn said(f: &mut fmt::Formatter<'_>, log: &LogReport, width: usize) -> fmt::Result {
    let accel = log.accel.as_ref();
    let blow = number(accel.map(|accel| accel.impact_ms as f32), 0);
    let held = number(accel.map(|accel| accel.held_s as f32), 2);
    let floor = number(accel.map(|accel| accel.floor_ms as f32), 0);
    let gyro = match &log.gyro {
        Some(gyro) => format!("{}/{}", gyro.offsets, gyro.suspicions),
        None => NONE.to_owned(),
    };
    let supervisor = match log.ends.as_slice() {
        [] => "flies".to_owned(),
        [first, rest @ ..] => {
            let more = if rest.is_empty() { String::new() } else { format!(" (+{})", rest.len()) };
            format!("{}{more}", end(first))
        }
    };
    writeln!(
        f,
        "{:width$} {:>7.1}  {:22} {blow:>7} {held:>6} {floor:>8} {gyro:>5}  {supervisor}",
        short(log),
        log.airborne_s,
        log.ended.iter().map(|end| ending(*end)).collect::<Vec<_>>().join(", "),
    )
}

/// How a flight ended by the log.
fn ending(ending: Ending) -> String {
    match ending {
        Ending::LogEnds => "log ends".to_owned(),
        Ending::Landed => "landed".to_owned(),
        Ending::MotorsStopped(height) => format!("off at {height:.1} m"),
        Ending::Tumbled => "crashed".to_owned(),
    }
}

/// How the supervisor would have ended a flight.
fn end(report: &EndReport) -> String {
    let how = match report.end {
        End::Lands(why) => format!("lands, {why:?}"),
        End::OnFloor(why) => format!("motors off, {why:?}"),
        End::Stops(why) => format!("stops, {why:?}"),
    };
    let fell =
        if report.under_least_thrust { ", with less thrust than it ever asks for" } else { "" };
    format!("{how} at {:.1} s ({}{fell})", report.at_s, report.phase.name())
}

fn forces(f: &mut fmt::Formatter<'_>, log: &LogReport, width: usize) -> fmt::Result {
    let Some(accel) = &log.accel else {
        return writeln!(
            f,
            "{:width$} {NONE:>27} {NONE:>27} {NONE:>7} {NONE:>6} {NONE:>20}",
            short(log)
        );
    };
    let [least, last, most] = accel.thrust_scale;
    let limit = if accel.thrust_scale_at_limit { ", limit" } else { "" };
    writeln!(
        f,
        "{:width$} {:>27} {:>27} {:>7} {:>6} {:>20}",
        short(log),
        spread(accel.lateral_impact),
        spread(accel.vertical_residual),
        number(accel.vertical_excess.map(|excess| excess.max), 2),
        format!("{:.1}%", 100.0 * accel.set_aside),
        format!("{last:.3} ({least:.3}–{most:.3}{limit})"),
    )
}

fn torques(f: &mut fmt::Formatter<'_>, log: &LogReport, width: usize) -> fmt::Result {
    write!(f, "{:width$} ", short(log))?;
    match &log.torque {
        Some(torque) => {
            let [roll, pitch, yaw] = torque.mean_nm.map(|part| 1e4 * part);
            let back = number(torque.nose_back_s, 1);
            let nose = format!("{:.1}° {back} s", torque.nose_swing_deg);
            let (tilt, turn) = (100.0 * torque.tilt_part, 100.0 * torque.yaw_part);
            write!(
                f,
                "{:>7.3} {roll:>6.2} {pitch:>6.2} {yaw:>6.2} {tilt:>4.0}% {turn:>4.0}% {nose:>12}",
                torque.thrust_n
            )?;
        }
        None => {
            write!(f, "{NONE:>7} {NONE:>6} {NONE:>6} {NONE:>6} {NONE:>5} {NONE:>5} {NONE:>12}")?
        }
    }
    match &log.battery {
        Some(battery) => {
            let gauge = match (battery.lost_at_s, battery.critical_at_s, battery.may_fly) {
                (Some(at), _, _) => format!("lost at {at:.1} s"),
                (None, Some(at), _) => format!("critical at {at:.1} s"),
                (None, None, Some(false)) => "would not take off".to_owned(),
                (None, None, _) => "flies".to_owned(),
            };
            writeln!(
                f,
                " {:>6} {:>6.2} {:>6} {:>6}  {gauge}",
                number(battery.before_v, 2),
                battery.least_v,
                number(battery.resistance_ohm, 3),
                number(battery.sag_v_per_n, 2),
            )
        }
        None => writeln!(f, " {NONE:>6} {NONE:>6} {NONE:>6} {NONE:>6}  {NONE}"),
    }
}

/// What logs do not hold, once for all logs that lack the same, and what was wrong with files.
fn missing(f: &mut fmt::Formatter<'_>, logs: &[LogReport]) -> fmt::Result {
    let mut kinds: Vec<(&[String], Vec<String>)> = Vec::new();
    for log in logs.iter().filter(|log| !log.missing.is_empty()) {
        match kinds.iter_mut().find(|(missing, _)| *missing == log.missing) {
            Some((_, of)) => of.push(short(log)),
            None => kinds.push((&log.missing, vec![short(log)])),
        }
    }
    for (missing, of) in kinds {
        writeln!(f, "\n{}:\n  {}", of.join(", "), missing.join("\n  "))?;
    }
    Ok(())
}

fn over_all(f: &mut fmt::Formatter<'_>, all: &OverAll) -> fmt::Result {
    let OverAll { logs, airborne_s, ended_in_flight, .. } = all;
    writeln!(
        f,
        "\nAll {logs} logs, {airborne_s:.1} s in the air; the supervisor would have ended \
         {ended_in_flight} in flight:\n"
    )?;
    writeln!(f, "{:36} {:>8} {:>8} {:>8}", "", "least", "median", "most")?;
    let rows = [
        ("thrust scale", all.thrust_scale, 1.0),
        ("lateral noise, p50, m/s²", all.lateral_noise_p50, 1.0),
        ("lateral noise, p99, m/s²", all.lateral_noise_p99, 1.0),
        ("vertical residual, p50, m/s²", all.vertical_residual_p50, 1.0),
        ("vertical residual, p99, m/s²", all.vertical_residual_p99, 1.0),
        ("roll torque, 10⁻⁴ N m", all.roll_nm, 1e4),
        ("pitch torque, 10⁻⁴ N m", all.pitch_nm, 1e4),
        ("yaw torque, 10⁻⁴ N m", all.yaw_nm, 1e4),
        ("internal resistance, Ω", all.resistance_ohm, 1.0),
        ("sag, V/N", all.sag_v_per_n, 1.0),
    ];
    for (name, of, unit) in rows {
        let Some(Spread { min, p50, max, .. }) = of else { continue };
        let [min, p50, max] = [min, p50, max].map(|value| unit * value);
        writeln!(f, "{name:36} {min:>8.3} {p50:>8.3} {max:>8.3}")?;
    }
    Ok(())
}

fn spread(of: Option<Spread>) -> String {
    of.map_or_else(
        || NONE.to_owned(),
        |of| format!("{:.2} / {:.2} / {:.2} / {:.2}", of.p50, of.p95, of.p99, of.max),
    )
}

fn number(value: Option<f32>, digits: usize) -> String {
    let mut text = String::new();
    match value {
        Some(value) if write!(text, "{value:.digits$}").is_ok() => text,
        _ => NONE.to_owned(),
    }
}
