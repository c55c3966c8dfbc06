//! What the logs of all flights have in common.

use std::io;

use input::InputError;
use serde::Serialize;

use super::course::Course;
use super::plant::PlantFit;
use super::report::LogReport;
use super::spread::Spread;

/// The results of all logs.
#[derive(Debug, Default, Serialize)]
pub struct FlightSummary {
    /// The results of each log, in the order given.
    pub logs: Vec<LogReport>,
    /// The distributions over the logs.
    pub all: OverAll,
    /// The simulated craft that was fitted to the logs, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<PlantFit>,
    /// The logs that had nothing to replay.
    #[serde(skip)]
    pub refused: Vec<InputError>,
    #[serde(skip)]
    courses: Vec<Course>,
}

/// The distributions of the logs' figures; `None` where no log has them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct OverAll {
    /// The number of logs.
    pub logs: usize,
    /// The time in the air, s.
    pub airborne_s: f64,
    /// The number of logs in which the supervisor would have ended the flight between take-off and
    /// landing.
    pub ended_in_flight: usize,
    /// Learnt ratio of true to commanded thrust at the end.
    pub thrust_scale: Option<Spread>,
    /// Medians of the lateral impact, m/s².
    pub lateral_noise_p50: Option<Spread>,
    /// 99 % values of the lateral impact, m/s².
    pub lateral_noise_p99: Option<Spread>,
    /// Medians of the vertical residual, m/s².
    pub vertical_residual_p50: Option<Spread>,
    /// 99 % values of the vertical residual, m/s².
    pub vertical_residual_p99: Option<Spread>,
    /// Mean torque about x, N m.
    pub roll_nm: Option<Spread>,
    /// Mean torque about y, N m.
    pub pitch_nm: Option<Spread>,
    /// Mean torque about z, N m.
    pub yaw_nm: Option<Spread>,
    /// Internal resistance by the gauge, Ω.
    pub resistance_ohm: Option<Spread>,
    /// Fall of the voltage for each newton, V/N.
    pub sag_v_per_n: Option<Spread>,
}

impl FlightSummary {
    pub(super) fn add(&mut self, report: LogReport, course: Course) {
        self.logs.push(report);
        self.courses.push(course);
    }

    pub(super) fn finish(&mut self) {
        let logs = &self.logs;
        let spread =
            |of: &dyn Fn(&LogReport) -> Option<f32>| Spread::of(logs.iter().filter_map(of));
        let torque = |axis: usize| spread(&|log| log.torque.as_ref()?.mean_nm.get(axis).copied());
        self.all = OverAll {
            logs: logs.len(),
            airborne_s: logs.iter().map(|log| log.airborne_s).sum(),
            ended_in_flight: logs.iter().filter(|log| log.ends_in_flight().is_some()).count(),
            thrust_scale: spread(&|log| Some(log.accel.as_ref()?.thrust_scale[1])),
            lateral_noise_p50: spread(&|log| Some(log.accel.as_ref()?.lateral_impact?.p50)),
            lateral_noise_p99: spread(&|log| Some(log.accel.as_ref()?.lateral_impact?.p99)),
            vertical_residual_p50: spread(&|log| Some(log.accel.as_ref()?.vertical_residual?.p50)),
            vertical_residual_p99: spread(&|log| Some(log.accel.as_ref()?.vertical_residual?.p99)),
            roll_nm: torque(0),
            pitch_nm: torque(1),
            yaw_nm: torque(2),
            resistance_ohm: spread(&|log| log.battery.as_ref()?.resistance_ohm),
            sag_v_per_n: spread(&|log| log.battery.as_ref()?.sag_v_per_n),
        };
    }

    /// What was wrong with files that were read none the less: the file, and what.
    pub fn notes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.logs.iter().filter_map(|log| Some((log.file.as_str(), log.note.as_deref()?)))
    }

    /// Fits the simulated craft to the logs of each drone.
    pub fn fit_plant(&mut self) {
        self.plant = Some(PlantFit::of(&self.logs, &self.courses));
    }

    /// Writes the time course of every log: one row for each hundredth of a second in the air, with
    /// the largest impacts of it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_course(&self, out: &mut dyn io::Write) -> io::Result<()> {
        writeln!(
            out,
            "file,time_s,phase,height_m,thrust_n,thrust_scale,lateral_impact_mps2,\
             lateral_residual_mps2,vertical_excess_mps2,vertical_residual_mps2,accel_sound,\
             gyro,roll_nm,pitch_nm,yaw_nm,volts,rest_volts"
        )?;
        for (log, course) in self.logs.iter().zip(&self.courses) {
            course.write_rows(&log.file, out)?;
        }
        Ok(())
    }
}
