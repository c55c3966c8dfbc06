//! Driver of the PMW3901, the optical flow sensor of the Flow deck v2.
//!
//! The chip needs pauses between the bytes of one transaction, so its bus must be able to wait
//! with the chip selected: [`Operation::DelayNs`]. (`embassy-embedded-hal`'s `SpiDevice` can, with
//! its feature `time`.) SPI mode 0, at most 2 MHz.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::{Operation, SpiDevice};

use crate::Error;

/// Pause in ns around each byte of a transaction, as in crazyflie-firmware's `pmw3901.c`; the data
/// sheet asks for 35 µs between address and data (t_SRAD) and less elsewhere.
const GAP: u32 = 50_000;
/// Pause in ns between address and data of a single read.
const READ_GAP: u32 = 500_000;
/// Pause in µs between transactions (data sheet: t_SWW = 45 µs).
const REST_US: u32 = 200;
/// Pause in µs after a motion burst.
const BURST_REST_US: u32 = 50;

/// The bit that is set in the address byte of a write.
const WRITE: u8 = 0x80;

const PRODUCT_ID: u8 = 0x00;
const MOTION: u8 = 0x02;
const MOTION_BURST: u8 = 0x16;
const POWER_UP_RESET: u8 = 0x3A;
const INVERSE_PRODUCT_ID: u8 = 0x5F;
const BANK: u8 = 0x7F;

/// The two identification bytes, each the inverse of the other.
const ID: u16 = 0x49B6;

/// The motion that the sensor counted since it was last read, and the quality of its image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Counts forward: positive when the drone moves forward over the ground. This is the chip's
    /// −Δy, as the Flow deck v2 mounts it.
    pub x: i16,
    /// Counts to the left. This is the chip's −Δx.
    pub y: i16,
    /// Whether the counts are valid: the motion byte is 0xB0, the only value that the vendor's
    /// firmware accepts. Without motion this is false, and the counts are zero.
    pub moved: bool,
    /// The motion byte.
    pub flags: u8,
    /// The surface quality: a quarter of the number of features seen (data sheet). Below about 25
    /// the ground has too little texture.
    pub squal: u8,
    /// The exposure in cycles of the chip's clock: long where it is dark.
    pub shutter: u16,
    /// The mean brightness of the image.
    pub raw_sum: u8,
    /// Brightness of the brightest pixel.
    pub raw_max: u8,
    /// Brightness of the darkest pixel.
    pub raw_min: u8,
}

impl Motion {
    const VALID: u8 = 0xB0;

    /// Decodes the 12 bytes of a burst: motion, observation, Δx, Δy, SQUAL, raw sum, max, min,
    /// shutter. The shutter alone has its high byte first.
    fn from_burst(burst: [u8; 12]) -> Self {
        let [flags, _, x0, x1, y0, y1, squal, raw_sum, raw_max, raw_min, s1, s0] = burst;
        Self {
            x: i16::from_le_bytes([y0, y1]).saturating_neg(),
            y: i16::from_le_bytes([x0, x1]).saturating_neg(),
            moved: flags == Self::VALID,
            flags,
            squal,
            shutter: u16::from_be_bytes([s1, s0]),
            raw_sum,
            raw_max,
            raw_min,
        }
    }
}

/// The driver of the chip.
#[derive(Debug)]
pub struct Pmw3901<SPI> {
    spi: SPI,
}

impl<SPI: SpiDevice> Pmw3901<SPI> {
    /// A driver that has not sent anything to the chip yet.
    pub const fn new(spi: SPI) -> Self {
        Self { spi }
    }

    /// Resets and configures the chip, which takes about 80 ms, of which the bus is busy for 20.
    ///
    /// # Errors
    /// [`Error::WrongDevice`], [`Error::Silent`], [`Error::Bus`].
    pub async fn init<D: DelayNs>(&mut self, delay: &mut D) -> Result<(), Error<SPI::Error>> {
        delay.delay_ms(40).await;
        self.reset_port(delay).await?;
        self.write(BANK, 0x00, delay).await?;
        self.identify(delay).await?;
        self.write(POWER_UP_RESET, 0x5A, delay).await?;
        delay.delay_ms(5).await;
        for register in MOTION..=MOTION + 4 {
            self.read(register, delay).await?;
        }
        delay.delay_ms(1).await;
        self.write_all(&TUNING, delay).await?;
        delay.delay_ms(10).await;
        self.write_all(&TUNING_AFTER_PAUSE, delay).await
    }

    /// Reads and clears the counts, which takes 0.25 ms on the bus. The vendor's firmware does so
    /// every 10 ms.
    ///
    /// # Errors
    /// [`Error::Silent`] if all bytes are 0x00 or all are 0xFF, which no chip sends;
    /// [`Error::Bus`].
    pub async fn read_motion<D: DelayNs>(
        &mut self,
        delay: &mut D,
    ) -> Result<Motion, Error<SPI::Error>> {
        // The byte is in a variable, because a constant lies in flash, which not every DMA reaches.
        let command = [MOTION_BURST];
        let mut burst = [0; 12];
        let mut burst_read = [
            Operation::DelayNs(GAP),
            Operation::Write(&command),
            Operation::DelayNs(GAP),
            Operation::Read(&mut burst),
            Operation::DelayNs(GAP),
        ];
        self.spi.transaction(&mut burst_read).await?;
        delay.delay_us(BURST_REST_US).await;
        if burst == [0x00; 12] || burst == [0xFF; 12] {
            return Err(Error::Silent);
        }
        Ok(Motion::from_burst(burst))
    }

