//! Fits the simulated craft to the flights of each drone, as keys of `[vehicle]` of a scenario.

use std::collections::HashSet;
use std::fmt::{self, Write};

use bodies::craft::battery::{Battery, CURRENT_PER_THRUST};
use serde::Serialize;

use super::course::{Course, Step};
use super::predicted::{Errors, Prediction, Shown, charge_at, errors, volts_error};
use super::report::LogReport;
use super::sag::per_newton;

/// The part of the standard deviation of the craft's lateral noise that the flight code's filters
/// leave: measured on simulated flights, where it was 0.53 to 0.56.
const PASSES: f32 = 0.55;
/// What the fit has seen, for the two kinds of predictions.
const FIRST_HALF: &str = "its first half";
const OTHERS: &str = "other flights";

/// The simulated craft of all drones.
#[derive(Clone, Debug, Serialize)]
pub struct PlantFit {
    /// The drones, in the order of their logs.
    pub drones: Vec<DroneFit>,
    /// The predictions of what a fit has not seen.
    pub held_out: Vec<Prediction>,
}

/// The simulated craft of one drone. A figure is `None` where no log has what it needs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DroneFit {
    /// The drone.
    pub drone: String,
    /// The number of its logs.
    pub logs: usize,
    /// The ratio of true to commanded thrust.
    pub thrust: Option<f32>,
    /// The least and the largest torque about x, y and z that turned it in one of its flights, N m.
    pub torque_nm: Option<[[f32; 2]; 3]>,
    /// Internal resistance of the battery, Ω.
    pub battery_ohm: Option<f32>,
    /// Standard deviation of the slow lateral noise of the accelerometer, m/s².
    pub lateral_noise_mps2: Option<f32>,
}

/// One log with its moments between take-off and landing.
struct Flown<'a> {
    log: &'a LogReport,
    steps: Vec<&'a Step>,
    shown: Shown,
}

impl Flown<'_> {
    fn weighs(&self) -> bool {
        self.log.accel.is_some()
    }

    fn ohm(&self) -> Option<f32> {
        let sag = self.log.battery.as_ref()?.sag_v_per_n?;
        Some(sag / CURRENT_PER_THRUST)
    }

    /// The standard deviation of the noise along one axis, m/s²; `None` without an accelerometer,
    /// since the estimator's acceleration is smoothed.
    fn noise(&self) -> Option<f32> {
        if !self.log.has_accelerometer || !self.weighs() {
            return None;
        }
        let squares = self.steps.iter().map(|step| step.finding.lateral_impact.powi(2));
        let mean = squares.sum::<f32>() / self.steps.len().max(1) as f32;
        Some((0.5 * mean).sqrt() / PASSES)
    }
}

impl PlantFit {
    pub(super) fn of(logs: &[LogReport], courses: &[Course]) -> Self {
        let flown: Vec<Flown<'_>> = logs
            .iter()
            .zip(courses)
            .map(|(log, course)| {
                let steps: Vec<&Step> = course.in_flight().collect();
                let shown = Shown::by(&steps, log.accel.is_some());
                Flown { log, steps, shown }
            })
            .collect();
        let mut names: Vec<&str> = logs.iter().map(|log| log.drone.as_str()).collect();
        let mut known = HashSet::new();
        names.retain(|name| known.insert(*name));
        let of = |name: &str| -> Vec<&Flown<'_>> {
            flown.iter().filter(|flown| flown.log.drone == name).collect()
        };
        let drones = names.iter().map(|name| DroneFit::of(name, &of(name))).collect();
        let mut held_out: Vec<Prediction> = flown.iter().filter_map(second_half).collect();
        held_out.extend(flown.iter().filter_map(|one| unseen(one, &of(&one.log.drone))));
        Self { drones, held_out }
    }

    /// All drones as a section of a scenario, with torques from drone to drone.
    #[must_use]
    pub fn scenario(&self) -> String {
        let all = |of: &dyn Fn(&DroneFit) -> Option<f32>| mean(self.drones.iter().filter_map(of));
        let torques: Vec<[[f32; 2]; 3]> =
            self.drones.iter().filter_map(|drone| drone.torque_nm).collect();
        let fit =
            DroneFit {
                drone: format!("{} drones", self.drones.len()),
                logs: self.drones.iter().map(|drone| drone.logs).sum(),
                thrust: all(&|drone| drone.thrust),
                torque_nm: range(torques.iter().flat_map(|torque| {
                    [torque.map(|[least, _]| least), torque.map(|[_, most]| most)]
                })),
                battery_ohm: all(&|drone| drone.battery_ohm),
                lateral_noise_mps2: all(&|drone| drone.lateral_noise_mps2),
            };
        fit.scenario()
    }
}

impl DroneFit {
    fn of(drone: &str, flown: &[&Flown<'_>]) -> Self {
        Self {
            drone: drone.to_owned(),
            logs: flown.len(),
            thrust: mean(flown.iter().filter_map(|one| one.shown.thrust)),
            torque_nm: range(flown.iter().filter_map(|one| one.shown.torque_nm)),
            battery_ohm: mean(flown.iter().filter_map(|one| one.ohm())),
            lateral_noise_mps2: mean(flown.iter().filter_map(|one| one.noise())),
        }
    }

    /// The drone's name as a part of a file's name.
    #[must_use]
    pub fn file_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
        self.drone.chars().map(plain).collect()
    }

