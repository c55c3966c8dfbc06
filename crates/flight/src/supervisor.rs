//! Decides when a drone may take off, when it must land, and when its motors must stop.
//!
//! ```text
//!              Fly, and ready
//!   Grounded ──────────────────▶ Flying ──▶ Landing ──▶ Landed
//!      ▲  ▲         Off            │      a Cause  touched    │
//!      │  └────────────────────────┘               down       │
//!      └──────────────────────────────────────────────────────┘
//!                               Off
//!   Stopped: from any mode, by a StopCause; until the next boot.
//! ```
//!
//! A drone that is landing never goes back to flying: a sensor that failed and recovered may fail
//! again, and a drone on the ground still shows why it landed.

use units::{Duration, Instant, Setpoint};

/// The flight mode.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// The drone is on the ground with its motors off.
    Grounded {
        /// Why the drone would not take off; `None` if it is ready.
        waits_for: Option<NotReady>,
    },
    /// The drone is in the air and follows its set-point.
    Flying {
        /// When it took off.
        since: Instant,
    },
    /// The drone is landing by its own decision.
    Landing {
        /// When the landing began.
        since: Instant,
        /// Why it lands.
        why: Cause,
    },
    /// The drone has landed by its own decision. The set-point [`Off`](units::Setpoint::Off) makes
    /// it [`Grounded`](Self::Grounded) again.
    Landed {
        /// Why it landed.
        why: Cause,
    },
    /// The motors stay off until the next boot.
    Stopped {
        /// Why they were stopped.
        why: StopCause,
    },
}

impl Mode {
    /// Whether the drone is in the air with its motors running.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        match self {
            Self::Flying { .. } | Self::Landing { .. } => true,
            Self::Grounded { .. } | Self::Landed { .. } | Self::Stopped { .. } => false,
        }
    }
}

/// Why a drone on the ground would not take off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NotReady {
    /// The inertial sensor gives no sound body rates.
    NoImu,
    /// The drone has not lain still for long enough to measure the gyroscope's bias.
    Calibrating,
    /// The drone does not stand level.
    Tilted,
    /// The optic flow sensor is silent.
    NoFlow,
    /// The ranger that looks down is silent.
    NoHeight,
    /// The battery voltage is unknown.
    NoBattery,
    /// The battery's charge is too low for a flight.
    BatteryLow,
}

/// Why the drone landed by its own decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Cause {
    /// The last set-point is too old.
    NoSetpoint,
    /// The gyroscope is silent, or its readings are implausible.
    NoImu,
    /// No sensor measures the velocity.
    NoFlow,
    /// No sensor measures the height, or the drone stands on something that the ranger does not
    /// show.
    NoHeight,
    /// The battery is empty.
    Battery,
    /// A motor cannot keep up, or the drone cannot hold its height.
    Overload,
    /// The drone keeps hitting an obstacle that its rangers do not show.
    Blocked,
}

/// Why the motors were stopped until the next boot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum StopCause {
    /// The set-point was [`Stop`](units::Setpoint::Stop).
    Ordered,
    /// The drone lies on its side or its back.
    Tumbled,
    /// The drone was in free fall.
    FreeFall,
    /// The drone tipped over at take-off: a propeller does not turn, or the drone is held.
    PropellerStuck,
}

