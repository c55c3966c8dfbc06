//! Driver of six rangers on one bus: the Flow deck's one, which looks down, and the Multi-ranger
//! deck's five.
//!
//! All of them answer at 0x29 after their reset, and each must get an address of its own while no
//! other is there. The Multi-ranger deck can hold its five rangers in reset, but not the one that
//! looks down, so that one gets its address first. Any ranger may lose its supply for a moment in
//! flight and then answer at 0x29 again, so start and recovery are the same sequence. One ranger at
//! a time goes through it while the others go on measuring:
//!
//! ```text
//!        due ┌─────────┐ 2 ms  ┌─────────────┐ one measurement ┌─────────┐
//!  Off ─────>│ Booting │──────>│ Calibrating │────────────────>│ Ranging │
//!   ^        └────┬────┘       └──────┬──────┘                 └────┬────┘
//!   └─────────────┴───────────────────┴─────── errors, silence ─────┘
//! ```
//!
//! The distance to a wall must never be taken for the height above the ground. So the ranger at
//! 0x29 gets an address only when it is certain which ranger it is:
//!
//! - Just before, the driver asks every ranger that should be up at its own address. A ranger that
//!   answers there cannot be at 0x29 until it has booted, which takes longer than the change of the
//!   address.
//! - Rangers with a reset line that are not up are in reset, and the expander confirms it just
//!   before.
//! - If the configuration has no rangers with a reset line, no expander answers.
//! - A ranger with a reset line is released only while the one that looks down answers at its own
//!   address. While that one is lost, the rangers that range go on, and the others wait.
//!
//! [`MultiRanger::poll`] never waits. It makes a bounded number of transactions, and must be called
//! 100 times a second or more.

mod counting_bus;
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

use counting_bus::CountingBus;
use slot::{Slot, Stage};

/// Time after its release from reset before which a ranger is not asked (crazyflie-firmware,
/// `multiranger.c`; the data sheet says 1.2 ms).
const BOOT: Duration = Duration::from_millis(2);
/// Time after its release from reset at which a ranger that does not answer has failed to boot.
const BOOT_LIMIT: Duration = Duration::from_millis(20);

/// The direction in which a ranger looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Beam {
    /// The ranger of the Flow deck looks down to the ground.
    Down,
    /// The ranger looks forward.
    Front,
    /// The ranger looks backward.
    Back,
    /// The ranger looks up to the ceiling.
    Up,
    /// The ranger looks to the left.
    Left,
    /// The ranger looks to the right.
    Right,
}

impl Beam {
    /// All six, in the order in which they are brought up.
    pub const ALL: [Self; 6] =
        [Self::Down, Self::Front, Self::Back, Self::Up, Self::Left, Self::Right];

    /// The I²C address that the ranger of this direction gets. The vendor's firmware uses 0x6A to
    /// 0x6F as well, but assigns them in the order of its decks.
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

    /// The line that holds the ranger of this direction in reset; none for the one that looks down.
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

/// The state of a ranger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeamState {
    /// The ranger ranges.
    Live,
    /// The ranger is being started.
    Starting,
    /// The ranger failed, or was never there, and is tried again from time to time.
    Lost,
    /// The configuration does not use the ranger.
    Unused,
}

/// The rangers to use, and the configuration of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RangerConfig {
    /// The configuration of the ranger that looks down. While that ranger is lost no other is
    /// started. If this is `None`, the drone must not carry a Flow deck, whose ranger would occupy
    /// 0x29.
    pub down: Option<vl53l1x::Config>,
    /// The configuration of the rangers to the front, back, left and right.
    pub sides: Option<vl53l1x::Config>,
    /// The configuration of the ranger that looks up.
    pub up: Option<vl53l1x::Config>,
    /// The limits by which a ranger counts as lost and is tried again.
    pub health: HealthConfig,
}

impl RangerConfig {
    /// The configuration for the Flow deck alone. It must not be used on a drone that carries a
    /// Multi-ranger deck, whose rangers, not held in reset, would answer together with the one that
    /// looks down. While an expander answers, no ranger gets another address than 0x29.
    pub const FLOW_DECK: Self = Self { sides: None, up: None, ..Self::DEFAULT };

    /// The configuration for the Multi-ranger deck alone: no ranger looks down.
    pub const MULTI_RANGER: Self = Self { down: None, ..Self::DEFAULT };

    /// The configuration for both decks with all six rangers.
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

/// The result of one poll: a reading from each ranger that had a new one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sweep {
    readings: [Option<Reading>; 6],
}

