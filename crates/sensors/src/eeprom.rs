//! The memory that keeps the configuration block: 24AA64, 8 KiB in pages of 32 bytes.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;

use crate::Error;
use crate::error::is_absence;

/// Its I²C address on the Crazyflie (crazyflie-firmware, `eeprom.h`).
pub const ADDRESS: u8 = 0x50;
/// Bytes in all.
pub const SIZE: u16 = 8192;
/// Bytes in a page, within which one write must stay (data sheet DS21189).
pub const PAGE: u16 = 32;

/// Two bytes of address and a page.
const FRAME: usize = 2 + PAGE as usize;
/// Writing a page takes up to 5 ms (data sheet, T_WC); the memory answers nothing meanwhile.
const WRITE_TRIES: u32 = 11;
const TRY_US: u32 = 500;

/// The driver.
#[derive(Debug)]
pub struct Eeprom<I2C> {
    i2c: I2C,
}

impl<I2C: I2c> Eeprom<I2C> {
    /// A driver that has not spoken to the memory yet.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c }
    }

    /// Reads from `address` on.
    ///
    /// # Errors
    /// [`Error::Unsupported`] beyond the end; [`Error::Bus`].
    pub async fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), Error<I2C::Error>> {
        check_span(address, bytes.len())?;
        Ok(self.i2c.write_read(ADDRESS, &address.to_be_bytes(), bytes).await?)
    }

    /// Writes from `address` on, page by page, and waits for each to be kept. What was to be
    /// written may be there in part after an error.
    ///
    /// # Errors
    /// [`Error::Unsupported`] beyond the end, and nothing is written; [`Error::Timeout`];
    /// [`Error::Bus`].
    pub async fn write<D: DelayNs>(
        &mut self,
        address: u16,
        bytes: &[u8],
        delay: &mut D,
    ) -> Result<(), Error<I2C::Error>> {
        check_span(address, bytes.len())?;
        let (mut at, mut rest) = (address, bytes);
        while !rest.is_empty() {
            let room = usize::from(PAGE - at % PAGE);
            let (now, later) = rest.split_at(room.min(rest.len()));
            self.write_page(at, now, delay).await?;
            at = at.saturating_add(now.len() as u16);
            rest = later;
        }
        Ok(())
    }

    /// Whether `bytes` are what is kept from `address` on.
    ///
    /// # Errors
    /// [`Error::NotKept`] with the address of the first byte that differs;
    /// [`Error::Unsupported`] beyond the end; [`Error::Bus`].
    pub async fn verify(&mut self, address: u16, bytes: &[u8]) -> Result<(), Error<I2C::Error>> {
        check_span(address, bytes.len())?;
        let mut at = address;
        for wanted in bytes.chunks(PAGE.into()) {
            let mut page = [0; PAGE as usize];
            let (kept, _) = page.split_at_mut(wanted.len().min(PAGE.into()));
            self.read(at, kept).await?;
            for (is, should) in kept.iter().zip(wanted) {
                if is != should {
                    return Err(Error::NotKept { register: at });
                }
                at = at.saturating_add(1);
            }
        }
        Ok(())
    }

    async fn write_page<D: DelayNs>(
        &mut self,
        address: u16,
        bytes: &[u8],
        delay: &mut D,
    ) -> Result<(), Error<I2C::Error>> {
        let mut frame = [0; FRAME];
        let filled = address.to_be_bytes().into_iter().chain(bytes.iter().copied());
        for (slot, byte) in frame.iter_mut().zip(filled) {
            *slot = byte;
        }
        let (used, _) = frame.split_at((2 + bytes.len()).min(FRAME));
        self.i2c.write(ADDRESS, used).await?;
        self.await_kept(delay).await
    }

    /// Asks until the memory answers again. It is asked with a read, because not every bus can
    /// send an address and nothing after it.
    async fn await_kept<D: DelayNs>(&mut self, delay: &mut D) -> Result<(), Error<I2C::Error>> {
        for _ in 0..WRITE_TRIES {
            match self.i2c.read(ADDRESS, &mut [0]).await.map_err(Error::Bus) {
                Ok(()) => return Ok(()),
                Err(error) if is_absence(&error) => delay.delay_us(TRY_US).await,
                Err(error) => return Err(error),
            }
        }
        Err(Error::Timeout)
    }
}

fn check_span<E>(address: u16, length: usize) -> Result<(), Error<E>> {
    match usize::from(address).checked_add(length) {
        Some(end) if end <= usize::from(SIZE) => Ok(()),
        _ => Err(Error::Unsupported),
    }
}
