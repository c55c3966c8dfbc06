//! [`Slot`], the state of one ranger from its reset to its readings.

use embedded_hal_async::i2c::I2c;
use units::{Duration, Instant};

use super::{Beam, BeamState};
use crate::Error;
use crate::bus::{Health, HealthConfig};
use crate::vl53l1x::{self, Config, RangeStatus, Reading, Vl53l1x};

/// Time beyond the budget that the first measurement may take.
const CALIBRATION_LIMIT: Duration = Duration::from_millis(100);

/// Time after a reading in which there is certainly no other, so that the sensor is not asked.
/// Three quarters of the period leave a margin for the oscillator and for a reading that came a
/// poll late. With a poll every 5 ms and a reading every 25 to 33 ms, five of six questions would
/// otherwise be in vain.
const fn pause(config: &Config) -> Duration {
    Duration::from_micros(config.period.as_micros() * 3 / 4)
}

/// The stage of a ranger in the sequence that the [module above](super) draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stage {
    /// The ranger is in reset if it has a reset line; otherwise its state is unknown.
    Off,
    /// The ranger was released from reset at `since`, and will answer at 0x29.
    Booting { since: Instant },
    /// The ranger has its own address and has been making its first measurement since `since`.
    Calibrating { since: Instant },
    /// The ranger ranges. `stream` is the count of its last measurement; it is asked for the next
    /// one from `asked_from` on.
    Ranging { stream: Option<u8>, asked_from: Instant },
}

/// One ranger with its configuration, stage and health.
#[derive(Debug)]
pub(super) struct Slot<E> {
    pub(super) beam: Beam,
    pub(super) config: Option<Config>,
    pub(super) stage: Stage,
    pub(super) health: Health,
    pub(super) last_error: Option<Error<E>>,
}

impl<E: embedded_hal::i2c::Error> Slot<E> {
    pub(super) const fn new(
        beam: Beam,
        config: Option<Config>,
        health: HealthConfig,
        now: Instant,
    ) -> Self {
        let health = Health::new(health, now);
        Self { beam, config, stage: Stage::Off, health, last_error: None }
    }

    pub(super) const fn state(&self) -> BeamState {
        match (self.config, self.stage) {
            (None, _) => BeamState::Unused,
            (Some(_), Stage::Off) => BeamState::Lost,
            (Some(_), Stage::Booting { .. } | Stage::Calibrating { .. }) => BeamState::Starting,
            (Some(_), Stage::Ranging { .. }) => BeamState::Live,
        }
    }

    /// Whether the ranger should answer at its own address.
    pub(super) const fn is_up(&self) -> bool {
        matches!(self.stage, Stage::Calibrating { .. } | Stage::Ranging { .. })
    }

    /// Whether the ranger has failed and does not range since.
    pub(super) const fn has_failed(&self) -> bool {
        !matches!(self.stage, Stage::Ranging { .. }) && self.last_error.is_some()
    }

    /// Whether the ranger is to be started now.
    pub(super) fn is_due(&self, now: Instant) -> bool {
        self.config.is_some() && self.stage == Stage::Off && self.health.may_retry(now)
    }

    /// Marks the ranger as lost until its next attempt.
    pub(super) fn fail(&mut self, error: Error<E>, now: Instant) {
        self.last_error = Some(error);
        self.stage = Stage::Off;
        self.health.lose(now);
    }

    /// Takes one step with a ranger that is up, and returns its reading if there is a new one.
    pub(super) async fn advance<I2C>(&mut self, i2c: &mut I2C, now: Instant) -> Option<Reading>
    where
        I2C: I2c<Error = E>,
    {
        let config = self.config?;
        let outcome = match self.stage {
            Stage::Off | Stage::Booting { .. } => return None,
            Stage::Ranging { asked_from, .. } if now < asked_from => return None,
            Stage::Ranging { stream, .. } => return self.range(i2c, now, stream, &config).await,
            Stage::Calibrating { since } => self.calibrate(i2c, now, since, &config).await,
        };
        match outcome {
            Ok(stage) => self.stage = stage,
            Err(error) => self.fail(error, now),
        }
        None
    }

    /// Marks the ranger as lost if it should answer at its own address and does not. Returns an
    /// error of the bus.
    pub(super) async fn check_address<I2C>(
        &mut self,
        i2c: &mut I2C,
        now: Instant,
    ) -> Result<(), Error<E>>
    where
        I2C: I2c<Error = E>,
    {
        if self.is_up() && !vl53l1x::answers(i2c, self.beam.address()).await? {
            self.fail(Error::Timeout, now);
        }
        Ok(())
    }

    /// Starts ranging if the first measurement is over.
    async fn calibrate<I2C>(
        &mut self,
        i2c: &mut I2C,
        now: Instant,
        since: Instant,
        config: &Config,
    ) -> Result<Stage, Error<E>>
    where
        I2C: I2c<Error = E>,
    {
        let mut sensor = Vl53l1x::new(i2c, self.beam.address());
        if sensor.end_calibration().await? {
            sensor.start().await?;
            self.health.started(now);
            return Ok(Stage::Ranging { stream: None, asked_from: now });
        }
        if now.since(since) < config.budget + CALIBRATION_LIMIT {
            Ok(self.stage)
        } else {
            Err(Error::Timeout)
        }
    }

    /// Reads the next measurement, and updates the ranger's health.
    async fn range<I2C>(
        &mut self,
        i2c: &mut I2C,
        now: Instant,
        stream: Option<u8>,
        config: &Config,
    ) -> Option<Reading>
    where
        I2C: I2c<Error = E>,
    {
        let polled = Vl53l1x::new(i2c, self.beam.address()).poll().await;
        let new = match polled {
            Ok(reading) => reading.filter(|reading| Some(reading.stream) != stream),
            Err(error) => {
                self.last_error = Some(error);
                self.health.bad(now);
                if self.health.is_lost(now) {
                    self.stage = Stage::Off;
                }
                return None;
            }
        };
        if let Some(reading) = new {
            let asked_from = now + pause(config);
            self.stage = Stage::Ranging { stream: Some(reading.stream), asked_from };
            match reading.status {
                RangeStatus::Hardware(_) => self.health.bad(now),
                _ => self.health.good(now),
            }
        }
        if self.health.is_lost(now) {
            self.last_error = Some(Error::Timeout);
            self.stage = Stage::Off;
        }
        new
    }
}
