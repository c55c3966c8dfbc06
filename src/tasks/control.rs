//! The control loop: a thousand times a second from the sensors to the motors.
//!
//! It waits for the gyroscope's next sample, no longer than [`PATIENCE`]: without a sample it steps
//! all the same, so that the flight code can land with the other sensors. It takes the latest values
//! of everything else without waiting. It feeds the watchdog, and ends bus transactions that take too
//! long.

use core::cell::Cell;

use cortex_m::peripheral::DWT;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::{Duration, with_timeout};
use flight::{Command, Duties, Flight, Outputs, Sensed, Status};
use static_cell::StaticCell;
use units::{Acceleration, AngularVelocity, Instant};

use crate::board::FLIGHT;
use crate::board::motors::{self, Motors};
use crate::board::{clock, deadline};
use crate::probe::UCHAIN_PROBE;
use crate::safety::{panic, reset, restart_mark};
use crate::tasks::latest::Latest;
use crate::tasks::{flow, health, imu, mission, radio, rangers};

/// The status of the flight code after its last step; `None` before the first.
pub(crate) static STATUS: Latest<Option<Status>> = Latest::new(None);

/// The measurements and motor duties of the last step, for clients.
#[derive(Clone, Copy)]
pub(crate) struct Measured {
    pub(crate) gyro: AngularVelocity,
    pub(crate) accel: Acceleration,
    pub(crate) duties: Duties,
}

pub(crate) static MEASURED: Latest<Measured> = Latest::new(Measured {
    gyro: AngularVelocity([0.0; 3]),
    accel: Acceleration([0.0; 3]),
    duties: Duties::OFF,
});

/// Two samples missed.
const PATIENCE: Duration = Duration::from_millis(2);

/// The memory of the flight code, which is too large for a stack.
static FLYER: StaticCell<Flight> = StaticCell::new();

/// Makes the flight code, once; `None` at a second call.
pub(crate) fn new_flight() -> Option<&'static mut Flight> {
    FLYER.try_init_with(Flight::new)
}

/// Whether the drone is in the air or about to be, so that a reset would be a fall.
pub(crate) fn is_airborne() -> bool {
    STATUS.get().is_some_and(|status| status.mode.is_airborne())
}

/// The task, on the control executor. Without motors it does the same, but for their signals.
#[embassy_executor::task]
pub(crate) async fn run(flight: &'static mut Flight, mut motors: Option<Motors>) -> ! {
    let mut last = DWT::cycle_count();
    let mut measured = MEASURED.get();
    loop {
        let gyro = with_timeout(PATIENCE, imu::RATES.wait()).await.ok();
        let begin = DWT::cycle_count();
        let sensed = Sensed {
            gyro,
            accel: imu::FORCE.take(),
            flow: flow::MOTION.take(),
            down: rangers::DOWN.take(),
            battery: radio::VOLTAGE.take(),
        };
        let outputs = step(flight, clock::now(), &sensed, &command());
        if let Some(motors) = &mut motors {
            motors.set(outputs.duties);
        }
        STATUS.set(Some(outputs.status));
        UCHAIN_PROBE.show_flight(&outputs.status);
        measured = Measured {
            gyro: sensed.gyro.unwrap_or(measured.gyro),
            accel: sensed.accel.unwrap_or(measured.accel),
            duties: outputs.duties,
        };
        MEASURED.set(measured);
        watch_over(&outputs.status);
        deadline::tick();
        time(begin.wrapping_sub(last), DWT::cycle_count().wrapping_sub(begin));
        last = begin;
    }
}

/// Steps the flight code. It is not inlined, so that `.ci/sizes` can measure it and all that it
/// calls.
#[inline(never)]
fn step(flight: &mut Flight, now: Instant, sensed: &Sensed, command: &Command) -> Outputs {
    flight.step(&FLIGHT, now, sensed, command)
}

/// The set-point of the mission, or a stop when the motors are locked, or the power button was pressed
/// on the ground.
fn command() -> Command {
    let ends = radio::is_shutting_down() && !is_airborne();
    if motors::are_locked() || ends {
        Command { setpoint: units::Setpoint::Stop, given: clock::now() }
    } else {
        mission::COMMAND.get()
    }
}

/// Feeds the watchdog, unless a task has stopped and the drone is on the ground.
fn watch_over(status: &Status) {
    let flies = status.mode.is_airborne();
    restart_mark::note_aloft(flies);
    if !flies && let Some(task) = health::silent() {
        panic::give_up(task.silence());
    }
    reset::feed_watchdog();
}

/// The timing of the loop, in µs.
#[derive(Clone, Copy)]
pub(crate) struct Timing {
    pub(crate) longest_step: u32,
    pub(crate) shortest_period: u32,
    pub(crate) longest_period: u32,
}

impl Timing {
    const NONE: Self = Self { longest_step: 0, shortest_period: u32::MAX, longest_period: 0 };
}

/// The timing since it was last taken, in cycles.
static TIMING: Mutex<CriticalSectionRawMutex, Cell<Timing>> = Mutex::new(Cell::new(Timing::NONE));

fn time(period: u32, step: u32) {
    TIMING.lock(|timing| {
        let so_far = timing.get();
        timing.set(Timing {
            longest_step: so_far.longest_step.max(step),
            shortest_period: so_far.shortest_period.min(period),
            longest_period: so_far.longest_period.max(period),
        });
    });
}

/// Takes the timing of the loop since the last call.
pub(crate) fn take_timing() -> Timing {
    /// At 168 MHz.
    const CYCLES: u32 = 168;
    let Timing { longest_step, shortest_period, longest_period } =
        TIMING.lock(|timing| timing.replace(Timing::NONE));
    Timing {
        longest_step: longest_step / CYCLES,
        shortest_period: shortest_period / CYCLES,
        longest_period: longest_period / CYCLES,
    }
}
