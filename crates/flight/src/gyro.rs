//! Checks the gyroscope against predicted body rates, and bridges its gaps with them: without body
//! rates a multicopter falls within a second.
//!
//! The rates are predicted from the torques of the motors, which works for a short time. Only the
//! torque in excess of its recent mean turns the body; the mean is the trim, which compensates for
//! an asymmetric airframe, unequal motors or an off-centre battery.
//!
//! The prediction replaces samples that are missing or frozen. It also exposes a faulty gyroscope:
//! rates do not jump by more than [`GyroConfig::jump`] within a millisecond unless the drone is
//! hit, and then the accelerometer measures the impact too.

use units::{Duration, Instant};

use crate::monitor::SensorMonitor;

/// The constants of the gyroscope's checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroConfig {
    /// A difference of more than this between reading and prediction is a jump, rad/s.
    pub jump: f32,
    /// The lateral specific force of an impact for each rad/s by which the rates jump in it, m/s².
    pub impact_per_jump: f32,
    /// Lateral specific force above which an offset is not corrected anew, m/s²: the drone is being
    /// hit.
    pub hit_force: f32,
    /// Time after a jump within which the accelerometer must show an impact and its end, behind its
    /// filter.
    pub suspect_for: Duration,
    /// A remaining offset smaller than this counts as none, rad/s.
    pub least_offset: f32,
    /// After this many bit-identical samples the sensor counts as frozen.
    pub most_repeats: u16,
    /// The first-order lag between a motor's command and its torque, s.
    pub motor_lag: f32,
    /// The time constant of the mean torque that is taken for the trim, s.
    pub trim_time_constant: f32,
}

impl GyroConfig {
    /// The strongest torque of a Crazyflie, with each motor at either zero or 0.12 N, changes the
    /// rate about one axis by 0.5 rad/s in a millisecond; in normal flight it is a tenth of that.
    /// An impact 5 cm from the centre that changes the rate by 0.5 rad/s changes the velocity by 5
    /// mm/s. Behind the accelerometer's 30 Hz filter that is a pulse of 0.43 m/s² after 6 ms, half of
    /// it after 14 ms; a stronger one in proportion. In real flights, by hand and lively, that
    /// reading is 0.17 m/s² in the middle, 0.42 at p95 and 0.96 at most
    /// (arplaboratory/data-driven-system-identification, `log15`): over the threshold of a jump of
    /// 1 rad/s in 0.02 % of the windows. Motor lag: 65 ms, the pole of the thrust in Förster's
    /// identification of the Crazyflie (2015).
    pub const DEFAULT: Self = Self {
        jump: 0.5,
        impact_per_jump: 0.8,
        hit_force: 2.5,
        suspect_for: Duration::from_millis(20),
        least_offset: 0.15,
        most_repeats: 4,
        motor_lag: 0.065,
        trim_time_constant: 0.5,
    };
}

/// The source of the rates in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RateSource {
    /// The reading is used.
    Measured,
    /// The reading jumped; the prediction is used until the reason is known.
    Suspect {
        since: Instant,
        /// The jump, along the axis where it is largest, rad/s.
        jump: f32,
        /// The strongest lateral specific force since the jump, m/s².
        peak_force: f32,
    },
    /// The reading is used without an offset that appeared from one sample to the next.
    Offset { since: Instant, offset: [f32; 3] },
    /// There is no reading; the prediction is used.
    Missing { since: Instant },
}

/// The body rates: measured, corrected or predicted.
#[derive(Clone, Debug)]
pub(crate) struct Gyro {
    monitor: SensorMonitor<[f32; 3]>,
    source: RateSource,
    rates: [f32; 3],
    /// Torque that the motors give behind their lag, N m.
    torque: [f32; 3],
    /// Mean torque that holds the airframe still, N m.
    trim: [f32; 3],
}

impl Gyro {
    pub(crate) const fn new() -> Self {
        Self {
            monitor: SensorMonitor::new(),
            source: RateSource::Missing { since: Instant::ZERO },
            rates: [0.0; 3],
            torque: [0.0; 3],
            trim: [0.0; 3],
        }
    }

    /// Clears the torques: on the ground the motors are off.
    pub(crate) fn rest(&mut self) {
        self.torque = [0.0; 3];
        self.trim = [0.0; 3];
    }

    /// Advances by `dt` seconds. `reading` has its bias removed, `lateral_force` is the horizontal
    /// specific force beyond its mean in m/s², `torque` the last commanded torque in N m.
    #[expect(clippy::too_many_arguments, reason = "a sample is checked against all of these")]
    pub(crate) fn step(
        &mut self,
        config: &GyroConfig,
        now: Instant,
        reading: Option<[f32; 3]>,
        lateral_force: f32,
        torque: [f32; 3],
        inertia: [f32; 3],
        dt: f32,
    ) {
        let predicted = self.predict(config, torque, inertia, dt);
        let reading = self.monitor.accept(now, reading, config.most_repeats);
        let reading = reading.filter(|rates| rates.iter().all(|rate| rate.is_finite()));
        (self.source, self.rates) = match reading {
            None => (self.missing(now), predicted),
            Some(reading) => self.classify(config, now, reading, predicted, lateral_force),
        };
    }

