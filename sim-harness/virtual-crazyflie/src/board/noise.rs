//! Disturbs bytes on a serial line, by a seed.

/// Of a million bytes, how many suffer what. What is more than a million together is cut off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shares {
    /// One bit is wrong, and the receiver does not notice.
    pub flipped: u32,
    /// The byte is right, and the receiver saw noise on it.
    pub noisy: u32,
    /// One bit is wrong, and the stop bit is missing.
    pub broken: u32,
    /// The byte is lost.
    pub lost: u32,
}

/// The outcome of a byte on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    Intact(u8),
    Noisy(u8),
    Broken(u8),
    Lost,
}

/// A line with its luck.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    shares: Shares,
    dice: Dice,
}

impl Noise {
    pub(super) const fn new(shares: Shares, seed: u64) -> Self {
        Self { shares, dice: Dice(seed) }
    }

    pub(super) const fn none() -> Self {
        let shares = Shares { flipped: 0, noisy: 0, broken: 0, lost: 0 };
        Self::new(shares, 0)
    }

    pub(super) fn pass(&mut self, byte: u8) -> Fate {
        let Shares { flipped, noisy, broken, lost } = self.shares;
        if (flipped, noisy, broken, lost) == (0, 0, 0, 0) {
            return Fate::Intact(byte);
        }
        let drawn = self.dice.below(1_000_000);
        let wrong = byte ^ (1 << self.dice.below(8));
        let mut left = drawn;
        let mut falls_in = |share: u32| {
            let within = left < share;
            left = left.saturating_sub(share);
            within
        };
        if falls_in(flipped) {
            Fate::Intact(wrong)
        } else if falls_in(noisy) {
            Fate::Noisy(byte)
        } else if falls_in(broken) {
            Fate::Broken(wrong)
        } else if falls_in(lost) {
            Fate::Lost
        } else {
            Fate::Intact(byte)
        }
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
struct Dice(u64);

impl Dice {
    fn below(&mut self, bound: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        // The upper half, scaled: it lies below the bound, and fits.
        (((z >> 32) * u64::from(bound)) >> 32) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quiet_line_leaves_every_byte_alone() {
        let mut line = Noise::none();
        assert!((0..=255).all(|byte| line.pass(byte) == Fate::Intact(byte)));
    }

    #[test]
    fn the_shares_are_those_asked_for_and_the_seed_decides() {
        let shares = Shares { flipped: 100_000, noisy: 50_000, broken: 200_000, lost: 10_000 };
        let fates = |seed| {
            let mut line = Noise::new(shares, seed);
            (0..100_000).map(|_| line.pass(0x5A)).collect::<Vec<_>>()
        };
        let first = fates(7);
        assert_eq!(first, fates(7));
        assert_ne!(first, fates(8));
        let count = |is: fn(&Fate) -> bool| first.iter().filter(|fate| is(fate)).count();
        assert!((9_500..10_500).contains(&count(|f| matches!(f, Fate::Intact(b) if *b != 0x5A))));
        assert!((4_700..5_300).contains(&count(|f| matches!(f, Fate::Noisy(0x5A)))));
        assert!((19_400..20_600).contains(&count(|f| matches!(f, Fate::Broken(b) if *b != 0x5A))));
        assert!((850..1_150).contains(&count(|f| *f == Fate::Lost)));
    }
}
