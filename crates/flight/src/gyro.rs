//! The gyroscope, and what stands in for it: without body rates a multicopter falls within a
//! second, so this reading is checked against physics and bridged by it.
//!
//! From the torques that the motors give, the body's rates can be told ahead for a short time. Of
//! these torques only what exceeds their mean of late turns the body: the mean is what it takes to
//! hold a crooked airframe, unlike motors and a battery that is not in the middle.
//! That prediction bridges samples that are missing or frozen, and it unmasks a gyroscope that
//! lies: rates do not jump by more than [`GyroConfig::jump`] within a millisecond unless something
//! hits the drone, and then the accelerometer feels it too.

use units::{Duration, Instant};

use crate::watch::Watch;

/// What is believed of a gyroscope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroConfig {
    /// More than this between prediction and reading is a jump, rad/s.
    pub jump: f32,
    /// The sideways specific force of a blow, m/s²: what it takes to jump by that much.
    pub blow: f32,
    /// How long after the jump a blow may be felt, and must then have passed: the accelerometer's
    /// filter is the slower one.
    pub doubt: Duration,
    /// An offset smaller than this is none, rad/s.
    pub least_offset: f32,
    /// After so many samples that are equal to the last bit, it is frozen.
    pub most_repeats: u16,
    /// First-order lag between a motor's command and its torque, s.
    pub motor_lag: f32,
    /// Over this time the mean torque is what the airframe takes to stand still, s.
    pub trim_time: f32,
}

impl GyroConfig {
    /// The strongest torque of a Crazyflie, all motors between none and 0.12 N, turns it up by
    /// 0.5 rad/s in a millisecond on one axis; in flight it is a tenth of that. A push at 5 cm
    /// from the middle that turns it by 0.5 rad/s changes its velocity by 5 mm/s, in a millisecond
    /// 5 m/s²; the accelerometer's 145 Hz filter leaves half. Motor lag: 65 ms, the
    /// thrust's pole in Förster's identification of the Crazyflie (2015).
    pub const DEFAULT: Self = Self {
        jump: 0.5,
        blow: 2.5,
        doubt: Duration::from_millis(8),
        least_offset: 0.15,
        most_repeats: 4,
        motor_lag: 0.065,
        trim_time: 0.5,
    };
}

/// How the rates in use came about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Belief {
    /// Read.
    Sound,
    /// Read something impossible: predicted until that is cleared up.
    Doubted {
        since: Instant,
        /// The hardest sideways push since.
        hit: f32,
    },
    /// Read, less an offset that appeared from one sample to the next.
    Offset { since: Instant, offset: [f32; 3] },
    /// Predicted: there is no reading.
    Missing { since: Instant },
}

/// Body rates, however they are known.
#[derive(Clone, Debug)]
pub(crate) struct Gyro {
    watch: Watch<[f32; 3]>,
    belief: Belief,
    rates: [f32; 3],
    /// Torque that the motors give by now, N m.
    torque: [f32; 3],
    /// The part of it that holds the airframe still.
    trim: [f32; 3],
}

impl Gyro {
    pub(crate) const fn new() -> Self {
        Self {
            watch: Watch::new(),
            belief: Belief::Missing { since: Instant::ZERO },
            rates: [0.0; 3],
            torque: [0.0; 3],
            trim: [0.0; 3],
        }
    }

    /// Forgets what the motors did: they stand.
    pub(crate) fn rest(&mut self) {
        self.torque = [0.0; 3];
        self.trim = [0.0; 3];
    }

