//! The whole system: its packages, missions, links, keys, replays, clients and the window of one, through the library of the simulator.

mod arrows;
mod bridge;
mod claims;
mod determinism;
mod flight;
mod golden;
mod horizons;
mod keys;
mod link;
mod one_drone;
mod replay;
mod replay_on_chip;
mod scenario_refusals;
mod serve;
mod virtual_drones;
mod virtual_hardware;
mod window;