    /// Checks the chip's identification. Call it between bursts only.
    ///
    /// # Errors
    /// [`Error::WrongDevice`], [`Error::Silent`], [`Error::Bus`].
    pub async fn identify<D: DelayNs>(&mut self, delay: &mut D) -> Result<(), Error<SPI::Error>> {
        let id = self.read(PRODUCT_ID, delay).await?;
        let inverse = self.read(INVERSE_PRODUCT_ID, delay).await?;
        match u16::from_be_bytes([id, inverse]) {
            ID => Ok(()),
            0x0000 | 0xFFFF => Err(Error::Silent),
            found => Err(Error::WrongDevice { found }),
        }
    }

    /// Resets the chip's serial port by selecting and deselecting the chip (data sheet, power-up
    /// sequence).
    async fn reset_port<D: DelayNs>(&mut self, delay: &mut D) -> Result<(), Error<SPI::Error>> {
        self.spi.transaction(&mut [Operation::DelayNs(2_000_000)]).await?;
        delay.delay_ms(2).await;
        Ok(())
    }

    async fn write_all<D: DelayNs>(
        &mut self,
        settings: &[(u8, u8)],
        delay: &mut D,
    ) -> Result<(), Error<SPI::Error>> {
        for (register, value) in settings {
            self.write(*register, *value, delay).await?;
        }
        Ok(())
    }

    async fn write<D: DelayNs>(
        &mut self,
        register: u8,
        value: u8,
        delay: &mut D,
    ) -> Result<(), Error<SPI::Error>> {
        let mut operations = [
            Operation::DelayNs(GAP),
            Operation::Write(&[register | WRITE]),
            Operation::DelayNs(GAP),
            Operation::Write(&[value]),
            Operation::DelayNs(GAP),
        ];
        self.spi.transaction(&mut operations).await?;
        delay.delay_us(REST_US).await;
        Ok(())
    }

    async fn read<D: DelayNs>(
        &mut self,
        register: u8,
        delay: &mut D,
    ) -> Result<u8, Error<SPI::Error>> {
        let mut value = [0];
        let mut operations = [
            Operation::DelayNs(GAP),
            Operation::Write(&[register & !WRITE]),
            Operation::DelayNs(READ_GAP),
            Operation::Read(&mut value),
            Operation::DelayNs(GAP),
        ];
        self.spi.transaction(&mut operations).await?;
        delay.delay_us(REST_US).await;
        let [value] = value;
        Ok(value)
    }
}

/// The manufacturer's settings, which the data sheet gives without an explanation ("performance
/// optimization registers"), with the values of crazyflie-firmware's `pmw3901.c`. Register 0x7F
/// selects the bank of the registers after it.
#[rustfmt::skip]
const TUNING: [(u8, u8); 59] = [
    (0x7F, 0x00), (0x61, 0xAD),
    (0x7F, 0x03), (0x40, 0x00),
    (0x7F, 0x05), (0x41, 0xB3), (0x43, 0xF1), (0x45, 0x14), (0x5B, 0x32), (0x5F, 0x34),
                  (0x7B, 0x08),
    (0x7F, 0x06), (0x44, 0x1B), (0x40, 0xBF), (0x4E, 0x3F),
    (0x7F, 0x08), (0x65, 0x20), (0x6A, 0x18),
    (0x7F, 0x09), (0x4F, 0xAF), (0x5F, 0x40), (0x48, 0x80), (0x49, 0x80), (0x57, 0x77),
                  (0x60, 0x78), (0x61, 0x78), (0x62, 0x08), (0x63, 0x50),
    (0x7F, 0x0A), (0x45, 0x60),
    (0x7F, 0x00), (0x4D, 0x11), (0x55, 0x80), (0x74, 0x1F), (0x75, 0x1F), (0x4A, 0x78),
                  (0x4B, 0x78), (0x44, 0x08), (0x45, 0x50), (0x64, 0xFF), (0x65, 0x1F),
    (0x7F, 0x14), (0x65, 0x67), (0x66, 0x08), (0x63, 0x70),
    (0x7F, 0x15), (0x48, 0x48),
    (0x7F, 0x07), (0x41, 0x0D), (0x43, 0x14), (0x4B, 0x0E), (0x45, 0x0F), (0x44, 0x42),
                  (0x4C, 0x80),
    (0x7F, 0x10), (0x5B, 0x02),
    (0x7F, 0x07), (0x40, 0x41), (0x70, 0x00),
];

/// The rest of the manufacturer's settings, written 10 ms later. The last two belong to the deck's
/// LED, which is off.
#[rustfmt::skip]
const TUNING_AFTER_PAUSE: [(u8, u8); 17] = [
    (0x32, 0x44),
    (0x7F, 0x07), (0x40, 0x40),
    (0x7F, 0x06), (0x62, 0xF0), (0x63, 0x00),
    (0x7F, 0x0D), (0x48, 0xC0), (0x6F, 0xD5),
    (0x7F, 0x00), (0x5B, 0xA0), (0x4E, 0xA8), (0x5A, 0x50), (0x40, 0x80),
    (0x7F, 0x00), (0x5A, 0x10), (0x54, 0x00),
];
