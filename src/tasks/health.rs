//! Whether everybody is still alive, and how near to its limits the firmware runs.
//!
//! Each task gives a sign of life in every round, and each has a time within which the next must
//! come. What happens to one that falls silent depends on where the drone is. On the ground the
//! control task ends the run, with the silent task's name as the reason. In the air it does not: a
//! reset is a fall, and the flight code lands by itself on what the silent task no longer brings.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_time::{Duration, Ticker};

use crate::safety::stack;
use crate::tasks::drone::Shared;
use crate::tasks::store::{Choice, KeysState};
use crate::tasks::{control, flow, imu, radio, rangers, store};

/// The tasks that owe a sign of life. The control task owes none: it checks the others.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Task {
    Gyro,
    Accel,
    Flow,
    Rangers,
    Receive,
    Transmit,
    Mission,
    Store,
    Lamps,
    Health,
}

impl Task {
    const ALL: [Self; 10] = [
        Self::Gyro,
        Self::Accel,
        Self::Flow,
        Self::Rangers,
        Self::Receive,
        Self::Transmit,
        Self::Mission,
        Self::Store,
        Self::Lamps,
        Self::Health,
    ];

    /// The longest that each may take for a round, by the sum of its own limits, and half as much
    /// again. In µs.
    const fn limit(self) -> u32 {
        match self {
            // Bringing a sensor up that answers every question too late.
            Self::Gyro => 1_500_000,
            Self::Accel => 1_500_000,
            Self::Flow => 1_500_000,
            Self::Rangers => 1_500_000,
            Self::Receive => 1_500_000,
            Self::Transmit => 1_500_000,
            Self::Mission => 1_000_000,
            Self::Store => 3_000_000,
            Self::Lamps => 1_000_000,
            Self::Health => 3_000_000,
        }
    }

    /// What the next boot reports when it fell silent.
    pub(crate) const fn silence(self) -> &'static str {
        match self {
            Self::Gyro => "the gyroscope's task fell silent",
            Self::Accel => "the accelerometer's task fell silent",
            Self::Flow => "the optic flow's task fell silent",
            Self::Rangers => "the rangers' task fell silent",
            Self::Receive => "the radio's receiving task fell silent",
            Self::Transmit => "the radio's sending task fell silent",
            Self::Mission => "the mission's task fell silent",
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
            Self::Store => &SIGNS.store,
            Self::Lamps => &SIGNS.lamps,
            Self::Health => &SIGNS.health,
        }
    }
}

/// When each gave its last sign, in µs since boot. They wrap after 71 minutes, and so does their
/// difference to now.
struct Signs {
    gyro: AtomicU32,
    accel: AtomicU32,
    flow: AtomicU32,
    rangers: AtomicU32,
    receive: AtomicU32,
    transmit: AtomicU32,
    mission: AtomicU32,
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
    store: AtomicU32::new(0),
    lamps: AtomicU32::new(0),
    health: AtomicU32::new(0),
};

fn micros() -> u32 {
    embassy_time::Instant::now().as_micros() as u32
}

/// `task` is alive.
pub(crate) fn sign(task: Task) {
    task.sign().store(micros(), Ordering::Relaxed);
}

/// A task that has been silent for too long.
pub(crate) fn silent() -> Option<Task> {
    // A sign that is given between the two lines must not look like one from the future.
    let signs = Task::ALL.map(|task| (task, task.sign().load(Ordering::Relaxed)));
    let now = micros();
    signs
        .into_iter()
        .find(|(task, sign)| now.wrapping_sub(*sign) > task.limit())
        .map(|(task, _)| task)
}

/// A number that one task keeps and others look at: errors, mostly.
pub(crate) struct Tally(AtomicU32);

impl Tally {
    pub(crate) const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// One more.
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

/// The task: once a second, what there is to say.
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
