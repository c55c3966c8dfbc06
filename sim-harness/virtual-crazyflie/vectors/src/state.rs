//! States from which one instruction is executed: registers and memory that reach what is special.

use crate::forms::{Aim, Form};
use crate::random::Random;
use virtual_crazyflie::memory::map;

/// The address of the instruction: the middle of the flash, so that branches stay within it.
pub const CODE: u32 = map::FLASH + map::FLASH_SIZE / 2;
/// Flash that holds literals, from here …
pub const LITERALS: u32 = CODE - 0x8000;
/// … and so many bytes.
pub const LITERALS_SIZE: u32 = 0x1_0000;
/// The stretch of RAM at which loads and stores are aimed.
pub const WINDOW: u32 = map::RAM + 0x8000;
/// Its size: the middle reaches as far as any offset.
pub const WINDOW_SIZE: u32 = 0x4000;

/// The state before an instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// R0 to R12, SP, LR.
    pub r: [u32; 15],
    /// N, Z, C, V, Q and GE at their places.
    pub apsr: u32,
    /// ITSTATE.
    pub it: u8,
    /// S0 to S31.
    pub s: [u32; 32],
    /// The state as bits.
    pub fpscr: u32,
    /// The window holds addresses of code, so that what is loaded can be jumped to.
    pub window_of_code: bool,
}

/// The states of one encoding.
pub struct States {
    random: Random,
    form: Option<&'static Form>,
    encoding: u32,
    index: u32,
}

impl States {
    /// Always the same ones for the same seed and encoding.
    #[must_use]
    pub fn of(encoding: u32, seed: u64) -> Self {
        let mut random = Random::new(seed ^ (u64::from(encoding) << 20));
        random.next();
        Self { random, form: crate::forms::of(encoding), encoding, index: 0 }
    }
}

impl Iterator for States {
    type Item = State;

    fn next(&mut self) -> Option<State> {
        let random = &mut self.random;
        let mut r = [0u32; 15];
        // Now and then there are few values, so that ends of ranges meet.
        let coarse = random.once_in(6);
        for index in 0..13 {
            r[index] = match random.below(8) {
                _ if coarse => {
                    random.pick(&[0, 1, u32::MAX, 1 << 31, i32::MAX as u32, 0x8000_8000])
                }
                0 if index > 0 => r[index - 1],
                1 if index > 0 => r[index - 1].wrapping_neg(),
                _ => integer(random),
            };
        }
        r[13] = near_middle(random, 4);
        r[14] = match random.below(3) {
            0 => integer(random),
            1 => near_middle(random, 4),
            _ => code(random),
        };
        let mut s = [0u32; 32];
        let coarse = random.once_in(6);
        for index in 0..32 {
            s[index] = match random.below(10) {
                _ if coarse => random.pick(&MEETING),
                0 if index > 0 => s[index - 1],
                1 if index > 0 => s[index - 1] ^ 1 << 31,
                // Apart by one or two in the last place, or by some powers of two: cancellation.
                2 if index > 0 => s[index - 1].wrapping_add(random.below(5)).wrapping_sub(2),
                3 if index > 0 => s[index - 1] ^ random.below(32) << 23,
                _ => float(random),
            };
        }
        let mut state = State {
            r,
            apsr: random.word() & 0xF80F_0000,
            it: 0,
            s,
            fpscr: fpscr(random, self.index),
            window_of_code: false,
        };
        if let Some(form) = self.form {
            aim(form, self.encoding, &mut state, random);
            // The last instruction of a block, so that one is enough; AL in a block is odd but is.
            let may_be_in_block = !OUTSIDE_BLOCKS.iter().any(|name| form.name.starts_with(name));
            if may_be_in_block && random.once_in(6) {
                state.it = (random.below(15) << 4 | 8) as u8;
            }
        }
        self.index += 1;
        Some(state)
    }
}

/// The instructions that must not stand in an IT block, or cannot be distinguished from the block's
/// own end.
const OUTSIDE_BLOCKS: [&str; 7] = ["B cond", "CBZ", "CBNZ", "IT", "CPS", "BKPT", "MOVS.N"];

/// A flash address with bit 0 set.
fn code(random: &mut Random) -> u32 {
    (LITERALS + random.below(LITERALS_SIZE)) | 1
}

fn near_middle(random: &mut Random, alignment: u32) -> u32 {
    WINDOW + WINDOW_SIZE / 2 + (random.below(256) & !(alignment - 1))
}

