//! A mission as a world to be served, with the same figures and the same record as any other.

use core::f32::consts::FRAC_PI_4;

use agent::State;
use airlink::{Counters, Refused, Standing};
use crtp::{About, Link, LinkState, Node, Parameters, Ranges, Snapshot};
use tunnel_nav::{Diagonals, Range};
use units::{Acceleration, AngularVelocity, Dbm, Instant, Metres, NodeId, Order, Radians, Role};

use super::{STEP, World};
use crate::craft::Craft;
use crate::metrics::{Reference, RunMetrics, Watch};
use crate::mission::{self, Mission, ROUND_US, View};
use crate::scenario::Scenario;
use crate::trace::Trace;

/// A mission that is flown by whoever connects.
pub struct Live<'a> {
    mission: Mission<'a>,
    watch: Watch<'a>,
    trace: Trace,
    keep: bool,
    orders: Vec<Orders>,
    height: Metres,
    /// At which a relay is launched, and at which a drone turns back.
    limits: [Dbm; 2],
    reach: Metres,
}

/// Orders that came in at a drone: its link says only which was the last.
#[derive(Clone, Copy, Default)]
struct Orders {
    last: u16,
    count: u32,
}

impl Orders {
    fn look(&mut self, last: u16) {
        self.count += u32::from(last != self.last);
        self.last = last;
    }
}

impl<'a> Live<'a> {
    /// Everybody at their places; `keep` for a trace of it all.
    #[must_use]
    pub fn new(
        scenario: &'a Scenario,
        world: &'a mission::World,
        reference: &'a Reference,
        seed: u64,
        keep: bool,
    ) -> Self {
        let mission = Mission::live(scenario, world, seed);
        let trace = mission.begin_trace(seed);
        Self {
            orders: vec![Orders::default(); mission.count()],
            height: scenario.agent.flight.height,
            limits: [scenario.agent.launch.limit, scenario.agent.retreat.limit],
            reach: Metres(scenario.vehicle.reach),
            watch: Watch::new(scenario, world, reference),
            mission,
            trace,
            keep,
        }
    }

    /// Microseconds since the start.
    #[must_use]
    pub const fn time_us(&self) -> u64 {
        self.mission.time_us()
    }

    /// How good it was.
    #[must_use]
    pub fn metrics(&self) -> RunMetrics {
        self.watch.verdict(&self.mission)
    }

    /// What was, round by round; without frames where they were not to be kept.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// What everybody is doing, head first, base last.
    pub fn states(&self) -> impl Iterator<Item = (NodeId, State)> {
        (0..).map(NodeId).zip(self.mission.states())
    }
}

impl Live<'_> {
    fn link(&self, member: usize, view: &View<'_>) -> Link {
        let Some((status, counters)) = view.link else { return Link::SILENT };
        let Counters { taken, refused, sent, .. } = counters;
        Link {
            state: match status.standing {
                Standing::Listening => LinkState::Listening,
                Standing::Member => LinkState::Member,
                Standing::Refused => LinkState::Refused,
                Standing::Left => LinkState::Off,
                Standing::Exhausted => LinkState::Exhausted,
            },
            accepted: taken.total(),
            refused: total(&refused),
            sent: sent.total(),
            orders: self.orders.get(member).map_or(0, |orders| orders.count),
        }
    }
}

/// The counts of a link wrap.
fn total(refused: &Refused) -> u32 {
    let Refused { malformed, no_slot, tag, own, twin, replayed, stale, body, forged, outdated } =
        *refused;
    [malformed, no_slot, tag, own, twin, replayed, stale, body, forged, outdated]
        .into_iter()
        .fold(0, u32::wrapping_add)
}

/// What a craft's flight code and its body have, beside what the flight code says itself.
fn look_at_craft(snapshot: &mut Snapshot, craft: &Craft, reach: Metres) {
    snapshot.duties = craft.outputs().duties;
    snapshot.gyro = AngularVelocity(craft.body().rates());
    snapshot.accel = Acceleration(craft.body().specific_force());
    snapshot.ranges = ranges(&craft.diagonals(reach), snapshot.height);
}

/// What there is of a point on the floor plan: it is always level, with the board's front an
/// eighth of a turn to the left of its nose, as it is mounted.
fn look_at_point(snapshot: &mut Snapshot, view: &View<'_>) {
    if view.role == units::Role::Base {
        return;
    }
    snapshot.attitude.yaw = Radians(view.body.yaw() + FRAC_PI_4);
    snapshot.accel = Acceleration([0.0, 0.0, flight::GRAVITY]);
    snapshot.velocity = view.senses.velocity;
    snapshot.height = Some(Metres(view.body.height()));
    snapshot.ranges = ranges(&view.senses.ranges, snapshot.height);
}

/// By where the beams look from the board (see [`agent::mounting`]).
fn ranges(beams: &Diagonals, height: Option<Metres>) -> Ranges {
    let seen = |range| match range {
        Range::At(distance) => Some(distance),
        Range::Clear | Range::Invalid => None,
    };
    Ranges {
        front: seen(beams.nw),
        right: seen(beams.ne),
        back: seen(beams.se),
        left: seen(beams.sw),
        up: None,
        down: height,
    }
}

impl World for Live<'_> {
    fn now(&self) -> Instant {
        Instant::from_micros(self.time_us())
    }

    fn advance(&mut self) {
        self.mission.advance(STEP.as_micros());
        for (member, orders) in self.orders.iter_mut().enumerate() {
            orders.look(self.mission.view(member).map_or(0, |view| view.heeded));
        }
        if self.time_us().is_multiple_of(ROUND_US) {
            self.watch.look(&self.mission);
            if self.keep {
                self.trace.frames.push(self.mission.frame());
            }
        }
    }

    fn members(&self) -> usize {
        self.mission.count()
    }

    fn state(&self, member: usize) -> Option<State> {
        self.mission.states().nth(member)
    }

    fn parameters(&self, member: usize) -> Parameters {
        let view = self.mission.view(member);
        let role = view.map_or(Role::Relay, |view| view.role);
        let flies = role != Role::Base;
        Parameters {
            height: self.height,
            launch_limit: self.limits[0],
            retreat_limit: self.limits[1],
            about: About {
                node: NodeId(member as u8),
                role,
                has_flow: flies,
                has_rangers: flies,
                ..Parameters::DEFAULT.about
            },
            ..Parameters::DEFAULT
        }
    }

    fn snapshot(&self, member: usize) -> Snapshot {
        let Some(view) = self.mission.view(member) else { return Snapshot::DEFAULT };
        let craft = view.body.craft();
        let status = craft.map(|craft| &craft.outputs().status);
        let mut snapshot = Snapshot {
            link: self.link(member, &view),
            ..Snapshot::of(self.now(), view.outputs, status)
        };
        match craft {
            Some(craft) => look_at_craft(&mut snapshot, craft, self.reach),
            None => look_at_point(&mut snapshot, &view),
        }
        if view.role == units::Role::Base {
            for (n, node) in snapshot.nodes.iter_mut().enumerate() {
                *node = self.mission.told(n).map(|told| Node {
                    telemetry: told.telemetry,
                    heard: Instant::from_micros(told.at_us),
                });
            }
        }
        snapshot
    }

    fn order(&mut self, task: Order) {
        self.mission.order(task);
    }
}