    fn predict(
        &mut self,
        config: &GyroConfig,
        torque: [f32; 3],
        inertia: [f32; 3],
        dt: f32,
    ) -> [f32; 3] {
        let part = (dt / config.motor_lag).min(1.0);
        let learnt =
            if self.source == RateSource::Measured { dt / config.trim_time_constant } else { 0.0 };
        let mut rates = self.rates;
        let torques = self.torque.iter_mut().zip(&mut self.trim).zip(torque).zip(inertia);
        for (rate, (((given, trim), asked), inertia)) in rates.iter_mut().zip(torques) {
            *given += part * (asked - *given);
            *trim += learnt.min(1.0) * (*given - *trim);
            *rate += (*given - *trim) / inertia * dt;
        }
        rates
    }

    fn missing(&self, now: Instant) -> RateSource {
        match self.source {
            missing @ RateSource::Missing { .. } => missing,
            RateSource::Suspect { since, .. } => RateSource::Missing { since },
            RateSource::Measured | RateSource::Offset { .. } => RateSource::Missing { since: now },
        }
    }

    fn classify(
        &self,
        config: &GyroConfig,
        now: Instant,
        reading: [f32; 3],
        predicted: [f32; 3],
        lateral_force: f32,
    ) -> (RateSource, [f32; 3]) {
        match self.source {
            // After a gap the prediction is too old to check the reading against.
            RateSource::Missing { .. } => (RateSource::Measured, reading),
            RateSource::Measured | RateSource::Suspect { .. }
                if !differ(reading, predicted, config.jump) =>
            {
                (RateSource::Measured, reading)
            }
            RateSource::Measured => {
                let jump = largest(minus(reading, predicted));
                (RateSource::Suspect { since: now, jump, peak_force: lateral_force }, predicted)
            }
            RateSource::Suspect { since, jump, peak_force }
                if now.since(since) < config.suspect_for =>
            {
                let peak_force = peak_force.max(lateral_force);
                (RateSource::Suspect { since, jump, peak_force }, predicted)
            }
            // An impact is over by now. A lateral force that lasts means that the accelerometer
            // failed together with the gyroscope.
            RateSource::Suspect { jump, peak_force, .. }
                if peak_force > config.impact_per_jump * jump
                    && lateral_force < 0.5 * peak_force =>
            {
                (RateSource::Measured, reading)
            }
            RateSource::Suspect { since, .. } => {
                (RateSource::Offset { since, offset: minus(reading, predicted) }, predicted)
            }
            RateSource::Offset { since, offset } => {
                let rates = minus(reading, offset);
                if lateral_force > config.hit_force || !differ(rates, predicted, config.jump) {
                    return (RateSource::Offset { since, offset }, rates);
                }
                let offset = minus(reading, predicted);
                if differ(offset, [0.0; 3], config.least_offset) {
                    (RateSource::Offset { since, offset }, predicted)
                } else {
                    (RateSource::Measured, reading)
                }
            }
        }
    }

    /// The body rates in use, rad/s.
    pub(crate) const fn rates(&self) -> [f32; 3] {
        self.rates
    }

    /// The source of the rates in use.
    #[cfg(feature = "replay")]
    pub(crate) const fn source(&self) -> RateSource {
        self.source
    }

    /// Whether the rates in use are predicted.
    pub(crate) const fn is_predicted(&self) -> bool {
        matches!(self.source, RateSource::Missing { .. } | RateSource::Suspect { .. })
    }

    /// For how long the rates have not been plain readings.
    pub(crate) fn unsound_for(&self, now: Instant) -> Duration {
        match self.source {
            RateSource::Measured => Duration::ZERO,
            RateSource::Suspect { since, .. }
            | RateSource::Offset { since, .. }
            | RateSource::Missing { since } => now.since(since),
        }
    }
}

fn minus(one: [f32; 3], other: [f32; 3]) -> [f32; 3] {
    let mut difference = one;
    for (value, other) in difference.iter_mut().zip(other) {
        *value -= other;
    }
    difference
}

fn differ(one: [f32; 3], other: [f32; 3], by: f32) -> bool {
    largest(minus(one, other)) > by
}

