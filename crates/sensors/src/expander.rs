//! Driver of the I/O expander of the Multi-ranger deck, whose lines hold five rangers in reset
//! while they are low.
//!
//! The chip is a PCA9534 or a compatible type (crazyflie-firmware, `multiranger.c` and
//! `pca95x4.c`).

use core::ops::BitOr;

use embedded_hal_async::i2c::I2c;

use crate::Error;
use crate::error::is_absence;

/// The expander's I²C address on the deck.
pub const ADDRESS: u8 = 0x20;

const OUTPUT: u8 = 0x01;
const DIRECTION: u8 = 0x03;
/// The value of the direction register: a zero bit makes a pin an output, and the three pins that
/// are not connected stay inputs.
const OUTPUTS: u8 = !Lines::ALL.0;

/// Number of attempts without an answer after which the expander counts as absent.
const ATTEMPTS: u32 = 3;

/// A set of the lines that lead to the rangers' XSHUT pins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lines(u8);

impl Lines {
    /// No line.
    pub const NONE: Self = Self(0);
    /// The line of the ranger that looks up, P0.
    pub const UP: Self = Self(1 << 0);
    /// The line of the ranger that looks backward, P1.
    pub const BACK: Self = Self(1 << 1);
    /// The line of the ranger that looks to the right, P2.
    pub const RIGHT: Self = Self(1 << 2);
    /// The line of the ranger that looks forward, P4.
    pub const FRONT: Self = Self(1 << 4);
    /// The line of the ranger that looks to the left, P6.
    pub const LEFT: Self = Self(1 << 6);
    /// All five lines.
    pub const ALL: Self = Self(0b0101_0111);

    /// The set as bits of the expander's registers.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }
}

impl BitOr for Lines {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The driver of the expander.
#[derive(Debug)]
pub struct Expander<I2C> {
    i2c: I2C,
}

impl<I2C: I2c> Expander<I2C> {
    /// A driver that has not sent anything to the expander yet.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c }
    }

    /// Whether an expander acknowledges, whatever its registers hold. It counts as absent only
    /// after repeated attempts.
    ///
    /// # Errors
    /// [`Error::Bus`] for any failure other than a missing acknowledgement.
    pub async fn answers(&mut self) -> Result<bool, Error<I2C::Error>> {
        for _ in 0..ATTEMPTS {
            match self.check_register(OUTPUT, 0).await {
                Ok(()) | Err(Error::NotKept { .. }) => return Ok(true),
                Err(error) if is_absence(&error) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }

    /// Drives the lines `high` high and the others low, and reads the registers back. The levels
    /// are written before the direction, so that no line is high for a moment that should be low.
    /// Both are written every time, so that an expander which was reset is configured again.
    ///
    /// # Errors
    /// [`Error::NotKept`]; [`Error::Bus`].
    pub async fn drive(&mut self, high: Lines) -> Result<(), Error<I2C::Error>> {
        self.i2c.write(ADDRESS, &[OUTPUT, high.0]).await?;
        // The bytes are in a variable, because a constant lies in flash, which not every DMA
        // reaches.
        let direction = [DIRECTION, OUTPUTS];
        self.i2c.write(ADDRESS, &direction).await?;
        self.confirm(high).await
    }

    /// Whether the lines `high`, and no others, are still driven high.
    ///
    /// # Errors
    /// [`Error::NotKept`] if not; [`Error::Bus`].
    pub async fn confirm(&mut self, high: Lines) -> Result<(), Error<I2C::Error>> {
        self.check_register(OUTPUT, high.0).await?;
        self.check_register(DIRECTION, OUTPUTS).await
    }

    async fn check_register(&mut self, register: u8, value: u8) -> Result<(), Error<I2C::Error>> {
        let mut read = [0];
        self.i2c.write_read(ADDRESS, &[register], &mut read).await?;
        if read == [value] { Ok(()) } else { Err(Error::NotKept { register: register.into() }) }
    }
}
