//! Answers the requests of clients to the log, parameter, supervisor, … services.

use heapless::Deque;
use units::{Duration, Instant, Metres, MetresPerSecond, RadiansPerSecond, Role};
use wire::crtp::{
    self, Errno, HighLevel, LinkRequest, LogRequest, MAX_DATA, MemoryRequest, Packet, ParamRequest,
    ParamType, PlatformRequest, Reply, Request, Rpyt, SupervisorCommand, SupervisorQuestion, Value,
};

use crate::blocks::{self, Blocks};
use crate::console::Console;
use crate::parameter_table::{self as table, Parameter, ParameterId};
use crate::{Parameters, Snapshot, variables};

/// The capacity of the queue of answers. A client sends one request at a time, from a few of its
/// threads.
const WAITING: usize = 16;

/// The name of the board (crazyflie-firmware, `platform_cf2.c`).
const DEVICE_TYPE: &str = "CF21";
/// The name of the firmware.
const FIRMWARE: &str = concat!("uchain ", env!("CARGO_PKG_VERSION"));

/// The access of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Access {
    /// The client may read and set values and give orders.
    Full,
    /// The client may only read values, and stop the drone.
    Read,
}

/// A request of a client to the rest of the drone, which answers by an [`Outcome`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// The client gives a set-point for the present moment.
    Setpoint(Setpoint),
    /// The client says where the drone is.
    Position(crtp::Fix),
    /// The client stops the motors until the drone is switched off.
    EmergencyStop,
    /// The client stops the motors unless it repeats this within a second.
    EmergencyStopWatchdog,
    /// The client orders to land.
    Land,
    /// The client orders to take off.
    TakeOff,
    /// The client asks the drone to forget its position.
    ResetEstimate,
    /// A parameter was set. Where the drone refuses it, the parameter gets back its previous value.
    ParameterSet(ParameterId),
}

impl Event {
    /// Whether every client may request it, with any access: that is so for stops, and for what says
    /// where a drone is.
    const fn is_open_to_all(&self) -> bool {
        match self {
            // Positions come from a system beside the client that may give orders, and lead nowhere
            // by themselves.
            Self::EmergencyStop
            | Self::EmergencyStopWatchdog
            | Self::Position(_)
            | Self::ResetEstimate => true,
            Self::Setpoint(_) | Self::Land | Self::TakeOff | Self::ParameterSet(_) => false,
        }
    }
}

/// The result of an [`Event`], by which the client is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// The drone has followed the request.
    Done,
    /// The drone has followed the request in part, or will follow it later; the console says how.
    DoneBut(Notice),
    /// The drone has not followed the request; the console says why.
    Refused(Notice),
}

impl Outcome {
    const fn is_done(self) -> bool {
        match self {
            Self::Done | Self::DoneBut(_) => true,
            Self::Refused(_) => false,
        }
    }

    const fn notice(self) -> Option<Notice> {
        match self {
            Self::Done => None,
            Self::DoneBut(notice) | Self::Refused(notice) => Some(notice),
        }
    }
}

/// A set-point of a kind that this drone can follow.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Setpoint {
    /// The end of a flight.
    Stop,
    /// A height, and velocities along the nose and to its left.
    Hover {
        /// The velocity along the nose.
        forward: MetresPerSecond,
        /// The velocity to the left of the nose.
        lateral: MetresPerSecond,
        /// The yaw rate, counter-clockwise.
        yaw_rate: RadiansPerSecond,
        /// The height over ground.
        height: Metres,
    },
}

/// Counts of packets, by what happened to them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// The number of packets received.
    pub received: u32,
    /// The number of packets of no known format, or for a service that does not exist.
    pub malformed: u32,
    /// The number of requests without access, or with a value out of range.
    pub refused: u32,
    /// The number of set-points and commands of a kind that this drone cannot follow.
    pub unsupported: u32,
    /// The number of requests that were not answered, because too many answers waited.
    pub overrun: u32,
    /// The number of packets sent.
    pub sent: u32,
    /// The number of log blocks that were not sent, because the line was too slow.
    pub missed: u32,
    /// The number of lines for which the console had no room.
    pub unsaid: u32,
}

