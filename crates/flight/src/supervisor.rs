//! What may fly, and what brings a flight to its end.
//!
//! ```text
//!              Fly, and ready
//!   Grounded ──────────────────▶ Flying ──▶ Landing ──▶ Landed
//!      ▲  ▲         Off            │      a Cause  touched    │
//!      │  └────────────────────────┘               down       │
//!      └──────────────────────────────────────────────────────┘
//!                               Off
//!   Stopped: from anywhere, by a StopCause; until the next boot.
//! ```
//!
//! A landing that has begun is not broken off: what failed and came back may fail again, and a
//! drone on the ground can be asked why.

use units::{Duration, Instant, Setpoint};

/// What the flight code is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// On the ground, motors off.
    Grounded {
        /// What keeps it there, if anything but that nobody wants it to fly.
        waits_for: Option<NotReady>,
    },
    /// In the air, following its set-point.
    Flying {
        /// Since when.
        since: Instant,
    },
    /// Coming down by itself.
    Landing {
        /// Since when.
        since: Instant,
        /// Why.
        why: Cause,
    },
    /// On the ground after a landing of its own; set-point [`Off`](crate::Setpoint::Off) makes it
    /// [`Grounded`](Self::Grounded) again.
    Landed {
        /// Why it came down.
        why: Cause,
    },
    /// Motors off until the next boot.
    Stopped {
        /// Why.
        why: StopCause,
    },
}

impl Mode {
    /// Whether the motors turn.
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
    /// No inertial sensor.
    NoImu,
    /// It has not lain still long enough for its gyroscope to be zeroed.
    Calibrating,
    /// It does not stand level.
    Tilted,
    /// No optic flow sensor.
    NoFlow,
    /// No ranger that looks down.
    NoHeight,
    /// No battery voltage.
    NoBattery,
    /// The battery would not bring it home.
    BatteryLow,
}

/// Why a flight was ended by a landing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Cause {
    /// Nobody said for too long what to do.
    NoSetpoint,
    /// The inertial sensor fell silent, or says what no drone does.
    NoImu,
    /// Nothing measures its velocity.
    NoFlow,
    /// Nothing measures its height, or what does is contradicted by the ground.
    NoHeight,
    /// The battery is at its end.
    Battery,
    /// A motor cannot keep up, or the drone cannot hold its height.
    Overload,
    /// It keeps hitting something: it does not see where it flies.
    Blocked,
}

/// Why the motors were stopped for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum StopCause {
    /// Somebody said so.
    Ordered,
    /// It lies on its side or its back.
    Tumbled,
    /// It fell.
    FreeFall,
    /// It tipped over at take-off: a propeller does not turn, or something holds it.
    PropellerStuck,
}

/// The supervisor's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupervisorConfig {
    /// A set-point older than this is no longer followed: the drone stands still.
    pub level_out_after: Duration,
    /// A set-point older than this ends the flight.
    pub give_up_after: Duration,
    /// A sensor that has not been heard for this long is missing on the ground.
    pub silent_after: Duration,
    /// Body rates that have not been sound for this long end the flight.
    pub blind_after: Duration,
    /// As long as this a drone flies without a velocity or a height that is measured.
    pub lost_after: Duration,
    /// The most tilt of a drone that takes off: its cosine.
    pub level: f32,
    /// The tilt beyond which a drone has tumbled: its cosine …
    pub tumbled: f32,
    /// … that must last this long.
    pub tumbled_for: Duration,
    /// A specific force under this is a fall, m/s² …
    pub falling: f32,
    /// … that must last this long …
    pub falling_for: Duration,
    /// … and lead downwards by this, m.
    pub fall: f32,
    /// Tipping over within this time after take-off means that a propeller is stuck.
    pub tips_over_within: Duration,
    /// More of its trim than this used up means that a motor cannot keep up.
    pub most_trim: f32,
    /// So long a motor may be unable to keep up.
    pub overload_for: Duration,
    /// A push from the side that is more than this is a blow, m/s².
    pub blow: f32,
    /// The most blows that are borne, each a millisecond of being hit, when those of a second ago
    /// count as a third.
    pub most_blows: f32,
    /// A push from below that is more than this, felt by a drone that sinks, is the floor, m/s².
    pub floor_blow: f32,
    /// And unexpected, if it comes above this estimated height, m.
    pub floor_expected: f32,
    /// Speed of a landing, m/s …
    pub descent: f32,
    /// … and of one without a gyroscope, m/s: every second counts.
    pub blind_descent: f32,
    /// Below this height the drone stands on its legs, m …
    pub ground: f32,
    /// … when it has been there for this long.
    pub ground_for: Duration,
    /// A drone that should sink, or rise, at least this fast, m/s, …
    pub should_move: f32,
    /// … and moves less than this, m/s, …
    pub stands: f32,
    /// … or is pushed up by more than this beside its motors, m/s², …
    pub floor_push: f32,
    /// … for this long is on the ground, whatever its ranger says; or is held there.
    pub held_up_for: Duration,
    /// A landing without a height ends at the latest so long after it should have touched down.
    pub overdue: Duration,
}

