//! Runs a mission whose orders come from clients, with the same metrics and the same trace as any
//! other.

use core::f32::consts::FRAC_PI_4;

use bridge::Polled;
use crtp::{Ranges, Snapshot};
use input::InputError;
use onboard::State;
use tunnel_nav::{Diagonals, Range};
use units::{Acceleration, AngularVelocity, Instant, Metres, NodeId, Order, Radians, Role};
use wire::crtp::Packet;

use super::{STEP, World, clients};
use bodies::craft::Craft;
use bodies::emulated::Emulated;
use measure::metrics::{Reference, RunMetrics, Watch};
use mission::trace::{Frame, Node, Thinning, Trace};
use mission::{Mission, ROUND_US, View};
use report::{Folder, OutputError, TraceFiles};
use scenario::Scenario;

/// A mission whose orders come from the clients that connect.
pub struct Live<'a> {
    mission: Mission<'a>,
    watch: Watch<'a>,
    trace: Trace,
    thinning: Thinning,
    keep: bool,
    files: Option<(Folder, TraceFiles)>,
    /// Why the files, or the companion, take no more.
    unwritten: Option<InputError>,
    reach: Metres,
    /// For each member the packets of its client; `None` for members on the host, whose server
    /// answers at once, and before the first packet of a client.
    polled: Vec<Option<Polled>>,
    companion: Option<Box<dyn Companion + Send + 'a>>,
}

/// Another program beside the clients, which is shown a served mission and asks the base for something.
pub trait Companion {
    /// Shows a frame of the mission.
    ///
    /// # Errors
    /// If the companion cannot go on: the mission ends.
    fn show(&mut self, trace: &Trace, frame: &Frame) -> Result<(), InputError>;

    /// The packets for the base that have come since the last call.
    fn asks(&mut self) -> Vec<Packet>;

    /// How many messages it could not pass on.
    fn lost(&self) -> u64;
}

impl<'a> Live<'a> {
    /// All drones at their places; with `keep` the record is kept, thinned where the mission is long.
    #[must_use]
    pub fn new(
        scenario: &'a Scenario,
        world: &'a world::World,
        reference: &'a Reference,
        seed: u64,
        keep: bool,
    ) -> Self {
        let mission = Mission::served(scenario, world, seed);
        Self::of(mission, scenario, world, reference, seed, keep)
    }

    /// Makes a mission as [`new`](Self::new) does, with emulated drones in it.
    #[must_use]
    pub fn emulated(
        scenario: &'a Scenario,
        world: &'a world::World,
        reference: &'a Reference,
        seed: u64,
        keep: bool,
        drones: Vec<Emulated>,
    ) -> Self {
        let mission = Mission::emulated(scenario, world, seed, drones).for_clients();
        Self::of(mission, scenario, world, reference, seed, keep)
    }

    fn of(
        mission: Mission<'a>,
        scenario: &'a Scenario,
        world: &'a world::World,
        reference: &'a Reference,
        seed: u64,
        keep: bool,
    ) -> Self {
        Self {
            reach: Metres(scenario.vehicle.reach),
            watch: Watch::new(scenario, world, reference),
            trace: mission.begin_trace(seed),
            polled: (0..mission.count()).map(|_| None).collect(),
            companion: None,
            mission,
            thinning: Thinning::default(),
            keep,
            files: None,
            unwritten: None,
        }
    }

    /// Keeps the record, and writes each frame of it into a folder when it is flown. A mission whose
    /// files cannot be written goes no further.
    ///
    /// # Errors
    /// If the files cannot be begun.
    pub fn with_files(mut self, folder: Folder) -> Result<Self, OutputError> {
        let files = TraceFiles::begin(&folder, &self.trace)?;
        (self.files, self.keep) = (Some((folder, files)), true);
        Ok(self)
    }

    /// Shows each frame of the mission to a companion, and lets it ask the base.
    #[must_use]
    pub fn with_companion(mut self, companion: Box<dyn Companion + Send + 'a>) -> Self {
        self.companion = Some(companion);
        self
    }

    /// How many messages the companion could not pass on; `None` where there is no companion.
    #[must_use]
    pub fn lost(&self) -> Option<u64> {
        self.companion.as_ref().map(|companion| companion.lost())
    }

    /// Hands over the folder with the files that are to be finished, if there is one.
    ///
    /// # Errors
    /// If a frame could not be written.
    pub fn take_files(&mut self) -> Result<Option<(Folder, TraceFiles)>, InputError> {
        self.unwritten.take().map_or_else(|| Ok(self.files.take()), Err)
    }

