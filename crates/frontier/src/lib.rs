//! Coordinated exploration: how the robots of one cluster share out the frontiers of what they know.
//!
//! A robot reduces its map to [`Candidate`]s ([`extract`]) and exchanges these, never the map
//! ([`Chunk`]). The leader of a cluster ([`leader`]) removes the candidates that lie in another
//! robot's area ([`is_overlapped`]), and assigns one candidate to each robot ([`assign`]) by one of
//! the [`Rule`]s.
//!
//! "The thesis" is the one behind N. Mahdoui, V. Frémont and E. Natalizio, "Communicating Multi-UAV
//! System for Cooperative SLAM-based Exploration" (Journal of Intelligent & Robotic Systems 98, 2020),
//! chapter 3, "Coordinated exploration". Where it contradicts itself, the documentation of the function
//! says which reading was taken.
#![no_std]

mod assignment;
mod candidate;
mod cluster;
mod message;
mod overlap;
mod rule;

pub use assignment::{Assignment, Explorer, assign};
pub use candidate::{Candidate, Candidates, MOST_CANDIDATES, SPACING, extract};
pub use cluster::{Links, ROBOTS, leader};
pub use message::{Chunk, ChunkError, Content, MOST_CHUNK_BYTES, POINTS};
pub use overlap::{NEAR, Shape, is_overlapped};
pub use rule::{Distance, Order, RULES, Rule, RuleEntry};
