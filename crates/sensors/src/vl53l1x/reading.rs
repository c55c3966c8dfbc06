//! Decodes the result of a measurement.

use core::fmt;

use units::Metres;

/// The status of a measurement. Its distance is meaningful only if [`RangeStatus::is_valid`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RangeStatus {
    /// A target was measured, and the result was checked.
    Valid,
    /// The measurement is the first after a start, for which a target beyond reach cannot yet be
    /// distinguished from a near one.
    Unchecked,
    /// σ is above the limit, because too little light came back: there is a target, and its distance
    /// is not well measured.
    SigmaFail,
    /// Hardly any light came back: there is no target within reach.
    SignalFail,
    /// The target is nearer than the sensor can measure.
    MinRangeClipped,
    /// The phase is out of bounds: there is no target within reach, or one beyond it.
    OutOfBounds,
    /// The laser or its supervision failed, with this code of the device.
    Hardware(u8),
    /// The result has wrapped: a target beyond reach is measured as a near one.
    WrapTarget,
    /// The sensor received no more light than its cover reflects.
    Crosstalk,
    /// The interrupt is the first of a series and has no measurement.
    Synchronisation,
    /// Two targets could not be distinguished.
    MergedPulse,
    /// The signal of the target is too weak to measure.
    LackOfSignal,
    /// The target is nearer than the smallest distance.
    MinRangeFail,
    /// The device gave this code, which ST does not name.
    Other(u8),
}

impl RangeStatus {
    /// Decodes RESULT__RANGE_STATUS by the table of `VL53L1X_GetRangeStatus`, with the hardware
    /// failures as ST's full API distinguishes them. A complete range with a stream count of zero
    /// is unchecked (the same API).
    pub(super) const fn from_registers(status: u8, stream: u8) -> Self {
        match status & 0x1F {
            9 if stream == 0 => Self::Unchecked,
            9 => Self::Valid,
            code @ (1 | 2 | 3 | 17) => Self::Hardware(code),
            4 => Self::SignalFail,
            5 => Self::OutOfBounds,
            6 => Self::SigmaFail,
            7 => Self::WrapTarget,
            8 => Self::MinRangeClipped,
            12 => Self::Crosstalk,
            13 => Self::MinRangeFail,
            18 => Self::Synchronisation,
            19 => Self::Unchecked,
            22 => Self::MergedPulse,
            23 => Self::LackOfSignal,
            code => Self::Other(code),
        }
    }

    /// Whether the distance is reliable enough to be used in flight.
    #[must_use]
    pub const fn is_valid(self) -> bool {
        matches!(self, Self::Valid)
    }
}

/// A rate of counted photons, in millions a second (Mcps).
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CountRate(pub f32);

impl CountRate {
    /// Decodes a register with 7 binary places.
    fn from_register(raw: [u8; 2]) -> Self {
        Self(f32::from(u16::from_be_bytes(raw)) / 128.0)
    }
}

impl fmt::Display for CountRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)?;
        f.write_str(" Mcps")
    }
}

/// What one step of RESULT__FINAL_CROSSTALK_CORRECTED_RANGE_MM_SD0 is worth: a millimetre times the
/// gain of ST's full driver, 2011/2048 (`VL53L1_copy_sys_and_core_results_to_range_results` and
/// `VL53L1_TUNINGPARM_LITE_RANGING_GAIN_FACTOR_DEFAULT` of its API, which crazyflie-firmware links;
/// the Ultra Lite Driver leaves it out, and reads 1.8 % too far).
pub(crate) const METRES_PER_STEP: f32 = 1e-3 * 2011.0 / 2048.0;

/// The result of one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading {
    /// The measured distance, which is reliable only if the status is valid: see
    /// [`Reading::range`].
    pub distance: Metres,
    /// The sensor's own estimate of the standard deviation.
    pub sigma: Metres,
    /// The status of the measurement.
    pub status: RangeStatus,
    /// The rate of the sensor's own light that was reflected back.
    pub signal: CountRate,
    /// The rate of the ambient light.
    pub ambient: CountRate,
    /// The count of measurements. Two readings with the same count are the same measurement, and a
    /// count that does not change means that the sensor has stopped measuring.
    pub stream: u8,
}

impl Reading {
    /// Decodes the 17 bytes from RESULT__RANGE_STATUS on.
    pub(super) fn from_registers(result: [u8; 17]) -> Self {
        let [status, _, stream, _, _, _, _, a1, a0, g1, g0, _, _, d1, d0, s1, s0] = result;
        Self {
            distance: Metres(f32::from(u16::from_be_bytes([d1, d0])) * METRES_PER_STEP),
            // The register holds quarters of a millimetre.
            sigma: Metres(f32::from(u16::from_be_bytes([g1, g0])) * 0.25e-3),
            status: RangeStatus::from_registers(status, stream),
            signal: CountRate::from_register([s1, s0]),
            ambient: CountRate::from_register([a1, a0]),
            stream,
        }
    }

    /// Returns the distance, if it is reliable enough to be used in flight.
    #[must_use]
    pub const fn range(&self) -> Option<Metres> {
        if self.status.is_valid() { Some(self.distance) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table is `status_rtn` of ST's driver, with the names of UM2510.
    #[test]
    fn every_code_of_the_device_has_its_name() {
        let named = [
            (4, RangeStatus::SignalFail),
            (5, RangeStatus::OutOfBounds),
            (6, RangeStatus::SigmaFail),
            (7, RangeStatus::WrapTarget),
            (8, RangeStatus::MinRangeClipped),
            (9, RangeStatus::Valid),
            (12, RangeStatus::Crosstalk),
            (13, RangeStatus::MinRangeFail),
            (18, RangeStatus::Synchronisation),
            (19, RangeStatus::Unchecked),
            (22, RangeStatus::MergedPulse),
            (23, RangeStatus::LackOfSignal),
        ];
        for code in 0..32 {
            let decoded = RangeStatus::from_registers(code, 1);
            let expected = match named.iter().find(|(named, _)| *named == code) {
                Some((_, status)) => *status,
                None if [1, 2, 3, 17].contains(&code) => RangeStatus::Hardware(code),
                None => RangeStatus::Other(code),
            };
            assert_eq!(decoded, expected, "{code}");
            assert_eq!(decoded.is_valid(), code == 9);
            // The upper bits are flags.
            assert_eq!(RangeStatus::from_registers(code | 0xE0, 1), decoded);
        }
        assert_eq!(RangeStatus::from_registers(9, 0), RangeStatus::Unchecked);
    }

    #[test]
    fn a_result_is_decoded_from_its_registers() {
        let reading = Reading::from_registers([
            0x09, 0xFF, 0x21, 0xFF, 0xFF, 0xFF, 0xFF, 0x00, 0x40, 0x00, 0x0A, 0xFF, 0xFF, 0x04,
            0xD2, 0x01, 0x80,
        ]);
        assert_eq!(reading.stream, 0x21);
        // 1234 · 2011/2048, as ST's driver gives it.
        assert!((reading.distance.0 - 1.211_7).abs() < 1e-4);
        assert!((reading.sigma.0 - 0.0025).abs() < 1e-7);
        assert_eq!(reading.ambient, CountRate(0.5));
        assert_eq!(reading.signal, CountRate(3.0));
        assert_eq!(reading.range(), Some(reading.distance));
    }
}
