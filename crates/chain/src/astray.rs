//! Notices that a relay is in another branch than the drone in front of it.
//!
//! In a tunnel a signal does not become weaker as its receiver comes nearer to the sender: the
//! monotonic propagation that the U-Chain paper assumes. So a relay that flies outward, while the
//! drone in front stays where it is or comes back, hears that drone better and better. Where it hears
//! it much worse, the way does not lead there.

use units::{Db, Dbm, Metres, NodeId};

/// The constants of the watch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AstrayConfig {
    /// The relay must have flown so far outward. Fading decorrelates within half a wavelength, 6 cm,
    /// and shadowing within some metres.
    pub way: Metres,
    /// The front link must have become weaker by so much: twice the difference that shadowing with a
    /// standard deviation of 4 dB has between two places. In the simulator the front link of a relay
    /// in a wrong branch becomes weaker by 15 to 35 dB within the same 1.5 m.
    pub fall: Db,
    /// While the drone in front flies away by more than this, its links may become weaker in any
    /// case: it may go round a corner. Our own number, above what an odometer trembles by at rest.
    pub still: Metres,
    /// A relay that has lost the drone in front, and has flown on for so long without finding it, is
    /// in a wrong branch as well: half of the way that it would fly on for at most.
    pub alone: Metres,
}

impl AstrayConfig {
    /// The constants that are flashed.
    pub const DEFAULT: Self =
        Self { way: Metres(1.5), fall: Db(12.0), still: Metres(0.15), alone: Metres(3.0) };
}

/// The drone in front, as a relay hears it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Front {
    /// The drone.
    pub peer: NodeId,
    /// The filtered strength of the link to it.
    pub rssi: Dbm,
    /// Its way along the tunnel, by its own odometer.
    pub odometer: Metres,
}

/// The state of the watch: where the front link was strongest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AstrayWatch {
    best: Option<(Metres, Front)>,
}

impl AstrayWatch {
    /// A watch that has heard no drone in front.
    #[must_use]
    pub const fn new() -> Self {
        Self { best: None }
    }

    /// Carries out one round of a relay at `way`, and returns whether it is in another branch than the
    /// drone in front. It can be only where the tunnel has opened to a side, at `opened`, since shortly
    /// before the front link was strongest: round a bend without another branch a link falls as much.
    pub fn step(
        &mut self,
        config: &AstrayConfig,
        way: Metres,
        opened: Option<Metres>,
        front: Option<Front>,
    ) -> bool {
        let Some(front) = front else { return false };
        let (best_way, best) = *self.best.get_or_insert((way, front));
        let is_same = best.peer == front.peer
            && way >= best_way
            && front.rssi <= best.rssi
            && front.odometer - best.odometer <= config.still;
        if !is_same {
            self.best = Some((way, front));
            return false;
        }
        let has_opened =
            opened.is_some_and(|opened| opened >= best_way - config.way && opened <= way);
        has_opened && way - best_way >= config.way && best.rssi - front.rssi >= config.fall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the watch reports a relay that flies outward for 3 m, while its front link changes by
    /// `gain` dB/m and the drone in front flies at `flies` of its speed.
    fn reports(gain: f32, flies: f32) -> bool {
        let mut watch = AstrayWatch::new();
        (0..60).any(|round| {
            let way = 0.05 * round as f32;
            let rssi = Dbm(-60.0 + gain * way);
            let front = Front { peer: NodeId(0), rssi, odometer: Metres(9.0 + flies * way) };
            watch.step(&AstrayConfig::DEFAULT, Metres(way), Some(Metres(0.0)), Some(front))
        })
    }

    #[test]
    fn a_relay_is_astray_that_hears_the_drone_in_front_ever_worse() {
        assert!(reports(-8.0, 0.0));
        assert!(reports(-8.0, -0.5), "the drone in front comes back");
    }

    #[test]
    fn a_relay_is_not_astray_whose_front_link_grows_or_whose_neighbour_flies_on() {
        assert!(!reports(3.0, 0.0));
        assert!(!reports(-2.0, 0.0), "shadowing");
        assert!(!reports(-8.0, 1.0));
    }

    #[test]
    fn a_relay_that_flies_back_is_not_astray() {
        let mut watch = AstrayWatch::new();
        for round in 0..60 {
            let way = 9.0 - 0.05 * round as f32;
            let front = Front { peer: NodeId(0), rssi: Dbm(-60.0 - way), odometer: Metres(12.0) };
            let opened = Some(Metres(way));
            assert!(!watch.step(&AstrayConfig::DEFAULT, Metres(way), opened, Some(front)));
            let weak = Front { rssi: Dbm(-60.0 - 8.0 * (9.0 - way)), ..front };
            assert!(!watch.step(&AstrayConfig::DEFAULT, Metres(way), opened, Some(weak)));
        }
    }
}
