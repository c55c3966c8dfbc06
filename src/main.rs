//! The firmware: everything that touches the chip, and nothing else.
//!
//! What a drone does is decided in `crates/agent`; this package gives it a clock, a 5 Hz tick, and
//! somewhere to put what it decides. It is small yet: sensors, radio and motors have no code, and
//! [`made_up`] stands in for the first two. The book's chapter "The firmware" says what it does
//! today and what is not in.
//!
//! | module | what it holds |
//! |---|---|
//! | [`board`] | clocks and pins of the Crazyflie 2.1 |
//! | [`motors`] | the four motor pins: how to stop them, whatever else has happened |
//! | [`mind`] | the task that runs `agent::Agent` and publishes what it decided |
//! | [`lamp`] | the task that shows the agent's state on the blue LED |
//! | [`made_up`] | scripted inputs, until there are real ones |
//! | [`mod@panic`] | panics and faults: motors off, leave a reason, reset |
//!
//! A task is a loop of "await a tick, call a step, publish the result". Nothing here waits for
//! anything but a tick, allocates, or panics on purpose.
#![no_std]
#![no_main]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable,
    clippy::indexing_slicing,
    clippy::string_slice
)]

mod board;
mod lamp;
mod made_up;
mod mind;
mod motors;
mod panic;

use defmt_rtt as _;
use embassy_executor::{Executor, Spawner};
use static_cell::StaticCell;

use board::Board;

static EXECUTOR: StaticCell<Executor> = StaticCell::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    motors::stop();
    let last_words = panic::take_last_words();
    let mut board = board::init();
    if let Some(words) = &last_words {
        board.fault_lamp.set_low();
        words.log();
    }
    defmt::info!("uchain-firmware {=str}, inputs are made up", env!("CARGO_PKG_VERSION"));
    match EXECUTOR.try_init_with(Executor::new) {
        Some(executor) => executor.run(|spawner| start(spawner, board)),
        None => panic::give_up("the executor was started twice"),
    }
}

/// Starts the tasks. Each is started once, so that none is refused unless memory is corrupt.
fn start(spawner: Spawner, board: Board) {
    let Some(agent) = mind::new_agent() else {
        panic::give_up("the agent was made twice");
    };
    match mind::run(agent) {
        Ok(task) => spawner.spawn(task),
        Err(_) => panic::give_up("the mind was started twice"),
    }
    match lamp::run(board.lamp) {
        Ok(task) => spawner.spawn(task),
        Err(_) => panic::give_up("the lamp was started twice"),
    }
    // Dropping a pin makes it float, and this one has to stay lit.
    core::mem::forget(board.fault_lamp);
}