impl SupervisorConfig {
    /// Watchdogs, and tumbling and falling in outline: crazyflie-firmware, `supervisor.c`. It
    /// switches the motors off where set-points fail for 2 s; we land. Gyroscope: predicted rates
    /// are good for a quarter of a second (the book's table of faults). Lost velocity: a tilt that
    /// is wrong by 0.5° makes 6 cm/s in 0.7 s, and a ranger that contradicts the estimate is
    /// believed after at most 0.4 s. A trim of 90 % is a motor at about half its thrust.
    ///
    /// Blows and pushes are numbers of ours, tuned in the simulator (`uchain bench faults`): a wall
    /// that is bumped into is felt for some milliseconds, one that is scraped along for some in
    /// each ten, and a floor that bears 7 % of the weight before the accelerometer is doubted for
    /// it.
    pub const DEFAULT: Self = Self {
        level_out_after: Duration::from_millis(500),
        give_up_after: Duration::from_secs(2),
        silent_after: Duration::from_secs(1),
        blind_after: Duration::from_millis(250),
        lost_after: Duration::from_millis(700),
        level: 0.966,
        tumbled: 0.342,
        tumbled_for: Duration::from_millis(100),
        falling: 3.0,
        falling_for: Duration::from_millis(100),
        fall: 0.05,
        tips_over_within: Duration::from_millis(1_000),
        most_trim: 0.9,
        overload_for: Duration::from_millis(1_000),
        blow: 4.0,
        most_blows: 12.0,
        floor_blow: 8.0,
        floor_expected: 0.12,
        descent: 0.3,
        blind_descent: 0.4,
        ground: 0.05,
        ground_for: Duration::from_millis(100),
        should_move: 0.15,
        stands: 0.04,
        floor_push: 0.7,
        held_up_for: Duration::from_millis(700),
        overdue: Duration::from_millis(700),
    };
}

/// What one step has shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observed {
    pub(crate) now: Instant,
    pub(crate) setpoint: Setpoint,
    /// Since it was given.
    pub(crate) setpoint_age: Duration,
    /// The gyroscope has been zeroed.
    pub(crate) zeroed: bool,
    /// For how long body rates have not been sound.
    pub(crate) blind_for: Duration,
    /// Since the sensors were last heard.
    pub(crate) flow_silent: Duration,
    pub(crate) down_silent: Duration,
    /// Since velocity and height were last measured.
    pub(crate) velocity_age: Duration,
    pub(crate) height_age: Duration,
    /// Cosine of the tilt.
    pub(crate) upright: f32,
    /// Length of the specific force, where it is read.
    pub(crate) force: Option<f32>,
    /// The latest reading of the ranger that looks down, m.
    pub(crate) clearance: Option<f32>,
    /// Estimated height, m.
    pub(crate) height: f32,
    pub(crate) battery_known: bool,
    pub(crate) battery_may_fly: bool,
    pub(crate) battery_critical: bool,
    /// More thrust is wanted than there is, or what there is does not hold the height.
    pub(crate) thrust_short: bool,
    /// The part of its trim that is used up.
    pub(crate) trim: f32,
    /// What the height controller wants, m/s upwards.
    pub(crate) wanted_climb: f32,
    /// What it gets by the estimate.
    pub(crate) climb: f32,
    /// The force upwards that the motors do not explain, m/s².
    pub(crate) unexplained: f32,
    /// A blow from the side, m/s².
    pub(crate) blow: f32,
    /// And from below.
    pub(crate) blow_up: f32,
}