/// The constants of the supervisor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupervisorConfig {
    /// A set-point older than this is no longer followed: the drone stops over ground and keeps the
    /// height.
    pub level_out_after: Duration,
    /// A set-point older than this ends the flight with a landing.
    pub give_up_after: Duration,
    /// A sensor that has been silent for this long on the ground counts as missing.
    pub silent_after: Duration,
    /// Body rates that have been unsound for this long end the flight.
    pub rates_lost_after: Duration,
    /// A velocity or a height that has not been measured for this long ends the flight.
    pub lost_after: Duration,
    /// Cosine of the largest tilt at which a drone takes off.
    pub level: f32,
    /// Cosine of the tilt beyond which a drone counts as tumbled.
    pub tumbled: f32,
    /// Time for which the drone must be tilted beyond `tumbled`.
    pub tumbled_for: Duration,
    /// Specific force below which a drone may be in free fall, m/s².
    pub falling: f32,
    /// Time for which the specific force must be below `falling`.
    pub falling_for: Duration,
    /// Distance by which the drone must have sunk meanwhile, m, if the ranger measures it.
    pub least_fall: f32,
    /// A drone that tumbles within this time after take-off has a stuck propeller.
    pub tips_over_within: Duration,
    /// Fraction of the rate loops' integral limit above which a motor counts as too weak.
    pub most_trim: f32,
    /// Time for which an overload is tolerated.
    pub overload_for: Duration,
    /// Lateral specific force above which a drone is being hit, m/s².
    pub impact: f32,
    /// Most impacts that are tolerated. Each millisecond of impact counts one, and the count decays
    /// with a time constant of 1 s.
    pub most_impacts: f32,
    /// Lasting lateral specific force above which something leans against the drone, m/s².
    pub lean_force: f32,
    /// Velocity over ground that must be missing meanwhile, m/s: an accelerometer that is wrong makes
    /// none.
    pub lean_error: f32,
    /// A drone that leans against something for this long is blocked.
    pub leans_for: Duration,
    /// Upward specific force beyond that of the motors, m/s², above which a sinking drone has hit
    /// the floor, if it lasts for [`floor_impact_for`](Self::floor_impact_for) and is stronger than
    /// the lateral one: a wall that a tilted drone hits pushes it along its z as well.
    pub floor_impact: f32,
    /// Time for which the force must be above `floor_impact`.
    pub floor_impact_for: Duration,
    /// Estimated height below which a flying drone expects to touch the floor, m: there
    /// `floor_impact` is not looked at.
    pub floor_expected: f32,
    /// Descent speed of a landing, m/s.
    pub descent: f32,
    /// Descent speed of a landing without a gyroscope, m/s: faster, because the predicted rates
    /// soon drift.
    pub descent_without_rates: f32,
    /// Height at or below which a landing drone stands on its legs, m.
    pub touchdown_height: f32,
    /// Time for which the drone must be at or below `touchdown_height`.
    pub touchdown_for: Duration,
    /// Climb rate, up or down, above which the height controller is asking for real motion, m/s.
    pub commanded_speed: f32,
    /// Climb rate below which the drone counts as standing still, m/s.
    pub standstill_speed: f32,
    /// Upward specific force beyond that of the motors, m/s², above which something holds the drone
    /// up.
    pub support_force: f32,
    /// A drone that sinks faster than this by its ranger, m/s, is not held up, whatever its
    /// accelerometer says.
    pub sinking_speed: f32,
    /// Thrust, in multiples of the weight, at which a drone must sink, whatever its motors and
    /// propellers are worth.
    pub sinking_lift: f32,
    /// A flying drone that is asked to sink, but is held up for this long, lands: it stands on
    /// something that its ranger does not show.
    pub held_up_for: Duration,
    /// A landing drone that is held up for this long stands, whatever its ranger says.
    pub stands_for: Duration,
    /// A landing without a measured height ends this long after the drone should have touched down.
    pub touchdown_overdue: Duration,
}

impl SupervisorConfig {
    /// The watchdogs, and the outline of the checks for tumbling and falling, follow
    /// crazyflie-firmware, `supervisor.c`; it stops the motors when set-points fail for 2 s, this
    /// supervisor lands. Gyroscope: predicted rates are good for a quarter of a second (the book's
    /// table of faults). Lost velocity: a tilt that is wrong by 0.5° adds 6 cm/s in 0.7 s, and the
    /// estimator resets to a ranger that contradicts it after at most 0.4 s. A trim of 90 % is a
    /// motor at about half its thrust.
    ///
    /// The thresholds of impacts and of the floor are our own, tuned in the simulator (`uchain
    /// bench faults`). A wall that the drone bumps into is felt for some milliseconds, and one that
    /// it scrapes along for some in each ten. A drone that leans against a wall at 6° is pushed back
    /// by 1 m/s², three times what offset and drag amount to. A floor is detected that bears 7 % of the weight,
    /// before the accelerometer is rejected for it. A
    /// drone that meets a floor at 0.15 m/s feels the impact for 6 ms behind the accelerometer's
    /// filter. Motors that give 150 % of what they are asked
    /// for, the most that is ever learnt, lift 90 % of the weight at `sinking_lift`.
    pub const DEFAULT: Self = Self {
        level_out_after: Duration::from_millis(500),
        give_up_after: Duration::from_secs(2),
        silent_after: Duration::from_secs(1),
        rates_lost_after: Duration::from_millis(250),
        lost_after: Duration::from_millis(700),
        level: 0.966,
        tumbled: 0.342,
        tumbled_for: Duration::from_millis(100),
        falling: 3.0,
        falling_for: Duration::from_millis(100),
        least_fall: 0.05,
        tips_over_within: Duration::from_millis(1_000),
        most_trim: 0.9,
        overload_for: Duration::from_millis(1_000),
        impact: 4.0,
        most_impacts: 12.0,
        lean_force: 1.0,
        lean_error: 0.25,
        leans_for: Duration::from_millis(500),
        floor_impact: 8.0,
        floor_impact_for: Duration::from_millis(5),
        floor_expected: 0.12,
        descent: 0.3,
        descent_without_rates: 0.4,
        touchdown_height: 0.05,
        touchdown_for: Duration::from_millis(100),
        commanded_speed: 0.15,
        standstill_speed: 0.04,
        support_force: 0.7,
        sinking_speed: 0.15,
        sinking_lift: 0.6,
        held_up_for: Duration::from_millis(700),
        stands_for: Duration::from_millis(300),
        touchdown_overdue: Duration::from_millis(700),
    };
}

