//! The firmware: everything that touches the chip, and nothing else.
//!
//! What a drone does is decided in `crates/agent` and `crates/flight`; what its sensors say and
//! what the radio's bytes mean, in `crates/sensors` and `crates/wire`. This package gives them
//! clocks, pins and buses, and tasks that wait, step and publish. The book's chapter "The firmware"
//! has the tasks with their priorities and the bounds of their waits.
//!
//! | module | what it holds |
//! |---|---|
//! | [`board`] | clocks, pins, buses and priorities of the board that was chosen |
//! | [`bus`] | an I²C bus on which no transaction waits for ever |
//! | [`deadline`] | the bounds of such waits, kept by the control loop's tick |
//! | [`motors`] | the motors: how to stop them whatever has happened, and how to drive them |
//! | [`imu`] | the tasks that read the inertial sensor's two dies, 1 kHz |
//! | [`control`] | the task that runs `flight::Flight`, 1 kHz, and feeds the watchdog |
//! | [`flow`] | the task that reads the optic flow, 100 Hz |
//! | [`rangers`] | the task that reads the rangers |
//! | [`radio`] | the tasks that talk to the radio chip |
//! | [`link`] | the drone's end of the chain's link, which they share with the mind |
//! | [`desk`] | what cfclient and cflib talk to |
//! | [`mind`] | the task that runs `agent::Agent`, 5 Hz |
//! | [`store`] | the task that keeps settings, keys and epochs in the EEPROM |
//! | [`page`] | the page in flash through which keys come in |
//! | [`lamps`] | the task that shows on the LEDs what goes on |
//! | [`health`] | signs of life, and the task that says how it all does, 1 Hz |
//! | [`aloft`] | whether the last run ended in the air |
//! | [`reset`] | why the chip started, and the watchdog |
//! | [`mod@panic`], [`fault`] | panics and faults: motors off, leave a reason, reset |
//! | [`stack`] | where the stack lies and how deep it has been |
//! | [`latest`], [`clock`] | how tasks hand each other values; the time |
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

mod aloft;
mod board;
mod bus;
mod clock;
mod control;
mod deadline;
mod desk;
mod fault;
mod flow;
mod health;
mod imu;
mod lamps;
mod latest;
mod link;
mod mind;
mod motors;
mod page;
mod panic;
mod radio;
mod rangers;
mod reset;
mod stack;
mod store;

use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::interrupt;
use embassy_sync::mutex::Mutex;
use static_cell::StaticCell;

use board::{DeckParts, FlowParts, ImuParts, Lamps, RadioParts};
use desk::Desk;
use imu::ImuBus;
use link::Link;
use motors::Motors;
use rangers::DeckBus;

/// Runs the inertial sensor and the control loop, above everything but what wakes them.
static CONTROL: InterruptExecutor = InterruptExecutor::new();
/// Runs all others, when there is nothing else to do.
static THREAD: StaticCell<Executor> = StaticCell::new();

static IMU_BUS: StaticCell<ImuBus> = StaticCell::new();
static DECK_BUS: StaticCell<DeckBus> = StaticCell::new();
static LINK: StaticCell<Link> = StaticCell::new();
static DESK: StaticCell<Desk> = StaticCell::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    motors::stop();
    let cause = reset::take_cause();
    let last_words = panic::take_last_words();
    let fell = aloft::take();
    reset::start_watchdog();
    defmt::info!("uchain-firmware {=str}, started by {}", env!("CARGO_PKG_VERSION"), cause);
    defmt::info!("brown-out below {=u16} mV", reset::brown_out_millivolts());
    if let Some(words) = &last_words {
        words.log();
    }
    if fell {
        defmt::error!("last run: it ended in the air");
    }
    let fault = fell || last_words.is_some() || cause.is_fault();

    if !board::crystal_starts() {
        panic::give_up("the crystal does not start");
    }
    let parts = board::init();
    health::start_cycle_counter();
    start_control(parts.imu);
    match THREAD.try_init_with(Executor::new) {
        Some(executor) => executor.run(|spawner| {
            start(spawner, parts.lamps, fault, parts.flow, parts.decks, parts.radio);
        }),
        None => panic::give_up("the executor was started twice"),
    }
}

/// Starts what flies.
fn start_control(imu: ImuParts) {
    let Some(flight) = control::new_flight() else {
        panic::give_up("the flight code was made twice");
    };
    let Some(bus) = IMU_BUS.try_init_with(|| Mutex::new(imu.bus)) else {
        panic::give_up("the inertial sensor's bus was made twice");
    };
    let bus: &'static ImuBus = bus;
    let spawner = CONTROL.start(board::CONTROL);
    spawner.spawn(granted(control::run(flight, Motors::take())));
    spawner.spawn(granted(imu::gyro(bus, imu.ready)));
    spawner.spawn(granted(imu::accel(bus)));
}

/// Starts all the rest. A function of its own, so that what it needs of the stack is given back
/// before the first task runs.
#[inline(never)]
fn start(
    spawner: Spawner,
    lamps: Lamps,
    fault: bool,
    flow: FlowParts,
    decks: DeckParts,
    radio: RadioParts,
) {
    let Some(decks) = DECK_BUS.try_init_with(|| Mutex::new(decks.bus)) else {
        panic::give_up("the decks' bus was made twice");
    };
    let decks: &'static DeckBus = decks;
    let (Some(link), Some(desk)) = (LINK.try_init_with(Link::new), DESK.try_init_with(Desk::new))
    else {
        panic::give_up("the link was made twice");
    };
    let link: &'static Link = link;
    spawner.spawn(granted(store::run(decks, link)));
    spawner.spawn(granted(radio::receive(radio.receive, link, desk)));
    spawner.spawn(granted(radio::transmit(radio.transmit, radio.wait, link)));
    spawner.spawn(granted(flow::run(flow)));
    spawner.spawn(granted(rangers::run(decks)));
    spawner.spawn(granted(mind::run(link, fault)));
    spawner.spawn(granted(lamps::run(lamps, fault, link)));
    spawner.spawn(granted(health::run(link)));
}

/// Each task is started once, so that none is refused unless memory is corrupt.
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
    // SAFETY: this is the interrupt that the executor was started with, and nobody else raises it
    // before that, nor calls this.
    unsafe { CONTROL.on_interrupt() }
}