/// A notice on the console that a request is not followed, or is followed in another way than the
/// client may expect. It is printed once for each client; one that says why the drone does not fly
/// is printed again when the client still asks for it after ten seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Notice {
    /// The drone is not the base, and takes orders from the base alone.
    NotTheBase,
    /// The base was provisioned to take no orders from clients.
    BaseTakesNone,
    /// The drone follows no set-points of this kind.
    UnknownSetpoint,
    /// The drone knows no high-level commands of this kind.
    UnknownHighLevel,
    /// The parameter is read-only, or the value is out of its range.
    OutOfRange,
    /// The drone does not have the service.
    NoSuchService,
    /// The drone is armed whenever it is ready to fly, and cannot be disarmed.
    NeverDisarmed,
    /// The drone follows only the forward velocity of a hover set-point.
    OnlyForward,
    /// The value takes effect at the next boot.
    NextBoot,
    /// There is no movement policy of this code.
    NoSuchPolicy,
    /// The policy of a drone in the air cannot be changed.
    Airborne,
    /// A stop is valid, so no other order is followed.
    StopStands,
    /// The drone's link cannot transmit, so that no drone has received the order.
    NotHeard,
    /// The head has received the order to fly, and stays on the ground.
    HeadStands,
    /// A drone in the air goes on by its estimate.
    EstimateFlies,
    /// Packets of a neighbour come late, so that the strength of the link is only reckoned.
    Reckoned,
}

/// The time after which a notice that the drone does not fly is printed again.
const REPEATS: Duration = Duration::from_secs(10);

impl Notice {
    /// The bits of the notices that say why the drone, or the head, does not fly.
    const REPEATED: u16 = Self::NotTheBase.bit()
        | Self::BaseTakesNone.bit()
        | Self::StopStands.bit()
        | Self::NotHeard.bit()
        | Self::HeadStands.bit()
        | Self::Reckoned.bit();

    const fn bit(self) -> u16 {
        1 << self as u16
    }

    const fn text(self) -> &'static str {
        match self {
            Self::NotTheBase => {
                "Refused: this drone takes orders by the chain's radio; give them at the base."
            }
            Self::BaseTakesNone => {
                "Refused: this base was provisioned to take no orders from clients."
            }
            Self::UnknownSetpoint => "Refused: only hover and stop set-points are flown.",
            Self::UnknownHighLevel => {
                "Refused: no mission flies to a place; only take-off, land and stop are flown."
            }
            Self::OutOfRange => "Refused: a parameter is read-only, or the value out of its range.",
            Self::NoSuchService => "Refused: this drone does not do that.",
            Self::NeverDisarmed => "Not disarmed: it is armed whenever it would fly. Land or stop.",
            Self::OnlyForward => "Of a hover set-point only vx is flown: the drones steer.",
            Self::NextBoot => "Kept: it holds from the next boot on.",
            Self::NoSuchPolicy => "Refused: there is no policy of this code.",
            Self::Airborne => "Refused: a drone in the air keeps its policy.",
            Self::StopStands => "Refused: a stop stands until the base is switched off.",
            Self::NotHeard => "Refused: this drone has no open link, no drone hears the order.",
            Self::HeadStands => {
                "The head stays down: see node0.state, node0.fault. Landed, it needs uchain.task 0."
            }
            Self::EstimateFlies => "Not reset: a drone in the air goes on by its estimate.",
            Self::Reckoned => "Packets come late: links are reckoned, and the head stands.",
        }
    }
}

