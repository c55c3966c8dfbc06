//! The Crazyflie Real-Time Protocol, in which cfclient and cflib talk to a drone.
//!
//! A [`Packet`] is a header of one byte, port and channel, and at most [`MAX_DATA`] bytes. A packet
//! from a client is a [`Request`], a packet to it a [`Reply`]. Layouts and numbers are those of
//! protocol version [`PROTOCOL_VERSION`] (crazyflie-firmware, `log.c`, `param_logic.c`,
//! `crtp_mem.c`, `crtp_supervisor.c`, `crtp_localization_service.c`, `crtp_commander_generic.c`; cflib 0.1.34,
//! `cflib/crazyflie/*.py`).
//!
//! | port | [`Port`] | channels |
//! |---|---|---|
//! | 0 | console | 0 text, from the drone |
//! | 2 | parameters | 0 table, 1 read, 2 write, 3 everything else |
//! | 3 | set-point of roll, pitch, yaw rate and thrust | 0 |
//! | 4 | memories | 0 information, 1 read, 2 write |
//! | 5 | log | 0 table, 1 control, 2 data, from the drone |
//! | 6 | localisation | 0 position, 1 poses, and the emergency stop of old clients, 2 positions of several drones |
//! | 7 | set-points | 0 set-point, 1 notice that they end |
//! | 8 | high-level commands | 0 |
//! | 9 | supervisor | 0 questions, 1 commands |
//! | 13 | platform | 0 commands, 1 versions, 2 the application's own |
//! | 15 | link | 0 echo, 1 source, 2 sink, 3 null packet |

mod commander;
mod log;
mod packet;
mod param;
mod position;
mod reply;
mod request;
mod value;

pub use commander::{HighLevel, Rpyt, Setpoint};
pub use log::{Entries, Entry, LogRequest};
pub use packet::{MAX_DATA, MAX_PACKET, Packet, Port};
pub use param::ParamRequest;
pub use position::{Fix, PackedPositions, Positions};
pub use reply::{Errno, LogData, Reply};
pub use request::{
    LinkRequest, MemoryRequest, PlatformRequest, Request, SupervisorCommand, SupervisorQuestion,
};
pub use value::{LogType, ParamType, Value};

use core::fmt;

/// The protocol version of these formats (crazyflie-firmware, `crtp.h`).
pub const PROTOCOL_VERSION: u8 = 12;

/// Why bytes are no packet, or a packet is no request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// The packet has this many bytes, which are too few or too many.
    Length(usize),
    /// No service has this port.
    Port(u8),
    /// The port accepts no requests on this channel.
    Channel(u8),
    /// The service has no command with this number.
    Command(u8),
    /// A number is not finite, or beyond all bounds.
    Value,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length(length) => write!(f, "{length} bytes are too few or too many"),
            Self::Port(port) => write!(f, "no service has port {port}"),
            Self::Channel(channel) => write!(f, "channel {channel} accepts no requests"),
            Self::Command(command) => write!(f, "there is no command {command}"),
            Self::Value => f.write_str("a number that is not finite or beyond all bounds"),
        }
    }
}

impl core::error::Error for Error {}
