//! The I/O expander of the Multi-ranger deck: one line per ranger, low holds it in reset.
//!
//! A PCA9534 or a sibling of it (crazyflie-firmware, `multiranger.c` and `pca95x4.c`).

use core::ops::BitOr;

use embedded_hal_async::i2c::I2c;

use crate::Error;
use crate::error::is_absence;

/// Its I²C address on the deck.
pub const ADDRESS: u8 = 0x20;

const OUTPUT: u8 = 0x01;
const DIRECTION: u8 = 0x03;
/// A zero makes a pin an output. The three that lead nowhere stay inputs.
const OUTPUTS: u8 = !Lines::ALL.0;

/// An expander that stays silent so often is not there.
const SILENCES: u32 = 3;

/// A set of the lines that lead to the rangers' XSHUT pins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lines(u8);

impl Lines {
    /// No line.
    pub const NONE: Self = Self(0);
    /// P0.
    pub const UP: Self = Self(1 << 0);
    /// P1.
    pub const BACK: Self = Self(1 << 1);
    /// P2.
    pub const RIGHT: Self = Self(1 << 2);
    /// P4.
    pub const FRONT: Self = Self(1 << 4);
    /// P6.
    pub const LEFT: Self = Self(1 << 6);
    /// All five.
    pub const ALL: Self = Self(0b0101_0111);

    /// The pins as the expander's registers have them.
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

/// The driver.
#[derive(Debug)]
pub struct Expander<I2C> {
    i2c: I2C,
}

impl<I2C: I2c> Expander<I2C> {
    /// A driver that has not spoken to the expander yet.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c }
    }

    /// Whether there is one, whatever it says. Silence is believed only when it is repeated.
    ///
    /// # Errors
    /// [`Error::Bus`], if it is not for want of an answer.
    pub async fn answers(&mut self) -> Result<bool, Error<I2C::Error>> {
        for _ in 0..SILENCES {
            match self.expect(OUTPUT, 0).await {
                Ok(()) | Err(Error::NotKept { .. }) => return Ok(true),
                Err(error) if is_absence(&error) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }

    /// Sets the lines `high` high and the others low, and reads back whether they are. The levels
    /// are written before the direction, so that no line is high for a moment that should not be,
    /// and both every time, so that an expander which was reset is put right.
    ///
    /// # Errors
    /// [`Error::NotKept`]; [`Error::Bus`].
    pub async fn drive(&mut self, high: Lines) -> Result<(), Error<I2C::Error>> {
        self.i2c.write(ADDRESS, &[OUTPUT, high.0]).await?;
        // In a variable, because a constant lies in flash, which not every DMA reaches.
        let direction = [DIRECTION, OUTPUTS];
        self.i2c.write(ADDRESS, &direction).await?;
        self.confirm(high).await
    }

    /// Whether the lines `high`, and no others, are still driven high.
    ///
    /// # Errors
    /// [`Error::NotKept`] if not; [`Error::Bus`].
    pub async fn confirm(&mut self, high: Lines) -> Result<(), Error<I2C::Error>> {
        self.expect(OUTPUT, high.0).await?;
        self.expect(DIRECTION, OUTPUTS).await
    }

    async fn expect(&mut self, register: u8, value: u8) -> Result<(), Error<I2C::Error>> {
        let mut is = [0];
        self.i2c.write_read(ADDRESS, &[register], &mut is).await?;
        if is == [value] { Ok(()) } else { Err(Error::NotKept { register: register.into() }) }
    }
}