fn aim(form: &Form, encoding: u32, state: &mut State, random: &mut Random) {
    let field = |letter| form.field(letter, encoding).map(|n| n as usize);
    let loads_pc = form.name.contains(" pc");
    state.window_of_code = loads_pc && !random.once_in(8);
    match form.aim {
        Aim::Nothing => {}
        Aim::Base | Aim::Indexed => {
            if let (Aim::Indexed, Some(m)) = (form.aim, field(b'm')) {
                let index = match random.below(4) {
                    0 => random.below(512).wrapping_neg(),
                    1 => random.below(64) * 4,
                    _ => random.below(512),
                };
                // PC is no index, but encodings of random bits may say so.
                if let Some(register) = state.r.get_mut(m) {
                    *register = index;
                }
            }
            let Some(n) = field(b'n') else { return };
            // Now and then it goes astray.
            if n < 13 && !random.once_in(24) {
                let alignment = if random.once_in(4) { 1 } else { 4 };
                state.r[n] = near_middle(random, alignment);
            }
        }
        Aim::Target => {
            let m = field(b'm').expect("a target is a register");
            if m != 13 && m != 15 {
                state.r[m] = code(random);
            }
        }
    }
}

/// Integers, with the ends of every range more often than chance would have it.
fn integer(random: &mut Random) -> u32 {
    const ENDS: [u32; 20] = [
        0,
        1,
        2,
        0x7F,
        0x80,
        0xFF,
        0x100,
        0x7FFF,
        0x8000,
        0xFFFF,
        0x1_0000,
        0x7FFF_FFFE,
        0x7FFF_FFFF,
        0x8000_0000,
        0x8000_0001,
        0xFFFF_8000,
        0xFFFF_7FFF,
        0xFFFF_FFFE,
        0xFFFF_FFFF,
        0x8000_8000,
    ];
    const HALVES: [u32; 8] = [0, 1, 0x7FFF, 0x8000, 0x8001, 0xFFFF, 0x80, 0x7F];
    const BYTES: [u32; 6] = [0, 1, 0x7F, 0x80, 0x81, 0xFF];
    match random.below(8) {
        0 => random.pick(&ENDS),
        1 => random.below(41),
        2 => 1 << random.below(32),
        3 => random.pick(&HALVES) << 16 | random.pick(&HALVES),
        4 => (0..4).fold(0, |word, _| word << 8 | random.pick(&BYTES)),
        5 => random.word() >> random.below(32),
        _ => random.word(),
    }
}

/// Single-precision bits, with zeros, denormals, infinities, NaNs of both kinds, what is just
/// representable as an integer, ties of conversions, and half-precision bits.
fn float(random: &mut Random) -> u32 {
    const SPECIAL: [u32; 26] = [
        0x0000_0000, // 0
        0x0000_0001, // the smallest denormal
        0x007F_FFFF, // the largest one
        0x0080_0000, // the smallest normal
        0x0080_0001,
        0x3F80_0000, // 1
        0x3F7F_FFFF,
        0x3F80_0001,
        0x3F00_0000, // 0.5
        0x3FC0_0000, // 1.5
        0x4020_0000, // 2.5
        0x4B00_0000, // 2^23
        0x4F00_0000, // 2^31
        0x4EFF_FFFF,
        0x4F80_0000, // 2^32
        0x4F7F_FFFF,
        0x7F7F_FFFF, // the largest
        0x7F80_0000, // infinity
        0x7FC0_0000, // the default NaN
        0x7FFF_FFFF,
        0x7F80_0001, // a signalling NaN
        0x7FBF_FFFF,
        0x477F_E000, // the largest half
        0x477F_F000, // what rounds beyond it
        0x3880_0000, // the smallest normal half
        0x3300_0000, // half of the smallest denormal half
    ];
    let sign = random.word() & 1 << 31;
    let exponents = |random: &mut Random, from: u32, count: u32| {
        (from + random.below(count)) << 23 | random.word() & 0x7F_FFFF
    };
    sign | match random.below(16) {
        0..=3 => random.pick(&SPECIAL),
        4 => random.word() & 0x7F_FFFF,
        5 => 0x7F80_0000 | random.word() & 0x7F_FFFF,
        // Numbers like those of a control loop.
        6..=9 => exponents(random, 117, 20),
        10 => exponents(random, 127, 32),
        11 => exponents(random, 1, 30),
        12 => exponents(random, 225, 30),
        // A few significant bits, so that results are exact or ties.
        13 => (100 + random.below(54)) << 23 | (random.word() & 0xF) << (19 - random.below(8)),
        14 => half(random) << 16 & 0x7FFF_0000 | half(random),
        _ => random.word() & 0x7FFF_FFFF,
    }
}