/// The supervisor's inputs at one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observed {
    pub(crate) now: Instant,
    pub(crate) setpoint: Setpoint,
    /// Time since the set-point was given.
    pub(crate) setpoint_age: Duration,
    /// Whether the gyroscope's bias has been measured.
    pub(crate) calibrated: bool,
    /// For how long the body rates have been unsound.
    pub(crate) rates_unsound_for: Duration,
    /// Time since the flow sensor's last fresh reading.
    pub(crate) flow_silent: Duration,
    /// Time since the last fresh reading of the ranger that looks down.
    pub(crate) down_silent: Duration,
    /// Time since the velocity was last measured.
    pub(crate) velocity_age: Duration,
    /// Time since the height was last measured.
    pub(crate) height_age: Duration,
    /// Cosine of the tilt.
    pub(crate) tilt_cosine: f32,
    /// Magnitude of the specific force, m/s²; `None` without a reading.
    pub(crate) specific_force: Option<f32>,
    /// Latest reading of the ranger that looks down, m; `None` if it was invalid.
    pub(crate) clearance: Option<f32>,
    /// Estimated height, m.
    pub(crate) height: f32,
    /// Whether the battery's voltage is known.
    pub(crate) battery_known: bool,
    /// Whether the battery's charge suffices to begin a flight.
    pub(crate) battery_may_fly: bool,
    /// Whether the battery is empty.
    pub(crate) battery_critical: bool,
    /// Whether the last step asked for more thrust than the motors give.
    pub(crate) thrust_short: bool,
    /// Fraction of the rate loops' integral limit that is used.
    pub(crate) trim: f32,
    /// Climb rate that the height controller asks for, m/s.
    pub(crate) wanted_climb: f32,
    /// Estimated climb rate, m/s.
    pub(crate) climb: f32,
    /// Thrust that the motors were last asked for, in multiples of the weight.
    pub(crate) lift: f32,
    /// Smoothed upward specific force that the motors do not explain, m/s².
    pub(crate) vertical_residual: f32,
    /// Smoothed lateral specific force, m/s².
    pub(crate) lateral_residual: f32,
    /// Horizontal velocity that is missing, m/s.
    pub(crate) velocity_error: f32,
    /// Momentary lateral specific force beyond its recent mean, m/s².
    pub(crate) lateral_impact: f32,
    /// Momentary upward specific force that the motors do not explain, m/s².
    pub(crate) vertical_impact: f32,
}

/// Measures for how long a condition has held without a break.
#[derive(Clone, Copy, Debug)]
struct HoldTimer {
    since: Option<Instant>,
}

impl HoldTimer {
    const fn new() -> Self {
        Self { since: None }
    }

    fn step(&mut self, now: Instant, holds: bool) -> Duration {
        self.since = if holds { self.since.or(Some(now)) } else { None };
        self.since.map_or(Duration::ZERO, |since| now.since(since))
    }
}

/// The state of the supervisor between steps.
#[derive(Clone, Debug)]
pub(crate) struct Supervisor {
    mode: Mode,
    tumbling: HoldTimer,
    falling: HoldTimer,
    /// Clearance when the free fall began, m.
    fell_from: Option<f32>,
    overload: HoldTimer,
    /// Decaying count of impacts, see [`SupervisorConfig::most_impacts`].
    impacts: f32,
    leaning: HoldTimer,
    last: Option<Instant>,
    near_ground: HoldTimer,
    hit_floor: HoldTimer,
    held_up: HoldTimer,
    /// Estimated height when the landing began, m.
    landing_from: f32,
}