/// How long something has been so.
#[derive(Clone, Copy, Debug)]
struct Held {
    since: Option<Instant>,
}

impl Held {
    const fn new() -> Self {
        Self { since: None }
    }

    fn step(&mut self, now: Instant, holds: bool) -> Duration {
        self.since = if holds { self.since.or(Some(now)) } else { None };
        self.since.map_or(Duration::ZERO, |since| now.since(since))
    }
}

/// The supervisor's memory.
#[derive(Clone, Debug)]
pub(crate) struct Supervisor {
    mode: Mode,
    tumbling: Held,
    falling: Held,
    /// Clearance when it began to fall.
    fell_from: Option<f32>,
    overload: Held,
    /// Blows of late.
    blows: f32,
    last: Option<Instant>,
    low: Held,
    held_up: Held,
    /// Estimated height when the landing began, m.
    landing_from: f32,
}

/// What one look at the timers says.
struct Verdict {
    tumbled: bool,
    fell: bool,
    overloaded: bool,
    blocked: bool,
    /// On its legs, by height.
    down: bool,
    /// On something, whatever the height.
    held_up: bool,
}

impl Supervisor {
    pub(crate) const fn new() -> Self {
        Self {
            mode: Mode::Grounded { waits_for: Some(NotReady::Calibrating) },
            tumbling: Held::new(),
            falling: Held::new(),
            fell_from: None,
            overload: Held::new(),
            blows: 0.0,
            last: None,
            low: Held::new(),
            held_up: Held::new(),
            landing_from: 0.0,
        }
    }

    pub(crate) const fn mode(&self) -> Mode {
        self.mode
    }

    pub(crate) fn step(&mut self, config: &SupervisorConfig, at: &Observed) -> Mode {
        let verdict = self.judge(config, at);
        let next = match self.mode {
            _ if at.setpoint == Setpoint::Stop => Mode::Stopped { why: StopCause::Ordered },
            Mode::Stopped { why } => Mode::Stopped { why },
            Mode::Grounded { .. } => grounded(config, at),
            Mode::Flying { since } => flying(since, config, at, &verdict),
            Mode::Landing { since, why } => self.landing(since, why, config, at, &verdict),
            Mode::Landed { why } => match at.setpoint {
                Setpoint::Off => Mode::Grounded { waits_for: not_ready(config, at) },
                Setpoint::Fly { .. } | Setpoint::Stop => Mode::Landed { why },
            },
        };
        if matches!(next, Mode::Landing { .. }) && !matches!(self.mode, Mode::Landing { .. }) {
            self.landing_from = at.height;
        }
        self.mode = next;
        next
    }