/// Floats that do something special to one another: zeros, ones, infinities, NaNs, denormals, the
/// ends of the range.
const MEETING: [u32; 16] = [
    0,
    1 << 31,
    0x3F80_0000,
    0xBF80_0000,
    0x7F80_0000,
    0xFF80_0000,
    0x7FC0_0001,
    0xFFC0_0002,
    0x7F80_0003,
    0xFFA0_0004,
    0x0000_0001,
    0x8040_0000,
    // The smallest normal number, and just below one: tiny before their product is rounded.
    0x0080_0000,
    0x3F7F_FFFF,
    0xBF7F_FFFF,
    0x7F7F_FFFF,
];

fn half(random: &mut Random) -> u32 {
    const SPECIAL: [u32; 12] =
        [0, 1, 0x3FF, 0x400, 0x3C00, 0x7BFF, 0x7C00, 0x7C01, 0x7DFF, 0x7E00, 0x7FFF, 0x8000];
    if random.once_in(2) { random.pick(&SPECIAL) } else { random.word() & 0xFFFF }
}

/// Every mode in turn. Half of the states begin without sticky flags, so that setting shows; and
/// some in the default mode with IXC set, where a core may take a shorter way.
fn fpscr(random: &mut Random, index: u32) -> u32 {
    const IXC: u32 = 0x10;
    let flags = random.word() & 0xF000_0000;
    let mode = match index % 4 {
        0 => 0,
        1 => (index / 4 % 4) << 22,
        2 => (index / 4 % 8) << 24 & 0x0300_0000 | (random.word() & 0x04C0_0000),
        _ => random.word() & 0x07C0_0000,
    };
    let sticky = match index % 8 {
        0 | 2 | 5 | 6 => 0,
        4 => IXC | if random.once_in(2) { 0 } else { random.word() & 0x9F },
        _ => random.word() & random.word() & 0x9F,
    };
    flags | mode | sticky
}

/// The contents of the window and the literals: addresses of code and data, and numbers of all
/// kinds.
#[must_use]
pub fn background(size: u32, of_code: bool) -> Vec<u8> {
    let mut random = Random::new(0x5EED);
    (0..size / 4)
        .map(|_| match random.below(6) {
            _ if of_code => code(&mut random),
            0 => code(&mut random),
            1 => near_middle(&mut random, 4),
            2 => integer(&mut random),
            _ => float(&mut random),
        })
        .flat_map(u32::to_le_bytes)
        .collect()
}

/// RAM and CCM, each with its address, as a state with such a window finds them.
#[must_use]
pub fn ram(of_code: bool) -> [(u32, Vec<u8>); 2] {
    let mut ram = vec![0xA5; map::RAM_SIZE as usize];
    ram[(WINDOW - map::RAM) as usize..][..WINDOW_SIZE as usize]
        .copy_from_slice(&background(WINDOW_SIZE, of_code));
    [(map::RAM, ram), (map::CCM, vec![0xA5; map::CCM_SIZE as usize])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_gives_the_same_states() {
        let encoding = 0xEE30_0A81;
        let twice: [Vec<State>; 2] =
            std::array::from_fn(|_| States::of(encoding, 7).take(50).collect());
        assert_eq!(twice[0], twice[1]);
        assert_ne!(twice[0], States::of(encoding, 8).take(50).collect::<Vec<_>>());
    }

    #[test]
    fn states_reach_every_mode_and_kind_of_number() {
        let states: Vec<State> = States::of(0xEE30_0A81, 1).take(64).collect();
        for mode in 0..4 {
            assert!(states.iter().any(|s| s.fpscr >> 22 & 3 == mode));
        }
        for bit in [24, 25, 26] {
            assert!(states.iter().any(|s| s.fpscr >> bit & 1 == 1));
        }
        let has = |kind: fn(f32) -> bool| {
            states.iter().flat_map(|s| s.s).any(|bits| kind(f32::from_bits(bits)))
        };
        assert!(has(f32::is_nan) && has(f32::is_infinite) && has(f32::is_subnormal));
        assert!(has(|x| x == 0.0 && x.is_sign_negative()));
        assert!(states.iter().filter(|s| s.fpscr & 0x07C0_001F == 0x10).count() >= 3);
    }
}
