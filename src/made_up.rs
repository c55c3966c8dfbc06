//! Made-up inputs: a short script that walks the agent through a mission and begins again.
//!
//! The drone lies on a desk. So that its whole chain loop runs all the same, on the clock and the
//! processor that it will fly with, this module plays the world to it: a head, a base, four walls,
//! and a body that does at once what the set-point says. It is deterministic and knows nothing of
//! physics; missions are studied in the simulator. The sensors' drivers and the radio take its
//! place, and then it goes.
//!
//! # The script
//! | second | what happens | what the agent does |
//! |---|---|---|
//! | 0 | the base says "wait" | idle |
//! | 4 | "explore"; the head flies ahead, 8 m | armed, until the head's link is weak |
//! | about 16 | | taking off, relaying, flying to the middle |
//! | 34 | the head falls silent | reconnecting |
//! | 39 | the head is back | relaying |
//! | 45 | something shades the base | backing up |
//! | 51 | it is gone | relaying |
//! | 58 | "return"; the head is out of the mission | flying home, landing, landed |
//! | 90 | the base says "wait" | idle, and from the top |

use agent::{BodyVelocity, Inputs, Setpoint};
use chain::neighbours::Heard;
use chain::report::{Order, Phase, Report, Task};
use heapless::Vec;
use tunnel_nav::{Diagonals, Range};
use units::{Db, DbPerMetre, Dbm, Metres, MetresPerSecond, NodeId, Radians, RadiansPerSecond};

/// Rounds in a second; the agent's 5 Hz.
const RATE: u32 = 5;
/// One round in seconds.
const ROUND: f32 = 1.0 / RATE as f32;

/// The script's length in seconds.
const LAP: u32 = 92;

/// The base's number: the largest of the 16 identities of a chain.
const BASE: NodeId = NodeId(15);

/// A link at no distance, and what it loses with every metre: round numbers, from no measurement.
const NEAR: Dbm = Dbm(-40.0);
const LOSS: DbPerMetre = DbPerMetre(5.0);

/// How fast the head flies, and where it stops.
const HEAD_SPEED: MetresPerSecond = MetresPerSecond(0.4);
const HEAD_GOAL: Metres = Metres(8.0);

/// A straight tunnel of 1 m, seen from its middle: 0.5 m · √2 along each beam.
const WALLS: Range = Range::At(Metres(0.5 * core::f32::consts::SQRT_2));

/// The made-up world.
pub(crate) struct MadeUp {
    /// Rounds since the script's beginning.
    round: u32,
    /// Counts reports and orders, and goes on from lap to lap.
    sequence: u16,
    /// Where this drone is along the tunnel; the base is at zero.
    me: Metres,
    /// Where its nose points; the tunnel runs towards zero.
    heading: Radians,
    /// Where the head is.
    head: Metres,
    /// What is in the air in this round.
    heard: Vec<Heard, 2>,
}

/// What the others do.
#[derive(Clone, Copy)]
struct Scene {
    task: Task,
    head: Head,
    /// What stands between this drone and the base.
    shade: Db,
}

/// What the head does.
#[derive(Clone, Copy, PartialEq)]
enum Head {
    /// Lies at the base and waits.
    Waits,
    /// Flies.
    Flies,
    /// Is not heard.
    Silent,
    /// Has landed, out of the mission.
    Out,
}

/// The script.
fn scene(second: u32) -> Scene {
    let explore = Task::Explore(HEAD_SPEED);
    let clear = Db::ZERO;
    match second {
        0..4 => Scene { task: Task::Wait, head: Head::Waits, shade: clear },
        4..34 => Scene { task: explore, head: Head::Flies, shade: clear },
        34..39 => Scene { task: explore, head: Head::Silent, shade: clear },
        39..45 => Scene { task: explore, head: Head::Flies, shade: clear },
        45..51 => Scene { task: explore, head: Head::Flies, shade: Db(12.0) },
        51..58 => Scene { task: explore, head: Head::Flies, shade: clear },
        58..90 => Scene { task: Task::Return, head: Head::Out, shade: clear },
        _ => Scene { task: Task::Wait, head: Head::Out, shade: clear },
    }
}

impl MadeUp {
    /// Everyone at the base, at the beginning of the script.
    pub(crate) const fn new() -> Self {
        Self {
            round: 0,
            sequence: 0,
            me: Metres::ZERO,
            heading: Radians::ZERO,
            head: Metres::ZERO,
            heard: Vec::new(),
        }
    }

    /// What this drone senses and hears one round later, having flown `setpoint` meanwhile.
    pub(crate) fn inputs(&mut self, setpoint: Setpoint) -> Inputs<'_> {
        let scene = scene(self.round / RATE);
        let still = MetresPerSecond::ZERO;
        let (forward, lateral, yaw_rate, height) = match setpoint {
            Setpoint::Off => (still, still, RadiansPerSecond::ZERO, Metres::ZERO),
            Setpoint::Fly { forward, lateral, yaw_rate, height } => {
                (forward, lateral, yaw_rate, height)
            }
        };
        self.me += Metres(forward.0 * ROUND);
        self.heading += Radians(yaw_rate.0 * ROUND);
        if scene.head == Head::Flies && self.head < HEAD_GOAL {
            self.head += Metres(HEAD_SPEED.0 * ROUND);
        }
        self.speak(scene);

        self.sequence = self.sequence.wrapping_add(1);
        self.round += 1;
        if self.round >= LAP * RATE {
            *self = Self { sequence: self.sequence, ..Self::new() };
        }
        Inputs {
            ranges: Diagonals { nw: WALLS, ne: WALLS, sw: WALLS, se: WALLS },
            velocity: Some(BodyVelocity { forward, lateral }),
            heading: Some(self.heading),
            height: Some(height),
            heard: &self.heard,
            order: None,
            emergency: false,
        }
    }

    /// Fills in what is heard in this round. The two reports have room; none is lost.
    fn speak(&mut self, scene: Scene) {
        let order = Some(Order { sequence: self.sequence, task: scene.task });
        let base = self.report(BASE, Phase::Base, MetresPerSecond::ZERO, Metres::ZERO, order);
        let base = Heard { report: base, rssi: link(self.me) - scene.shade };

        let (phase, velocity) = match scene.head {
            Head::Waits => (Phase::Waiting, MetresPerSecond::ZERO),
            Head::Flies if self.head < HEAD_GOAL => (Phase::Linked, HEAD_SPEED),
            Head::Flies | Head::Silent => (Phase::Linked, MetresPerSecond::ZERO),
            Head::Out => (Phase::Out, MetresPerSecond::ZERO),
        };
        let head = self.report(NodeId::HEAD, phase, velocity, self.head, None);
        let head = Heard { report: head, rssi: link(self.head - self.me) };

        self.heard.clear();
        let _ = self.heard.push(base);
        if scene.head != Head::Silent {
            let _ = self.heard.push(head);
        }
    }

    fn report(
        &self,
        from: NodeId,
        phase: Phase,
        velocity: MetresPerSecond,
        odometer: Metres,
        order: Option<Order>,
    ) -> Report {
        Report { from, sequence: self.sequence, phase, velocity, odometer, links: None, order }
    }
}

/// The strength of a link over this distance.
fn link(distance: Metres) -> Dbm {
    NEAR - LOSS * distance.abs()
}
