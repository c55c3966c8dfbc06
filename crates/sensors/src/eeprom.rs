//! The EEPROM that holds the configuration block: a 24AA64 of 8 KiB in pages of 32 bytes.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;

use crate::Error;
use crate::error::is_absence;

/// The memory's I²C address on the Crazyflie (crazyflie-firmware, `eeprom.h`).
pub const ADDRESS: u8 = 0x50;
/// The size of the memory in bytes.
pub const SIZE: u16 = 8192;
/// The size of a page in bytes; one write must stay within a page (data sheet DS21189).
pub const PAGE: u16 = 32;

/// Size of the longest write in bytes: two of address and a page.
const FRAME: usize = 2 + PAGE as usize;
/// Number of polls after a write. Writing a page takes up to 5 ms (data sheet, T_WC), in which the
/// memory acknowledges nothing.
const WRITE_POLLS: u32 = 11;
/// Time between two polls in µs.
const POLL_US: u32 = 500;

/// The driver of the memory.
#[derive(Debug)]
pub struct Eeprom<I2C> {
    i2c: I2C,
}

impl<I2C: I2c> Eeprom<I2C> {
    /// A driver that has not sent anything to the memory yet.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c }
    }

    /// Fills `bytes` from the memory, beginning at `address`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the span reaches beyond the end; [`Error::Bus`].
    pub async fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), Error<I2C::Error>> {
        check_span(address, bytes.len())?;
        Ok(self.i2c.write_read(ADDRESS, &address.to_be_bytes(), bytes).await?)
    }

    /// Writes `bytes`, beginning at `address`, page by page, and waits until each page is stored.
    /// After an error a part of the bytes may be written.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the span reaches beyond the end, and nothing is written;
    /// [`Error::Timeout`]; [`Error::Bus`].
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
            let (page, later) = rest.split_at(room.min(rest.len()));
            self.write_page(at, page, delay).await?;
            at = at.saturating_add(page.len() as u16);
            rest = later;
        }
        Ok(())
    }

    /// Checks that the memory holds `bytes`, beginning at `address`.
    ///
    /// # Errors
    /// [`Error::NotKept`] with the address of the first byte that differs;
    /// [`Error::Unsupported`] if the span reaches beyond the end; [`Error::Bus`].
    pub async fn verify(&mut self, address: u16, bytes: &[u8]) -> Result<(), Error<I2C::Error>> {
        check_span(address, bytes.len())?;
        let mut at = address;
        for expected in bytes.chunks(PAGE.into()) {
            let mut page = [0; PAGE as usize];
            let (read, _) = page.split_at_mut(expected.len().min(PAGE.into()));
            self.read(at, read).await?;
            for (byte, expected) in read.iter().zip(expected) {
                if byte != expected {
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
        self.await_stored(delay).await
    }

    /// Polls the memory until it acknowledges again. A poll is a read, because not every bus can
    /// send an address and nothing after it.
    async fn await_stored<D: DelayNs>(&mut self, delay: &mut D) -> Result<(), Error<I2C::Error>> {
        for _ in 0..WRITE_POLLS {
            match self.i2c.read(ADDRESS, &mut [0]).await.map_err(Error::Bus) {
                Ok(()) => return Ok(()),
                Err(error) if is_absence(&error) => delay.delay_us(POLL_US).await,
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