/// The conditions that end a flight, after their hold times.
struct Conditions {
    tumbled: bool,
    fell: bool,
    overloaded: bool,
    blocked: bool,
    /// The measured height says that the drone stands on its legs.
    touched_down: bool,
    /// The drone met a floor while it was to sink, and not where a flying drone expects one.
    hit_floor: bool,
    /// For how long the drone has been held up while it was to sink.
    held_up: Duration,
}

impl Supervisor {
    pub(crate) const fn new() -> Self {
        Self {
            mode: Mode::Grounded { waits_for: Some(NotReady::Calibrating) },
            tumbling: HoldTimer::new(),
            falling: HoldTimer::new(),
            fell_from: None,
            overload: HoldTimer::new(),
            impacts: 0.0,
            leaning: HoldTimer::new(),
            last: None,
            near_ground: HoldTimer::new(),
            hit_floor: HoldTimer::new(),
            held_up: HoldTimer::new(),
            landing_from: 0.0,
        }
    }

    pub(crate) const fn mode(&self) -> Mode {
        self.mode
    }

    pub(crate) fn step(&mut self, config: &SupervisorConfig, at: &Observed) -> Mode {
        let conditions = self.evaluate(config, at);
        let next = match self.mode {
            _ if at.setpoint == Setpoint::Stop => Mode::Stopped { why: StopCause::Ordered },
            Mode::Stopped { why } => Mode::Stopped { why },
            Mode::Grounded { .. } => grounded(config, at),
            Mode::Flying { since } => flying(since, config, at, &conditions),
            Mode::Landing { since, why } => self.landing(since, why, config, at, &conditions),
            Mode::Landed { why } => match at.setpoint {
                Setpoint::Off => Mode::Grounded { waits_for: not_ready(config, at) },
                Setpoint::Fly { .. } | Setpoint::Stop => Mode::Landed { why },
            },
        };
        if matches!(next, Mode::Landing { .. }) && !matches!(self.mode, Mode::Landing { .. }) {
            self.landing_from = at.height;
            // Whether it stands has still to be seen: what ends a flight does not stop the motors.
            self.held_up = HoldTimer::new();
        }
        self.mode = next;
        next
    }

    /// Advances the timers and evaluates the conditions. On the ground no timer runs.
    fn evaluate(&mut self, config: &SupervisorConfig, at: &Observed) -> Conditions {
        let now = at.now;
        let airborne = self.mode.is_airborne();
        let tumbling = self.tumbling.step(now, airborne && at.tilt_cosine < config.tumbled);
        let weightless = at.specific_force.is_some_and(|force| force < config.falling);
        let falling = self.falling.step(now, airborne && weightless);
        if falling == Duration::ZERO {
            self.fell_from = at.clearance;
        }
        let sank = match (self.fell_from, at.clearance) {
            (Some(from), Some(to)) => from - to >= config.least_fall,
            _ => true,
        };
        let (wanted, climb) = (at.wanted_climb, at.climb);
        let held_down = wanted > config.commanded_speed && climb < config.standstill_speed;
        let floor_expected =
            at.height < config.floor_expected && matches!(self.mode, Mode::Flying { .. });
        let hit_floor = airborne
            && wanted < -config.commanded_speed
            && at.vertical_impact > config.floor_impact.max(at.lateral_impact)
            && !floor_expected;
        let measured = at.height_age < config.lost_after;
        let sinks = measured && climb < -config.sinking_speed;
        let supported = at.vertical_residual > config.support_force && !sinks;
        let stays = climb > -config.standstill_speed && at.lift < config.sinking_lift;
        let held_up = airborne && wanted < -config.commanded_speed && (supported || stays);
        let overload = airborne && (at.thrust_short || held_down || at.trim > config.most_trim);
        let low = measured && at.height <= config.touchdown_height;
        let dt = self.last.map_or(0.0, |last| now.since(last).as_secs_f32().min(1.0));
        self.last = Some(now);
        self.impacts = if airborne { self.impacts * (1.0 - dt) } else { 0.0 };
        if at.lateral_impact > config.impact {
            self.impacts += 1.0;
        }
        let leans = airborne
            && at.lateral_residual > config.lean_force
            && at.velocity_error > config.lean_error;
        let leaning = self.leaning.step(now, leans);
        Conditions {
            blocked: self.impacts > config.most_impacts || leaning >= config.leans_for,
            tumbled: tumbling >= config.tumbled_for,
            fell: falling >= config.falling_for && sank,
            overloaded: self.overload.step(now, overload) >= config.overload_for,
            touched_down: self.near_ground.step(now, airborne && low) >= config.touchdown_for,
            hit_floor: self.hit_floor.step(now, hit_floor) >= config.floor_impact_for,
            held_up: self.held_up.step(now, held_up),
        }
    }