impl Sweep {
    /// The new reading of the ranger in this direction, if there is one.
    #[must_use]
    pub fn of(&self, beam: Beam) -> Option<Reading> {
        self.iter().find_map(|(of, reading)| (of == beam).then_some(reading))
    }

    /// All new readings, each with its direction.
    pub fn iter(&self) -> impl Iterator<Item = (Beam, Reading)> {
        Beam::ALL
            .into_iter()
            .zip(self.readings)
            .filter_map(|(beam, reading)| reading.map(|reading| (beam, reading)))
    }
}

/// The driver of the rangers of both decks.
#[derive(Debug)]
pub struct MultiRanger<I2C: I2c> {
    bus: CountingBus<I2C>,
    slots: [Slot<I2C::Error>; 6],
    /// Whether there is a Multi-ranger deck. If so, no ranger at 0x29 gets an address unless the
    /// expander has confirmed which rangers can be there.
    has_lines: bool,
}

impl<I2C: I2c> MultiRanger<I2C> {
    /// A driver that has not sent anything yet; all rangers count as lost and are due for a start.
    pub fn new(i2c: I2C, config: RangerConfig, now: Instant) -> Self {
        let slots = Beam::ALL.map(|beam| Slot::new(beam, config.of(beam), config.health, now));
        let has_lines = config.sides.is_some() || config.up.is_some();
        Self { bus: CountingBus::new(i2c), slots, has_lines }
    }

    /// Asks every ranger that is up for a new reading, and takes one step in starting the others.
    /// `now` must not run backwards.
    pub async fn poll(&mut self, now: Instant) -> Sweep {
        self.bus.reset_counts();
        let mut sweep = Sweep::default();
        for (slot, reading) in self.slots.iter_mut().zip(&mut sweep.readings) {
            *reading = slot.advance(&mut self.bus, now).await;
        }
        self.start_next(now).await;
        sweep
    }

    /// The state of a ranger.
    #[must_use]
    pub fn state(&self, beam: Beam) -> BeamState {
        self.slot(beam).map_or(BeamState::Unused, Slot::state)
    }

    /// Number of failed transactions with a ranger while it ranged, since the beginning.
    #[must_use]
    pub fn errors(&self, beam: Beam) -> u32 {
        self.slot(beam).map_or(0, |slot| slot.health.errors())
    }

    /// Number of times that a ranger was lost after it had been started.
    #[must_use]
    pub fn losses(&self, beam: Beam) -> u32 {
        self.slot(beam).map_or(0, |slot| slot.health.losses())
    }

    /// The last error of a ranger.
    #[must_use]
    pub fn last_error(&self, beam: Beam) -> Option<&Error<I2C::Error>> {
        self.slot(beam).and_then(|slot| slot.last_error.as_ref())
    }

