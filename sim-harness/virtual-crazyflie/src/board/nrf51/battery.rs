//! The battery as the chip measures it: at times and in steps (crazyflie2-nrf-firmware, `pm.c`).

use crate::soc::Nanos;

/// Two conversions, each started at every sixth tick, take turns: the battery's and the charger's.
const PERIOD: Nanos = 12_000_000;
/// A step of the converter: 1.2 V in 10 bits. Its input is a divider's, and the voltage is 4.5 times
/// what is compared.
const STEP_VOLTS: f32 = 1.2 * 4.5 / 1023.0;
/// The charger's current in the units of `pmGetISET`, which are amperes whatever its document says.
const CHARGE_AMPERES: f32 = 0.5;

/// The battery, and what the chip has measured of it last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Battery {
    volts: f32,
    charging: bool,
    usb: bool,
    /// The result of the last conversion, and its number since the clock began.
    measured: (f32, Nanos),
}

impl Battery {
    /// A battery of 4.0 V, which the chip has just measured.
    pub(super) fn new() -> Self {
        let volts = 4.0;
        Self { volts, charging: false, usb: false, measured: (in_steps(volts), 0) }
    }

    /// From now on this is what the chip would measure.
    pub(super) fn set(&mut self, now: Nanos, volts: f32, charging: bool, usb: bool) {
        self.convert(now);
        if now == 0 {
            self.measured = (in_steps(volts), 0);
        }
        (self.volts, self.charging, self.usb) = (volts, charging, usb);
    }

    /// The conversions up to now: only the last of them counts.
    fn convert(&mut self, now: Nanos) {
        let number = now / PERIOD;
        if number > self.measured.1 {
            self.measured = (in_steps(self.volts), number);
        }
    }

    /// The voltage of the last conversion.
    pub(super) fn volts(&mut self, now: Nanos) -> f32 {
        self.convert(now);
        self.measured.0
    }

    /// The data of a report: flags, voltage and the charger's current.
    pub(super) fn report(&mut self, now: Nanos) -> Vec<u8> {
        // The third flag: there is a charger. A Crazyflie has one, a Bolt has not.
        let mut data = vec![u8::from(self.charging) | u8::from(self.usb) << 1 | 1 << 2];
        data.extend_from_slice(&self.volts(now).to_le_bytes());
        let amperes = if self.charging { CHARGE_AMPERES } else { 0.0 };
        data.extend_from_slice(&amperes.to_le_bytes());
        data
    }
}

fn in_steps(volts: f32) -> f32 {
    (volts / STEP_VOLTS).floor().clamp(0.0, 1023.0) * STEP_VOLTS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voltage_is_measured_every_twelve_milliseconds_in_steps() {
        let mut battery = Battery::new();
        battery.set(1, 3.75, false, false);
        assert!((battery.volts(11_999_999) - 4.0).abs() < STEP_VOLTS);
        let volts = battery.volts(12_000_000);
        assert!((0.0..STEP_VOLTS).contains(&(3.75 - volts)), "{volts}");
        // Of a sag between two conversions the chip knows nothing.
        battery.set(13_000_000, 3.0, false, false);
        battery.set(23_000_000, 3.75, false, false);
        assert_eq!(battery.volts(24_000_000).to_bits(), volts.to_bits());
    }

    #[test]
    fn every_step_is_five_millivolts_and_a_quarter() {
        let steps: std::collections::BTreeSet<u32> =
            (0..=1_000).map(|n| in_steps(3.7 + n as f32 * 1e-4).to_bits()).collect();
        assert_eq!(steps.len(), 20);
    }
}
