//! Resamples blocks of predicted packets for the intervals of what is computed from them.

use std::collections::BTreeMap;

use random::{Purpose, Stream};

use super::{Gain, Interval, N, PAIRS, Predicted, STILL};

/// The number of samples of the bootstrap: 25 lie beyond each bound of 95 %.
const RESAMPLED: usize = 1_000;

/// Sums over the packets of one block of a link's time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    count: f64,
    pub(super) squares: [f64; N],
    pub(super) log_likelihoods: [f64; N],
    pub(super) motion_squares: f64,
    /// The change that the motion should make, times the change that came.
    motion_products: f64,
}

impl Block {
    /// The blocks of some packets.
    pub(super) fn of(packets: &[&Predicted]) -> Vec<Self> {
        let mut blocks: BTreeMap<(usize, u64), Self> = BTreeMap::new();
        for one in packets {
            let block = blocks.entry((one.link, one.block)).or_default();
            block.count += 1.0;
            for n in 0..N {
                block.squares[n] += one.errors[n] * one.errors[n];
                block.log_likelihoods[n] += one.log_likelihoods[n];
            }
            block.motion_squares += one.motion * one.motion;
            block.motion_products += one.motion * one.errors[STILL];
        }
        blocks.into_values().collect()
    }

    /// The sum of blocks.
    pub(super) fn sum<'a>(blocks: impl Iterator<Item = &'a Self>) -> Self {
        blocks.fold(Self::default(), |mut sum, block| {
            sum.count += block.count;
            for n in 0..N {
                sum.squares[n] += block.squares[n];
                sum.log_likelihoods[n] += block.log_likelihoods[n];
            }
            sum.motion_squares += block.motion_squares;
            sum.motion_products += block.motion_products;
            sum
        })
    }

    /// The part of the expected change that came.
    pub(super) fn came(&self) -> f64 {
        self.motion_products / self.motion_squares
    }
}

/// A value of all blocks, with the interval of the same of blocks drawn again with replacement.
pub(super) fn interval(blocks: &[Block], of: impl Fn(&Block) -> f64) -> Interval {
    let mut random = Stream::new(0, Purpose::Fit);
    let draw = |_| {
        let chosen = (0..blocks.len()).map(|_| &blocks[random.below(blocks.len() as u32) as usize]);
        of(&Block::sum(chosen))
    };
    let mut values: Vec<f64> = (0..RESAMPLED).map(draw).collect();
    values.sort_by(f64::total_cmp);
    let at = |part: f64| values[((part * RESAMPLED as f64) as usize).min(RESAMPLED - 1)];
    Interval { value: of(&Block::sum(blocks.iter())), low: at(0.025), high: at(0.975) }
}

/// The gain of each filter by the motion.
pub(super) fn gains(blocks: &[Block]) -> Vec<Gain> {
    let gain = |&(filter, still, moving): &(&'static str, usize, usize)| Gain {
        filter,
        rmse_percent: interval(blocks, |sum| {
            100.0 * (1.0 - (sum.squares[moving] / sum.squares[still]).sqrt())
        }),
        log_likelihood: interval(blocks, |sum| {
            (sum.log_likelihoods[moving] - sum.log_likelihoods[still]) / sum.count
        }),
    };
    PAIRS.iter().map(gain).collect()
}
