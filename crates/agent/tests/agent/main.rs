//! Tests the agent by [`agent::Agent::step`] alone, with scripted inputs.
//!
//! * [`state_table`]: every state in every situation, as a golden table.
//! * [`behaviour`]: what a mission depends on, story by story.
//! * [`odometer`]: the way that a drone has flown, by command and by optic flow.
//! * [`search`]: a relay that looks for a better place, with its two neighbours.
//! * [`any_inputs`]: packet storms, bad clocks and numbers of any bits.
//!
//! All but the search flies with the paper's T0, whose raw signal makes one packet count at once; what the
//! tuned policies do is tested where they are.

mod any_inputs;
mod behaviour;
mod explore;
mod homing;
mod odometer;
mod rig;
mod search;
mod state_table;
mod swarm;
