//! The pilot of a map, who goes by the head's odometer: forward until it is as deep as was asked for,
//! or has not come on for longer than a relay needs; then a hold, and home.

use mission::Mission;
use scenario::Scenario;
use units::{Course, MetresPerSecond, NodeId, Order};

/// The time for which the head hovers before it is called home, s: as in a map's own mission.
pub(super) const HOLDS_S: f32 = 40.0;
/// A head has come on that is farther by this than ever before, m.
const ON_M: f32 = 0.3;
/// The patience of a pilot beyond the time that a relay needs to come, s.
const PATIENCE_S: f32 = 30.0;
/// The time that a launch may be held up by its policy, s (`LaunchConfig::WHEN_SETTLED`).
const CALLED_S: f32 = 10.0;
/// The time that all drones are down before the mission is over, s.
const DOWN_S: f32 = 2.0;

/// Why the pilot ended the exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Why {
    /// By its odometer, and where it took off, the head is as deep as was asked for.
    There,
    /// The head has not come on.
    Stood,
    /// A battery called the chain home.
    Battery,
    /// There was no more time.
    Time,
}

impl Why {
    /// The name in a mission's JSON.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::There => "there",
            Self::Stood => "stood",
            Self::Battery => "battery",
            Self::Time => "time",
        }
    }

    /// The cause of a head that came short of its depth.
    pub(super) const fn short(self) -> &'static str {
        match self {
            Self::There => "short-by-odometer",
            Self::Stood => "short-stood",
            Self::Battery => "short-battery",
            Self::Time => "short-time",
        }
    }
}

/// What the pilot does.
#[derive(Clone, Copy, Debug)]
enum Phase {
    /// The head is sent forward; the farthest that it told, m, and since when, s.
    Out { best_m: f32, since_s: f32 },
    /// It hovers since this moment, s.
    Holds { since_s: f32 },
    /// All are called home since this moment, s, and were all down since another.
    Home { since_s: f32, down_s: Option<f32> },
}

/// The pilot of one mission.
pub(super) struct Pilot<'a> {
    scenario: &'a Scenario,
    depth_m: f32,
    /// When there is no more time for the exploration, s.
    ends_s: f32,
    phase: Phase,
    /// Why the exploration ended, and when it did, s.
    pub(super) ended: Option<(Why, f32)>,
}

/// The time for which the head is sent forward at most, s: for each relay the time that it needs to
/// come, and as much again for the way.
pub(super) fn explores_s(scenario: &Scenario, depth_m: f32) -> f32 {
    let relays = scenario.drones.relays as f32;
    (relays + 2.0) * (comes_s(scenario, depth_m) + PATIENCE_S)
}

/// The time that a chain is given to come home, s.
pub(super) fn home_s(scenario: &Scenario, depth_m: f32) -> f32 {
    let way_s = depth_m / scenario.agent.flight.return_speed.0;
    1.6 * way_s + 40.0 + 6.0 * scenario.drones.relays as f32
}

/// The time that a relay needs to come to a head at this distance, s.
fn comes_s(scenario: &Scenario, way_m: f32) -> f32 {
    scenario.call_s() + CALLED_S + way_m / scenario.agent.flight.return_speed.0
}

impl<'a> Pilot<'a> {
    pub(super) fn of(scenario: &'a Scenario) -> Self {
        let depth_m = scenario.depth_m.unwrap_or(f32::INFINITY);
        let ends_s = scenario.hold().map_or(f32::INFINITY, |hold| 1e-6 * hold.from_us as f32);
        let phase = Phase::Out { best_m: 0.0, since_s: 0.0 };
        Self { scenario, depth_m, ends_s, phase, ended: None }
    }

    /// For how long it holds the head after the exploration, µs.
    pub(super) fn holds_us(&self) -> u64 {
        let holds = matches!(self.phase, Phase::Holds { .. });
        if holds { (1e6 * HOLDS_S) as u64 } else { 0 }
    }

    /// Looks at the mission between two rounds and steers it; says whether the mission is over.
    pub(super) fn steer(&mut self, mission: &mut Mission<'_>) -> bool {
        let now_s = (mission.time_us() as f64 * 1e-6) as f32;
        match self.phase {
            Phase::Out { best_m, since_s } => self.out(mission, now_s, best_m, since_s),
            Phase::Holds { since_s } if now_s - since_s >= HOLDS_S => {
                mission.steer(Order::Return);
                self.phase = Phase::Home { since_s: now_s, down_s: None };
            }
            Phase::Holds { .. } => {}
            Phase::Home { since_s, down_s } => {
                let is_down = !mission.states().any(|state| state.is_airborne());
                let down_s = is_down.then(|| down_s.unwrap_or(now_s));
                self.phase = Phase::Home { since_s, down_s };
                return down_s.is_some_and(|down| now_s - down >= DOWN_S)
                    || now_s - since_s >= home_s(self.scenario, self.depth_m);
            }
        }
        false
    }

    fn out(&mut self, mission: &mut Mission<'_>, now_s: f32, best_m: f32, since_s: f32) {
        let told = mission.told(usize::from(NodeId::HEAD.0));
        let odometer_m = told.map_or(0.0, |told| told.telemetry.odometer.0);
        let way_m = self.scenario.drones.row_m() + odometer_m;
        let (best_m, since_s) =
            if way_m > best_m + ON_M { (way_m, now_s) } else { (best_m, since_s) };
        self.phase = Phase::Out { best_m, since_s };
        let patience_s = comes_s(self.scenario, best_m) + PATIENCE_S;
        let why = if mission.is_recalled() {
            Why::Battery
        } else if way_m >= self.depth_m {
            Why::There
        } else if now_s - since_s > patience_s {
            Why::Stood
        } else if now_s >= self.ends_s {
            Why::Time
        } else {
            return;
        };
        self.ended = Some((why, now_s));
        if why == Why::Battery {
            mission.steer(Order::Return);
            self.phase = Phase::Home { since_s: now_s, down_s: None };
        } else {
            mission.steer(Order::Explore(Course { speed: MetresPerSecond::ZERO, branch: None }));
            self.phase = Phase::Holds { since_s: now_s };
        }
    }
}
