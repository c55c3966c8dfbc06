//! Packets from a client to a drone.

use super::{Error, HighLevel, LogRequest, Packet, ParamRequest, Port, Positions, Rpyt, Setpoint};

/// A request of a client.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Request<'a> {
    /// A packet without content, which lets the drone send one in return.
    Null,
    /// A request to the parameter service.
    Param(ParamRequest<'a>),
    /// A set-point in the oldest format.
    Rpyt(Rpyt),
    /// A request to the memory service.
    Memory(MemoryRequest),
    /// A request to the log service.
    Log(LogRequest<'a>),
    /// A set-point.
    Setpoint(Setpoint),
    /// The notice that no more set-points will come; the last one holds for this many milliseconds.
    SetpointsEnd(u32),
    /// A high-level command: take-off, landing, trajectories.
    HighLevel(HighLevel),
    /// A question to the supervisor.
    Supervisor(SupervisorQuestion),
    /// A command to the supervisor.
    Command(SupervisorCommand),
    /// A command to the supervisor from a client that is older than the supervisor's port. The
    /// answer to it is the client's own packet.
    OldCommand(SupervisorCommand),
    /// Positions from an external positioning system.
    Positions(Positions<'a>),
    /// A question or a command about the drone itself.
    Platform(PlatformRequest<'a>),
    /// A request to the link service.
    Link(LinkRequest<'a>),
}

/// A request to the memory service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MemoryRequest {
    /// The client asks for the number of memories.
    Count,
    /// The client asks for a description of this memory.
    Info(u8),
    /// The client reads from a memory.
    Read {
        /// The memory's number.
        memory: u8,
        /// The address in the memory.
        address: u32,
    },
    /// The client writes to a memory.
    Write {
        /// The memory's number.
        memory: u8,
        /// The address in the memory.
        address: u32,
    },
}

/// A question to the supervisor about its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SupervisorQuestion {
    /// The client asks for one bit of the state, 0 to 10.
    Bit(u8),
    /// The client asks for all bits of the state.
    All,
}

/// A command to the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SupervisorCommand {
    /// The drone is to be armed (true) or disarmed.
    Arm(bool),
    /// The drone is to recover from a crash.
    Recover,
    /// The motors are to be switched off now.
    EmergencyStop,
    /// The motors are to be switched off unless this command comes again within a second.
    EmergencyStopWatchdog,
}

/// A question or a command about the drone itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlatformRequest<'a> {
    /// The radio is to transmit without end, so that it can be measured.
    ContinuousWave,
    /// The drone is to beep or blink.
    Notify,
    /// The client asks for the protocol's version.
    Protocol,
    /// The client asks for the firmware's version.
    Firmware,
    /// The client asks for the type of the drone.
    DeviceType,
    /// A packet for the application, which defines its bytes.
    Application(&'a [u8]),
}

/// A request to the link service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LinkRequest<'a> {
    /// The drone is to send these bytes back.
    Echo(&'a [u8]),
    /// The drone is to send the text of its source.
    Source,
    /// The drone is to answer nothing.
    Sink,
}

impl<'a> Request<'a> {
    /// The request that a packet contains. Bytes after the request are ignored, as the vendor's
    /// firmware ignores them.
    ///
    /// # Errors
    /// [`Error`].
    pub fn parse(packet: &'a Packet) -> Result<Self, Error> {
        let (channel, data) = (packet.channel(), packet.data());
        match packet.port()? {
            Port::Param => ParamRequest::parse(channel, data).map(Self::Param),
            Port::Log => LogRequest::parse(channel, data).map(Self::Log),
            Port::Memory => MemoryRequest::parse(channel, data).map(Self::Memory),
            Port::Commander if channel == 0 => Rpyt::parse(data).map(Self::Rpyt),
            Port::Setpoint if channel == 0 => Setpoint::parse(data).map(Self::Setpoint),
            Port::Setpoint if channel == 1 => Self::setpoints_end(data),
            Port::HighLevel if channel == 0 => HighLevel::parse(data).map(Self::HighLevel),
            Port::Supervisor => Self::supervisor(channel, data),
            Port::Localization => Self::localization(channel, data),
            Port::Platform => Self::platform(channel, data),
            Port::Link => Ok(match channel {
                0 => Self::Link(LinkRequest::Echo(data)),
                1 => Self::Link(LinkRequest::Source),
                2 => Self::Link(LinkRequest::Sink),
                _ => Self::Null,
            }),
            _ => Err(Error::Channel(channel)),
        }
    }

    fn setpoints_end(data: &[u8]) -> Result<Self, Error> {
        match data {
            [0, a, b, c, d, ..] => Ok(Self::SetpointsEnd(u32::from_le_bytes([*a, *b, *c, *d]))),
            [] | [0, ..] => Err(Error::Length(data.len())),
            [command, ..] => Err(Error::Command(*command)),
        }
    }

    fn supervisor(channel: u8, data: &[u8]) -> Result<Self, Error> {
        match (channel, data) {
            (_, []) => Err(Error::Length(0)),
            (0, [question @ 1..=11, ..]) => {
                Ok(Self::Supervisor(SupervisorQuestion::Bit(question - 1)))
            }
            (0, [12, ..]) => Ok(Self::Supervisor(SupervisorQuestion::All)),
            (1, [1, arm, ..]) => Ok(Self::Command(SupervisorCommand::Arm(*arm != 0))),
            (1, [1]) => Err(Error::Length(1)),
            (1, [2, ..]) => Ok(Self::Command(SupervisorCommand::Recover)),
            (1, [3, ..]) => Ok(Self::Command(SupervisorCommand::EmergencyStop)),
            (1, [4, ..]) => Ok(Self::Command(SupervisorCommand::EmergencyStopWatchdog)),
            (0 | 1, [command, ..]) => Err(Error::Command(*command)),
            (channel, _) => Err(Error::Channel(channel)),
        }
    }

    fn localization(channel: u8, data: &'a [u8]) -> Result<Self, Error> {
        match (channel, data) {
            (1, [3, ..]) => Ok(Self::OldCommand(SupervisorCommand::EmergencyStop)),
            (1, [4, ..]) => Ok(Self::OldCommand(SupervisorCommand::EmergencyStopWatchdog)),
            (channel, data) => Positions::parse(channel, data).map(Self::Positions),
        }
    }

    fn platform(channel: u8, data: &'a [u8]) -> Result<Self, Error> {
        match (channel, data) {
            (2, data) => Ok(Self::Platform(PlatformRequest::Application(data))),
            (0 | 1, []) => Err(Error::Length(0)),
            (0, [0, ..]) => Ok(Self::Platform(PlatformRequest::ContinuousWave)),
            (0, [1, arm, ..]) => Ok(Self::OldCommand(SupervisorCommand::Arm(*arm != 0))),
            (0, [1]) => Err(Error::Length(1)),
            (0, [2, ..]) => Ok(Self::OldCommand(SupervisorCommand::Recover)),
            (0, [3, ..]) => Ok(Self::Platform(PlatformRequest::Notify)),
            (1, [0, ..]) => Ok(Self::Platform(PlatformRequest::Protocol)),
            (1, [1, ..]) => Ok(Self::Platform(PlatformRequest::Firmware)),
            (1, [2, ..]) => Ok(Self::Platform(PlatformRequest::DeviceType)),
            (0 | 1, [command, ..]) => Err(Error::Command(*command)),
            (channel, _) => Err(Error::Channel(channel)),
        }
    }

    /// The packet that a client sends for this request.
    #[must_use]
    pub fn packet(&self) -> Packet {
        let on = Packet::empty;
        match self {
            Self::Null => Packet::NULL,
            Self::Param(request) => request.packet(),
            Self::Rpyt(setpoint) => setpoint.packet(),
            Self::Memory(request) => request.packet(),
            Self::Log(request) => request.packet(),
            Self::Setpoint(setpoint) => setpoint.packet(),
            Self::SetpointsEnd(millis) => {
                on(Port::Setpoint, 1).with(&[0]).with(&millis.to_le_bytes())
            }
            Self::HighLevel(command) => command.packet(),
            Self::Supervisor(SupervisorQuestion::Bit(bit)) => {
                on(Port::Supervisor, 0).with(&[bit.saturating_add(1)])
            }
            Self::Supervisor(SupervisorQuestion::All) => on(Port::Supervisor, 0).with(&[12]),
            Self::Command(command) => command.packet(),
            Self::OldCommand(command) => command.old_packet(),
            Self::Positions(positions) => positions.packet(),
            Self::Platform(request) => request.packet(),
            Self::Link(LinkRequest::Echo(data)) => on(Port::Link, 0).with(data),
            Self::Link(LinkRequest::Source) => on(Port::Link, 1).with(&[0]),
            Self::Link(LinkRequest::Sink) => on(Port::Link, 2),
        }
    }
}

impl MemoryRequest {
    fn parse(channel: u8, data: &[u8]) -> Result<Self, Error> {
        match (channel, data) {
            (_, []) => Err(Error::Length(0)),
            (0, [1, ..]) => Ok(Self::Count),
            (0, [2, memory, ..]) => Ok(Self::Info(*memory)),
            (0, [2]) => Err(Error::Length(1)),
            (0, [command, ..]) => Err(Error::Command(*command)),
            (1, [memory, a, b, c, d, _, ..]) => {
                Ok(Self::Read { memory: *memory, address: u32::from_le_bytes([*a, *b, *c, *d]) })
            }
            (2, [memory, a, b, c, d, ..]) => {
                Ok(Self::Write { memory: *memory, address: u32::from_le_bytes([*a, *b, *c, *d]) })
            }
            (1 | 2, _) => Err(Error::Length(data.len())),
            (channel, _) => Err(Error::Channel(channel)),
        }
    }

    fn packet(&self) -> Packet {
        let on = |channel| Packet::empty(Port::Memory, channel);
        match self {
            Self::Count => on(0).with(&[1]),
            Self::Info(memory) => on(0).with(&[2, *memory]),
            Self::Read { memory, address } => {
                on(1).with(&[*memory]).with(&address.to_le_bytes()).with(&[1])
            }
            Self::Write { memory, address } => on(2).with(&[*memory]).with(&address.to_le_bytes()),
        }
    }
}

impl SupervisorCommand {
    /// The command's number.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Arm(_) => 1,
            Self::Recover => 2,
            Self::EmergencyStop => 3,
            Self::EmergencyStopWatchdog => 4,
        }
    }

    fn packet(self) -> Packet {
        let packet = Packet::empty(Port::Supervisor, 1).with(&[self.code()]);
        if let Self::Arm(arm) = self { packet.with(&[u8::from(arm)]) } else { packet }
    }

    fn old_packet(self) -> Packet {
        let code = [self.code()];
        match self {
            Self::Arm(arm) => Packet::empty(Port::Platform, 0).with(&code).with(&[u8::from(arm)]),
            Self::Recover => Packet::empty(Port::Platform, 0).with(&code),
            Self::EmergencyStop | Self::EmergencyStopWatchdog => {
                Packet::empty(Port::Localization, 1).with(&code)
            }
        }
    }
}

impl PlatformRequest<'_> {
    fn packet(&self) -> Packet {
        let on = |channel| Packet::empty(Port::Platform, channel);
        match self {
            Self::ContinuousWave => on(0).with(&[0, 1]),
            Self::Notify => on(0).with(&[3, 1]),
            Self::Protocol => on(1).with(&[0]),
            Self::Firmware => on(1).with(&[1]),
            Self::DeviceType => on(1).with(&[2]),
            Self::Application(data) => on(2).with(data),
        }
    }
}
