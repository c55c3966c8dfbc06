//! The reception of one packet on a link whose true strength is known.

use units::{Db, Dbm};

/// Random numbers for one packet, which the caller draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draws {
    /// A standard normal number: mean 0, variance 1.
    pub normal: f32,
    /// A number uniform in [0, 1): when it is below the loss rate, the packet is lost.
    pub luck: f32,
}

/// The effects of the air and the receiver on a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reception {
    /// The B of equation (19), in dB²: the variance of one packet's RSSI about the link's strength.
    pub noise_variance: f32,
    /// The step in which RSSI is reported; the nRF51's RSSI register counts whole decibels.
    pub resolution: Db,
    /// The part of all packets that is lost whatever the signal, 0 to 1: 20 % "consistent with our
    /// experience with the Crazyflies" (section V-A.2).
    pub loss_rate: f32,
    /// The −s_min of section V-A.1: a weaker packet is not received.
    pub sensitivity: Dbm,
}

impl Reception {
    /// The paper's noise and packet loss (section V-A.2), with RSSI in whole decibels and a
    /// receiver without a limit of sensitivity.
    pub const PAPER: Self = Self {
        noise_variance: 3.0,
        resolution: Db(1.0),
        loss_rate: 0.2,
        sensitivity: Dbm(f32::NEG_INFINITY),
    };

    /// Whether packets of a link of this strength can be received.
    #[must_use]
    pub fn reaches(&self, strength: Dbm) -> bool {
        strength >= self.sensitivity
    }

    /// The RSSI that the receiver reports for one packet, or `None` where the packet is lost.
    #[must_use]
    pub fn receive(&self, strength: Dbm, draws: Draws) -> Option<Dbm> {
        if draws.luck < self.loss_rate || !self.reaches(strength) {
            return None;
        }
        let noisy = strength.0 + libm::sqrtf(self.noise_variance) * draws.normal;
        let rounded = if self.resolution.0 > 0.0 {
            libm::roundf(noisy / self.resolution.0) * self.resolution.0
        } else {
            noisy
        };
        Some(Dbm(rounded))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_is_noisy_rounded_or_lost() {
        let receive = |strength: f32, normal, luck| {
            Reception { sensitivity: Dbm(-90.0), ..Reception::PAPER }
                .receive(Dbm(strength), Draws { normal, luck })
        };
        assert_eq!(receive(-60.2, 0.0, 0.5), Some(Dbm(-60.0)));
        assert_eq!(receive(-60.2, 1.0, 0.5), Some(Dbm(-58.0))); // 1.73 dB better
        assert_eq!(receive(-60.2, 1.0, 0.19), None); // unlucky
        assert_eq!(receive(-90.5, 3.0, 0.5), None); // too weak, whatever the noise
    }
}