    /// One step of `dt` seconds. `reading` has its bias taken off, `sideways` is the horizontal
    /// specific force, `torque` what the motors were last told to give.
    #[expect(clippy::too_many_arguments, reason = "all that a sample is weighed against")]
    pub(crate) fn step(
        &mut self,
        config: &GyroConfig,
        now: Instant,
        reading: Option<[f32; 3]>,
        sideways: f32,
        torque: [f32; 3],
        inertia: [f32; 3],
        dt: f32,
    ) {
        let predicted = self.predict(config, torque, inertia, dt);
        let reading = self.watch.pass(now, reading, config.most_repeats);
        let reading = reading.filter(|rates| rates.iter().all(|rate| rate.is_finite()));
        (self.belief, self.rates) = match reading {
            None => (self.missing(now), predicted),
            Some(reading) => self.weigh(config, now, reading, predicted, sideways),
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
        let learnt = if self.belief == Belief::Sound { dt / config.trim_time } else { 0.0 };
        let mut rates = self.rates;
        let torques = self.torque.iter_mut().zip(&mut self.trim).zip(torque).zip(inertia);
        for (rate, (((given, trim), asked), inertia)) in rates.iter_mut().zip(torques) {
            *given += part * (asked - *given);
            *trim += learnt.min(1.0) * (*given - *trim);
            *rate += (*given - *trim) / inertia * dt;
        }
        rates
    }

    fn missing(&self, now: Instant) -> Belief {
        match self.belief {
            missing @ Belief::Missing { .. } => missing,
            Belief::Doubted { since, .. } => Belief::Missing { since },
            Belief::Sound | Belief::Offset { .. } => Belief::Missing { since: now },
        }
    }

    fn weigh(
        &self,
        config: &GyroConfig,
        now: Instant,
        reading: [f32; 3],
        predicted: [f32; 3],
        sideways: f32,
    ) -> (Belief, [f32; 3]) {
        match self.belief {
            // After a gap anything may be true.
            Belief::Missing { .. } => (Belief::Sound, reading),
            Belief::Sound | Belief::Doubted { .. } if !differ(reading, predicted, config.jump) => {
                (Belief::Sound, reading)
            }
            Belief::Sound => (Belief::Doubted { since: now, hit: sideways }, predicted),
            Belief::Doubted { since, hit } if now.since(since) < config.doubt => {
                (Belief::Doubted { since, hit: hit.max(sideways) }, predicted)
            }
            // A blow is over by now; an accelerometer that went wrong with the gyroscope is not.
            Belief::Doubted { hit, .. } if hit > config.blow && sideways < 0.5 * hit => {
                (Belief::Sound, reading)
            }
            Belief::Doubted { since, .. } => {
                (Belief::Offset { since, offset: minus(reading, predicted) }, predicted)
            }
            Belief::Offset { since, offset } => {
                let rates = minus(reading, offset);
                if sideways > config.blow || !differ(rates, predicted, config.jump) {
                    return (Belief::Offset { since, offset }, rates);
                }
                let offset = minus(reading, predicted);
                if differ(offset, [0.0; 3], config.least_offset) {
                    (Belief::Offset { since, offset }, predicted)
                } else {
                    (Belief::Sound, reading)
                }
            }
        }
    }

    /// rad/s.
    pub(crate) const fn rates(&self) -> [f32; 3] {
        self.rates
    }

    /// Whether they are only predicted.
    pub(crate) const fn is_blind(&self) -> bool {
        matches!(self.belief, Belief::Missing { .. } | Belief::Doubted { .. })
    }

    /// For how long they have been anything but sound.
    pub(crate) fn unsound_for(&self, now: Instant) -> Duration {
        match self.belief {
            Belief::Sound => Duration::ZERO,
            Belief::Doubted { since, .. }
            | Belief::Offset { since, .. }
            | Belief::Missing { since } => now.since(since),
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
    minus(one, other).iter().any(|difference| difference.abs() > by)
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
        /// A drone that has hovered for a moment.
        fn hovering() -> Self {
            let mut bench = Self { gyro: Gyro::new(), ms: 0 };
            for _ in 0..20 {
                bench.read([0.0; 3], 0.0);
            }
            bench
        }

        fn step(&mut self, reading: Option<[f32; 3]>, sideways: f32, torque: [f32; 3]) {
            self.ms += 1;
            let now = Instant::from_millis(self.ms);
            self.gyro.step(&CONFIG, now, reading, sideways, torque, INERTIA, 1e-3);
        }

        /// A reading with noise on it.
        fn read(&mut self, rates: [f32; 3], sideways: f32) {
            let noise = 1e-3 * libm::sinf(self.ms as f32);
            self.step(Some(rates.map(|rate| rate + noise)), sideways, [0.0; 3]);
        }

        fn unsound(&self) -> u64 {
            self.gyro.unsound_for(Instant::from_millis(self.ms)).as_micros() / 1_000
        }

        fn is_near(&self, rates: [f32; 3]) -> bool {
            !differ(self.gyro.rates(), rates, 0.02)
        }
    }

    #[test]
    fn a_gap_is_bridged_by_what_the_motors_do() {
        let mut bench = Bench::hovering();
        let torque = 1e-4;
        for _ in 0..200 {
            bench.step(None, 0.0, [torque, 0.0, 0.0]);
        }
        // α t less what the motors' lag keeps back: τ/J · (t − lag).
        let expected = torque / INERTIA[0] * (0.2 - CONFIG.motor_lag);
        let [roll, pitch, yaw] = bench.gyro.rates();
        assert!((roll / expected - 1.0).abs() < 0.05, "{roll} {expected}");
        assert!(pitch.abs() < 0.02 && yaw.abs() < 0.02);
        assert!(bench.gyro.is_blind() && bench.unsound() == 199);
        bench.read([0.7, 0.0, 0.0], 0.0);
        assert!(bench.is_near([0.7, 0.0, 0.0]) && bench.unsound() == 0);
    }

    #[test]
    fn a_frozen_gyroscope_is_a_missing_one() {
        let mut bench = Bench::hovering();
        for _ in 0..10 {
            bench.step(Some([0.3, 0.0, 0.0]), 0.0, [0.0; 3]);
        }
        assert!(bench.gyro.is_blind());
    }

    #[test]
    fn an_offset_out_of_nowhere_is_taken_off_and_stays_unsound_until_it_goes() {
        for axis in 0..3 {
            for offset in [1.0, -1.0, 5.0] {
                let mut bench = Bench::hovering();
                let mut lie = [0.0; 3];
                lie[axis] = offset;
                for _ in 0..150 {
                    bench.read(lie, 0.0);
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
    fn a_blow_that_the_accelerometer_feels_is_believed() {
        for late in 0..4 {
            let mut bench = Bench::hovering();
            for ms in 0..50 {
                bench.read([2.0, -1.0, 0.0], if ms == late { 4.0 } else { 0.0 });
            }
            assert!(bench.is_near([2.0, -1.0, 0.0]), "{late} {:?}", bench.gyro);
            assert_eq!(bench.unsound(), 0);
        }
    }

    #[test]
    fn the_wildest_turn_that_its_motors_can_do_is_believed() {
        let mut bench = Bench::hovering();
        // All thrust on one side, then on the other: 4 · 0.06 N · 0.0325 m.
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
