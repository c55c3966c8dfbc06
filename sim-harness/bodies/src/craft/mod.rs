//! One drone at flight level: everything between motor duties and sensor readings, with the
//! firmware's [`flight::Flight`] in the loop, a thousand times a second.
//!
//! | module | what it holds |
//! |---|---|
//! | [`body`] | the rigid body, its air and its floor |
//! | [`motors`], [`battery`] | motors with propellers, and their supply |
//! | [`imu`], [`flow`], [`rangers`] | the sensors |
//! | [`vibration`] | the vibration of the propellers |
//! | [`faults`] | the faults of a drone |
//! | [`record`] | the extremes and endings of its flights |
//! | `outside` | a craft that is flown by the firmware in an emulator |
//!
//! A craft has a clock of its own, which starts when it is switched on: a mission that begins in
//! the air begins some seconds later ([`Craft::hovering`]).

pub mod battery;
pub mod body;
pub mod faults;
pub mod flow;
pub mod imu;
pub mod motors;
#[cfg(feature = "virtual")]
pub(crate) mod outside;
pub mod rangers;
pub mod record;
pub mod vibration;

use flight::{Airframe, Command, Flight, FlightConfig, Mode, Outputs, Sensed};
use onboard::mounting::Sides;
use random::Stream;
use sensors::pmw3901::Motion;
use sensors::vl53l1x::Reading;
use units::{
    Acceleration, AngularVelocity, Instant, Metres, MetresPerSecond, Point2, Setpoint, Volts,
};
use world::Tunnel;

use crate::others::Others;
use scenario::{Ground, VehicleSpec};

use battery::Battery;
use body::{BodySpec, Drive, RigidBody, STEP};
use faults::{Failing, Fault, Saboteur};
use flow::Flow;
use imu::Imu;
use motors::Motors;
use rangers::Ranger;
pub(crate) use rangers::level_range;
use record::Record;
use vibration::Vibration;

/// The surroundings of a craft.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// The walls.
    pub tunnel: &'a Tunnel,
    /// Light and texture of the floor.
    pub ground: Ground,
    /// The vehicle's outer measures.
    pub vehicle: &'a VehicleSpec,
    /// The other drones, as its rangers see them.
    pub others: Others<'a>,
}

/// The flow sensor and the down ranger above the feet, m: the Flow deck hangs under the board.
const DECK_ABOVE_FEET: f32 = 0.01;
/// The side rangers above the centre of mass, m: the Multi-ranger deck sits on the board. Standing
/// on the floor they see it in the lower edge of their cones, at a quarter of a metre.
const BEAMS_ABOVE_CENTRE: f32 = 0.012;
/// The directions of the side beams in the board's axes: front, right, back, left.
const BEAMS: [[f32; 2]; 4] = [[1.0, 0.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 1.0]];
/// Milliseconds between two readings of each side beam, of the down beam and of the battery
/// (100 a second from the radio chip).
const SIDE_PERIOD_MS: u64 = 33;
const DOWN_PERIOD_MS: u64 = 25;
const BATTERY_PERIOD_MS: u64 = 10;
/// A touch of a wall within this time of the last one is the same touch, ms.
const SAME_TOUCH_MS: u16 = 200;
/// Time between two set-points: they are given five times a second.
const COMMAND_PERIOD_MS: u64 = 200;
/// Spread of the mass over drones, as a part of it: batteries differ by half a gram.
const MASS_SPREAD: f32 = 0.015;

/// One drone.
#[derive(Clone)]
pub struct Craft {
    config: FlightConfig,
    /// The true constants of the machine, which differ a little from those in the configuration.
    airframe: Airframe,
    spec: BodySpec,
    body: RigidBody,
    motors: Motors,
    battery: Battery,
    imu: Imu,
    vibration: Vibration,
    flow: Flow,
    down: Ranger,
    sides: [Ranger; 4],
    ranges: [Option<Reading>; 4],
    /// `None` where the firmware itself flies it, in an emulator (`outside`).
    flight: Option<Flight>,
    command: Command,
    outputs: Outputs,
    /// The readings since the flight code's last step.
    sensed: Sensed,
    random: Stream,
    saboteur: Option<Saboteur>,
    now_ms: u64,
    /// When the flight code runs next, if it is late.
    due_us: u64,
    /// When it was switched on, by the mission's clock, is this long before its beginning.
    head_start_ms: u64,
    /// For how long a new touch of the wall still counts as the last one, ms.
    touching_ms: u16,
    contacts: u32,
    record: Record,
}

