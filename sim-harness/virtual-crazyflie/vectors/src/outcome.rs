//! Registers and memory after one instruction, and their hash.

/// Registers and memory after an instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct After {
    /// R0 to R15. R15 is where execution goes on.
    pub r: [u32; 16],
    /// N, Z, C, V, Q and GE at their places.
    pub apsr: u32,
    /// EPSR.T.
    pub thumb: bool,
    /// ITSTATE.
    pub it: u8,
    /// S0 to S31.
    pub s: [u32; 32],
    /// The outcome as bits.
    pub fpscr: u32,
    /// MSP, PSP, PRIMASK, BASEPRI, FAULTMASK, CONTROL.
    pub special: [u32; 6],
    /// The bytes of RAM and CCM that are not as they were, with their addresses.
    pub memory: Vec<(u32, u8)>,
}

/// The ending of an instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The instruction was executed.
    Done(Box<After>),
    /// A fault.
    Fault(String),
    /// Any other ending.
    Other(String),
}

impl After {
    /// 32 bits of all that is here.
    #[must_use]
    pub fn hash(&self) -> u32 {
        let mut hash = Hash::new();
        self.r.iter().for_each(|word| hash.word(*word));
        hash.word(self.apsr);
        hash.word(u32::from(self.thumb) << 8 | u32::from(self.it));
        self.s.iter().for_each(|word| hash.word(*word));
        hash.word(self.fpscr);
        self.special.iter().for_each(|word| hash.word(*word));
        for (address, byte) in &self.memory {
            hash.word(*address);
            hash.word((*byte).into());
        }
        hash.finish()
    }

    /// The parts in which it differs from another.
    #[must_use]
    pub fn differs_from(&self, other: &Self) -> Vec<String> {
        let mut found = Vec::new();
        let mut word = |name: String, a: u32, b: u32| {
            if a != b {
                found.push(format!("{name} {a:08x} not {b:08x}"));
            }
        };
        for n in 0..16 {
            word(format!("r{n}"), self.r[n], other.r[n]);
        }
        word("apsr".to_owned(), self.apsr, other.apsr);
        word("thumb".to_owned(), self.thumb.into(), other.thumb.into());
        word("it".to_owned(), self.it.into(), other.it.into());
        for n in 0..32 {
            word(format!("s{n}"), self.s[n], other.s[n]);
        }
        word("fpscr".to_owned(), self.fpscr, other.fpscr);
        let names = ["msp", "psp", "primask", "basepri", "faultmask", "control"];
        for (n, name) in names.iter().enumerate() {
            word((*name).to_owned(), self.special[n], other.special[n]);
        }
        if self.memory != other.memory {
            found.push(format!("memory {:02x?} not {:02x?}", self.memory, other.memory));
        }
        found
    }
}

/// FNV-1a over words, 64 bits wide, folded.
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3);
        }
    }

    const fn finish(&self) -> u32 {
        (self.0 ^ self.0 >> 32) as u32
    }
}

/// The bytes in which `now`, which lies at `base`, is not `before`.
pub fn changes(base: u32, before: &[u8], now: &[u8], changed: &mut Vec<(u32, u8)>) {
    const STRETCH: usize = 1024;
    let stretches = (base..).step_by(STRETCH).zip(before.chunks(STRETCH)).zip(now.chunks(STRETCH));
    for ((base, before), now) in stretches.filter(|((_, before), now)| before != now) {
        let bytes = (base..).zip(before).zip(now).filter(|((_, before), now)| before != now);
        changed.extend(bytes.map(|((address, _), now)| (address, *now)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_counts_for_the_hash_and_for_the_comparison() {
        let zero = After {
            r: [0; 16],
            apsr: 0,
            thumb: true,
            it: 0,
            s: [0; 32],
            fpscr: 0,
            special: [0; 6],
            memory: Vec::new(),
        };
        let mut others = Vec::new();
        let mut with = |change: &dyn Fn(&mut After)| {
            let mut other = zero.clone();
            change(&mut other);
            others.push(other);
        };
        (0..16).for_each(|n| with(&|a| a.r[n] = 1));
        (0..32).for_each(|n| with(&|a| a.s[n] = 1));
        (0..6).for_each(|n| with(&|a| a.special[n] = 1));
        with(&|a| a.apsr = 1 << 16);
        with(&|a| a.thumb = false);
        with(&|a| a.it = 8);
        with(&|a| a.fpscr = 1);
        with(&|a| a.memory = vec![(0, 0)]);
        for other in &others {
            assert_ne!(zero.hash(), other.hash());
            assert_eq!(zero.differs_from(other).len(), 1);
        }
    }
}