/// The largest of the three, without its sign.
fn largest(of: [f32; 3]) -> f32 {
    of.iter().fold(0.0, |most: f32, part| most.max(part.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airframe::Airframe;

    const CONFIG: GyroConfig = GyroConfig::DEFAULT;
    const INERTIA: [f32; 3] = Airframe::CRAZYFLIE_2_1.inertia;

    struct Bench {
        gyro: Gyro,
        ms: u64,
    }

    impl Bench {
        /// A drone that has hovered for 20 ms.
        fn hovering() -> Self {
            let mut bench = Self { gyro: Gyro::new(), ms: 0 };
            for _ in 0..20 {
                bench.read([0.0; 3], 0.0);
            }
            bench
        }

        fn step(&mut self, reading: Option<[f32; 3]>, lateral_force: f32, torque: [f32; 3]) {
            self.ms += 1;
            let now = Instant::from_millis(self.ms);
            self.gyro.step(&CONFIG, now, reading, lateral_force, torque, INERTIA, 1e-3);
        }

        /// Steps with a reading of these rates plus noise.
        fn read(&mut self, rates: [f32; 3], lateral_force: f32) {
            let noise = 1e-3 * libm::sinf(self.ms as f32);
            self.step(Some(rates.map(|rate| rate + noise)), lateral_force, [0.0; 3]);
        }

        fn unsound(&self) -> u64 {
            self.gyro.unsound_for(Instant::from_millis(self.ms)).as_micros() / 1_000
        }

        fn is_near(&self, rates: [f32; 3]) -> bool {
            !differ(self.gyro.rates(), rates, 0.02)
        }
    }

    #[test]
    fn a_gap_is_bridged_by_the_prediction_from_the_motors() {
        let mut bench = Bench::hovering();
        let torque = 1e-4;
        for _ in 0..200 {
            bench.step(None, 0.0, [torque, 0.0, 0.0]);
        }
        // τ/J · (t − lag): the motors' lag delays the acceleration.
        let expected = torque / INERTIA[0] * (0.2 - CONFIG.motor_lag);
        let [roll, pitch, yaw] = bench.gyro.rates();
        assert!((roll / expected - 1.0).abs() < 0.05, "{roll} {expected}");
        assert!(pitch.abs() < 0.02 && yaw.abs() < 0.02);
        assert!(bench.gyro.is_predicted() && bench.unsound() == 199);
        bench.read([0.7, 0.0, 0.0], 0.0);
        assert!(bench.is_near([0.7, 0.0, 0.0]) && bench.unsound() == 0);
    }

    #[test]
    fn a_frozen_gyroscope_counts_as_missing() {
        let mut bench = Bench::hovering();
        for _ in 0..10 {
            bench.step(Some([0.3, 0.0, 0.0]), 0.0, [0.0; 3]);
        }
        assert!(bench.gyro.is_predicted());
    }

    #[test]
    fn a_sudden_offset_is_corrected_and_stays_unsound_until_it_goes() {
        for axis in 0..3 {
            for offset in [1.0, -1.0, 5.0] {
                let mut bench = Bench::hovering();
                let mut wrong = [0.0; 3];
                wrong[axis] = offset;
                for _ in 0..150 {
                    bench.read(wrong, 0.0);
                }
                assert!(bench.is_near([0.0; 3]), "{:?}", bench.gyro);
                assert!(bench.unsound() > 100);
                for _ in 0..10 {
                    bench.read([0.0; 3], 0.0);
                }
                assert!(bench.is_near([0.0; 3]) && bench.unsound() == 0, "{:?}", bench.gyro);
            }
        }
    }

    #[test]
    fn an_impact_that_the_accelerometer_measures_is_accepted() {
        for late in 0..4 {
            let mut bench = Bench::hovering();
            for ms in 0..50 {
                bench.read([2.0, -1.0, 0.0], if ms == late { 4.0 } else { 0.0 });
            }
            assert!(bench.is_near([2.0, -1.0, 0.0]), "{late} {:?}", bench.gyro);
            assert_eq!(bench.unsound(), 0);
        }
    }

    /// Recorded flights read 0.7 m/s² for a moment every second or so.
    #[test]
    fn the_shaking_of_a_real_flight_is_no_impact_that_explains_a_sudden_offset() {
        for late in 0..20 {
            let mut bench = Bench::hovering();
            for ms in 0..150 {
                bench.read([0.0, 1.0, 0.0], if ms % 20 == late { 0.7 } else { 0.17 });
            }
            assert!(bench.is_near([0.0; 3]), "{late} {:?}", bench.gyro);
        }
    }

    #[test]
    fn the_fastest_turn_that_the_motors_can_make_is_accepted() {
        let mut bench = Bench::hovering();
        // The motors of one side at 0.12 N and the others off, then the reverse: 4 · 0.06 N ·
        // 0.0325 m.
        let most = 4.0 * 0.06 * Airframe::CRAZYFLIE_2_1.arm;
        let (mut rate, mut given) = (0.0, 0.0);
        for ms in 0..400 {
            let asked = if (ms / 50) % 2 == 0 { most } else { -most };
            given += 1e-3 / CONFIG.motor_lag * (asked - given);
            rate += 1e-3 * given / INERTIA[0];
            bench.step(Some([rate, 0.0, 1e-3 * ms as f32]), 0.0, [asked, 0.0, 0.0]);
            assert_eq!(bench.unsound(), 0, "after {ms} ms");
        }
    }
}