impl Craft {
    /// Takes the flight code out of the craft: the firmware flies it from now on.
    pub fn fly_from_outside(&mut self) {
        self.flight = None;
    }

    /// A craft that was just switched on, standing here, its nose along the unit vector `nose`.
    #[must_use]
    pub fn standing(
        config: FlightConfig,
        at: Point2,
        nose: [f32; 2],
        vehicle: &VehicleSpec,
        mut random: Stream,
    ) -> Self {
        let mass = config.airframe.mass * (1.0 + MASS_SPREAD * random.gauss());
        let airframe = Airframe { mass, ..config.airframe };
        // The board's front is an eighth of a turn to the left of the nose.
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let front = [(nose[0] - nose[1]) * half, (nose[0] + nose[1]) * half];
        let imu = Imu::new(&mut random);
        let mut motors = Motors::drawn(&mut random);
        let flow = Flow::new(1.0 + vehicle.flow_scale_error * random.gauss());
        let down = Ranger::new(&mut random);
        let sides = std::array::from_fn(|_| Ranger::new(&mut random));
        let vibration = Vibration::new(&airframe, vehicle.vibration, &mut random)
            .blown_by(vehicle.lateral_noise);
        motors.err(vehicle.thrust, vehicle.motor_error, &mut random);
        let spec = BodySpec::of(&airframe).twisted_by(vehicle.draw_torques(&mut random));
        let mut flight = Flight::new();
        let outputs = flight.step(&config, Instant::ZERO, &Sensed::default(), &Command::default());
        Self {
            config,
            airframe,
            spec,
            body: RigidBody::standing([at.x, at.y], front),
            motors,
            battery: Battery::aged(vehicle.charge, vehicle.battery_ohm),
            imu,
            vibration,
            flow,
            down,
            sides,
            ranges: [None; 4],
            flight: Some(flight),
            command: Command::default(),
            outputs,
            sensed: Sensed::default(),
            random,
            saboteur: None,
            now_ms: 0,
            due_us: 0,
            head_start_ms: 0,
            touching_ms: 0,
            contacts: 0,
            record: Record::new(),
        }
    }

    /// The longest time for take-off before a mission that begins in the air.
    const LONGEST_PRELUDE_MS: u64 = 15_000;
    /// The time that the craft then hovers before the mission begins.
    const SETTLE_MS: u64 = 1_500;

    /// A craft in the air, for missions that begin there. It was switched on in its place, has
    /// calibrated itself, taken off and settled at `height` by the same code as in any flight; then
    /// the mission's clock starts. Its record begins at that moment.
    #[must_use]
    pub fn hovering(mut self, height: Metres, around: Surroundings<'_>) -> Self {
        let mut settled = 0;
        while settled < Self::SETTLE_MS && self.now_ms < Self::LONGEST_PRELUDE_MS {
            if self.now_ms.is_multiple_of(COMMAND_PERIOD_MS) {
                self.command(hover(height));
            }
            self.advance(around);
            let high = (self.body.height() - height.0).abs() < 0.05;
            let up = matches!(self.outputs.status.mode, Mode::Flying { .. }) && high;
            settled = if up { settled + 1 } else { 0 };
        }
        self.head_start_ms = self.now_ms;
        self.record = Record::begun_flying(self.outputs.status.mode);
        self.contacts = 0;
        self
    }

    /// Sets a fault; its times count from the mission's beginning.
    pub fn sabotage(&mut self, failing: Failing, random: &mut Stream) {
        let failing = Failing {
            from_ms: failing.from_ms.saturating_add(self.head_start_ms),
            until_ms: failing.until_ms.saturating_add(self.head_start_ms),
            ..failing
        };
        self.saboteur = Some(Saboteur::new(failing, random));
    }

