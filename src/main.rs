//! The firmware: everything that touches the chip, and nothing else.
//!
//! `crates/onboard` and `crates/flight` decide what the drone does; `crates/sensors` drives its
//! sensors, and `crates/wire` reads and writes the radio's bytes. This package gives them clocks,
//! pins and buses, and tasks that wait, step and publish. The book's chapter "The firmware" has the
//! tasks with their priorities and the bounds of their waits.
//!
//! | module | holds |
//! |---|---|
//! | [`board`] | clocks, pins, buses and motors of the board that was chosen |
//! | [`tasks`] | the tasks, which wait, step and publish |
//! | [`safety`] | panics, faults, resets, and what outlives them |
//! | [`mod@probe`] | the inputs and decisions of the drone, shown to an emulator |
//! | [`rtt`] | the log and the replay's channels, to a debug probe |
//!
//! Nothing here allocates, panics on purpose, or waits without a bound.
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
mod probe;
mod rtt;
mod safety;
mod tasks;

use embassy_executor::{Executor, InterruptExecutor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::interrupt;
use embassy_sync::mutex::Mutex;
use static_cell::StaticCell;
use storage::board_name::Board;

use board::motors::{self, Motors};
use board::{DeckParts, FlowParts, ImuParts, Lamps, RadioParts};
use board::{ccm, identity};
use safety::{panic, reset, restart_mark};
use tasks::drone::{self, Shared};
use tasks::imu::{self, ImuBus};
use tasks::rangers::{self, DeckBus};
use tasks::store::LastRun;
use tasks::{control, exploration, flow, health, lamps, mission, radio, replay, store};

/// The executor of the inertial sensor and the control loop. Only the interrupts that wake these
/// tasks have a higher priority.
static CONTROL: InterruptExecutor = InterruptExecutor::new();
/// The executor of all other tasks, which runs while no interrupt does.
static THREAD: StaticCell<Executor> = StaticCell::new();

static IMU_BUS: StaticCell<ImuBus> = StaticCell::new();
static DECK_BUS: StaticCell<DeckBus> = StaticCell::new();
static SHARED: StaticCell<Shared> = StaticCell::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    motors::stop();
    let cause = reset::take_cause();
    let crash = panic::take_crash_record();
    let mark = restart_mark::take();
    reset::start_watchdog();
    ccm::clear();
    probe::UCHAIN_PROBE.begin();
    defmt::info!("uchain-firmware {=str}, started by {}", env!("CARGO_PKG_VERSION"), cause);
    defmt::info!("brown-out below {=u16} mV", reset::brown_out_millivolts());
    if let Some(record) = &crash {
        record.log();
    }
    if mark.aloft {
        defmt::error!("last run: it ended in the air");
    }
    if mark.stopped {
        defmt::warn!("a stop stands: switch the drone off by its button to end it");
    }
    let failed = mark.aloft || crash.is_some() || cause.is_fault();
    let last_run = LastRun { failed, stopped: mark.stopped };

    if !board::crystal_starts() {
        panic::give_up("the crystal does not start");
    }
    let parts = board::init();
    health::start_cycle_counter();
    start_control(parts.imu);
    match THREAD.try_init_with(Executor::new) {
        Some(executor) => executor.run(|spawner| {
            start(spawner, parts.lamps, last_run, parts.flow, parts.decks, parts.radio);
        }),
        None => panic::give_up("the executor was started twice"),
    }
}

/// Starts the tasks of the control executor: control loop, gyroscope, accelerometer.
fn start_control(imu: ImuParts) {
    let Some(flight) = control::new_flight() else {
        panic::give_up("the flight code was made twice");
    };
    let Some(bus) = IMU_BUS.try_init_with(|| Mutex::new(imu.bus)) else {
        panic::give_up("the inertial sensor's bus was made twice");
    };
    let bus: &'static ImuBus = bus;
    let spawner = CONTROL.start(board::CONTROL);
    let board = identity::board();
    defmt::info!("board: {}", board);
    // The pins of other boards' motors drive speed controllers.
    let motors = (board == Board::Crazyflie21).then(Motors::take);
    spawner.spawn(granted(control::run(flight, motors)));
    spawner.spawn(granted(imu::gyro(bus, imu.ready)));
    spawner.spawn(granted(imu::accel(bus)));
}

/// Starts the tasks of the thread. It is a function of its own, so that its stack frame is given
/// back before the first task runs.
#[inline(never)]
fn start(
    spawner: Spawner,
    lamps: Lamps,
    last_run: LastRun,
    flow: FlowParts,
    decks: DeckParts,
    radio: RadioParts,
) {
    let Some(decks) = DECK_BUS.try_init_with(|| Mutex::new(decks.bus)) else {
        panic::give_up("the decks' bus was made twice");
    };
    let decks: &'static DeckBus = decks;
    let Some(drone) = drone::make() else {
        panic::give_up("the drone was made twice");
    };
    let Some(shared) = SHARED.try_init_with(|| Shared::new(drone)) else {
        panic::give_up("the drone was shared twice");
    };
    let shared: &'static Shared = shared;
    let Some(exploration) = exploration::take() else {
        panic::give_up("the exploration's memory was taken twice");
    };
    spawner.spawn(granted(store::run(decks, shared, last_run)));
    spawner.spawn(granted(radio::receive(radio.receive, shared)));
    spawner.spawn(granted(radio::transmit(radio.transmit, radio.wait, shared)));
    spawner.spawn(granted(flow::run(flow)));
    spawner.spawn(granted(rangers::run(decks)));
    spawner.spawn(granted(mission::run(shared, exploration)));
    spawner.spawn(granted(replay::run(shared)));
    spawner.spawn(granted(lamps::run(lamps, last_run.failed, shared)));
    spawner.spawn(granted(health::run(shared)));
}

/// Takes the token of a task. It is there unless memory is corrupt, since each task is started once.
fn granted<S>(task: Result<SpawnToken<S>, SpawnError>) -> SpawnToken<S> {
    match task {
        Ok(task) => task,
        Err(_) => panic::give_up("a task was started twice"),
    }
}

/// The control executor's interrupt: see [`board::CONTROL`].
#[interrupt]
#[allow(unsafe_code, reason = "embassy asks for a promise")]
unsafe fn CAN2_SCE() {
    // SAFETY: this is the interrupt that the executor was started with; it is not raised before
    // that, and no code calls this function.
    unsafe { CONTROL.on_interrupt() }
}