    /// Moves the timers on. On the ground none of them runs.
    fn judge(&mut self, config: &SupervisorConfig, at: &Observed) -> Verdict {
        let now = at.now;
        let air = self.mode.is_airborne();
        let tumbling = self.tumbling.step(now, air && at.upright < config.tumbled);
        let weightless = at.force.is_some_and(|force| force < config.falling);
        let falling = self.falling.step(now, air && weightless);
        if falling == Duration::ZERO {
            self.fell_from = at.clearance;
        }
        let sank = match (self.fell_from, at.clearance) {
            (Some(from), Some(to)) => from - to >= config.fall,
            _ => true,
        };
        let (wanted, gets) = (at.wanted_climb, at.climb);
        let held_down = wanted > config.should_move && gets < config.stands;
        let expected =
            at.height < config.floor_expected && matches!(self.mode, Mode::Flying { .. });
        let hit_floor = wanted < -config.should_move && at.blow_up > config.floor_blow && !expected;
        let pushed = gets > -config.stands || at.unexplained > config.floor_push;
        let held_up = wanted < -config.should_move && pushed;
        let overload = air && (at.thrust_short || held_down || at.trim > config.most_trim);
        let measured = at.height_age < config.lost_after;
        let low = measured && at.height <= config.ground;
        let dt = self.last.map_or(0.0, |last| now.since(last).as_secs_f32().min(1.0));
        self.last = Some(now);
        self.blows = if air { self.blows * (1.0 - dt) } else { 0.0 };
        if at.blow > config.blow {
            self.blows += 1.0;
        }
        Verdict {
            blocked: self.blows > config.most_blows,
            tumbled: tumbling >= config.tumbled_for,
            fell: falling >= config.falling_for && sank,
            overloaded: self.overload.step(now, overload) >= config.overload_for,
            down: self.low.step(now, air && low) >= config.ground_for,
            held_up: self.held_up.step(now, air && held_up) >= config.held_up_for
                || (air && hit_floor),
        }
    }

    fn landing(
        &self,
        since: Instant,
        why: Cause,
        config: &SupervisorConfig,
        at: &Observed,
        verdict: &Verdict,
    ) -> Mode {
        let blind = why == Cause::NoImu;
        let descent = if blind { config.blind_descent } else { config.descent };
        let due = Duration::from_millis((1e3 * self.landing_from.max(0.0) / descent) as u32 as u64);
        let measured = at.height_age < config.lost_after;
        let overdue = !measured && at.now.since(since) >= due + config.overdue;
        if at.setpoint == Setpoint::Off || verdict.down || verdict.held_up || overdue {
            Mode::Landed { why }
        } else if verdict.tumbled {
            Mode::Stopped { why: StopCause::Tumbled }
        } else if verdict.fell {
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
        (missing(at.blind_for), NotReady::NoImu),
        (!at.zeroed, NotReady::Calibrating),
        // Written so that an attitude which is not a number is not level.
        (!(at.upright >= config.level), NotReady::Tilted),
        (missing(at.flow_silent), NotReady::NoFlow),
        (missing(at.down_silent), NotReady::NoHeight),
        (!at.battery_known, NotReady::NoBattery),
        (!at.battery_may_fly, NotReady::BatteryLow),
    ]
    .into_iter()
    .find_map(|(holds, why)| holds.then_some(why))
}

fn flying(since: Instant, config: &SupervisorConfig, at: &Observed, verdict: &Verdict) -> Mode {
    let young = at.now.since(since) < config.tips_over_within;
    let land = |why| Mode::Landing { since: at.now, why };
    if at.setpoint == Setpoint::Off {
        Mode::Grounded { waits_for: not_ready(config, at) }
    } else if verdict.tumbled && young {
        Mode::Stopped { why: StopCause::PropellerStuck }
    } else if verdict.tumbled {
        Mode::Stopped { why: StopCause::Tumbled }
    } else if verdict.fell {
        Mode::Stopped { why: StopCause::FreeFall }
    } else if at.blind_for >= config.blind_after {
        land(Cause::NoImu)
    } else if at.height_age >= config.lost_after {
        land(Cause::NoHeight)
    } else if verdict.held_up {
        Mode::Landed { why: Cause::NoHeight }
    } else if at.velocity_age >= config.lost_after {
        land(Cause::NoFlow)
    } else if at.battery_critical {
        land(Cause::Battery)
    } else if verdict.overloaded {
        land(Cause::Overload)
    } else if verdict.blocked {
        land(Cause::Blocked)
    } else if at.setpoint_age >= config.give_up_after {
        land(Cause::NoSetpoint)
    } else {
        Mode::Flying { since }
    }
}
