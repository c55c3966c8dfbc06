//! The battery: a voltage that falls with the charge that was taken and sags with the current.

use scenario::VehicleSpec;

use super::body::STEP;

/// Charge of a full battery, A s: 250 mAh, the one that comes with a Crazyflie 2.1.
const CAPACITY: f64 = 0.25 * 3600.0;
/// Open-circuit voltage at 0, 10, … 100 % of the charge: `bat671723HS25C` of `pm_stm32f4.c` in
/// crazyflie-firmware, which is this battery's, and 4.2 V when full.
const OPEN: [f32; 11] = [3.00, 3.78, 3.83, 3.87, 3.89, 3.92, 3.96, 4.00, 4.04, 4.10, 4.20];
/// The current of board, radio and decks, A. The same measurements, over eight thrusts.
const IDLE: f32 = 0.24;
/// The current of the motors per thrust, A/N, by the same measurements.
pub const CURRENT_PER_THRUST: f32 = 6.65;

/// One battery.
#[derive(Clone, Debug)]
pub struct Battery {
    /// The part of its charge that is left. Steps of 3e-6 of the whole do not add up in an `f32`.
    charge: f64,
    /// Internal resistance, wiring included, Ω.
    resistance: f32,
    volts: f32,
}

impl Battery {
    /// The internal resistance of a battery of which a scenario says nothing, Ω.
    pub const USUAL_OHM: f32 = VehicleSpec::BATTERY_OHM;

    /// A new battery with this part of its charge, 0 to 1.
    #[must_use]
    pub fn with_charge(charge: f32) -> Self {
        Self::aged(charge, Self::USUAL_OHM)
    }

    /// A battery with this part of its charge, 0 to 1, and this internal resistance, Ω: it grows with
    /// age.
    #[must_use]
    pub fn aged(charge: f32, resistance: f32) -> Self {
        let charge = f64::from(charge.clamp(0.0, 1.0));
        let mut battery = Self { charge, resistance, volts: 0.0 };
        battery.volts = battery.open() - resistance * IDLE;
        battery
    }

    /// The part of its charge that is left.
    #[must_use]
    pub const fn charge(&self) -> f32 {
        self.charge as f32
    }

    /// The voltage at its terminals, under load, V.
    #[must_use]
    pub const fn volts(&self) -> f32 {
        self.volts
    }

    /// Discharges the battery to this part of a full charge.
    pub fn drain_to(&mut self, charge: f32) {
        self.charge = self.charge.min(f64::from(charge));
    }

    /// One millisecond under motors that lift `lift` newtons.
    pub fn advance(&mut self, lift: f32) {
        self.advance_for(lift, STEP);
    }

    /// So many seconds under motors that lift `lift` newtons.
    pub fn advance_for(&mut self, lift: f32, seconds: f32) {
        let current = current(lift);
        self.charge = (self.charge - f64::from(current * seconds) / CAPACITY).max(0.0);
        self.volts = (self.open() - self.resistance * current).max(0.0);
    }

    /// The time until the voltage under motors that lift `lift` newtons falls to `critical` volts, s.
    #[must_use]
    pub fn lasts(&self, lift: f32, critical: f32) -> f32 {
        let current = current(lift);
        let least = charge_at(critical + self.resistance * current);
        let left = (self.charge as f32 - least).max(0.0);
        left * CAPACITY as f32 / current
    }

    /// The voltage without load.
    fn open(&self) -> f32 {
        let place = self.charge as f32 * (OPEN.len() - 1) as f32;
        let below = (place as usize).min(OPEN.len() - 2);
        let (low, high) = (OPEN[below], OPEN[below + 1]);
        low + (place - below as f32) * (high - low)
    }
}

/// The current under motors that lift `lift` newtons, A.
fn current(lift: f32) -> f32 {
    IDLE + CURRENT_PER_THRUST * lift
}

/// The part of the charge that is left where the voltage without load is `open`.
fn charge_at(open: f32) -> f32 {
    let parts = (OPEN.len() - 1) as f32;
    let steps = OPEN.windows(2).zip(0_u8..);
    let within = steps.filter_map(|(pair, below)| {
        let (low, high) = (pair[0], pair[1]);
        let part = (open - low) / (high - low);
        (open < high).then(|| (f32::from(below) + part.max(0.0)) / parts)
    });
    { within }.next().unwrap_or(1.0)
}
