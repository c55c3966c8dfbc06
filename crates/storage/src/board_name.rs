//! The name of the board, which the vendor has written into the one-time programmable bytes of the
//! flight processor.
//!
//! From crazyflie-firmware, `platform_stm32f4.c` and `platform.c`: 16 blocks of 32 bytes, of which
//! the first that does not begin with a zero holds a text such as `0;CF21;R=D`, up to a zero. The
//! second field is the type of the board. Bytes that were never written are taken for `0;CF20`.

/// The address of the bytes in the flight processor (STM32F405: RM0090, "Embedded Flash memory").
pub const ADDRESS: usize = 0x1FFF_7800;
/// The number of the bytes.
pub const LENGTH: usize = BLOCK * 16;
const BLOCK: usize = 32;

/// The type of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Board {
    /// A Crazyflie 2.1 or 2.1+: the plus is the same board with other propellers and battery.
    Crazyflie21,
    /// A Crazyflie 2.0, which has another inertial sensor; or bytes that were never written.
    Crazyflie20,
    /// Another board, such as a Bolt (`CB10`, `CB11`), or a Crazyflie 2.1 Brushless (`C21B`), whose
    /// pins of the motors drive speed controllers; or a text that names no board.
    Other,
}

impl Board {
    /// The board whose bytes these are.
    #[must_use]
    pub fn named(bytes: &[u8; LENGTH]) -> Self {
        let blocks = bytes.as_chunks::<BLOCK>().0;
        let name = blocks.iter().find(|block| !block.starts_with(&[0]));
        let Some(name) = name.filter(|block| !block.starts_with(&[0xFF])) else {
            return Self::Crazyflie20;
        };
        let text = name.split(|byte| *byte == 0).next().unwrap_or_default();
        let mut fields = text.split(|byte| *byte == b';');
        match (fields.next(), fields.next()) {
            (Some(b"0"), Some(b"CF21")) => Self::Crazyflie21,
            (Some(b"0"), Some(b"CF20")) => Self::Crazyflie20,
            _ => Self::Other,
        }
    }
}
