//! Six rangers on one bus: the Flow deck's, which looks down, and the Multi-ranger deck's five.
//!
//! All of them answer at 0x29 after their reset, and each must be moved to an address of its own
//! while no other is there. The Multi-ranger deck can hold its five in reset; the one that looks
//! down it cannot, so that one moves first. Any of them may lose its supply for a moment in the
//! air and be back at 0x29, so bringing up and bringing back are one and the same road, taken one
//! ranger at a time while the others range on:
//!
//! ```text
//!        due ┌─────────┐ 2 ms  ┌─────────────┐ one measurement ┌─────────┐
//!  Off ─────>│ Booting │──────>│ Calibrating │────────────────>│ Ranging │
//!   ^        └────┬────┘       └──────┬──────┘                 └────┬────┘
//!   └─────────────┴───────────────────┴─────── errors, silence ─────┘
//! ```
//!
//! Nobody's wall must ever be taken for the ground. So whoever is at 0x29 is moved only when it is
//! certain who it is:
//!
//! - Every ranger that is thought to be up is asked at its own address just before. One that
//!   answers there cannot be at 0x29 until it has booted, which takes it longer than the move.
//! - Rangers with a reset line that are not up are in reset, and the expander confirms it just
//!   before.
//! - Where the configuration knows of no rangers with a line, no expander answers.
//! - A ranger with a line leaves its reset only while the one without answers at its own address.
//!   While that one is lost, those that range go on, and those that do not wait for it.
//!
//! [`MultiRanger::poll`] never waits. It makes a bounded number of transactions, and is to be
//! called 100 times a second or more.

mod counted;
mod decks;
mod slot;

use embedded_hal_async::i2c::I2c;
use units::{Duration, Instant};

use crate::Error;
use crate::bus::HealthConfig;
use crate::error::is_absence;
use crate::expander::{Expander, Lines};
use crate::vl53l1x::{self, DEFAULT_ADDRESS, Reading, Vl53l1x};
pub use decks::DeckProbe;

use counted::Counted;
use slot::{Slot, Stage};

/// A ranger let out of its reset is not asked before this (crazyflie-firmware, `multiranger.c`;
/// the data sheet says 1.2 ms).
const BOOT: Duration = Duration::from_millis(2);
/// A ranger that does not answer by then will not.
const BOOT_LIMIT: Duration = Duration::from_millis(20);

/// Where a ranger looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Beam {
    /// At the ground, from the Flow deck.
    Down,
    /// Forward.
    Front,
    /// Backward.
    Back,
    /// At the ceiling.
    Up,
    /// To the left.
    Left,
    /// To the right.
    Right,
}

impl Beam {
    /// All six, in the order in which they are brought up.
    pub const ALL: [Self; 6] =
        [Self::Down, Self::Front, Self::Back, Self::Up, Self::Left, Self::Right];

    /// The I²C address that it is given: the vendor's firmware uses 0x6A to 0x6F as well, but
    /// numbers them in the order of its decks.
    #[must_use]
    pub const fn address(self) -> u8 {
        match self {
            Self::Down => 0x6A,
            Self::Front => 0x6B,
            Self::Back => 0x6C,
            Self::Up => 0x6D,
            Self::Left => 0x6E,
            Self::Right => 0x6F,
        }
    }

    /// The line that holds it in reset; none for the one that looks down.
    const fn line(self) -> Lines {
        match self {
            Self::Down => Lines::NONE,
            Self::Front => Lines::FRONT,
            Self::Back => Lines::BACK,
            Self::Up => Lines::UP,
            Self::Left => Lines::LEFT,
            Self::Right => Lines::RIGHT,
        }
    }
}

/// What a ranger is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeamState {
    /// It ranges.
    Live,
    /// It is being brought up.
    Starting,
    /// It failed, or was never there, and is tried again from time to time.
    Lost,
    /// The configuration does without it.
    Unused,
}

/// Which rangers there are and how they range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RangerConfig {
    /// The one that looks down. While it is lost no other is brought up. Without it the Flow deck
    /// must not be there either: its ranger would keep 0x29 occupied.
    pub down: Option<vl53l1x::Config>,
    /// Front, back, left and right.
    pub sides: Option<vl53l1x::Config>,
    /// The one that looks up.
    pub up: Option<vl53l1x::Config>,
    /// When one counts as lost, and when it is tried again.
    pub health: HealthConfig,
}

impl RangerConfig {
    /// The Flow deck alone. Never for a drone that carries a Multi-ranger deck: its rangers, not
    /// held in reset, would answer together with the one that looks down. As long as an expander
    /// answers nobody is moved away from 0x29.
    pub const FLOW_DECK: Self = Self { sides: None, up: None, ..Self::DEFAULT };

    /// The Multi-ranger deck alone: the sides range, and nobody looks down.
    pub const MULTI_RANGER: Self = Self { down: None, ..Self::DEFAULT };