/// An answer that waits to be sent.
#[derive(Clone, Copy, Debug)]
enum Waiting {
    Ready(Packet),
    /// The value of a parameter at the time of sending, as the answer to a read.
    Read(u16),
    /// The value of a parameter at the time of sending, as the answer to a write.
    Written(u16),
    /// The state of the supervisor at the time of sending.
    Supervisor(SupervisorQuestion),
    /// The result of a command to the supervisor; `old` says that the command came by the port that
    /// clients used before the supervisor had one.
    Commanded {
        command: SupervisorCommand,
        done: bool,
        old: bool,
    },
}

/// Answers the packets of a client. The log blocks of one client are deleted when the next one
/// connects.
#[derive(Debug)]
pub struct Server {
    blocks: Blocks,
    waiting: Deque<Waiting, WAITING>,
    console: Console,
    /// Bit n says that the notice of that number was given.
    given: u16,
    /// When the last packet came.
    heard: Instant,
    /// When a notice that is printed again was last printed.
    repeated: Instant,
    counters: Counters,
}

impl Default for Server {
    fn default() -> Self {
        Self::new()
    }
}

impl Server {
    /// Makes a server that has received no request.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            blocks: Blocks::new(),
            waiting: Deque::new(),
            console: Console::new(),
            given: 0,
            heard: Instant::ZERO,
            repeated: Instant::ZERO,
            counters: Counters {
                received: 0,
                malformed: 0,
                refused: 0,
                unsupported: 0,
                overrun: 0,
                sent: 0,
                missed: 0,
                unsaid: 0,
            },
        }
    }

    /// Processes a packet, header and data, as received; any bytes are accepted. `act` is called
    /// once at most; it follows the client's request and returns the outcome, so that an answer
    /// "done" is always true.
    pub fn receive(
        &mut self,
        now: Instant,
        packet: &[u8],
        access: Access,
        parameters: &mut Parameters,
        act: impl FnMut(Event, &mut Parameters) -> Outcome,
    ) {
        count(&mut self.counters.received);
        self.heard = now;
        if now.since(self.repeated) >= REPEATS {
            self.given &= !Notice::REPEATED;
        }
        let Ok(packet) = Packet::from_bytes(packet) else {
            return count(&mut self.counters.malformed);
        };
        let Ok(request) = Request::parse(&packet) else {
            return count(&mut self.counters.malformed);
        };
        // A request that cannot be answered is not followed, so that the client can repeat it. One
        // that needs no answer never waits.
        if is_answered(&request) && self.waiting.is_full() {
            return count(&mut self.counters.overrun);
        }
        let mut asked = Asked { access, parameters, act };
        match request {
            Request::Null | Request::SetpointsEnd(_) | Request::Link(LinkRequest::Sink) => {}
            Request::Log(request) => self.log(now, request),
            Request::Param(request) => self.param(request, &mut asked),
            Request::Memory(request) => self.answer(&memory(request)),
            Request::Link(LinkRequest::Echo(_)) => self.wait(Waiting::Ready(packet)),
            Request::Link(LinkRequest::Source) => self.answer(&Reply::Source),
            Request::Platform(request) => self.platform(request, packet),
            Request::Supervisor(question) => self.wait(Waiting::Supervisor(question)),
            Request::Command(command) => {
                let done = self.command(command, &mut asked);
                self.wait(Waiting::Commanded { command, done, old: false });
            }
            Request::OldCommand(command) => {
                let done = self.command(command, &mut asked);
                if packet.port() == Ok(crtp::Port::Platform) {
                    self.wait(Waiting::Commanded { command, done, old: true });
                }
            }
            Request::Positions(positions) => {
                if let Some(fix) = positions.of(asked.parameters.about.node.0) {
                    // There is no answer to a position.
                    let _ = self.act(Event::Position(fix), &mut asked);
                }
            }
            Request::Setpoint(setpoint) => self.setpoint(setpoint, &mut asked),
            Request::Rpyt(setpoint) => self.rpyt(setpoint, &asked),
            Request::HighLevel(command) => self.high_level(command, packet, &mut asked),
        }
    }

    /// Returns the packet to send next: first answers, then console text, then the log block that
    /// has been due for longest.
    pub fn poll(
        &mut self,
        now: Instant,
        snapshot: &Snapshot,
        parameters: &Parameters,
    ) -> Option<Packet> {
        let packet = self
            .next_answer(snapshot, parameters)
            .or_else(|| self.next_text())
            .or_else(|| self.next_block(now, snapshot))?;
        count(&mut self.counters.sent);
        Some(packet)
    }

    /// The time at which the next log block is due.
    #[must_use]
    pub fn due(&self) -> Option<Instant> {
        self.blocks.due()
    }

    /// Prints a line on the console. When too many lines wait, the line is lost.
    pub fn say(&mut self, line: &str) {
        if !self.console.say(line) {
            count(&mut self.counters.unsaid);
        }
    }

    /// The counts of packets so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    fn next_answer(&mut self, snapshot: &Snapshot, parameters: &Parameters) -> Option<Packet> {
        let state = snapshot.supervisor();
        let is = |bit: u16| state >> bit & 1 == 1;
        let value = |id| table::row(id).map(|row| row.value(parameters)).ok_or(Errno::Missing);
        Some(match self.waiting.pop_front()? {
            Waiting::Ready(packet) => packet,
            Waiting::Read(id) => Reply::ParamRead { id, value: value(id) }.packet(),
            Waiting::Written(id) => Reply::ParamWritten { id, value: value(id) }.packet(),
            Waiting::Supervisor(question) => Reply::Supervisor { question, state }.packet(),
            Waiting::Commanded { command, done, old } => {
                let (armed, crashed) = (is(1), is(7));
                // A drone is armed whenever it would fly: a request to arm or to disarm is answered
                // with "done" when that is the drone's state, and changes nothing.
                let (done, holds) = match command {
                    SupervisorCommand::Arm(arm) => (done && armed == arm, armed),
                    SupervisorCommand::Recover => (done && !crashed, !crashed),
                    SupervisorCommand::EmergencyStop | SupervisorCommand::EmergencyStopWatchdog => {
                        (done, false)
                    }
                };
                if command == SupervisorCommand::Arm(false) && armed {
                    self.notice(Notice::NeverDisarmed);
                }
                let reply = Reply::Commanded { command, done, holds };
                if old { reply.old_packet() } else { reply.packet() }
            }
        })
    }

    fn next_text(&mut self) -> Option<Packet> {
        let mut text = [0; MAX_DATA];
        let length = self.console.next(&mut text);
        let text = text.get(..length).filter(|text| !text.is_empty())?;
        Some(Reply::Console(text).packet())
    }

    fn next_block(&mut self, now: Instant, snapshot: &Snapshot) -> Option<Packet> {
        let sent = self.blocks.poll(now, snapshot)?;
        self.counters.missed = self.counters.missed.saturating_add(sent.missed);
        Some(sent.packet)
    }

    fn wait(&mut self, answer: Waiting) {
        if self.waiting.push_back(answer).is_err() {
            count(&mut self.counters.overrun);
        }
    }

    fn answer(&mut self, reply: &Reply<'_>) {
        self.wait(Waiting::Ready(reply.packet()));
    }

    /// Prints a notice on the console, unless that was done already.
    pub fn notice(&mut self, notice: Notice) {
        if self.given & notice.bit() == 0 {
            self.given |= notice.bit();
            if notice.bit() & Notice::REPEATED != 0 {
                self.repeated = self.heard;
            }
            self.say(notice.text());
        }
    }

    fn allow<A>(&mut self, asked: &Asked<'_, A>) -> bool {
        match asked.access {
            Access::Full => true,
            Access::Read => {
                count(&mut self.counters.refused);
                self.notice(match asked.parameters.about.role {
                    Role::Base => Notice::BaseTakesNone,
                    Role::Head | Role::Relay => Notice::NotTheBase,
                });
                false
            }
        }
    }

    /// Has the drone follow a request, if the client has the access for it.
    fn act<A: Act>(&mut self, event: Event, asked: &mut Asked<'_, A>) -> Result<(), Errno> {
        if !event.is_open_to_all() && !self.allow(asked) {
            return Err(Errno::NotAllowed);
        }
        let outcome = (asked.act)(event, asked.parameters);
        if let Some(notice) = outcome.notice() {
            self.notice(notice);
        }
        if outcome.is_done() {
            return Ok(());
        }
        count(&mut self.counters.refused);
        Err(Errno::NotAllowed)
    }

    fn unsupported(&mut self, notice: Notice) {
        count(&mut self.counters.unsupported);
        self.notice(notice);
    }

    fn log(&mut self, now: Instant, request: LogRequest<'_>) {
        let (command, block, outcome) = match request {
            LogRequest::TableInfo => {
                return self.answer(&Reply::LogTable {
                    count: variables::COUNT,
                    crc: variables::CRC,
                    blocks: blocks::BLOCKS as u8,
                    entries: blocks::ENTRIES as u8,
                });
            }
            LogRequest::TableItem(id) => {
                return self.answer(&variables::row(id).map_or(Reply::NoLogVariable, |row| {
                    let (kind, group, name) = (row.kind(), row.group(), row.name());
                    Reply::LogVariable { id, kind, group, name }
                }));
            }
            LogRequest::Create { block, entries } => (6, block, self.blocks.create(block, entries)),
            LogRequest::Append { block, entries } => (7, block, self.blocks.append(block, entries)),
            LogRequest::Delete(block) => (2, block, self.blocks.delete(block)),
            LogRequest::Start { block, period, command } => {
                (command, block, self.blocks.start(block, period, now))
            }
            LogRequest::Stop(block) => (4, block, self.blocks.stop(block)),
            LogRequest::Reset => {
                // The first thing that a client does.
                self.blocks.reset();
                self.given = 0;
                (5, 0, Ok(()))
            }
            LogRequest::Unknown { command, block } => (command, block, Err(Errno::NoCommand)),
        };
        if outcome.is_err() {
            count(&mut self.counters.refused);
        }
        self.answer(&Reply::LogControl { command, block, outcome });
    }

    fn param<A: Act>(&mut self, request: ParamRequest<'_>, asked: &mut Asked<'_, A>) {
        let missing = Err(Errno::Missing);
        let reply = match request {
            ParamRequest::TableInfo => Reply::ParamTable { count: table::COUNT, crc: table::CRC },
            ParamRequest::TableItem(id) => table::row(id).map_or(Reply::NoParam, |row| {
                let (kind, group, name) = (row.kind(), row.group, row.name);
                Reply::Param { id, kind, read_only: row.is_read_only(), group, name }
            }),
            ParamRequest::Read(id) => return self.wait(Waiting::Read(id)),
            ParamRequest::Write { id, value } => return self.write(id, value, asked),
            ParamRequest::SetByName { group, name, kind, value } => {
                let outcome = self.set_by_name(group, name, kind, value, asked);
                Reply::ParamSetByName { group, name, outcome }
            }
            // Nothing can be stored: other tools write the drone's memory.
            ParamRequest::ExtendedType { id, with_status } => {
                Reply::ParamNotExtended { id, with_status }
            }
            ParamRequest::Store(id) => Reply::ParamNotKept { command: 3, id },
            ParamRequest::StoredState(id) => Reply::ParamNotKept { command: 4, id },
            ParamRequest::Clear(id) => Reply::ParamNotKept { command: 5, id },
            ParamRequest::Default { id, with_status } => {
                let row = table::row(id).filter(|row| !row.is_read_only());
                let value = row.map_or(missing, |row| Ok(row.value(&Parameters::DEFAULT)));
                Reply::ParamDefault { id, value, with_status }
            }
        };
        self.answer(&reply);
    }

    /// The answer is the value that holds afterwards, set or not: clients wait for an answer, and
    /// take it for that value.
    fn write<A: Act>(&mut self, id: u16, value: &[u8], asked: &mut Asked<'_, A>) {
        self.wait(Waiting::Written(id));
        match table::row(id) {
            Some(row) => {
                let value = row.kind().read(value);
                let _ = self.set(ParameterId::new(id), row, value, asked);
            }
            None => count(&mut self.counters.refused),
        }
    }

    fn set_by_name<A: Act>(
        &mut self,
        group: &[u8],
        name: &[u8],
        kind: u8,
        value: &[u8],
        asked: &mut Asked<'_, A>,
    ) -> Result<(), Errno> {
        let Some((id, row)) = table::named(group, name) else {
            count(&mut self.counters.refused);
            return Err(Errno::Missing);
        };
        let value = ParamType::from_code(kind)
            .filter(|kind| *kind == row.kind())
            .and_then(|kind| kind.read(value));
        self.set(id, row, value, asked)
    }

    /// Sets a parameter and has the drone follow it. Where the drone does not, the parameter is
    /// again what it was before.
    fn set<A: Act>(
        &mut self,
        id: ParameterId,
        row: &Parameter,
        value: Option<Value>,
        asked: &mut Asked<'_, A>,
    ) -> Result<(), Errno> {
        let before = *asked.parameters;
        let outcome = match value {
            None => Err(Errno::Invalid),
            Some(Value::U8(0)) if id == ParameterId::RESET_ESTIMATION => return Ok(()),
            Some(Value::U8(1)) if id == ParameterId::RESET_ESTIMATION => {
                return self.act(Event::ResetEstimate, asked);
            }
            Some(_) if row.is_read_only() => Err(Errno::NotAllowed),
            Some(_) if !self.allow(asked) => return Err(Errno::NotAllowed),
            Some(value) if row.set(asked.parameters, value) => {
                let done = self.act(Event::ParameterSet(id), asked);
                if done.is_err() {
                    *asked.parameters = before;
                }
                return done;
            }
            Some(_) => Err(Errno::Invalid),
        };
        count(&mut self.counters.refused);
        self.notice(Notice::OutOfRange);
        outcome
    }

    fn platform(&mut self, request: PlatformRequest<'_>, packet: Packet) {
        match request {
            PlatformRequest::Protocol => self.answer(&Reply::Protocol),
            PlatformRequest::Firmware => self.answer(&Reply::Firmware(FIRMWARE)),
            PlatformRequest::DeviceType => self.answer(&Reply::DeviceType(DEVICE_TYPE)),
            PlatformRequest::Notify => self.wait(Waiting::Ready(packet)),
            // A carrier without end would silence the chain.
            PlatformRequest::ContinuousWave => {
                self.wait(Waiting::Ready(packet));
                self.unsupported(Notice::NoSuchService);
            }
            PlatformRequest::Application(_) => self.unsupported(Notice::NoSuchService),
        }
    }

    /// Whether the drone has followed the command, as far as that is known before the answer is
    /// sent.
    fn command<A: Act>(&mut self, command: SupervisorCommand, asked: &mut Asked<'_, A>) -> bool {
        match command {
            SupervisorCommand::Arm(_) | SupervisorCommand::Recover => self.allow(asked),
            SupervisorCommand::EmergencyStop => self.act(Event::EmergencyStop, asked).is_ok(),
            SupervisorCommand::EmergencyStopWatchdog => {
                self.act(Event::EmergencyStopWatchdog, asked).is_ok()
            }
        }
    }

    fn setpoint<A: Act>(&mut self, setpoint: crtp::Setpoint, asked: &mut Asked<'_, A>) {
        let setpoint = match setpoint {
            crtp::Setpoint::Stop => Setpoint::Stop,
            crtp::Setpoint::Hover { forward, lateral, yaw_rate, height } => {
                Setpoint::Hover { forward, lateral, yaw_rate, height }
            }
            // A chain has no coordinate system, and a client could not hold angles between walls.
            crtp::Setpoint::Velocity { .. }
            | crtp::Setpoint::Height { .. }
            | crtp::Setpoint::Position { .. }
            | crtp::Setpoint::Other(_) => {
                if self.allow(asked) {
                    self.unsupported(Notice::UnknownSetpoint);
                }
                return;
            }
        };
        // A set-point has no answer; the console reports a refusal.
        let _ = self.act(Event::Setpoint(setpoint), asked);
    }

    /// A client sends zeros while its gamepad is not touched, and when it disconnects: they end no
    /// flight.
    fn rpyt<A>(&mut self, setpoint: Rpyt, asked: &Asked<'_, A>) {
        if !setpoint.is_off() && self.allow(asked) {
            self.unsupported(Notice::UnknownSetpoint);
        }
    }

    fn high_level<A: Act>(&mut self, command: HighLevel, packet: Packet, asked: &mut Asked<'_, A>) {
        // A drone belongs to no group but that of all.
        const ALL: u8 = 0;
        let outcome = match command {
            HighLevel::Other(0) => Ok(()),
            HighLevel::TakeOff { group: ALL } => self.act(Event::TakeOff, asked),
            HighLevel::Land { group: ALL } => self.act(Event::Land, asked),
            HighLevel::Stop { group: ALL } => self.act(Event::Setpoint(Setpoint::Stop), asked),
            _ if !self.allow(asked) => Err(Errno::NotAllowed),
            HighLevel::TakeOff { .. } | HighLevel::Land { .. } | HighLevel::Stop { .. } => Ok(()),
            HighLevel::Other(_) => {
                self.unsupported(Notice::UnknownHighLevel);
                Err(Errno::NoCommand)
            }
        };
        let mut head = [0; 3];
        for (place, byte) in head.iter_mut().zip(packet.data()) {
            *place = *byte;
        }
        self.answer(&Reply::HighLevel { head, outcome });
    }
}

