//! The inertial sensor: a gyroscope, whose samples set the control loop's pace, and an
//! accelerometer, read after each of them.
//!
//! The two dies share only a bus, and each has a task of its own, so that one goes on when the other
//! fails. A sample of both takes 0.42 ms of the bus, which leaves room in each millisecond to bring
//! one of them up.

use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::signal::Signal;
use embassy_time::{Delay, Duration, Timer, with_timeout};
use sensors::Level;
use sensors::bmi088::{Accel, Die, Gyro, Keeper};
use units::{Acceleration, AngularVelocity};

use crate::board::Edge;
use crate::board::bus::Bus;
use crate::board::clock;
use crate::tasks::health::{self, Tally, Task};
use crate::tasks::latest::Latest;
use crate::tasks::store;

/// The sensor's bus, for the two tasks of this module.
pub(crate) type ImuBus = Mutex<CriticalSectionRawMutex, Bus>;
type Share = I2cDevice<'static, CriticalSectionRawMutex, Bus>;

/// The gyroscope's latest sample, for the control task alone, which it wakes.
pub(crate) static RATES: Signal<CriticalSectionRawMutex, AngularVelocity> = Signal::new();
/// The accelerometer's, until the control loop takes it: a millisecond old by then, because the
/// gyroscope's starts the loop's step, and the accelerometer is read after it.
pub(crate) static FORCE: Latest<Option<Acceleration>> = Latest::new(None);

/// The errors of the gyroscope.
pub(crate) static GYRO: Troubles = Troubles::new();
/// The errors of the accelerometer.
pub(crate) static ACCEL: Troubles = Troubles::new();

/// Signalled when the gyroscope has been read, or should have been: the accelerometer may use the
/// bus.
static TURN: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Samples come 1000 times a second, so this is two of them missed.
const SILENCE: Duration = Duration::from_micros(2_500);
/// Without a gyroscope the accelerometer is read as often.
const PATIENCE: Duration = Duration::from_millis(2);
/// The pause between polls of a die that is being brought up.
const PAUSE: Duration = Duration::from_millis(1);

/// The error counters of a die.
pub(crate) struct Troubles {
    /// Samples that could not be read, or did not come, and attempts to bring it up that failed.
    pub(crate) errors: Tally,
    /// How often the die was lost.
    pub(crate) losses: Tally,
}

impl Troubles {
    const fn new() -> Self {
        Self { errors: Tally::new(), losses: Tally::new() }
    }

    fn publish<D: Die>(&self, die: &Keeper<Share, D>) {
        self.errors.set(die.errors());
        self.losses.set(die.losses());
    }
}

/// The gyroscope's task, on the control executor.
#[embassy_executor::task]
pub(crate) async fn gyro(bus: &'static ImuBus, mut ready: Edge) -> ! {
    let mut die = Keeper::<_, Gyro>::new(I2cDevice::new(bus), clock::now());
    loop {
        health::sign(Task::Gyro);
        if die.is_lost(clock::now()) {
            revive(&mut die).await;
        } else {
            match with_timeout(SILENCE, ready.wait_for_rising_edge()).await {
                Ok(()) => {
                    if let Some(rates) = die.read(clock::now).await {
                        RATES.signal(rates);
                    }
                }
                Err(_) => die.missed(clock::now()),
            }
            TURN.signal(());
        }
        GYRO.publish(&die);
    }
}

/// The accelerometer's task, on the control executor.
#[embassy_executor::task]
pub(crate) async fn accel(bus: &'static ImuBus) -> ! {
    let mut die = Keeper::<_, Accel>::new(I2cDevice::new(bus), clock::now());
    let mut level = None;
    loop {
        health::sign(Task::Accel);
        if die.is_lost(clock::now()) {
            revive(&mut die).await;
        } else {
            // Without the signal the accelerometer takes the bus all the same.
            let _ = with_timeout(PATIENCE, TURN.wait()).await;
            let force = die.read(clock::now).await;
            // The settings may be read a little later than the first samples.
            level = level.or_else(|| store::trim().map(|trim| Level::new(trim.roll, trim.pitch)));
            if let Some(force) = force {
                FORCE.set(Some(level.map_or(force, |level| level.apply(force))));
            }
        }
        ACCEL.publish(&die);
    }
}

async fn revive<D: Die>(die: &mut Keeper<Share, D>) {
    die.bring_up(clock::now, &mut Delay).await;
    if die.is_lost(clock::now()) {
        Timer::after(PAUSE).await;
    }
}
