//! The reception of one packet on a link whose true strength is known.

use units::{Db, Dbm};

/// Random numbers for one packet, which the caller draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draws {
    /// A standard normal number: mean 0, variance 1.
    pub normal: f32,
    /// A number uniform in [0, 1): when it is below the loss rate, the packet is lost.
    pub luck: f32,
    /// What a recorded packet adds to the reported strength; zero without a recording.
    pub deviation: Db,
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
    /// The strength at which one bit of a thousand is wrong, as data sheets give it
    /// ([`Reception::bit_error_rate`]). With −∞ no packet is too weak.
    pub sensitivity: Dbm,
}

/// The signal-to-noise ratio of a bit at the sensitivity: ½·exp(−γ/2) is 0.1 % at 2·ln 500.
const GAMMA: f32 = 12.429_216;
/// A packet that is weaker than the sensitivity by this much is never received: 4 % of its bits are
/// wrong, and the shortest packet, of 225 bits, gets through once in 16,000 times.
const HOPELESS: Db = Db(4.0);
/// A packet that is stronger than the sensitivity by this much has no wrong bits: one in 10¹¹.
const CLEAN: Db = Db(6.0);

impl Reception {
    /// The sensitivity of the nRF51822 at 2 Mbit/s, typical, at a bit error rate of 0.1 % (nRF51822
    /// product specification, receiver specifications). The amplifier that the Crazyflie 2.1 has in
    /// front of it is left out.
    pub const NRF51_AT_2_MBIT: Dbm = Dbm(-85.0);
    /// The sensitivity of the nRF51822 at 1 Mbit/s, typical, in the chip's own mode and not
    /// Bluetooth's. The number has yet to be checked against the product specification.
    pub const NRF51_AT_1_MBIT: Dbm = Dbm(-90.0);
    /// The sensitivity of the nRF51822 at 250 kbit/s, typical. The number has yet to be checked against
    /// the product specification.
    pub const NRF51_AT_250_KBIT: Dbm = Dbm(-96.0);

    /// The paper's noise and packet loss (section V-A.2), with RSSI in whole decibels and a
    /// receiver without a limit of sensitivity.
    pub const PAPER: Self = Self {
        noise_variance: 3.0,
        resolution: Db(1.0),
        loss_rate: 0.2,
        sensitivity: Dbm(f32::NEG_INFINITY),
    };

    /// Whether any packets of a link of this strength are received.
    #[must_use]
    pub fn reaches(&self, strength: Dbm) -> bool {
        strength >= self.sensitivity - HOPELESS
    }

    /// The part of the bits that is wrong at this strength: that of orthogonal binary FSK without a
    /// phase reference in white noise,
    ///
    /// > ½ · exp(−γ/2), with γ = 2·ln 500 · 10^((strength − sensitivity) / 10 dB)
    ///
    /// (J. Proakis, *Digital Communications*, noncoherent detection), which is 0.1 % at the
    /// sensitivity, whatever the noise figure of the receiver. The narrower keying of the nRF51 needs
    /// more signal, which the sensitivity contains; the slope is taken to be the same.
    #[must_use]
    pub fn bit_error_rate(&self, strength: Dbm) -> f32 {
        let above = strength - self.sensitivity;
        if above >= CLEAN {
            return 0.0;
        }
        let gamma = GAMMA * libm::powf(10.0, above.0 * 0.1);
        0.5 * libm::expf(-0.5 * gamma)
    }

    /// The part of the packets of so many bits that is lost by the noise of the receiver: that in
    /// which any bit is wrong, 1 − (1 − p)ⁿ. It grows with the length and the weakness of a packet.
    #[must_use]
    pub fn packet_error_rate(&self, strength: Dbm, bits: u64) -> f32 {
        if !self.reaches(strength) {
            return 1.0;
        }
        let wrong = self.bit_error_rate(strength);
        if wrong == 0.0 { 0.0 } else { -libm::expm1f(bits as f32 * libm::log1pf(-wrong)) }
    }

    /// The part of the packets of so many bits that is lost, by chance or by noise.
    #[must_use]
    pub fn loss_rate_of(&self, strength: Dbm, bits: u64) -> f32 {
        self.loss_rate + (1.0 - self.loss_rate) * self.packet_error_rate(strength, bits)
    }

    /// The RSSI that the receiver reports for a packet of so many bits, or `None` where the packet is
    /// lost.
    #[must_use]
    pub fn receive(&self, strength: Dbm, bits: u64, draws: Draws) -> Option<Dbm> {
        if draws.luck < self.loss_rate_of(strength, bits) {
            return None;
        }
        let noise = libm::sqrtf(self.noise_variance) * draws.normal + draws.deviation.0;
        let noisy = strength.0 + noise;
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
    use proptest::prelude::*;

    const NRF51: Reception =
        Reception { sensitivity: Reception::NRF51_AT_2_MBIT, ..Reception::PAPER };
    /// The longest P2P packet.
    const LONGEST: u64 = 569;

    #[test]
    fn a_packet_is_noisy_rounded_or_lost() {
        let receive = |strength: f32, normal, luck| {
            NRF51.receive(Dbm(strength), 300, Draws { normal, luck, deviation: Db(0.0) })
        };
        assert_eq!(receive(-60.2, 0.0, 0.5), Some(Dbm(-60.0)));
        assert_eq!(receive(-60.2, 1.0, 0.5), Some(Dbm(-58.0))); // 1.73 dB better
        assert_eq!(receive(-60.2, 1.0, 0.19), None); // unlucky
        assert_eq!(receive(-89.1, 3.0, 0.999), None); // too weak, whatever the noise
        let recorded = Draws { normal: 0.0, luck: 0.5, deviation: Db(-4.4) };
        assert_eq!(NRF51.receive(Dbm(-60.2), 300, recorded), Some(Dbm(-65.0)));
    }

    #[test]
    fn one_bit_in_a_thousand_is_wrong_at_the_sensitivity() {
        assert!((NRF51.bit_error_rate(Dbm(-85.0)) - 1e-3).abs() < 1e-6);
        let rates = [-88.0, -86.0, -85.0, -84.0, -83.0, -82.0, -79.0]
            .map(|dbm| (NRF51.packet_error_rate(Dbm(dbm), LONGEST) * 1_000.0).round());
        assert_eq!(rates, [1_000.0, 871.0, 434.0, 108.0, 15.0, 1.0, 0.0]);
        let no_limit = Reception::PAPER.packet_error_rate(Dbm(-300.0), LONGEST);
        assert_eq!(no_limit, 0.0);
    }

    proptest! {
        /// The loss is a part, and never falls with the length or the weakness of a packet.
        #[test]
        fn the_longer_and_the_weaker_a_packet_the_more_are_lost(
            strength in -120.0f32..0.0, weaker in 0.0f32..10.0,
            bits in 1_u64..600, longer in 0_u64..600, loss_rate in 0.0f32..1.0,
        ) {
            let air = Reception { loss_rate, ..NRF51 };
            let loss = air.loss_rate_of(Dbm(strength), bits);
            prop_assert!((loss_rate..=1.0 + 1e-6).contains(&loss));
            prop_assert!(air.loss_rate_of(Dbm(strength - weaker), bits) >= loss - 1e-6);
            prop_assert!(air.loss_rate_of(Dbm(strength), bits + longer) >= loss - 1e-6);
        }
    }
}
