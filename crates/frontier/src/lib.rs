//! Coordinated exploration: how robots that hear each other share out what none of them knows.
//!
//! An [`Explorer`] is one robot. At each step it is given its pose, what its sensors see, and the
//! packets that it has received; it returns its motion and the packets that it sends. It keeps a map
//! of its own ([`Ground`]) and tells the others its frontiers, never the map ([`Packet`]). Among the
//! robots that hear each other, over other robots too, the one with the lowest number leads: it
//! assigns a frontier to each robot that has none to go to ([`assign`]) by one of the [`RULES`], and
//! stops them all when nothing is left.
//!
//! "The thesis" is the one behind N. Mahdoui, V. Frémont and E. Natalizio, "Communicating Multi-UAV
//! System for Cooperative SLAM-based Exploration" (Journal of Intelligent & Robotic Systems 98, 2020),
//! chapter 3, "Coordinated exploration". Where it contradicts itself, the documentation of the function
//! says which reading was taken.
#![no_std]

mod apart;
mod assignment;
mod atlas;
mod barred;
mod bidding;
mod board;
mod cluster;
mod explorer;
mod flight;
mod going;
mod homeward;
mod lead;
mod ledger;
mod list;
mod marking;
mod meeting;
mod overlap;
mod packet;
mod rule;
mod team;
mod telling;
mod tile;
mod walls;

pub use assignment::{Assignment, Distances, Place, assign, take};
pub use atlas::{
    Atlas, Atlas160, Atlas256, Atlas512, Atlas1024, Ground, Sight, View, frontiers, length,
};
pub use board::Candidate;
pub use cluster::{MOST_ROBOTS, RobotSet, cluster};
pub use explorer::{Config, Explorer, Inputs, Outputs};
pub use flight::{Gaze, Limits, Motion};
pub use grid_map::{Beam, Cone, Side};
pub use overlap::{NEAR, Shape, is_overlapped};
pub use packet::{
    Activity, Bid, Body, Changes, Known, MOST_BIDS, MOST_BYTES, MOST_CHANGES, MOST_KNOWN,
    MOST_ORDERS, Order, Packet, PacketError, Status, Task,
};
pub use rule::{
    Distance, Facing, Order as RobotOrder, Overlap, Pace, RULES, Rule, RuleEntry, Utility,
};
pub use tile::{Gain, Mark, Tile};
