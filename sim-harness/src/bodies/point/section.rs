//! The section `[vehicle]` of a scenario file.

use input::InputError;
use input::reader::{At, Pair, Reader};
use serde::Deserialize;

use super::VehicleSpec;

/// The table `[vehicle]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VehicleTable {
    charge: Option<At<f32>>,
    lag_s: Option<At<f32>>,
    flow_noise_mps: Option<At<f32>>,
    flow_scale_error: Option<At<f32>>,
    radius_m: Option<At<f32>>,
    reach_m: Option<At<f32>>,
    range_noise_m: Option<At<f32>>,
    sees_drones: Option<bool>,
    position_noise_m: Option<At<f32>>,
    vibration_g: Option<At<f32>>,
    thrust: Option<At<f32>>,
    motor_error: Option<At<f32>>,
    yaw_torque_nm: Option<At<Pair>>,
    battery_ohm: Option<At<f32>>,
}

impl VehicleTable {
    /// Checks the section.
    pub(crate) fn read(&self, reader: &Reader<'_>) -> Result<VehicleSpec, InputError> {
        let usual = VehicleSpec::DEFAULT;
        let number = |value: &Option<At<f32>>, key, range, default| {
            reader.or(value.as_ref(), key, range, default)
        };
        Ok(VehicleSpec {
            charge: number(&self.charge, "charge", 0.0..=1.0, usual.charge)?,
            lag: number(&self.lag_s, "lag_s", 0.0..=5.0, usual.lag)?,
            flow_noise: number(
                &self.flow_noise_mps,
                "flow_noise_mps",
                0.0..=5.0,
                usual.flow_noise,
            )?,
            flow_scale_error: number(
                &self.flow_scale_error,
                "flow_scale_error",
                0.0..=0.5,
                usual.flow_scale_error,
            )?,
            radius: number(&self.radius_m, "radius_m", 0.02..=0.2, usual.radius)?,
            reach: number(&self.reach_m, "reach_m", 0.2..=10.0, usual.reach)?,
            range_noise: number(
                &self.range_noise_m,
                "range_noise_m",
                0.0..=1.0,
                usual.range_noise,
            )?,
            sees_drones: self.sees_drones.unwrap_or(usual.sees_drones),
            position_noise: self
                .position_noise_m
                .as_ref()
                .map(|noise| reader.number(noise, "position_noise_m", 0.0..=1.0))
                .transpose()?,
            vibration: number(&self.vibration_g, "vibration_g", 0.0..=2.0, usual.vibration)?,
            thrust: number(&self.thrust, "thrust", 0.5..=1.5, usual.thrust)?,
            motor_error: number(&self.motor_error, "motor_error", 0.0..=0.3, usual.motor_error)?,
            yaw_torque: match &self.yaw_torque_nm {
                Some(range) => yaw_torque(reader, range)?,
                None => usual.yaw_torque,
            },
            battery_ohm: number(&self.battery_ohm, "battery_ohm", 0.05..=1.0, usual.battery_ohm)?,
        })
    }
}

/// The least and the largest yaw torque, N m. A Crazyflie's motors hold about twice the limit.
fn yaw_torque(reader: &Reader<'_>, range: &At<Pair>) -> Result<[f32; 2], InputError> {
    const LIMIT: f32 = 0.001;
    let Pair([least, most]) = *range.as_ref();
    if least >= -LIMIT && least <= most && most <= LIMIT {
        return Ok([least, most]);
    }
    let remedy = format!("give two numbers from -{LIMIT} to {LIMIT}, the smaller first");
    Err(reader.wrong(range, format!("yaw_torque_nm = [{least}, {most}] is out of range"), remedy))
}
