//! Recovery of a hung I²C bus ([`recover`]), and the decision when a device counts as lost and when
//! it is tried again ([`Health`]).

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::delay::DelayNs;
use units::{Duration, Instant};

/// Half a clock period of the recovery in µs: 100 kHz, which any device follows.
const HALF_CLOCK: u32 = 5;

/// Number of clocks after which every device that was interrupted while sending has released SDA:
/// eight bits and the acknowledgement (UM10204, section 3.1.16).
const CLOCKS: u8 = 9;

/// Frees a bus whose SDA a device holds low because it was interrupted in the middle of a byte:
/// sends up to nine clocks until the device releases SDA, then a stop. Returns whether SDA is free.
///
/// Both pins must be open-drain outputs, taken from the I²C peripheral while this function runs;
/// the peripheral must be initialised again afterwards. If a pin fails, the bus counts as not free.
pub async fn recover<Scl, Sda, D>(scl: &mut Scl, sda: &mut Sda, delay: &mut D) -> bool
where
    Scl: OutputPin,
    Sda: OutputPin + InputPin,
    D: DelayNs,
{
    free_sda(scl, sda, delay).await.unwrap_or(false)
}

/// Does the work of [`recover`], and returns `None` if a pin failed.
async fn free_sda<Scl, Sda, D>(scl: &mut Scl, sda: &mut Sda, delay: &mut D) -> Option<bool>
where
    Scl: OutputPin,
    Sda: OutputPin + InputPin,
    D: DelayNs,
{
    sda.set_high().ok()?;
    scl.set_high().ok()?;
    delay.delay_us(HALF_CLOCK).await;
    for _ in 0..CLOCKS {
        if sda.is_high().ok()? {
            break;
        }
        scl.set_low().ok()?;
        delay.delay_us(HALF_CLOCK).await;
        scl.set_high().ok()?;
        delay.delay_us(HALF_CLOCK).await;
    }
    scl.set_low().ok()?;
    sda.set_low().ok()?;
    delay.delay_us(HALF_CLOCK).await;
    scl.set_high().ok()?;
    delay.delay_us(HALF_CLOCK).await;
    sda.set_high().ok()?;
    delay.delay_us(HALF_CLOCK).await;
    sda.is_high().ok()
}

/// The limits by which a device counts as lost and is tried again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthConfig {
    /// The number of errors in a row that a device may have without being lost.
    pub tolerated: u8,
    /// A device that has delivered nothing new for this long is lost.
    pub silence: Duration,
    /// The time from the loss to the first attempt to bring the device up again. Each attempt that
    /// fails doubles the time to the next.
    pub first_retry: Duration,
    /// The longest time between two attempts.
    pub longest_retry: Duration,
}

impl HealthConfig {
    /// The values for a device that is read some tens of times a second. They are chosen, not
    /// measured: three errors in a row are no accident on a bus that loses one transaction in a
    /// thousand; in a quarter of a second a drone at 0.4 m/s flies 10 cm without new readings;
    /// attempts every two seconds to start a device that has failed for good take hardly any time
    /// from the other devices on the bus.
    pub const DEFAULT: Self = Self {
        tolerated: 2,
        silence: Duration::from_millis(250),
        first_retry: Duration::from_millis(50),
        longest_retry: Duration::from_secs(2),
    };
}

impl Default for HealthConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The health of a device: its owner reports the outcome of each read, and asks whether the device
/// is lost and when to try it again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    config: HealthConfig,
    state: State,
    /// The wait after the next failure. Only new data from the device makes it short again, so that
    /// a device which starts and fails over and over is not tried all the time.
    wait: Duration,
    errors: u32,
    losses: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum State {
    /// The device delivered something last at `heard`, and has had `errors` errors since.
    Working { heard: Instant, errors: u8 },
    /// The device is lost, and is tried again from `retry_at` on.
    Lost { retry_at: Instant },
}

impl Health {
    /// The health of a device that has not been started: it is lost, and is tried at once.
    #[must_use]
    pub const fn new(config: HealthConfig, now: Instant) -> Self {
        Self {
            config,
            state: State::Lost { retry_at: now },
            wait: config.first_retry,
            errors: 0,
            losses: 0,
        }
    }

    /// Records that the device was started. It counts as lost again if it delivers nothing for
    /// [`HealthConfig::silence`].
    pub fn started(&mut self, now: Instant) {
        self.state = State::Working { heard: now, errors: 0 };
    }

    /// Records that the device delivered something new.
    pub fn good(&mut self, now: Instant) {
        self.started(now);
        self.wait = self.config.first_retry;
    }

    /// Records that a transaction with the device failed.
    pub fn bad(&mut self, now: Instant) {
        self.errors = self.errors.saturating_add(1);
        match self.state {
            State::Working { errors, .. } if errors >= self.config.tolerated => self.lose(now),
            State::Working { heard, errors } => {
                self.state = State::Working { heard, errors: errors.saturating_add(1) };
            }
            State::Lost { .. } => self.lose(now),
        }
    }

    /// Whether the device is lost at `now`: it has been silent for too long, or was lost before.
    pub fn is_lost(&mut self, now: Instant) -> bool {
        match self.state {
            State::Working { heard, .. } if now.since(heard) >= self.config.silence => {
                self.lose(now);
                true
            }
            State::Working { .. } => false,
            State::Lost { .. } => true,
        }
    }

    /// Marks the device as lost. If it is lost already, the next attempt is put off.
    pub fn lose(&mut self, now: Instant) {
        if matches!(self.state, State::Working { .. }) {
            self.losses = self.losses.saturating_add(1);
        }
        self.state = State::Lost { retry_at: now + self.wait };
        let doubled = self.wait + self.wait;
        self.wait = doubled.min(self.config.longest_retry);
    }

    /// Whether the device is lost and it is time to try it again.
    #[must_use]
    pub fn may_retry(&self, now: Instant) -> bool {
        match self.state {
            State::Working { .. } => false,
            State::Lost { retry_at } => now >= retry_at,
        }
    }

    /// Number of failed transactions since the beginning.
    #[must_use]
    pub const fn errors(&self) -> u32 {
        self.errors
    }

    /// Number of times that the device was lost after it had been started.
    #[must_use]
    pub const fn losses(&self) -> u32 {
        self.losses
    }
}
