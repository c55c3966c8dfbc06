//! Who answers what.

use heapless::Deque;
use units::{Instant, Metres, MetresPerSecond, RadiansPerSecond};
use wire::crtp::{
    self, Errno, HighLevel, LinkRequest, LogRequest, MAX_DATA, MemoryRequest, Packet, ParamRequest,
    ParamType, PlatformRequest, Reply, Request, Rpyt, SupervisorCommand, SupervisorQuestion, Value,
};

use crate::blocks::{self, Blocks};
use crate::console::Console;
use crate::parameters::{self, Parameter, ParameterId};
use crate::{Parameters, Snapshot, variables};

/// Answers that can wait. A client asks for one thing at a time, from a few of its threads.
const WAITING: usize = 16;

/// What this drone is to a client: the board (crazyflie-firmware, `platform_cf2.c`).
const DEVICE_TYPE: &str = "CF21";
/// And what runs on it.
const FIRMWARE: &str = concat!("uchain ", env!("CARGO_PKG_VERSION"));

/// What a client may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Access {
    /// Look, set and fly.
    Full,
    /// Look.
    Read,
}

/// What a client wants of the rest of the drone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// Fly like this, now.
    Setpoint(Setpoint),
    /// Motors off, until the next boot.
    EmergencyStop,
    /// Motors off, unless this comes again within a second.
    EmergencyStopWatchdog,
    /// Arm, or disarm.
    Arm(bool),
    /// Land.
    Land,
    /// Take off.
    TakeOff,
    /// A parameter was set.
    ParameterSet(ParameterId),
}

/// A set-point that is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Setpoint {
    /// The end of a flight.
    Stop,
    /// A height, and velocities along the nose and to its left.
    Hover {
        /// Along the nose.
        forward: MetresPerSecond,
        /// To its left.
        lateral: MetresPerSecond,
        /// Counter-clockwise.
        yaw_rate: RadiansPerSecond,
        /// Over ground.
        height: Metres,
    },
}

/// What happened to packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Came in.
    pub received: u32,
    /// Were none, or asked for nothing that there is.
    pub malformed: u32,
    /// Wanted what the client may not, or a value that cannot be.
    pub refused: u32,
    /// Wanted a kind of flying that this drone does not know.
    pub unsupported: u32,
    /// Were not answered, because too many answers waited.
    pub overrun: u32,
    /// Went out.
    pub sent: u32,
    /// Log blocks that were not sent, because the line was too slow.
    pub missed: u32,
    /// Lines for the console that there was no room for.
    pub unsaid: u32,
}

/// What a client is told once, so that it does not wonder.
#[derive(Clone, Copy)]
enum Notice {
    MayOnlyLook = 1,
    UnknownSetpoint = 2,
    UnknownHighLevel = 4,
    OutOfRange = 8,
    NoSuchService = 16,
}

impl Notice {
    const fn text(self) -> &'static str {
        match self {
            Self::MayOnlyLook => "Refused: over this link one may look, not set or fly.",
            Self::UnknownSetpoint => "Refused: only hover and stop set-points are flown.",
            Self::UnknownHighLevel => {
                "Refused: of high-level commands only take-off, land and stop."
            }
            Self::OutOfRange => "Refused: a parameter is read-only, or the value out of its range.",
            Self::NoSuchService => "Refused: this drone does not do that.",
        }
    }
}

/// An answer on its way.
#[derive(Clone, Copy, Debug)]
enum Waiting {
    Ready(Packet),
    /// A value, as it is when it is sent, to who asked for it
    Read(u16),
    /// or wanted to change it.
    Written(u16),
    /// What the supervisor sees when it is sent.
    Supervisor(SupervisorQuestion),
    /// What became of a command when that is sent.
    Commanded(SupervisorCommand, bool),
}

/// What answers a client. It keeps nothing of one client that could mislead the next: log blocks
/// go when the next one connects.
#[derive(Debug)]
pub struct Server {
    blocks: Blocks,
    waiting: Deque<Waiting, WAITING>,
    console: Console,
    /// The notices that were given.
    given: u8,
    counters: Counters,
}

impl Default for Server {
    fn default() -> Self {
        Self::new()
    }
}

impl Server {
    /// Before anybody has asked anything.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            blocks: Blocks::new(),
            waiting: Deque::new(),
            console: Console::new(),
            given: 0,
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

