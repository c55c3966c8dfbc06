//! An I²C bus that hangs, and devices that come and go: how to free the one, and when to give up
//! the other and try it again.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::delay::DelayNs;
use units::{Duration, Instant};

/// Half a clock of the recovery in µs: 100 kHz, which any device follows.
const HALF_CLOCK: u32 = 5;

/// The clocks after which every device that was interrupted while sending has let go of SDA:
/// eight bits and the acknowledgement (UM10204, section 3.1.16).
const CLOCKS: u8 = 9;

/// Frees a bus whose SDA a device holds low because it was interrupted in the middle of a byte:
/// up to nine clocks until it lets go, then a stop. Returns whether SDA is free.
///
/// Both pins must be open-drain outputs, taken from the I²C peripheral for as long as this lasts;
/// the peripheral is to be initialised again afterwards. A pin that fails counts as a bus that is
/// not free.
pub async fn recover<Scl, Sda, D>(scl: &mut Scl, sda: &mut Sda, delay: &mut D) -> bool
where
    Scl: OutputPin,
    Sda: OutputPin + InputPin,
    D: DelayNs,
{
    free(scl, sda, delay).await.unwrap_or(false)
}

/// As [`recover`]; `None` where a pin failed.
async fn free<Scl, Sda, D>(scl: &mut Scl, sda: &mut Sda, delay: &mut D) -> Option<bool>
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

/// When a device counts as lost, and when it is tried again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthConfig {
    /// As many errors in a row are put up with.
    pub tolerated: u8,
    /// A device that has said nothing new for this long is lost.
    pub silence: Duration,
    /// The first attempt to have it back comes this long after the loss. After each that fails the
    /// wait is doubled,
    pub first_retry: Duration,
    /// up to this.
    pub longest_retry: Duration,
}

impl HealthConfig {
    /// For a device that is read some tens of times a second. Chosen, not measured: three errors in
    /// a row are no accident on a bus that loses one transaction in a thousand; in a quarter of a
    /// second a drone at 0.4 m/s flies 10 cm without seeing; two seconds apart, attempts at a
    /// device that is gone for good cost the others nothing that they would notice.
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

/// Whether a device can be relied on: told what its reads gave, it says when the device is lost
/// and when to try it again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    config: HealthConfig,
    state: Trust,
    /// The wait after the next failure. Only a device that delivers something makes it short
    /// again, so that one which starts and dies, starts and dies is not tried all the time.
    wait: Duration,
    errors: u32,
    losses: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Trust {
    Trusted { heard: Instant, errors: u8 },
    Lost { retry_at: Instant },
}

impl Health {
    /// A device that has not been started: lost, and due at once.
    #[must_use]
    pub const fn new(config: HealthConfig, now: Instant) -> Self {
        Self {
            config,
            state: Trust::Lost { retry_at: now },
            wait: config.first_retry,
            errors: 0,
            losses: 0,
        }
    }

    /// The device was started again; it has until the silence is over to deliver something.
    pub fn started(&mut self, now: Instant) {
        self.state = Trust::Trusted { heard: now, errors: 0 };
    }

    /// The device delivered something new.
    pub fn good(&mut self, now: Instant) {
        self.started(now);
        self.wait = self.config.first_retry;
    }

    /// A transaction with the device failed.
    pub fn bad(&mut self, now: Instant) {
        self.errors = self.errors.saturating_add(1);
        match self.state {
            Trust::Trusted { errors, .. } if errors >= self.config.tolerated => self.lose(now),
            Trust::Trusted { heard, errors } => {
                self.state = Trust::Trusted { heard, errors: errors.saturating_add(1) };
            }
            Trust::Lost { .. } => self.lose(now),
        }
    }

    /// Time has passed: whether the device has been silent for too long, or was lost before.
    pub fn is_lost(&mut self, now: Instant) -> bool {
        match self.state {
            Trust::Trusted { heard, .. } if now.since(heard) >= self.config.silence => {
                self.lose(now);
                true
            }
            Trust::Trusted { .. } => false,
            Trust::Lost { .. } => true,
        }
    }

    /// Gives the device up, or puts off the next attempt at one that is lost.
    pub fn lose(&mut self, now: Instant) {
        if matches!(self.state, Trust::Trusted { .. }) {
            self.losses = self.losses.saturating_add(1);
        }
        self.state = Trust::Lost { retry_at: now + self.wait };
        let doubled = self.wait + self.wait;
        self.wait = doubled.min(self.config.longest_retry);
    }

    /// Whether the device is lost and the time has come to try it again.
    #[must_use]
    pub fn may_retry(&self, now: Instant) -> bool {
        match self.state {
            Trust::Trusted { .. } => false,
            Trust::Lost { retry_at } => now >= retry_at,
        }
    }

    /// Failed transactions since the beginning.
    #[must_use]
    pub const fn errors(&self) -> u32 {
        self.errors
    }

    /// How often the device was given up after it had been started.
    #[must_use]
    pub const fn losses(&self) -> u32 {
        self.losses
    }
}
