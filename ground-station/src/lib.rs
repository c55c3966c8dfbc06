//! The operator's station: a page in the browser of this machine that shows a chain of drones and
//! gives it orders, through the base of the chain.
//!
//! ```text
//!   browser ──WebSocket──▶ server ──▶ station ──CRTP──▶ base ─ ─ ─▶ drones
//!      ▲                                │  │              │
//!      └────────── state, 10 Hz ────────┘  └─▶ recorder   └─ ─ telemetry
//! ```
//! The station decides nothing for the drones. While no page steers it sends nothing, so that the
//! time-outs of the drones count; only a stop that was ordered is sent until it is answered.
//!
//! | module | its part |
//! |---|---|
//! | [`session`] | speaks CRTP to the base, without a clock and without a socket |
//! | [`table`], [`blocks`] | read the base's tables and its log blocks |
//! | [`order`], [`stopping`] | give orders, and repeat a stop until all drones have answered |
//! | [`chain_view`], [`battery`], [`words`] | what is known of the drones, in words |
//! | [`checklist`], [`advice`] | what must be so before a flight, and what to do next |
//! | [`link_history`] | the links of the last minutes, for pages that are opened later |
//! | [`status`] | the state of all that as JSON, for the pages |
//! | [`map`] | the floor plan on which the pages show the chain |
//! | [`range_survey`] | how far a link reaches, and which limits follow |
//! | [`freshness`], [`clock`] | how old an order of a page may be at most |
//! | [`steering`] | which of the open pages steers, and which of their requests are heeded |
//! | [`fleet`] | the fleet files: names, addresses and limits of the drones |
//! | [`check`], [`inspection`] | check every drone against that file before a flight |
//! | [`address`], [`link`] | carry packets to a drone |
//! | `radio` | reaches a drone through a Crazyradio, with the feature `crazyradio` |
//! | [`message`] | what was heard and ordered, as JSON messages |
//! | [`recorder`] | writes these to CSV and MCAP |
//! | [`live_stream`], [`foxglove`] | gives them to viewers as they happen, by Foxglove's protocol |
//! | `ros2` | gives them to programs by ROS 2, and takes their orders, with the feature `ros2` |
//! | [`station`] | brings these together with the clock |
//! | [`access`], [`token`], [`token_guard`] | who may connect |
//! | [`server`], [`listener`], [`page_socket`] | the page itself, its connections and their time limits |
//! | [`cli`] | the command `uchain-ground` |

pub mod access;
pub mod address;
pub mod advice;
pub mod battery;
pub mod blocks;
pub mod chain_view;
pub mod check;
pub mod checklist;
pub mod cli;
pub mod clock;
pub mod console;
pub mod fleet;
pub mod flight_log;
pub mod foxglove;
pub mod freshness;
pub mod grade;
pub mod inspection;
pub mod link;
pub mod link_history;
pub mod listener;
pub mod live_stream;
pub mod map;
pub mod message;
pub mod order;
pub mod page_socket;
#[cfg(feature = "crazyradio")]
pub mod radio;
pub mod range_survey;
pub mod recorder;
#[cfg(feature = "ros2")]
pub mod ros2;
pub mod server;
pub mod session;
pub mod station;
pub mod status;
pub mod steering;
pub mod stopping;
pub mod table;
pub mod token;
pub mod token_guard;
pub mod words;
