//! One ranger's way from its reset to its readings, and back.

use embedded_hal_async::i2c::I2c;
use units::{Duration, Instant};

use super::{Beam, BeamState};
use crate::Error;
use crate::bus::{Health, HealthConfig};
use crate::vl53l1x::{self, Config, RangeStatus, Reading, Vl53l1x};

/// The first measurement must be over by its budget and this.
const CALIBRATION_LIMIT: Duration = Duration::from_millis(100);

/// How long after a reading there is certainly no other: three quarters of the period leave room
/// for the oscillator and for a reading that was asked for a poll late. With a poll each 5 ms and
/// readings each 25 to 33, five of six questions would be for what is not there.
const fn quiet(config: &Config) -> Duration {
    Duration::from_micros(config.period.as_micros() * 3 / 4)
}

/// How far a ranger has come. See the picture in the [module above](super).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stage {
    /// In reset, if it has a line; otherwise not to be relied on.
    Off,
    /// Let out of reset, at 0x29.
    Booting { since: Instant },
    /// At its own address, making its first measurement.
    Calibrating { since: Instant },
    /// Ranging: the number of its last measurement, and when it is worth asking for the next.
    Ranging { stream: Option<u8>, asked_from: Instant },
}

/// A ranger's place.
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

    /// Whether it should have its own address.
    pub(super) const fn is_up(&self) -> bool {
        matches!(self.stage, Stage::Calibrating { .. } | Stage::Ranging { .. })
    }

    /// Whether it has failed and not come up since.
    pub(super) const fn has_failed(&self) -> bool {
        !matches!(self.stage, Stage::Ranging { .. }) && self.last_error.is_some()
    }

    /// Whether it should be brought up now.
    pub(super) fn is_due(&self, now: Instant) -> bool {
        self.config.is_some() && self.stage == Stage::Off && self.health.may_retry(now)
    }

    /// Gives it up until its next turn.
    pub(super) fn fail(&mut self, error: Error<E>, now: Instant) {
        self.last_error = Some(error);
        self.stage = Stage::Off;
        self.health.lose(now);
    }

    /// One step on, with the reading that it brought.
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

    /// Gives it up if it should be at its own address and is not. An error is the bus's.
    pub(super) async fn audit<I2C>(&mut self, i2c: &mut I2C, now: Instant) -> Result<(), Error<E>>
    where
        I2C: I2c<Error = E>,
    {
        if self.is_up() && !vl53l1x::answers(i2c, self.beam.address()).await? {
            self.fail(Error::Timeout, now);
        }
        Ok(())
    }

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
            let asked_from = now + quiet(config);
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
