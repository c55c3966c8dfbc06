//! Says where a drone of a swarm goes next: virtual forces, and the survey of an area in rows.
//!
//! The strategy is that of Falomir, Chaumette and Guerrini, "Mobility Strategies based on Virtual
//! Forces for Swarms of Autonomous UAVs in Constrained Environments" (ICINCO 2017); equation
//! numbers in this crate are that paper's. Each drone decides for itself, from its own position and
//! from what it hears of its neighbours. The crate does no input or output, and keeps no clock: one
//! call is one round.
//!
//! ```
//! use units::{Metres, Point2};
//! use virtual_forces::{Config, Survey};
//!
//! // Twelve rows of 0.75 m cover an area of 9 m by 7.5 m.
//! let survey = Survey::new(&Config::PAPER, Metres(9.0), Metres(7.5));
//! assert_eq!(survey.rows(), 12);
//! // The first of two drones starts in the middle of the first cell of the first row.
//! assert_eq!(survey.goal(0, 2, 0), Some(Point2::new(0.375, 0.375)));
//! ```
#![no_std]

mod config;
mod force;
mod heading;
mod survey;

pub use config::{Config, ObstacleForce, Wait, Weight};
pub use force::{attraction_to_goal, between_drones, from_obstacle};
pub use heading::Resultant;
pub use survey::{Heard, Survey, direction, guarded};
