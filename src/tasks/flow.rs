//! Optic flow: a hundred times a second, how far the ground has moved.

use embassy_embedded_hal::shared_bus::asynch::spi::SpiDevice;
use embassy_stm32::gpio::Output;
use embassy_stm32::mode::Async;
use embassy_stm32::spi::{Spi, mode::Master};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Delay, Duration, Ticker, with_timeout};
use sensors::bus::{Health, HealthConfig};
use sensors::pmw3901::{Motion, Pmw3901};

use crate::board::FlowParts;
use crate::board::clock;
use crate::tasks::health::{self, Tally, Task};
use crate::tasks::latest::Latest;

/// The counts since the control loop took them last.
pub(crate) static MOTION: Latest<Option<Motion>> = Latest::new(None);

/// The last reading, for clients.
static LATEST: Latest<Option<Motion>> = Latest::new(None);

/// The last reading; `None` until the sensor has answered.
pub(crate) fn latest() -> Option<Motion> {
    LATEST.get()
}

/// Whether the sensor has answered since boot.
pub(crate) fn is_there() -> bool {
    LATEST.get().is_some()
}

/// Readings that failed.
pub(crate) static ERRORS: Tally = Tally::new();

/// The vendor's rate (crazyflie-firmware, `flowdeck_v1v2.c`).
const ROUND: Duration = Duration::from_millis(10);
/// Bringing it up takes 80 ms.
const INIT_LIMIT: Duration = Duration::from_millis(500);
/// A reading takes 0.25 ms.
const READ_LIMIT: Duration = Duration::from_millis(5);

/// The driver, on a bus that no other device shares.
type Sensor<'a> =
    Pmw3901<SpiDevice<'a, NoopRawMutex, Spi<'static, Async, Master>, Output<'static>>>;

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(parts: FlowParts) -> ! {
    let bus = Mutex::<NoopRawMutex, _>::new(parts.bus);
    let mut sensor = Pmw3901::new(SpiDevice::new(&bus, parts.select));
    let mut trust = Health::new(HealthConfig::DEFAULT, clock::now());
    let mut ticker = Ticker::every(ROUND);
    loop {
        health::sign(Task::Flow);
        if !trust.is_lost(clock::now()) {
            read(&mut sensor, &mut trust).await;
        } else if trust.may_retry(clock::now()) {
            bring_up(&mut sensor, &mut trust).await;
            ticker.reset();
        }
        ticker.next().await;
    }
}

async fn read(sensor: &mut Sensor<'_>, trust: &mut Health) {
    match with_timeout(READ_LIMIT, sensor.read_motion(&mut Delay)).await {
        Ok(Ok(motion)) => {
            MOTION.set(Some(motion));
            LATEST.set(Some(motion));
            trust.good(clock::now());
        }
        Ok(Err(_)) | Err(_) => {
            ERRORS.count();
            trust.bad(clock::now());
            if trust.is_lost(clock::now()) {
                defmt::warn!("optic flow: lost");
            }
        }
    }
}

async fn bring_up(sensor: &mut Sensor<'_>, trust: &mut Health) {
    match with_timeout(INIT_LIMIT, sensor.init(&mut Delay)).await {
        Ok(Ok(())) => {
            defmt::info!("optic flow: up");
            trust.started(clock::now());
        }
        Ok(Err(_)) | Err(_) => {
            ERRORS.count();
            trust.bad(clock::now());
        }
    }
}
