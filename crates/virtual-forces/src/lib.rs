//! Says where a drone of a swarm goes next: virtual forces, the survey of an area in rows, compact
//! formations, and the way through a narrow passage.
//!
//! The strategy is that of Falomir, Chaumette and Guerrini, "Mobility Strategies based on Virtual
//! Forces for Swarms of Autonomous UAVs in Constrained Environments" (ICINCO 2017); equation
//! numbers in this crate are that paper's. Each drone decides for itself, from its own position,
//! from what it hears of its neighbours and from the obstacles that it sees. The crate does no input
//! or output, and keeps no clock: one call of [`Member::step`] is one round. [`Config::PAPER`] flies
//! the paper as printed, and [`Config::OURS`] adds what keeps drones apart and linked.
//!
//! ```
//! use units::{Metres, Point2};
//! use virtual_forces::{Config, Survey};
//!
//! // Twelve rows of 0.75 m cover an area of 9 m by 7.5 m.
//! let area = (Metres(9.0), Metres(7.5));
//! let survey = Survey::new(&Config::PAPER, Point2::default(), area, 2);
//! assert_eq!(survey.rows(), 12);
//! // The first of two drones starts in the middle of the first cell of the first row.
//! assert_eq!(survey.goal(0, 0), Some(Point2::new(0.375, 0.375)));
//! ```
#![no_std]

#[cfg(test)]
extern crate std;

mod config;
mod crossing;
mod force;
mod formation;
mod geometry;
mod heading;
mod member;
mod obstacles;
mod pace;
mod plan;
mod room;
mod survey;
mod takeover;
mod target;
mod team;

pub use config::{Config, Guard, ObstacleForce, Places, Rows, Sweep, Wait, Weight};
pub use force::{attraction_to_goal, between_drones, from_obstacle};
pub use formation::{Formation, Passage};
pub use heading::Resultant;
pub use member::{DOWN, Member, Task};
pub use obstacles::Obstacles;
pub use pace::Pace;
pub use plan::Plan;
pub use survey::Survey;
pub use target::Target;
pub use team::Heard;