    /// Both decks, every beam.
    pub const DEFAULT: Self = Self {
        down: Some(vl53l1x::Config::DOWN),
        sides: Some(vl53l1x::Config::SIDE),
        up: Some(vl53l1x::Config::SIDE),
        health: HealthConfig::DEFAULT,
    };

    const fn of(&self, beam: Beam) -> Option<vl53l1x::Config> {
        match beam {
            Beam::Down => self.down,
            Beam::Front | Beam::Back | Beam::Left | Beam::Right => self.sides,
            Beam::Up => self.up,
        }
    }
}

impl Default for RangerConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What one poll brought: a reading from each ranger that had a new one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sweep {
    readings: [Option<Reading>; 6],
}

impl Sweep {
    /// The new reading of one ranger.
    #[must_use]
    pub fn of(&self, beam: Beam) -> Option<Reading> {
        self.iter().find_map(|(of, reading)| (of == beam).then_some(reading))
    }

    /// All new readings.
    pub fn iter(&self) -> impl Iterator<Item = (Beam, Reading)> {
        Beam::ALL
            .into_iter()
            .zip(self.readings)
            .filter_map(|(beam, reading)| reading.map(|reading| (beam, reading)))
    }
}

/// The driver of both decks' rangers.
#[derive(Debug)]
pub struct MultiRanger<I2C: I2c> {
    bus: Counted<I2C>,
    slots: [Slot<I2C::Error>; 6],
    /// Whether there is a Multi-ranger deck. If so nothing is done at 0x29 unless its expander has
    /// confirmed which of its rangers can be there.
    has_lines: bool,
}

impl<I2C: I2c> MultiRanger<I2C> {
    /// A driver that has not spoken to anybody yet; all rangers count as lost and are due.
    pub fn new(i2c: I2C, config: RangerConfig, now: Instant) -> Self {
        let slots = Beam::ALL.map(|beam| Slot::new(beam, config.of(beam), config.health, now));
        let has_lines = config.sides.is_some() || config.up.is_some();
        Self { bus: Counted::new(i2c), slots, has_lines }
    }

    /// Asks every ranger that is up for a new reading, and goes one step further with those that
    /// are not. `now` must not run backwards.
    pub async fn poll(&mut self, now: Instant) -> Sweep {
        self.bus.begin();
        let mut sweep = Sweep::default();
        for (slot, reading) in self.slots.iter_mut().zip(&mut sweep.readings) {
            *reading = slot.advance(&mut self.bus, now).await;
        }
        self.bring_up_next(now).await;
        sweep
    }

    /// What a ranger is doing.
    #[must_use]
    pub fn state(&self, beam: Beam) -> BeamState {
        self.slot(beam).map_or(BeamState::Unused, Slot::state)
    }

    /// Failed transactions with a ranger while it ranged, since the beginning.
    #[must_use]
    pub fn errors(&self, beam: Beam) -> u32 {
        self.slot(beam).map_or(0, |slot| slot.health.errors())
    }

    /// How often a ranger was lost after it had worked.
    #[must_use]
    pub fn losses(&self, beam: Beam) -> u32 {
        self.slot(beam).map_or(0, |slot| slot.health.losses())
    }

    /// What went wrong with a ranger last.
    #[must_use]
    pub fn last_error(&self, beam: Beam) -> Option<&Error<I2C::Error>> {
        self.slot(beam).and_then(|slot| slot.last_error.as_ref())
    }