    /// The active fault, if there is one.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.saboteur.as_ref().and_then(|saboteur| saboteur.fault(self.now_ms))
    }

    /// Whether the drone can neither hear nor be heard.
    #[must_use]
    pub fn is_silenced(&self) -> bool {
        self.fault() == Some(Fault::RadioSilence)
    }

    /// The time since the drone was switched on, by its own clock.
    #[must_use]
    pub const fn now(&self) -> Instant {
        Instant::from_millis(self.now_ms)
    }

    /// Gives it a set-point in the board's axes.
    pub fn command(&mut self, setpoint: Setpoint) {
        self.command = Command { setpoint, given: self.now() };
    }

    /// Simulates one millisecond.
    pub fn advance(&mut self, around: Surroundings<'_>) {
        self.now_ms += 1;
        let fault = self.fault();
        self.sense(around, fault);
        self.think(fault);
        self.move_on(around, fault);
    }

    /// Moves the body by a millisecond.
    fn move_on(&mut self, around: Surroundings<'_>, fault: Option<Fault>) {
        self.befall(fault);
        self.motors.advance(&self.airframe, self.outputs.duties, self.battery.volts());
        self.battery.advance(self.motors.lift());
        let wind = match (fault, &self.saboteur) {
            (Some(Fault::Gust(speed)), Some(saboteur)) => gust(speed, saboteur.which),
            _ => [0.0; 3],
        };
        let drive = Drive { thrust: self.motors.thrust(), spin: self.motors.spin(), wind };
        self.body.advance(&self.spec, &drive);
        self.collide(around);
        self.record.look(self.now_ms, &self.body, &self.outputs.status, self.battery.volts());
    }

    /// Reads the sensors that have a new reading.
    fn sense(&mut self, around: Surroundings<'_>, fault: Option<Fault>) {
        let now = self.now_ms;
        let (gyro, accel) = self.sense_inertia();
        self.sensed.gyro = gyro.or(self.sensed.gyro);
        self.sensed.accel = accel.or(self.sensed.accel);
        self.watch_ground();
        if now.is_multiple_of(Flow::PERIOD_MS) {
            self.sensed.flow = self.sense_flow(around, fault).or(self.sensed.flow);
        }
        if now % DOWN_PERIOD_MS == 3 {
            self.sensed.down = self.sense_down().or(self.sensed.down);
        }
        if now % BATTERY_PERIOD_MS == 5 {
            self.sensed.battery = self.sense_battery().or(self.sensed.battery);
        }
        // The side rangers are read one after the other, an eighth of their period apart.
        let phase = now % SIDE_PERIOD_MS;
        if phase.is_multiple_of(8) && phase < 32 {
            self.sense_side(around, (phase / 8) as usize);
        }
    }

    fn sense_inertia(&mut self) -> (Option<AngularVelocity>, Option<Acceleration>) {
        let hovering = 4.0 * self.config.airframe.hover_thrust();
        let shaking = self.motors.lift() / hovering;
        let (rates, force) = (self.body.rates(), self.body.specific_force());
        let shake = self.vibration.shake(self.motors.thrust(), &mut self.random);
        let (gyro, accel) = self.imu.sample(rates, force, shaking, shake, &mut self.random);
        let (gyro, accel) = (AngularVelocity(gyro), Acceleration(accel));
        match &mut self.saboteur {
            None => (Some(gyro), Some(accel)),
            Some(saboteur) => {
                (saboteur.gyro(self.now_ms, gyro), saboteur.accel(self.now_ms, accel))
            }
        }
    }

    /// Shows the flow sensor another millisecond of the ground.
    fn watch_ground(&mut self) {
        let (body, height) = (&self.body, self.height_of_deck());
        self.flow.watch(body.velocity_body(), body.rates(), body.uprightness(), height, STEP);
    }

    fn sense_flow(&mut self, around: Surroundings<'_>, fault: Option<Fault>) -> Option<Motion> {
        let ground = if fault == Some(Fault::DarkGround) { Ground::DARK } else { around.ground };
        let height = self.height_of_deck();
        let reading = self.flow.read(ground, height, &mut self.random);
        match &mut self.saboteur {
            None => Some(reading),
            Some(saboteur) => saboteur.flow(self.now_ms, reading),
        }
    }

    fn sense_down(&mut self) -> Option<Reading> {
        let (height, upright) = (self.height_of_deck(), self.body.uprightness());
        let reading = self.down.look_down(height, upright, &mut self.random);
        match &mut self.saboteur {
            None => Some(reading),
            Some(saboteur) => saboteur.down(self.now_ms, reading),
        }
    }

    fn sense_battery(&mut self) -> Option<Volts> {
        let volts = Volts(self.battery.volts());
        match &mut self.saboteur {
            None => Some(volts),
            Some(saboteur) => saboteur.battery(self.now_ms, volts),
        }
    }

    fn sense_side(&mut self, around: Surroundings<'_>, side: usize) {
        let body = &self.body;
        let [x, y, z] = body.position();
        let up = body.rotation()[2][2] * BEAMS_ABOVE_CENTRE;
        let (place, beam) = ([x, y, z + up], BEAMS[side]);
        let random = &mut self.random;
        let reading = &mut self.sides[side];
        let reading = reading.look_along(around, place, body.rotation(), beam, random);
        self.ranges[side] = match &mut self.saboteur {
            None => Some(reading),
            Some(saboteur) => saboteur.side(self.now_ms, side, reading),
        };
    }

    /// Runs the flight code when its time has come.
    fn think(&mut self, fault: Option<Fault>) {
        let now_us = self.now_ms * 1_000;
        let at_us = if fault == Some(Fault::TickJitter) {
            if now_us < self.due_us {
                return;
            }
            let at_us = now_us - 1_000 + self.due_us % 1_000;
            let late = 200 + (4_800.0 * self.random.uniform()) as u64;
            self.due_us = at_us + 1_000 + late;
            at_us
        } else {
            now_us
        };
        let sensed = std::mem::take(&mut self.sensed);
        let now = Instant::from_micros(at_us);
        if let Some(flight) = &mut self.flight {
            self.outputs = flight.step(&self.config, now, &sensed, &self.command);
        }
    }

    /// Applies the faults that happen at one moment.
    fn befall(&mut self, fault: Option<Fault>) {
        let Some(saboteur) = &mut self.saboteur else { return };
        match fault {
            Some(Fault::WeakMotor(part)) if saboteur.strikes_now() => {
                self.motors.weaken(saboteur.which, part);
            }
            Some(Fault::LowBattery(charge)) => self.battery.drain_to(charge),
            _ => {}
        }
    }

    fn collide(&mut self, around: Surroundings<'_>) {
        let [x, y, _] = self.body.position();
        match around.tunnel.bump(Point2::new(x, y), around.vehicle.radius) {
            Some(Point2 { x, y }) => {
                self.body.stop_at([x, y]);
                self.contacts += u32::from(self.touching_ms == 0);
                self.touching_ms = SAME_TOUCH_MS;
            }
            None => self.touching_ms = self.touching_ms.saturating_sub(1),
        }
    }

    /// The body.
    #[must_use]
    pub const fn body(&self) -> &RigidBody {
        &self.body
    }

    /// The battery.
    #[must_use]
    pub const fn battery(&self) -> &Battery {
        &self.battery
    }

    /// The outputs of the flight code's last step.
    #[must_use]
    pub const fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// The record of the flights.
    #[must_use]
    pub const fn record(&self) -> &Record {
        &self.record
    }

    /// The flight code, for observation; `None` where it runs in an emulator.
    #[must_use]
    pub const fn flight(&self) -> Option<&Flight> {
        self.flight.as_ref()
    }

    /// The down ranger above the floor, m: the height that the flight code flies by.
    #[must_use]
    pub const fn height_of_deck(&self) -> f32 {
        self.body.height() + DECK_ABOVE_FEET
    }

    /// The latest readings of the side rangers.
    #[must_use]
    pub const fn sides(&self) -> Sides {
        let [front, right, back, left] = self.ranges;
        Sides { front, right, back, left }
    }

    /// How often it has touched a wall.
    #[must_use]
    pub const fn contacts(&self) -> u32 {
        self.contacts
    }

    /// The heading of the nose on the floor plan: a unit vector.
    #[must_use]
    pub fn nose(&self) -> [f32; 2] {
        let rotation = self.body.rotation();
        let [x, y] = [rotation[0][0] - rotation[0][1], rotation[1][0] - rotation[1][1]];
        let length = libm::sqrtf(x * x + y * y);
        if length > 1e-3 { [x / length, y / length] } else { [1.0, 0.0] }
    }
}

/// Hovering level at this height.
fn hover(height: Metres) -> Setpoint {
    Setpoint::Fly {
        forward: MetresPerSecond::ZERO,
        lateral: MetresPerSecond::ZERO,
        yaw_rate: units::RadiansPerSecond::ZERO,
        height,
    }
}

/// A wind from one of four sides.
fn gust(speed: f32, side: usize) -> body::Vector {
    [[speed, 0.0, 0.0], [0.0, speed, 0.0], [-speed, 0.0, 0.0], [0.0, -speed, 0.0]]
        .get(side)
        .copied()
        .unwrap_or([speed, 0.0, 0.0])
}