    /// The mission, for the accounts of its emulated drones.
    #[must_use]
    pub const fn mission(&self) -> &Mission<'a> {
        &self.mission
    }

    /// Microseconds since the start.
    #[must_use]
    pub const fn time_us(&self) -> u64 {
        self.mission.time_us()
    }

    /// The metrics of the mission.
    #[must_use]
    pub fn metrics(&self) -> RunMetrics {
        self.watch.verdict(&self.mission)
    }

    /// The record, thinned where the mission is long; without frames where they are not kept.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// The state of each member, head first, base last.
    pub fn states(&self) -> impl Iterator<Item = (NodeId, State)> {
        (0..).map(NodeId).zip(self.mission.states())
    }
}

impl Live<'_> {
    /// Shows the present state of the mission to the companion, and takes it into the record where one is kept.
    fn note(&mut self) {
        let frame = self.mission.frame();
        if let Some(companion) = &mut self.companion
            && let Err(error) = companion.show(&self.trace, &frame)
        {
            self.unwritten.get_or_insert(error);
        }
        if !self.keep {
            return;
        }
        if let Some((folder, files)) = &mut self.files
            && let Err(error) = files.frame(folder, &self.trace, &frame)
        {
            self.unwritten.get_or_insert(error);
        }
        self.trace.team_map.look(&self.mission);
        self.thinning.add(&mut self.trace.frames, frame);
    }

    /// Lets the Crazyradios of clients exchange a packet each with their drones.
    fn poll_emulated(&mut self) {
        for (member, polled) in self.polled.iter_mut().enumerate() {
            let Some(polled) = polled else { continue };
            let take = |answer: &[u8]| polled.acknowledged(answer);
            self.mission.poll_client(member, &Snapshot::DEFAULT, take);
            self.mission.client(member, polled.next_packet());
        }
    }

    /// The values of a drone's body for clients.
    fn measured(&self, member: usize) -> Snapshot {
        let Some(view) = self.mission.view(member) else { return Snapshot::DEFAULT };
        match view.body.craft() {
            Some(craft) => {
                let mut snapshot = onboard::observed(&craft.outputs().status);
                look_at_craft(&mut snapshot, craft, self.reach);
                snapshot
            }
            None => {
                let mut snapshot = Snapshot::DEFAULT;
                look_at_point(&mut snapshot, &view);
                snapshot
            }
        }
    }
}

/// Adds the values of a craft that the flight code's status does not have.
fn look_at_craft(snapshot: &mut Snapshot, craft: &Craft, reach: Metres) {
    snapshot.duties = craft.outputs().duties;
    snapshot.gyro = AngularVelocity(craft.body().rates());
    snapshot.accel = Acceleration(craft.body().specific_force());
    snapshot.ranges = ranges(&craft.sides().diagonals(reach), snapshot.height);
}

/// Adds the values of a point on the floor plan: it is always level, with the board's front an
/// eighth of a turn to the left of its nose, as it is mounted.
fn look_at_point(snapshot: &mut Snapshot, view: &View<'_>) {
    if view.role == Role::Base {
        return;
    }
    snapshot.attitude.yaw = Radians(view.body.yaw() + FRAC_PI_4);
    snapshot.accel = Acceleration([0.0, 0.0, flight::GRAVITY]);
    snapshot.velocity = view.senses.velocity;
    snapshot.height = Some(Metres(view.body.height()));
    snapshot.ranges = ranges(&view.senses.ranges, snapshot.height);
}

/// The ranges by the directions of the beams from the board (see [`onboard::mounting`]).
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
        let asked = self.companion.as_mut().map(|companion| companion.asks());
        let base = self.mission.count().saturating_sub(1);
        asked.iter().flatten().for_each(|packet| self.client(base, packet.bytes()));
        self.poll_emulated();
        self.mission.advance(STEP.as_micros());
        if self.time_us().is_multiple_of(ROUND_US) {
            self.watch.look(&self.mission);
            if self.keep || self.companion.is_some() {
                self.note();
            }
        }
    }

    fn nodes(&self) -> Vec<Node> {
        self.trace.nodes.clone()
    }

    fn state(&self, member: usize) -> Option<State> {
        self.mission.states().nth(member)
    }

    fn client(&mut self, member: usize, packet: &[u8]) {
        if self.mission.emulated_drone(member).is_none() {
            self.mission.client(member, packet);
        } else if let Some(polled) = self.polled.get_mut(member) {
            polled.get_or_insert_default().give(packet);
        }
    }

    fn poll_client(&mut self, member: usize, take: &mut dyn FnMut(&[u8])) {
        if let Some(Some(polled)) = self.polled.get_mut(member) {
            return polled.take_received().iter().for_each(|packet| take(packet));
        }
        let measured = self.measured(member);
        self.mission.poll_client(member, &measured, take);
    }

    fn most_clients(&self, member: usize) -> usize {
        if self.mission.emulated_drone(member).is_none() { clients::MOST } else { 1 }
    }

    fn is_halted(&self) -> bool {
        self.mission.halted().is_some() || self.unwritten.is_some()
    }

    fn ordered(&self) -> Option<Order> {
        self.mission.clients_order()
    }
}