    /// Whether every ranger has either come up or failed to at least once, or waits for one that
    /// has: a program that waits for them at its start need not wait any longer.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let waiting = self.slot(Beam::Down).is_some_and(Slot::has_failed);
        self.slots.iter().all(|slot| match slot.state() {
            BeamState::Live | BeamState::Unused => true,
            BeamState::Lost | BeamState::Starting => slot.has_failed() || waiting,
        })
    }

    /// Whether everything that the last poll tried failed, and not because nobody answered:
    /// probably the bus hangs, and its owner should [free it](crate::bus::recover).
    #[must_use]
    pub const fn bus_is_suspect(&self) -> bool {
        self.bus.is_suspect()
    }

    fn slot(&self, beam: Beam) -> Option<&Slot<I2C::Error>> {
        self.slots.iter().find(|slot| slot.beam == beam)
    }

    /// Goes on with the ranger that boots, or else begins with the next one that is due.
    async fn bring_up_next(&mut self, now: Instant) {
        let booting = self.slots.iter().find_map(|slot| match slot.stage {
            Stage::Booting { since } => Some((slot.beam, since)),
            _ => None,
        });
        let ground_is_known = self.ground_is_known();
        let due = self
            .slots
            .iter()
            .find(|slot| slot.is_due(now) && (slot.beam == Beam::Down || ground_is_known))
            .map(|slot| slot.beam);
        let (beam, outcome) = match (booting, due) {
            (Some((beam, since)), _) => (beam, self.finish_boot(beam, since, now).await),
            (None, Some(Beam::Down)) => (Beam::Down, self.claim_down(now).await),
            (None, Some(side)) => (side, self.raise(side, now).await),
            (None, None) => return,
        };
        let Some(slot) = self.slots.iter_mut().find(|slot| slot.beam == beam) else { return };
        match outcome {
            Ok(stage) => slot.stage = stage,
            Err(error) => slot.fail(error, now),
        }
    }

    /// The ranger that looks down is at its own address if only the processor was reset, and at
    /// 0x29 if it was reset itself.
    async fn claim_down(&mut self, now: Instant) -> Result<Stage, Error<I2C::Error>> {
        if !vl53l1x::answers(&mut self.bus, Beam::Down.address()).await? {
            self.reset_all_but_live(now).await?;
            self.take_over(Beam::Down, now).await?;
        }
        self.begin(Beam::Down, now).await
    }

    /// Lets one ranger of the Multi-ranger deck out of its reset.
    async fn raise(&mut self, beam: Beam, now: Instant) -> Result<Stage, Error<I2C::Error>> {
        self.reset_all_but_live(now).await?;
        if vl53l1x::answers(&mut self.bus, DEFAULT_ADDRESS).await? {
            return Err(Error::AddressTaken);
        }
        let lines = self.live_lines() | beam.line();
        Expander::new(&mut self.bus).drive(lines).await?;
        Ok(Stage::Booting { since: now })
    }

    /// Moves the ranger that was let out of its reset to its own address.
    async fn finish_boot(
        &mut self,
        beam: Beam,
        since: Instant,
        now: Instant,
    ) -> Result<Stage, Error<I2C::Error>> {
        let waited = now.since(since);
        if waited < BOOT {
            return Ok(Stage::Booting { since });
        }
        let mut sensor = Vl53l1x::new(&mut self.bus, DEFAULT_ADDRESS);
        match sensor.is_booted().await {
            Ok(true) => {}
            Ok(false) if waited >= BOOT_LIMIT => return Err(Error::Timeout),
            Err(error) if waited >= BOOT_LIMIT || !is_absence(&error) => return Err(error),
            Ok(false) | Err(_) => return Ok(Stage::Booting { since }),
        }
        if vl53l1x::answers(&mut self.bus, beam.address()).await? {
            return Err(Error::AddressTaken);
        }
        self.take_over(beam, now).await?;
        self.begin(beam, now).await
    }

    /// Moves who is at 0x29 to its own address, if no other ranger can have joined it there: one
    /// that answers at its own address now, or is in reset now, is at 0x29 only after it has
    /// booted, 1.2 ms later.
    async fn take_over(&mut self, beam: Beam, now: Instant) -> Result<(), Error<I2C::Error>> {
        Vl53l1x::new(&mut self.bus, DEFAULT_ADDRESS).identify().await?;
        if self.audit(now).await? || !(beam == Beam::Down || self.ground_is_known()) {
            return Err(Error::AddressTaken);
        }
        if self.has_lines {
            // One that was given up since the lines were driven is not in reset yet, and the
            // expander says so.
            let lines = self.live_lines() | beam.line();
            Expander::new(&mut self.bus).confirm(lines).await?;
        } else if Expander::new(&mut self.bus).answers().await? {
            return Err(Error::AddressTaken);
        }
        Vl53l1x::new(&mut self.bus, DEFAULT_ADDRESS).move_to(beam.address()).await
    }

    /// Asks every ranger that is up at its own address, and gives up those that are not there.
    /// Whether there were any.
    async fn audit(&mut self, now: Instant) -> Result<bool, Error<I2C::Error>> {
        let mut missing = false;
        for slot in &mut self.slots {
            let was_up = slot.is_up();
            slot.audit(&mut self.bus, now).await?;
            missing |= was_up && !slot.is_up();
        }
        Ok(missing)
    }

    /// Whether the ranger that has no reset line is where it should be.
    fn ground_is_known(&self) -> bool {
        self.slot(Beam::Down).is_some_and(|slot| slot.config.is_none() || slot.is_up())
    }

    /// Configures the ranger at its own address and lets it make its first measurement.
    async fn begin(&mut self, beam: Beam, now: Instant) -> Result<Stage, Error<I2C::Error>> {
        let config = self.slot(beam).and_then(|slot| slot.config).ok_or(Error::Unsupported)?;
        let mut sensor = Vl53l1x::new(&mut self.bus, beam.address());
        sensor.identify().await?;
        sensor.configure(&config).await?;
        sensor.begin_calibration().await?;
        Ok(Stage::Calibrating { since: now })
    }

    /// Puts every ranger in reset that has a line and does not answer where it should.
    async fn reset_all_but_live(&mut self, now: Instant) -> Result<(), Error<I2C::Error>> {
        self.audit(now).await?;
        if !self.has_lines {
            return Ok(());
        }
        let lines = self.live_lines();
        Expander::new(&mut self.bus).drive(lines).await
    }

    fn live_lines(&self) -> Lines {
        self.slots
            .iter()
            .filter(|slot| slot.is_up())
            .fold(Lines::NONE, |lines, slot| lines | slot.beam.line())
    }
}