    /// Takes in a packet: header and data, as it came from the line. Any bytes may.
    pub fn receive(
        &mut self,
        now: Instant,
        packet: &[u8],
        access: Access,
        parameters: &mut Parameters,
    ) -> Option<Event> {
        count(&mut self.counters.received);
        let Ok(packet) = Packet::from_bytes(packet) else {
            count(&mut self.counters.malformed);
            return None;
        };
        let request = match Request::parse(&packet) {
            Ok(request) => request,
            Err(_) => {
                count(&mut self.counters.malformed);
                return None;
            }
        };
        // What cannot be answered is not done either, so that what is not answered can be asked
        // again. What needs no answer is never kept waiting.
        if is_answered(&request) && self.waiting.is_full() {
            count(&mut self.counters.overrun);
            return None;
        }
        match request {
            Request::Null | Request::SetpointsEnd(_) | Request::Link(LinkRequest::Sink) => None,
            Request::Log(request) => {
                self.log(now, request);
                None
            }
            Request::Param(request) => self.param(request, access, parameters),
            Request::Memory(request) => {
                self.answer(&memory(request));
                None
            }
            Request::Link(LinkRequest::Echo(_)) => {
                self.wait(Waiting::Ready(packet));
                None
            }
            Request::Link(LinkRequest::Source) => {
                self.answer(&Reply::Source);
                None
            }
            Request::Platform(request) => {
                self.platform(request, packet);
                None
            }
            Request::Supervisor(question) => {
                self.wait(Waiting::Supervisor(question));
                None
            }
            Request::Command(command) => self.command(command, access),
            Request::OldCommand(command) => {
                if packet.port() == Ok(crtp::Port::Platform) {
                    self.wait(Waiting::Ready(packet));
                }
                self.allow(access).then(|| event_of(command)).flatten()
            }
            Request::Setpoint(setpoint) => self.setpoint(setpoint, access),
            Request::Rpyt(setpoint) => self.rpyt(setpoint, access),
            Request::HighLevel(command) => self.high_level(command, packet, access),
        }
    }

    /// The packet that is sent next: answers first, then text, then the log block that has been
    /// due for longest.
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

    /// When the next log block is due.
    #[must_use]
    pub fn due(&self) -> Option<Instant> {
        self.blocks.due()
    }

    /// A line for the console. When too many wait, it is lost.
    pub fn say(&mut self, line: &str) {
        if !self.console.say(line) {
            count(&mut self.counters.unsaid);
        }
    }