    /// Whether every ranger has started, has failed to start at least once, or waits for one that
    /// has failed. A program that waits for the rangers at its start need not wait any longer then.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let waiting = self.slot(Beam::Down).is_some_and(Slot::has_failed);
        self.slots.iter().all(|slot| match slot.state() {
            BeamState::Live | BeamState::Unused => true,
            BeamState::Lost | BeamState::Starting => slot.has_failed() || waiting,
        })
    }

    /// Whether all transactions of the last poll failed otherwise than by a missing
    /// acknowledgement. Then the bus probably hangs, and its owner should [free
    /// it](crate::bus::recover).
    #[must_use]
    pub const fn bus_is_suspect(&self) -> bool {
        self.bus.is_suspect()
    }

    fn slot(&self, beam: Beam) -> Option<&Slot<I2C::Error>> {
        self.slots.iter().find(|slot| slot.beam == beam)
    }

    /// Goes on with the ranger that boots, or else begins with the next one that is due.
    async fn start_next(&mut self, now: Instant) {
        let booting = self.slots.iter().find_map(|slot| match slot.stage {
            Stage::Booting { since } => Some((slot.beam, since)),
            _ => None,
        });
        let down_is_up = self.down_is_up();
        let due = self
            .slots
            .iter()
            .find(|slot| slot.is_due(now) && (slot.beam == Beam::Down || down_is_up))
            .map(|slot| slot.beam);
        let (beam, outcome) = match (booting, due) {
            (Some((beam, since)), _) => (beam, self.finish_boot(beam, since, now).await),
            (None, Some(Beam::Down)) => (Beam::Down, self.start_down(now).await),
            (None, Some(side)) => (side, self.release_side(side, now).await),
            (None, None) => return,
        };
        let Some(slot) = self.slots.iter_mut().find(|slot| slot.beam == beam) else { return };
        match outcome {
            Ok(stage) => slot.stage = stage,
            Err(error) => slot.fail(error, now),
        }
    }

    /// Starts the ranger that looks down. It is at its own address if only the processor was reset,
    /// and at 0x29 if it was reset itself.
    async fn start_down(&mut self, now: Instant) -> Result<Stage, Error<I2C::Error>> {
        if !vl53l1x::answers(&mut self.bus, Beam::Down.address()).await? {
            self.reset_all_but_live(now).await?;
            self.assign_address(Beam::Down, now).await?;
        }
        self.begin_calibration(Beam::Down, now).await
    }

    /// Releases one ranger of the Multi-ranger deck from reset.
    async fn release_side(&mut self, beam: Beam, now: Instant) -> Result<Stage, Error<I2C::Error>> {
        self.reset_all_but_live(now).await?;
        if vl53l1x::answers(&mut self.bus, DEFAULT_ADDRESS).await? {
            return Err(Error::AddressTaken);
        }
        let lines = self.live_lines() | beam.line();
        Expander::new(&mut self.bus).drive(lines).await?;
        Ok(Stage::Booting { since: now })
    }

    /// Gives the ranger that was released from reset its own address once it has booted, and begins
    /// its calibration.
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
        self.assign_address(beam, now).await?;
        self.begin_calibration(beam, now).await
    }

    /// Gives the ranger at 0x29 the address of `beam`, if no other ranger can be at 0x29 too: a
    /// ranger that answers at its own address now, or is in reset now, can be at 0x29 only after it
    /// has booted, 1.2 ms later.
    async fn assign_address(&mut self, beam: Beam, now: Instant) -> Result<(), Error<I2C::Error>> {
        Vl53l1x::new(&mut self.bus, DEFAULT_ADDRESS).identify().await?;
        if self.check_addresses(now).await? || !(beam == Beam::Down || self.down_is_up()) {
            return Err(Error::AddressTaken);
        }
        if self.has_lines {
            // A ranger that was lost since the lines were driven is not in reset yet, and then the
            // expander does not confirm the lines.
            let lines = self.live_lines() | beam.line();
            Expander::new(&mut self.bus).confirm(lines).await?;
        } else if Expander::new(&mut self.bus).answers().await? {
            return Err(Error::AddressTaken);
        }
        Vl53l1x::new(&mut self.bus, DEFAULT_ADDRESS).move_to(beam.address()).await
    }

    /// Asks every ranger that should be up at its own address, and marks those that do not answer
    /// as lost. Returns whether there were any.
    async fn check_addresses(&mut self, now: Instant) -> Result<bool, Error<I2C::Error>> {
        let mut missing = false;
        for slot in &mut self.slots {
            let was_up = slot.is_up();
            slot.check_address(&mut self.bus, now).await?;
            missing |= was_up && !slot.is_up();
        }
        Ok(missing)
    }

    /// Whether the ranger that looks down has its own address, or is not used.
    fn down_is_up(&self) -> bool {
        self.slot(Beam::Down).is_some_and(|slot| slot.config.is_none() || slot.is_up())
    }

    /// Configures the ranger at its own address and lets it make its first measurement.
    async fn begin_calibration(
        &mut self,
        beam: Beam,
        now: Instant,
    ) -> Result<Stage, Error<I2C::Error>> {
        let config = self.slot(beam).and_then(|slot| slot.config).ok_or(Error::Unsupported)?;
        let mut sensor = Vl53l1x::new(&mut self.bus, beam.address());
        sensor.identify().await?;
        sensor.configure(&config).await?;
        sensor.begin_calibration().await?;
        Ok(Stage::Calibrating { since: now })
    }

    /// Puts every ranger in reset that has a reset line and does not answer at its own address.
    async fn reset_all_but_live(&mut self, now: Instant) -> Result<(), Error<I2C::Error>> {
        self.check_addresses(now).await?;
        if !self.has_lines {
            return Ok(());
        }
        let lines = self.live_lines();
        Expander::new(&mut self.bus).drive(lines).await
    }

    /// The reset lines of the rangers that are up.
    fn live_lines(&self) -> Lines {
        self.slots
            .iter()
            .filter(|slot| slot.is_up())
            .fold(Lines::NONE, |lines, slot| lines | slot.beam.line())
    }
}
