//! Checks that the estimate is as good as its covariance says, in a world whose errors are those of
//! the configuration.

use flight::{EstimatorConfig, Nis, Verdict};

use super::world::{AccelInput, DT, Path, Rng, SensorErrors, SimulatedFlight};

fn wandering(seed: u64) -> SimulatedFlight {
    let mut rng = Rng(seed);
    let path = Path::wandering(&mut rng);
    let errors = SensorErrors::drawn(&EstimatorConfig::DEFAULT, &mut rng);
    SimulatedFlight::new(path, errors, rng)
}

/// Root mean square of the values that were added.
#[derive(Default)]
struct Rms(f64, u32);

impl Rms {
    fn add(&mut self, value: f64) {
        self.0 += value * value;
        self.1 += 1;
    }

    fn add_all(&mut self, values: [f64; 2]) {
        values.into_iter().for_each(|value| self.add(value));
    }

    fn get(&self) -> f64 {
        (self.0 / f64::from(self.1)).sqrt()
    }
}

#[test]
fn errors_are_small_and_as_large_as_predicted() {
    let [mut velocity, mut height, mut climb, mut tilt] = [(); 4].map(|()| Rms::default());
    let [mut velocity_sd, mut height_sd, mut tilt_sd] = [(); 3].map(|()| Rms::default());
    for seed in 0..20 {
        let mut drone = wandering(seed);
        drone.fly(4.0);
        for _ in 0..40 {
            drone.fly(0.1);
            velocity.add_all(drone.velocity_error());
            height.add(drone.height_error());
            climb.add(drone.climb_error());
            tilt.add(drone.tilt_error());
            velocity_sd.add(drone.estimator.velocity_sd().into());
            height_sd.add(drone.estimator.height_sd().into());
            tilt_sd.add(drone.estimator.tilt_sd().into());
        }
        assert!(drone.estimator.is_sound());
    }
    assert!(velocity.get() < 0.022, "{} m/s", velocity.get());
    assert!(height.get() < 0.002, "{} m", height.get());
    assert!(climb.get() < 0.016, "{} m/s", climb.get());
    // The error is over two axes.
    assert!(tilt.get() < 0.006, "{} rad", tilt.get());
    for (is, said) in [(velocity, velocity_sd), (height, height_sd)] {
        let ratio = is.get() / said.get();
        assert!((0.85..1.25).contains(&ratio), "{} but predicts {}", is.get(), said.get());
    }
    assert!(tilt.get() < 2.5 * tilt_sd.get(), "{} but predicts {}", tilt.get(), tilt_sd.get());
}

/// Bar-Shalom's test. At each time, the sum of the NIS over many flights follows a χ² distribution
/// with as many degrees of freedom as there were numbers. At least nine in ten times must lie
/// within the bounds of 95 %, and the mean over all times must be near one per degree.
#[test]
fn the_innovations_are_as_large_as_predicted() {
    const FLIGHTS: u64 = 60;
    let mut drones: Vec<_> = (0..FLIGHTS).map(|seed| wandering(1_000 + seed)).collect();
    for drone in &mut drones {
        drone.fly(3.0);
    }
    let mut flow = Sums::default();
    let mut down = Sums::default();
    for _ in 0..100 {
        let verdicts: Vec<_> = drones
            .iter_mut()
            .map(|drone| {
                drone.fly(0.05 - DT);
                drone.step()
            })
            .collect();
        flow.close(verdicts.iter().filter_map(|both| both.flow));
        down.close(verdicts.iter().filter_map(|both| both.down));
    }
    flow.check("flow");
    down.check("down");
}

#[derive(Default)]
struct Sums {
    times: u32,
    outside: u32,
    sum: f64,
    degrees: f64,
}

impl Sums {
    fn close(&mut self, verdicts: impl Iterator<Item = Verdict>) {
        let (mut sum, mut degrees) = (0.0, 0.0);
        for verdict in verdicts {
            let Verdict::Used(Nis { value, degrees: of }) = verdict else {
                panic!("{verdict:?}");
            };
            sum += f64::from(value);
            degrees += f64::from(of);
        }
        // χ² of so many degrees of freedom is nearly normal.
        let bound = 1.96 * (2.0 * degrees).sqrt();
        self.times += 1;
        self.outside += u32::from((sum - degrees).abs() > bound);
        self.sum += sum;
        self.degrees += degrees;
    }

