//! Computes what the best chain loses that does not know the shadows and fades of a place.
//!
//! The oracle beside which the gap of a chain is measured stands on the crests of all fades. No drone
//! that measures its own links while it flies can find them. What is left to a drone is the mean of a
//! link over some wavelengths, where it has flown, and the law of the path loss, where it has not. So
//! beside the oracle there are two chains: the one that is the best in the local mean, with the
//! shadows and without the fades, and the one that is the best by the law alone. Each is flown in
//! thought: its relays are anywhere within a wavelength of their places, as the noise of their flow
//! sensors has them, and the mean of the weakest link's loss over such places counts.

use radio_model::WAVELENGTH;
use random::{Purpose, Stream};
use world::{Known, World, best_chain_known};

use measure::metrics::Reference;

/// The places about those of a chain at which it is looked at: the mean of their weakest links' losses,
/// which scatter by some 5 dB, is known to 0.25 dB.
const LOOKS: usize = 400;

/// How far below the oracle those chains are that do not know all of the radio, in dB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnknownGaps {
    /// The chain that is the best in the local mean.
    pub local_mean_db: f64,
    /// The chain that is the best by the law of the path loss.
    pub law_db: f64,
}

impl UnknownGaps {
    /// The gaps in a place; `None` where there are neither shadows nor fades, or no chain that is in
    /// the air from the start.
    pub(super) fn of(world: &World, reference: &Reference) -> Option<Self> {
        let (way, oracle) = reference.fixed().filter(|_| world.radio.has_fields())?;
        let links = oracle.positions.len().checked_sub(1)?;
        let gap = |known| {
            let chain = best_chain_known(&world.radio, known, way, links);
            let mut random = Stream::new(0, Purpose::Start);
            let looked = |_| {
                let last = chain.positions.len() - 1;
                let near = chain.positions.iter().enumerate().map(|(n, &at)| {
                    let moves = n > 0 && n < last;
                    let by = if moves { WAVELENGTH * (2.0 * random.uniform() - 1.0) } else { 0.0 };
                    way.at((at + by).clamp(0.0, way.length()))
                });
                let places: Vec<_> = near.collect();
                let losses = places.windows(2).map(|pair| world.radio.strength(pair[0], pair[1]));
                losses
                    .map(|strength| f64::from(strength.loss().0))
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            (0..LOOKS).map(looked).sum::<f64>() / LOOKS as f64 - f64::from(oracle.worst.0)
        };
        Some(Self { local_mean_db: gap(Known::Shadows), law_db: gap(Known::Law) })
    }
}