    /// The section `[vehicle]` of a scenario, within what its keys may have.
    #[must_use]
    pub fn scenario(&self) -> String {
        let mut text = String::new();
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> fmt::Result {
        let name: String = self.drone.chars().filter(|c| !c.is_control()).collect();
        writeln!(text, "# Fitted to {} flights of {name}.\n[vehicle]", self.logs)?;
        if let Some(thrust) = self.thrust {
            writeln!(text, "thrust = {:.3}", thrust.clamp(0.5, 1.5))?;
        }
        let keys = ["roll_torque_nm", "pitch_torque_nm", "yaw_torque_nm"];
        for ((key, limit), torque) in
            keys.into_iter().zip([0.002, 0.002, 0.001]).zip(self.torque_nm.into_iter().flatten())
        {
            let [least, most] = torque.map(|torque| torque.clamp(-limit, limit));
            writeln!(text, "{key} = [{least:.6}, {most:.6}]")?;
        }
        if let Some(ohm) = self.battery_ohm {
            writeln!(text, "battery_ohm = {:.3}", ohm.clamp(0.05, 1.0))?;
        }
        if let Some(noise) = self.lateral_noise_mps2 {
            writeln!(text, "lateral_noise_mps2 = {:.3}", noise.clamp(0.0, 2.0))?;
        }
        Ok(())
    }
}

/// What a craft without a fit shows.
const USUAL: Shown = Shown { thrust: Some(1.0), torque_nm: Some([0.0; 3]) };

/// How well the first half of a flight predicts the second.
fn second_half(one: &Flown<'_>) -> Option<Prediction> {
    let (first, second) = one.steps.split_at(one.steps.len() / 2);
    let middle = second.first()?.time;
    let [by, truth] = [first, second].map(|half| Shown::by(half, one.weighs()));
    let volts = |ohm: f32| {
        // The charge at the beginning of the first half: the one that is right in its mean.
        let load = mean(first.iter().filter_map(|step| step.thrust))?;
        let seen = mean(first.iter().filter_map(|step| step.volts))?;
        let charge = charge_at(seen + ohm * CURRENT_PER_THRUST * load, ohm);
        let half = first.len() / 2;
        volts_error(Battery::aged(charge, ohm), one.steps.get(half..)?, |step| step.time >= middle)
    };
    let ohm = per_newton(first.iter().copied()).map(|sag| sag / CURRENT_PER_THRUST);
    let fitted = errors(&by, &truth, ohm.and_then(volts));
    let usual = errors(&USUAL, &truth, volts(Battery::USUAL_OHM));
    Some(Prediction { file: one.log.file.clone(), seen: FIRST_HALF, fitted, usual })
}

/// How well the other flights of the drone predict this one.
fn unseen(one: &Flown<'_>, all: &[&Flown<'_>]) -> Option<Prediction> {
    let others: Vec<&Flown<'_>> =
        all.iter().copied().filter(|other| other.log.file != one.log.file).collect();
    if others.is_empty() {
        return None;
    }
    let torques: Vec<[f32; 3]> = others.iter().filter_map(|other| other.shown.torque_nm).collect();
    let axis = |axis: usize| mean(torques.iter().filter_map(|torque| torque.get(axis).copied()));
    let by = Shown {
        thrust: mean(others.iter().filter_map(|other| other.shown.thrust)),
        torque_nm: axis(0).zip(axis(1)).zip(axis(2)).map(|((x, y), z)| [x, y, z]),
    };
    let volts = |ohm: f32| {
        let before = one.log.battery.as_ref()?.before_v?;
        let battery = Battery::aged(charge_at(before, ohm), ohm);
        volts_error(battery, &one.steps, |_| true)
    };
    let ohm = mean(others.iter().filter_map(|other| other.ohm()));
    let fitted = errors(&by, &one.shown, ohm.and_then(volts));
    let usual = errors(&USUAL, &one.shown, volts(Battery::USUAL_OHM));
    Some(Prediction { file: one.log.file.clone(), seen: OTHERS, fitted, usual })
}

fn mean(values: impl Iterator<Item = f32>) -> Option<f32> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f32)
}

/// The least and the largest value of each axis.
fn range(torques: impl Iterator<Item = [f32; 3]>) -> Option<[[f32; 2]; 3]> {
    torques.fold(None, |range, torque| {
        let mut range = range.unwrap_or_else(|| torque.map(|part| [part; 2]));
        for ([least, most], part) in range.iter_mut().zip(torque) {
            (*least, *most) = (least.min(part), most.max(part));
        }
        Some(range)
    })
}

impl fmt::Display for PlantFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "The simulated craft:\n")?;
        for drone in &self.drones {
            writeln!(f, "{}", drone.scenario())?;
        }
        writeln!(
            f,
            "What fits predict that have not seen it, and what the defaults do (mean errors):\n"
        )?;
        writeln!(
            f,
            "{:16} {:>5} {:>17} {:>22} {:>17}",
            "seen", "logs", "thrust", "torque, 10⁻⁴ N m", "V"
        )?;
        for seen in [FIRST_HALF, OTHERS] {
            let of: Vec<&Prediction> =
                self.held_out.iter().filter(|one| one.seen == seen).collect();
            let pair = |of_errors: &dyn Fn(&Errors) -> Option<f32>, unit: f32| {
                let by = |part: &dyn Fn(&Prediction) -> Errors| {
                    mean(of.iter().filter_map(|one| of_errors(&part(one))))
                };
                match by(&|one| one.fitted).zip(by(&|one| one.usual)) {
                    Some((fitted, usual)) => format!("{:.3} / {:.3}", unit * fitted, unit * usual),
                    None => "–".to_owned(),
                }
            };
            let thrust = pair(&|errors| errors.thrust, 1.0);
            let torque = pair(&|errors| errors.torque_nm, 1e4);
            let volts = pair(&|errors| errors.volts, 1.0);
            writeln!(f, "{seen:16} {:>5} {thrust:>17} {torque:>22} {volts:>17}", of.len())?;
        }
        Ok(())
    }
}
