//! Notices that the signal does not fall evenly along the tunnel.
//!
//! Where it does, as section III-B of the paper assumes, a link that reaches farther at both of its
//! ends is weaker than the link within. A link that was weaker before it was lengthened, or stronger
//! before it was shortened, is evidence that a wall leaks or a chamber reflects; and only there can a
//! relay gain by looking for another place than the one at which its links are equal.

/// The record of one link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Relief {
    /// The largest loss of a link within the present one.
    within: Extent,
    /// The least loss of a link around the present one.
    around: Extent,
    /// The largest loss that lengthening the link has taken away.
    hump: f32,
}

/// A link as it was at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extent {
    /// How much farther out than at the first packet this drone's end and its neighbour's end were, m.
    ends: [f32; 2],
    /// Its loss, dB.
    loss: f32,
}

impl Extent {
    /// Ends that are nearer are the same, m: more than the tremble of two drones that hover, by their
    /// odometers.
    const SLACK: f32 = 0.05;
    /// A link is compared with one that it exceeds by this much, m: the filter follows a corner only
    /// on the next 0.1 to 0.2 m, and what it says there is not the loss of the place.
    const LAG: f32 = 0.5;

    /// Whether this link reaches at least as far as `other` at both ends.
    fn contains(&self, other: &Self) -> bool {
        self.ends.iter().zip(other.ends).all(|(end, within)| *end >= within - Self::SLACK)
    }

    /// Whether this link, which contains `other`, is longer than it by more than the filter's lag.
    fn exceeds(&self, other: &Self) -> bool {
        let longer: f32 = self.ends.iter().sum::<f32>() - other.ends.iter().sum::<f32>();
        longer >= Self::LAG
    }
}

impl Relief {
    /// The record of a link whose first packet had this loss, dB.
    pub(super) const fn first(loss: f32) -> Self {
        let now = Extent { ends: [0.0; 2], loss };
        Self { within: now, around: now, hump: 0.0 }
    }

    /// Moves this drone's end and its neighbour's end out by so much, m.
    pub(super) fn separate(&mut self, [own, peer]: [f32; 2]) {
        // The record is kept relative to the present ends, so that its numbers stay small.
        for extent in [&mut self.within, &mut self.around] {
            extent.ends = [extent.ends[0] - own, extent.ends[1] - peer];
        }
    }

    /// Notes the present loss of the link, dB. Of two losses of nearly the same link the one that
    /// makes the smaller hump counts.
    pub(super) fn note(&mut self, loss: f32) {
        let now = Extent { ends: [0.0; 2], loss };
        let within = &mut self.within;
        if !now.contains(within) || now.exceeds(within) && loss > within.loss {
            *within = now;
        } else if now.exceeds(within) {
            self.hump = self.hump.max(within.loss - loss);
        } else {
            within.loss = within.loss.min(loss);
        }
        let around = &mut self.around;
        if !around.contains(&now) || around.exceeds(&now) && loss < around.loss {
            *around = now;
        } else if around.exceeds(&now) {
            self.hump = self.hump.max(loss - around.loss);
        } else {
            around.loss = around.loss.max(loss);
        }
    }

    /// The largest loss that lengthening the link has taken away, dB.
    pub(super) const fn hump(&self) -> f32 {
        self.hump
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hump of a link of this length whose neighbour flies out and back again by `ways`, where the
    /// link of a length has this loss.
    fn hump(mut length: f32, ways: &[f32], loss: impl Fn(f32) -> f32) -> f32 {
        let mut relief = Relief::first(loss(length));
        for way in ways {
            for _ in 0..50 {
                relief.separate([0.0, way / 50.0]);
                length += way / 50.0;
                relief.note(loss(length));
            }
        }
        relief.hump()
    }

    #[test]
    fn a_signal_that_falls_evenly_has_no_hump() {
        let even = |length: f32| 40.0 + 25.0 * libm::log10f(length);
        assert_eq!(hump(1.0, &[5.0, -3.0, 6.0, -8.0, 9.0], even), 0.0);
        let corner = |length: f32| even(length) + if length > 4.0 { 20.0 } else { 0.0 };
        assert_eq!(hump(1.0, &[5.0, -3.0, 6.0, -8.0, 9.0], corner), 0.0);
    }

    #[test]
    fn a_wall_that_leaks_is_a_hump_on_the_way_out_and_on_the_way_back() {
        let leaky = |length: f32| if (3.0..5.0).contains(&length) { 70.0 } else { 55.0 };
        assert!(hump(1.0, &[5.0], leaky) > 14.0);
        // The first packet comes from beyond the wall.
        assert!(hump(7.0, &[-3.0], leaky) > 14.0);
    }

    /// A drone that hovers hears its neighbour now 12 dB weaker and now as before.
    #[test]
    fn a_link_that_does_not_change_its_length_has_no_hump() {
        let mut relief = Relief::first(60.0);
        for round in 0..200 {
            let tremble = if round % 2 == 0 { 0.02 } else { -0.02 };
            relief.separate([tremble, -tremble]);
            relief.note(if round % 20 < 3 { 72.0 } else { 60.0 });
        }
        assert_eq!(relief.hump(), 0.0);
    }
}