    fn landing(
        &self,
        since: Instant,
        why: Cause,
        config: &SupervisorConfig,
        at: &Observed,
        conditions: &Conditions,
    ) -> Mode {
        let without_rates = why == Cause::NoImu;
        let descent = if without_rates { config.descent_without_rates } else { config.descent };
        let due = Duration::from_millis((1e3 * self.landing_from.max(0.0) / descent) as u32 as u64);
        let measured = at.height_age < config.lost_after;
        let overdue = !measured && at.now.since(since) >= due + config.touchdown_overdue;
        let stands = conditions.touched_down
            || conditions.hit_floor
            || conditions.held_up >= config.stands_for;
        if at.setpoint == Setpoint::Off || stands || overdue {
            Mode::Landed { why }
        } else if conditions.tumbled {
            Mode::Stopped { why: StopCause::Tumbled }
        } else if conditions.fell {
            Mode::Stopped { why: StopCause::FreeFall }
        } else {
            Mode::Landing { since, why }
        }
    }
}

fn grounded(config: &SupervisorConfig, at: &Observed) -> Mode {
    let waits_for = not_ready(config, at);
    let wanted =
        matches!(at.setpoint, Setpoint::Fly { .. }) && at.setpoint_age < config.level_out_after;
    if wanted && waits_for.is_none() {
        Mode::Flying { since: at.now }
    } else {
        Mode::Grounded { waits_for }
    }
}

fn not_ready(config: &SupervisorConfig, at: &Observed) -> Option<NotReady> {
    let missing = |silent: Duration| silent >= config.silent_after;
    [
        (missing(at.rates_unsound_for), NotReady::NoImu),
        (!at.calibrated, NotReady::Calibrating),
        // Written so that a NaN attitude is not level.
        (!(at.tilt_cosine >= config.level), NotReady::Tilted),
        (missing(at.flow_silent), NotReady::NoFlow),
        (missing(at.down_silent), NotReady::NoHeight),
        (!at.battery_known, NotReady::NoBattery),
        (!at.battery_may_fly, NotReady::BatteryLow),
    ]
    .into_iter()
    .find_map(|(holds, why)| holds.then_some(why))
}

fn flying(
    since: Instant,
    config: &SupervisorConfig,
    at: &Observed,
    conditions: &Conditions,
) -> Mode {
    let just_took_off = at.now.since(since) < config.tips_over_within;
    let land = |why| Mode::Landing { since: at.now, why };
    if at.setpoint == Setpoint::Off {
        Mode::Grounded { waits_for: not_ready(config, at) }
    } else if conditions.tumbled && just_took_off {
        Mode::Stopped { why: StopCause::PropellerStuck }
    } else if conditions.tumbled {
        Mode::Stopped { why: StopCause::Tumbled }
    } else if conditions.fell {
        Mode::Stopped { why: StopCause::FreeFall }
    } else if at.rates_unsound_for >= config.rates_lost_after {
        land(Cause::NoImu)
    } else if at.height_age >= config.lost_after {
        land(Cause::NoHeight)
    } else if conditions.hit_floor {
        Mode::Landed { why: Cause::NoHeight }
    } else if conditions.held_up >= config.held_up_for {
        land(Cause::NoHeight)
    } else if at.velocity_age >= config.lost_after {
        land(Cause::NoFlow)
    } else if at.battery_critical {
        land(Cause::Battery)
    } else if conditions.overloaded {
        land(Cause::Overload)
    } else if conditions.blocked {
        land(Cause::Blocked)
    } else if at.setpoint_age >= config.give_up_after {
        land(Cause::NoSetpoint)
    } else {
        Mode::Flying { since }
    }
}