    fn check(&self, of: &str) {
        let mean = self.sum / self.degrees;
        assert!((0.93..1.08).contains(&mean), "{of}: NIS {mean}");
        assert!(10 * self.outside <= self.times, "{of}: {} of {}", self.outside, self.times);
    }
}

/// Flies two drones that are alike but for a disturbance of one: their difference shows the
/// filter's response without any noise.
#[test]
fn the_configured_time_constants_are_those_of_the_filter() {
    let inertial = EstimatorConfig::DEFAULT.inertial;
    // Time until the difference has fallen to 1/e, s.
    let until = |disturb: fn(&mut SimulatedFlight),
                 difference: fn(&SimulatedFlight, &SimulatedFlight) -> f64| {
        let config = EstimatorConfig::DEFAULT;
        let mut rng = Rng(7);
        let errors = SensorErrors::drawn(&config, &mut rng);
        let mut one = SimulatedFlight::new(Path::HOVER, errors, rng);
        one.fly(8.0);
        let mut other = one.clone();
        disturb(&mut other);
        let first = difference(&one, &other);
        let mut time = 0.0;
        while difference(&one, &other) > first / std::f64::consts::E {
            one.fly(0.01);
            other.fly(0.01);
            time += 0.01;
            assert!(time < 10.0);
        }
        time as f32
    };
    let tilt = until(
        |drone| drone.estimator.predict(&drone.config, 1e-3, [0.0, 5.0, 0.0], [0.0, 0.0, 9.8]),
        |one, other| (one.estimator.up()[0] - other.estimator.up()[0]).abs().into(),
    );
    let velocity = until(
        |drone| drone.estimator.predict(&drone.config, 1e-3, [0.0; 3], [30.0, 0.0, 9.8]),
        |one, other| (one.estimator.velocity()[0] - other.estimator.velocity()[0]).abs().into(),
    );
    let climb = until(
        |drone| drone.estimator.predict(&drone.config, 1e-3, [0.0; 3], [0.0, 0.0, 30.0]),
        |one, other| (one.estimator.climb() - other.estimator.climb()).abs().into(),
    );
    for (is, said) in [
        (tilt, inertial.tilt_time_constant),
        (velocity, inertial.velocity_time_constant),
        (climb, inertial.climb_time_constant),
    ] {
        assert!((0.8..1.25).contains(&(is / said)), "{is} s, not {said} s");
    }
}

/// Shows why the force along x and y is best given as zero.
#[test]
fn drag_by_formula_beats_an_accelerometer_with_an_offset() {
    let fly = |force: AccelInput| {
        let mut velocity = Rms::default();
        for seed in 0..8 {
            let mut drone = wandering(seed);
            drone.force = force;
            if force == AccelInput::Full {
                drone.config.inertial.drag = 0.0;
            }
            drone.fly(4.0);
            for _ in 0..40 {
                drone.fly(0.1);
                velocity.add_all(drone.velocity_error());
            }
        }
        velocity.get()
    };
    let (by_formula, measured) = (fly(AccelInput::AlongZ), fly(AccelInput::Full));
    assert!(2.0 * by_formula < measured, "{by_formula} and {measured} m/s");
}

#[test]
fn the_length_of_the_steps_does_not_matter() {
    let mut velocity = Rms::default();
    let mut height = Rms::default();
    for seed in 0..10 {
        let mut drone = wandering(seed);
        let mut jitter = Rng(100 + seed);
        let (mut flow_at, mut down_at) = (0.0, 0.0);
        while drone.t < 8.0 {
            drone.advance(0.2e-3 + 4.8e-3 * jitter.uniform());
            if drone.t >= flow_at {
                let motion = drone.read_flow();
                drone.estimator.flow(&drone.config, &motion);
                flow_at = drone.t + 0.01;
            }
            if drone.t >= down_at {
                let reading = drone.read_range();
                drone.estimator.down(&drone.config, &reading);
                down_at = drone.t + 0.025;
            }
            if drone.t > 4.0 {
                velocity.add_all(drone.velocity_error());
                height.add(drone.height_error());
            }
        }
    }
    assert!(velocity.get() < 0.025, "{} m/s", velocity.get());
    assert!(height.get() < 0.003, "{} m", height.get());
}
