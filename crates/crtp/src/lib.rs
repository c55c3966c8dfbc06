//! Provides the services that cfclient and cflib expect of a Crazyflie: the log, the parameters,
//! the console, the supervisor, and set-points from clients with access.
//!
//! [`Server`] is the whole interface. [`Server::receive`] processes each packet of a client; where
//! the rest of the drone must act, it passes an [`Event`] to it and answers the client by the
//! [`Outcome`]. [`Server::poll`] returns the next packet to send. Log variables are read from a
//! [`Snapshot`], and [`Parameters`] holds the parameters. The server owns no clock and no line,
//! never allocates and never panics.
//!
//! ```
//! use crtp::{Access, Outcome, Parameters, Server, Snapshot};
//! use units::Instant;
//!
//! let mut server = Server::new();
//! let mut parameters = Parameters::DEFAULT;
//! // A client asks for the kind of device.
//! server.receive(Instant::ZERO, &[0xFD, 0], Access::Read, &mut parameters, |_, _| Outcome::Done);
//! let answer = server.poll(Instant::ZERO, &Snapshot::DEFAULT, &parameters).unwrap();
//! assert_eq!(&answer.bytes()[1..19], b"Bitcraze Crazyflie");
//! ```
//!
//! # Two kinds of line
//! Over UDP the drone may send at any time: after each received packet, and at [`Server::due`], the
//! caller polls until there is nothing more to send. Over the radio the drone may send one packet
//! for each that it receives: the caller polls once for each, and sends nothing, or
//! [`Packet::NULL`], when nothing is due. A drone may use both lines at once.
//!
//! | module | its part |
//! |---|---|
//! | `server` | answers the requests of clients |
//! | `blocks` | log blocks: what is in them, and when they are due |
//! | `console` | the buffer of console text |
//! | `variables` | the table of log variables |
//! | `parameters` | the values of the parameters |
//! | `parameter_table` | the table of parameters |
//! | `snapshot` | the values of the log variables at one moment |
//! | `table` | the rows and checksums of both tables |
#![no_std]

mod blocks;
mod console;
mod parameter_table;
mod parameters;
mod server;
mod snapshot;
mod table;
mod variables;

pub use parameter_table::{ParameterId, parameters};
pub use parameters::{About, OperatorTask, Parameters};
pub use server::{Access, Counters, Event, Notice, Outcome, Server, Setpoint};
pub use snapshot::{Link, LinkState, Node, Power, Radio, Ranges, Snapshot, Variance};
pub use table::Documented;
pub use variables::variables;
pub use wire::crtp::Packet;