/// The context of a request: the client's access, the parameters, and the function that acts on an
/// [`Event`].
struct Asked<'a, A> {
    access: Access,
    parameters: &'a mut Parameters,
    act: A,
}

/// Acts on an [`Event`].
trait Act: FnMut(Event, &mut Parameters) -> Outcome {}

impl<A: FnMut(Event, &mut Parameters) -> Outcome> Act for A {}

/// Whether a client waits for an answer to a packet. Set-points and stops are followed even when too
/// many answers wait. Not inlined: in a larger function its table of jumps is taken for a call.
#[inline(never)]
const fn is_answered(request: &Request<'_>) -> bool {
    match request {
        Request::Null
        | Request::Rpyt(_)
        | Request::Setpoint(_)
        | Request::Positions(_)
        | Request::SetpointsEnd(_)
        | Request::HighLevel(HighLevel::Land { .. } | HighLevel::Stop { .. })
        | Request::Command(
            SupervisorCommand::EmergencyStop | SupervisorCommand::EmergencyStopWatchdog,
        )
        | Request::OldCommand(
            SupervisorCommand::EmergencyStop | SupervisorCommand::EmergencyStopWatchdog,
        )
        | Request::Platform(PlatformRequest::Application(_))
        | Request::Link(LinkRequest::Sink) => false,
        Request::Param(_)
        | Request::Memory(_)
        | Request::Log(_)
        | Request::HighLevel(_)
        | Request::Supervisor(_)
        | Request::Command(_)
        | Request::OldCommand(_)
        | Request::Platform(_)
        | Request::Link(_) => true,
    }
}

/// The answer to a question about memories, of which there are none.
const fn memory(request: MemoryRequest) -> Reply<'static> {
    match request {
        MemoryRequest::Count => Reply::MemoryCount(0),
        MemoryRequest::Info(memory) => Reply::NoMemoryInfo(memory),
        MemoryRequest::Read { memory, address } => Reply::NoMemoryRead { memory, address },
        MemoryRequest::Write { memory, address } => Reply::NoMemoryWrite { memory, address },
    }
}

const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
