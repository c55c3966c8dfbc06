//! RNG: the random number generator. Its numbers follow from the chip's unique number and how many
//! were drawn, so that a flight can be repeated.

use crate::bus::Refused;

/// RNG_CR: the generator is on.
const RNGEN: u32 = 1 << 2;

/// The registers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rng {
    cr: u32,
    state: u32,
}

impl Rng {
    /// The generator of the chip with this number.
    pub(crate) const fn new(unique_id: [u32; 3]) -> Self {
        let [a, b, c] = unique_id;
        Self { cr: 0, state: a ^ b.rotate_left(11) ^ c.rotate_left(22) }
    }

    pub(crate) const fn reset(&mut self) {
        self.cr = 0;
    }

    pub(crate) fn read(&mut self, offset: u32) -> Result<u32, Refused> {
        let is_on = self.cr & RNGEN != 0;
        Ok(match offset {
            0x00 => self.cr,
            // A number is there at once: it takes under a microsecond.
            0x04 => u32::from(is_on),
            0x08 if is_on => {
                // Numerical Recipes' generator, and the upper bits of its product.
                self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (self.state ^ self.state >> 15).wrapping_mul(0x2C1B_3C6D)
            }
            0x08 => 0,
            _ => return Err(Refused::Unmodelled { what: "RNG: a reserved register" }),
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        match offset {
            0x00 if value & 1 << 3 != 0 => {
                return Err(Refused::Unmodelled { what: "RNG_CR: the interrupt" });
            }
            0x00 => self.cr = value & RNGEN,
            // The flags of faults, of which there are none, and the number.
            0x04 | 0x08 => {}
            _ => return Err(Refused::Unmodelled { what: "RNG: a reserved register" }),
        }
        Ok(())
    }
}