    /// What happened so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    fn next_answer(&mut self, snapshot: &Snapshot, parameters: &Parameters) -> Option<Packet> {
        let state = snapshot.supervisor();
        let is = |bit: u16| state >> bit & 1 == 1;
        let value = |id| parameters::row(id).map(|row| row.value(parameters)).ok_or(Errno::Missing);
        Some(match self.waiting.pop_front()? {
            Waiting::Ready(packet) => packet,
            Waiting::Read(id) => Reply::ParamRead { id, value: value(id) }.packet(),
            Waiting::Written(id) => Reply::ParamWritten { id, value: value(id) }.packet(),
            Waiting::Supervisor(question) => Reply::Supervisor { question, state }.packet(),
            Waiting::Commanded(command, allowed) => {
                // Nobody arms these drones: a request to arm has come true when it would fly.
                let (armed, crashed) = (is(1), is(7));
                let (done, holds) = match command {
                    SupervisorCommand::Arm(true) => (allowed && armed, armed),
                    SupervisorCommand::Arm(false) => (allowed, armed),
                    SupervisorCommand::Recover => (allowed && !crashed, !crashed),
                    _ => (allowed, false),
                };
                Reply::Commanded { command, done, holds }.packet()
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

    fn notice(&mut self, notice: Notice) {
        let bit = notice as u8;
        if self.given & bit == 0 {
            self.given |= bit;
            self.say(notice.text());
        }
    }

    fn allow(&mut self, access: Access) -> bool {
        match access {
            Access::Full => true,
            Access::Read => {
                count(&mut self.counters.refused);
                self.notice(Notice::MayOnlyLook);
                false
            }
        }
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

    fn param(
        &mut self,
        request: ParamRequest<'_>,
        access: Access,
        parameters: &mut Parameters,
    ) -> Option<Event> {
        let missing = Err(Errno::Missing);
        let reply = match request {
            ParamRequest::TableInfo => {
                Reply::ParamTable { count: parameters::COUNT, crc: parameters::CRC }
            }
            ParamRequest::TableItem(id) => parameters::row(id).map_or(Reply::NoParam, |row| {
                let (kind, group, name) = (row.kind(), row.group, row.name);
                Reply::Param { id, kind, read_only: row.is_read_only(), group, name }
            }),
            ParamRequest::Read(id) => {
                self.wait(Waiting::Read(id));
                return None;
            }
            ParamRequest::Write { id, value } => return self.write(id, value, access, parameters),
            ParamRequest::SetByName { group, name, kind, value } => {
                let outcome = self.set_by_name(group, name, kind, value, access, parameters);
                self.answer(&Reply::ParamSetByName { group, name, outcome: outcome.map(|_| ()) });
                return outcome.ok().map(Event::ParameterSet);
            }
            // Nothing can be kept: what a drone remembers is written by other tools.
            ParamRequest::ExtendedType { id, with_status } => {
                Reply::ParamNotExtended { id, with_status }
            }
            ParamRequest::Store(id) => Reply::ParamNotKept { command: 3, id },
            ParamRequest::StoredState(id) => Reply::ParamNotKept { command: 4, id },
            ParamRequest::Clear(id) => Reply::ParamNotKept { command: 5, id },
            ParamRequest::Default { id, with_status } => {
                let row = parameters::row(id).filter(|row| !row.is_read_only());
                let value = row.map_or(missing, |row| Ok(row.value(&Parameters::DEFAULT)));
                Reply::ParamDefault { id, value, with_status }
            }
        };
        self.answer(&reply);
        None
    }

    /// Whatever becomes of it, the answer is the value that holds afterwards: clients take what
    /// they get for that value, and wait until they get one.
    fn write(
        &mut self,
        id: u16,
        value: &[u8],
        access: Access,
        parameters: &mut Parameters,
    ) -> Option<Event> {
        self.wait(Waiting::Written(id));
        let Some(row) = parameters::row(id) else {
            count(&mut self.counters.refused);
            return None;
        };
        let done = self.set(row, row.kind().read(value), access, parameters).is_ok();
        done.then_some(Event::ParameterSet(ParameterId::new(id)))
    }

    fn set_by_name(
        &mut self,
        group: &[u8],
        name: &[u8],
        kind: u8,
        value: &[u8],
        access: Access,
        parameters: &mut Parameters,
    ) -> Result<ParameterId, Errno> {
        let Some((id, row)) = parameters::named(group, name) else {
            count(&mut self.counters.refused);
            return Err(Errno::Missing);
        };
        let value = ParamType::from_code(kind)
            .filter(|kind| *kind == row.kind())
            .and_then(|kind| kind.read(value));
        self.set(row, value, access, parameters)?;
        Ok(id)
    }

    fn set(
        &mut self,
        row: &Parameter,
        value: Option<Value>,
        access: Access,
        parameters: &mut Parameters,
    ) -> Result<(), Errno> {
        let outcome = match value {
            None => Err(Errno::Invalid),
            Some(_) if row.is_read_only() => Err(Errno::NotAllowed),
            Some(_) if !self.allow(access) => return Err(Errno::NotAllowed),
            Some(value) if row.set(parameters, value) => return Ok(()),
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

    fn command(&mut self, command: SupervisorCommand, access: Access) -> Option<Event> {
        let allowed = self.allow(access);
        self.wait(Waiting::Commanded(command, allowed));
        allowed.then(|| event_of(command)).flatten()
    }

    fn setpoint(&mut self, setpoint: crtp::Setpoint, access: Access) -> Option<Event> {
        if !self.allow(access) {
            return None;
        }
        match setpoint {
            crtp::Setpoint::Stop => Some(Event::Setpoint(Setpoint::Stop)),
            crtp::Setpoint::Hover { forward, lateral, yaw_rate, height } => {
                Some(Event::Setpoint(Setpoint::Hover { forward, lateral, yaw_rate, height }))
            }
            // There is neither a room to have axes, nor anyone to hold angles against the walls.
            crtp::Setpoint::Velocity { .. }
            | crtp::Setpoint::Height { .. }
            | crtp::Setpoint::Position { .. }
            | crtp::Setpoint::Other(_) => {
                self.unsupported(Notice::UnknownSetpoint);
                None
            }
        }
    }

    /// A client sends zeros while nobody touches its gamepad, and when it goes: they end nothing.
    fn rpyt(&mut self, setpoint: Rpyt, access: Access) -> Option<Event> {
        if !setpoint.is_off() && self.allow(access) {
            self.unsupported(Notice::UnknownSetpoint);
        }
        None
    }

    fn high_level(&mut self, command: HighLevel, packet: Packet, access: Access) -> Option<Event> {
        // A drone belongs to no group but that of all.
        const ALL: u8 = 0;
        let (event, outcome) = match command {
            HighLevel::Other(0) => (None, Ok(())),
            _ if !self.allow(access) => (None, Err(Errno::NotAllowed)),
            HighLevel::TakeOff { group: ALL } => (Some(Event::TakeOff), Ok(())),
            HighLevel::Land { group: ALL } => (Some(Event::Land), Ok(())),
            HighLevel::Stop { group: ALL } => (Some(Event::Setpoint(Setpoint::Stop)), Ok(())),
            HighLevel::TakeOff { .. } | HighLevel::Land { .. } | HighLevel::Stop { .. } => {
                (None, Ok(()))
            }
            HighLevel::Other(_) => {
                self.unsupported(Notice::UnknownHighLevel);
                (None, Err(Errno::NoCommand))
            }
        };
        let mut head = [0; 3];
        for (place, byte) in head.iter_mut().zip(packet.data()) {
            *place = *byte;
        }
        self.answer(&Reply::HighLevel { head, outcome });
        event
    }
}

/// Whether a client may wait for an answer to it. Set-points and everything that stops a drone are
/// followed however many answers wait.
const fn is_answered(request: &Request<'_>) -> bool {
    match request {
        Request::Null
        | Request::Rpyt(_)
        | Request::Setpoint(_)
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

const fn event_of(command: SupervisorCommand) -> Option<Event> {
    match command {
        SupervisorCommand::Arm(arm) => Some(Event::Arm(arm)),
        SupervisorCommand::Recover => None,
        SupervisorCommand::EmergencyStop => Some(Event::EmergencyStop),
        SupervisorCommand::EmergencyStopWatchdog => Some(Event::EmergencyStopWatchdog),
    }
}

/// A drone has no memories that it would show.
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
