//! The section `[vehicle]` of a scenario file.

use input::InputError;
use input::reader::{At, Pair, Reader};
use random::Stream;
use serde::Deserialize;
use units::MissionKind;

/// The vehicle's constants, the same for all drones of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleSpec {
    /// The time constant of the response to a velocity command, s.
    pub lag: f32,
    /// Standard deviation of one flow velocity (the mean over a round), m/s.
    pub flow_noise: f32,
    /// Standard deviation, over drones, of the factor by which a flow sensor is wrong.
    pub flow_scale_error: f32,
    /// Half the drone's width with its guards, m.
    pub radius: f32,
    /// The largest distance that a side ranger measures, m.
    pub reach: f32,
    /// Standard deviation of one range, m.
    pub range_noise: f32,
    /// Whether the side rangers of points see cones, as those of rigid bodies always do, and not rays: drones that
    /// draw maps do, unless the scenario says otherwise.
    pub sees_cones: bool,
    /// Whether the side rangers see other drones.
    pub sees_drones: bool,
    /// Standard deviation along each axis of a position by a positioning system, m; `None` without
    /// one.
    pub position_noise: Option<f32>,
    /// The charge of the batteries at switch-on, 0 to 1: of rigid bodies, and of points that have one.
    pub charge: f32,
    /// The vibration of the propellers of rigid bodies at hover: the root mean square of the
    /// horizontal vector that an accelerometer reads, in multiples of gravity.
    pub vibration: f32,
    /// The thrust of rigid bodies as a multiple of what the flight code believes.
    pub thrust: f32,
    /// By this part is each motor stronger or weaker than the mean motor, at random.
    pub motor_error: f32,
    /// The least and the largest yaw torque by which propellers that are not alike twist a drone to
    /// the left at hover, N m; each drone has one in between. [`Self::MEASURED_YAW_TORQUE`] has been
    /// measured.
    pub yaw_torque: [f32; 2],
    /// The least and the largest torque about x and about y at hover, N m, by propellers that are not
    /// alike and a battery that is not in the middle; each drone has one in between.
    pub tilt_torque: [[f32; 2]; 2],
    /// The standard deviation along x and along y of the slow noise that the air of the propellers
    /// adds to the accelerometer at hover, m/s².
    pub lateral_noise: f32,
    /// The internal resistance of the batteries, Ω.
    pub battery_ohm: f32,
}

impl VehicleSpec {
    /// Internal resistance of a new battery, wiring included, Ω: 4.01 V at 0.24 A and 3.67 V at 2.11 A
    /// (wiki.bitcraze.io, "Investigations: thrust").
    pub const BATTERY_OHM: f32 = 0.18;

    /// Lag and flow errors from the studies behind the book's "Chain control" chapter; 0.08 m is
    /// a Crazyflie with propeller guards; 2 m is the reach of section V-B. The vibration is a third
    /// of what four propellers may make in the vendor's propeller test
    /// (`Vibration` of the package `bodies`).
    pub const DEFAULT: Self = Self {
        lag: 0.3,
        flow_noise: 0.02,
        flow_scale_error: 0.03,
        radius: 0.08,
        reach: 2.0,
        range_noise: 0.0,
        sees_cones: false,
        sees_drones: true,
        position_noise: None,
        charge: 1.0,
        vibration: 0.1,
        thrust: 1.0,
        motor_error: 0.0,
        yaw_torque: [0.0; 2],
        tilt_torque: [[0.0; 2]; 2],
        lateral_noise: 0.0,
        battery_ohm: Self::BATTERY_OHM,
    };

    /// The yaw torques of three undamaged Crazyflies 2.1 in 15 recorded flights: two with 1.8 to
    /// 3.5e-4 N m (CrazyPAD, github.com/AerialRoboticsUUST/CrazyPAD), one with 0.2 to 0.8e-4
    /// (github.com/arplaboratory/data-driven-system-identification). All twist to the left.
    pub const MEASURED_YAW_TORQUE: [f32; 2] = [0.24e-4, 3.5e-4];
    /// The largest of 222 flights of the first two: with propellers cut by 4 mm.
    pub const LARGEST_YAW_TORQUE: f32 = 5.35e-4;

    /// One drone's torques about x, y and z at hover, N m. Where all are alike none is drawn.
    #[must_use]
    pub fn draw_torques(&self, random: &mut Stream) -> [f32; 3] {
        let mut draw = |[least, most]: [f32; 2]| {
            if most > least { least + (most - least) * random.uniform() } else { least }
        };
        let yaw = draw(self.yaw_torque);
        let [roll, pitch] = self.tilt_torque.map(draw);
        [roll, pitch, yaw]
    }
}

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
    sees_cones: Option<bool>,
    sees_drones: Option<bool>,
    position_noise_m: Option<At<f32>>,
    vibration_g: Option<At<f32>>,
    thrust: Option<At<f32>>,
    motor_error: Option<At<f32>>,
    yaw_torque_nm: Option<At<Pair>>,
    roll_torque_nm: Option<At<Pair>>,
    pitch_torque_nm: Option<At<Pair>>,
    lateral_noise_mps2: Option<At<f32>>,
    battery_ohm: Option<At<f32>>,
}

impl VehicleTable {
    /// Checks the section.
    pub(crate) fn read(
        &self,
        mission: MissionKind,
        reader: &Reader<'_>,
    ) -> Result<VehicleSpec, InputError> {
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
            sees_cones: self.sees_cones.unwrap_or(mission == MissionKind::Explore),
            sees_drones: self.sees_drones.unwrap_or(usual.sees_drones),
            position_noise: self
                .position_noise_m
                .as_ref()
                .map(|noise| reader.number(noise, "position_noise_m", 0.0..=1.0))
                .transpose()?,
            vibration: number(&self.vibration_g, "vibration_g", 0.0..=2.0, usual.vibration)?,
            thrust: number(&self.thrust, "thrust", 0.5..=1.5, usual.thrust)?,
            motor_error: number(&self.motor_error, "motor_error", 0.0..=0.3, usual.motor_error)?,
            yaw_torque: torque(reader, &self.yaw_torque_nm, "yaw_torque_nm", YAW_LIMIT)?,
            tilt_torque: [
                torque(reader, &self.roll_torque_nm, "roll_torque_nm", TILT_LIMIT)?,
                torque(reader, &self.pitch_torque_nm, "pitch_torque_nm", TILT_LIMIT)?,
            ],
            lateral_noise: number(
                &self.lateral_noise_mps2,
                "lateral_noise_mps2",
                0.0..=2.0,
                usual.lateral_noise,
            )?,
            battery_ohm: number(&self.battery_ohm, "battery_ohm", 0.05..=1.0, usual.battery_ohm)?,
        })
    }
}

/// The largest yaw torque, N m. A Crazyflie's motors hold about twice as much.
const YAW_LIMIT: f32 = 0.001;
/// The largest torque about x and y, N m: what the integrals of the flight code's rate loops give.
const TILT_LIMIT: f32 = 0.002;

/// The least and the largest torque of a key, N m; none without the key.
fn torque(
    reader: &Reader<'_>,
    range: &Option<At<Pair>>,
    key: &str,
    limit: f32,
) -> Result<[f32; 2], InputError> {
    let Some(range) = range else { return Ok([0.0; 2]) };
    let Pair([least, most]) = *range.as_ref();
    if least >= -limit && least <= most && most <= limit {
        return Ok([least, most]);
    }
    let remedy = format!("give two numbers from -{limit} to {limit}, the smaller first");
    Err(reader.wrong(range, format!("{key} = [{least}, {most}] is out of range"), remedy))
}
