//! Checks that every task still runs, and logs how near to its limits the firmware runs.
//!
//! Each task signs in every round, and must sign again within a time limit of its own. When a task
//! does not, on the ground the control task ends the run, with the name of that task as the reason.
//! In the air it does not, since a reset is a fall: there the flight code notices that the task's
//! values are missing, and lands.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_time::{Duration, Ticker};

use crate::safety::stack;
use crate::tasks::drone::Shared;
use crate::tasks::store::{Choice, KeysState};
use crate::tasks::{control, flow, imu, radio, rangers, store};

/// The tasks that sign. The control task does not: it checks the others.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Task {
    Gyro,
    Accel,
    Flow,
    Rangers,
    Receive,
    Transmit,
    Mission,
    Replay,
    Store,
    Lamps,
    Health,
}

impl Task {
    const ALL: [Self; 11] = [
        Self::Gyro,
        Self::Accel,
        Self::Flow,
        Self::Rangers,
        Self::Receive,
        Self::Transmit,
        Self::Mission,
        Self::Replay,
        Self::Store,
        Self::Lamps,
        Self::Health,
    ];

    /// The longest round of each task in µs: the sum of its time limits, and half as much again.
    const fn limit(self) -> u32 {
        match self {
            // Time to bring up a sensor that answers every request too late.
            Self::Gyro => 1_500_000,
            Self::Accel => 1_500_000,
            Self::Flow => 1_500_000,
            Self::Rangers => 1_500_000,
            Self::Receive => 1_500_000,
            Self::Transmit => 1_500_000,
            Self::Mission => 1_000_000,
            Self::Replay => 1_000_000,
            Self::Store => 3_000_000,
            Self::Lamps => 1_000_000,
            Self::Health => 3_000_000,
        }
    }

    /// The reason that the next boot reports when this task has stopped.
    pub(crate) const fn silence(self) -> &'static str {
        match self {
            Self::Gyro => "the gyroscope's task fell silent",
            Self::Accel => "the accelerometer's task fell silent",
            Self::Flow => "the optic flow's task fell silent",
            Self::Rangers => "the rangers' task fell silent",
            Self::Receive => "the radio's receiving task fell silent",
            Self::Transmit => "the radio's sending task fell silent",
            Self::Mission => "the mission's task fell silent",
            Self::Replay => "the replay's task fell silent",
            Self::Store => "the store fell silent",
            Self::Lamps => "the lamps' task fell silent",
            Self::Health => "the health task fell silent",
        }
    }

    fn sign(self) -> &'static AtomicU32 {
        match self {
            Self::Gyro => &SIGNS.gyro,
            Self::Accel => &SIGNS.accel,
            Self::Flow => &SIGNS.flow,
            Self::Rangers => &SIGNS.rangers,
            Self::Receive => &SIGNS.receive,
            Self::Transmit => &SIGNS.transmit,
            Self::Mission => &SIGNS.mission,
            Self::Replay => &SIGNS.replay,
            Self::Store => &SIGNS.store,
            Self::Lamps => &SIGNS.lamps,
            Self::Health => &SIGNS.health,
        }
    }
}

/// The time of each task's last signature, in µs since boot. The times wrap after 71 minutes, and so
/// do differences of them.
struct Signs {
    gyro: AtomicU32,
    accel: AtomicU32,
    flow: AtomicU32,
    rangers: AtomicU32,
    receive: AtomicU32,
    transmit: AtomicU32,
    mission: AtomicU32,
    replay: AtomicU32,
    store: AtomicU32,
    lamps: AtomicU32,
    health: AtomicU32,
}

static SIGNS: Signs = Signs {
    gyro: AtomicU32::new(0),
    accel: AtomicU32::new(0),
    flow: AtomicU32::new(0),
    rangers: AtomicU32::new(0),
    receive: AtomicU32::new(0),
    transmit: AtomicU32::new(0),
    mission: AtomicU32::new(0),
    replay: AtomicU32::new(0),
    store: AtomicU32::new(0),
    lamps: AtomicU32::new(0),
    health: AtomicU32::new(0),
};

fn micros() -> u32 {
    embassy_time::Instant::now().as_micros() as u32
}

/// Notes that `task` still runs.
pub(crate) fn sign(task: Task) {
    task.sign().store(micros(), Ordering::Relaxed);
}

/// A task that has not signed for too long.
pub(crate) fn silent() -> Option<Task> {
    // In this order: a task that signs between the two lines must not seem to sign in the future.
    let signs = Task::ALL.map(|task| (task, task.sign().load(Ordering::Relaxed)));
    let now = micros();
    signs
        .into_iter()
        .find(|(task, sign)| now.wrapping_sub(*sign) > task.limit())
        .map(|(task, _)| task)
}

/// A counter that one task increments and others read, mostly of errors.
pub(crate) struct Tally(AtomicU32);

impl Tally {
    pub(crate) const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Adds one.
    pub(crate) fn count(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn set(&self, value: u32) {
        self.0.store(value, Ordering::Relaxed);
    }

    pub(crate) fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Starts the counter of the processor's cycles, by which the control loop is timed.
pub(crate) fn start_cycle_counter() {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
}

/// The task, which logs once a second.
#[embassy_executor::task]
pub(crate) async fn run(shared: &'static Shared) -> ! {
    let mut ticker = Ticker::every(Duration::from_secs(1));
    loop {
        ticker.next().await;
        sign(Task::Health);
        let timing = control::take_timing();
        defmt::info!(
            "control: step {=u32} µs, period {=u32} to {=u32} µs; stack {=u32} of {=u32} bytes",
            timing.longest_step,
            timing.shortest_period,
            timing.longest_period,
            stack::used(),
            stack::size(),
        );
        defmt::info!(
            "errors: gyro {=u32}, lost {=u32}; accel {=u32}, lost {=u32}; flow {=u32}; rangers {=u32}; radio {=u32}, dropped {=u32}; mailbox {=u32}",
            imu::GYRO.errors.get(),
            imu::GYRO.losses.get(),
            imu::ACCEL.errors.get(),
            imu::ACCEL.losses.get(),
            flow::ERRORS.get(),
            rangers::errors(),
            radio::ERRORS.get(),
            radio::DROPPED.get(),
            shared.with(|drone| drone.dropped_reports()).unwrap_or_default(),
        );
        if let Some(fault) = radio::hardware_fault() {
            defmt::warn!("hardware: {}", fault);
        }
        if let Some(status) = control::STATUS.get() {
            defmt::info!("{}, {=f32} V", status.mode, status.battery.volts.0);
        }
        match store::choice() {
            Choice::Unread => defmt::info!("settings: not read yet"),
            Choice::Settled { from, .. } => defmt::debug!("settings: {}", from),
        }
        let status = shared.with(|drone| drone.link_status()).flatten();
        let counters = shared.with(|drone| drone.link_counters()).flatten();
        match (store::keys_state(), status, counters) {
            (KeysState::Held { .. }, Some(status), Some(counters)) => {
                defmt::info!("link: {}", status);
                defmt::debug!("{}", counters);
            }
            (state, ..) => defmt::info!("link: shut, keys: {}", state),
        }
    }
}
