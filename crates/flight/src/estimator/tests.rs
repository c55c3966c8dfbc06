//! What is written by hand against what it stands for: the Jacobians against differences, the
//! block-wise covariance against dense matrices in double precision.

use nalgebra::{SMatrix, SVector};
use sensors::pmw3901::Motion;
use sensors::vl53l1x::{CountRate, RangeStatus, Reading};
use units::Metres;

use super::covariance::{Covariance, Errors, Growth, Sight};
use super::flow::Passed;
use super::*;

type Matrix = SMatrix<f64, 9, 9>;
type Column = SVector<f64, 9>;

const CONFIG: EstimatorConfig = EstimatorConfig {
    inertial: InertialConfig { drag: 0.0, ..InertialConfig::BMI088 },
    ..EstimatorConfig::DEFAULT
};
const GYRO: Vector = [0.7, -0.4, 1.1];
const ACCEL: Vector = [0.3, -0.2, 10.4];

/// Somewhere in the air, moving, leaning and turned.
fn flying() -> Estimator {
    let mut drone = Estimator::new();
    drone.settle(&CONFIG, [0.0, 0.0, GRAVITY]);
    drone.position = [1.0, -2.0, 0.4];
    drone.velocity = [0.6, -0.3, 0.2];
    drone.turn_to(Quaternion::from_turn([0.2, -0.15, 0.8]));
    drone
}

/// The same, off by these errors.
fn off(drone: &Estimator, errors: &Errors) -> Estimator {
    let mut off = *drone;
    off.mend(errors);
    off
}

fn errors(values: &[f32; 9]) -> Errors {
    let [px, py, pz, vx, vy, vz, tx, ty, tz] = *values;
    Errors { position: [px, py, pz], velocity: [vx, vy, vz], turn: [tx, ty, tz] }
}

/// By which errors the second is off from the first.
fn between(from: &Estimator, to: &Estimator) -> Column {
    let Quaternion { w, x, y, z } = from.quaternion;
    let turn = to.quaternion.times(Quaternion { w, x: -x, y: -y, z: -z });
    let turn = scaled([turn.x, turn.y, turn.z], 2.0 * turn.w.signum());
    let undone = Quaternion::from_turn(scaled(turn, -1.0)).normalised().rotation();
    let velocity = undone.to_world(to.velocity);
    let parts = [minus(to.position, from.position), minus(velocity, from.velocity), turn];
    Column::from_iterator(parts.into_iter().flatten().map(f64::from))
}

fn minus(one: Vector, other: Vector) -> Vector {
    add(one, scaled(other, -1.0))
}

/// F as the documentation of `covariance` has it.
fn transition(velocity: Vector, gravity: f32, dt: f32) -> Matrix {
    let [x, y, z] = velocity.map(|part| f64::from(part * dt));
    let lean = f64::from(gravity * dt);
    let mut f = Matrix::identity();
    for i in 0..3 {
        f[(i, 3 + i)] = f64::from(dt);
    }
    for (row, column, value) in
        [(0, 7, z), (0, 8, -y), (1, 6, -z), (1, 8, x), (2, 6, y), (2, 7, -x)]
    {
        f[(row, column)] = value;
    }
    f[(3, 7)] = lean;
    f[(4, 6)] = -lean;
    f
}

/// A difference of single-precision states: steps small enough for the second order and large
/// enough for the rounding.
fn numeric(of: impl Fn(&Estimator) -> Column) -> Matrix {
    let drone = flying();
    let step = 4e-3;
    let mut jacobian = Matrix::zeros();
    for i in 0..9 {
        let mut values = [0.0; 9];
        values[i] = step;
        let ahead = of(&off(&drone, &errors(&values)));
        values[i] = -step;
        let behind = of(&off(&drone, &errors(&values)));
        jacobian.set_column(i, &((ahead - behind) / f64::from(2.0 * step)));
    }
    jacobian
}

#[test]
fn the_transition_is_the_derivative_of_the_prediction() {
    let dt = LONGEST_STEP;
    let predicted = |drone: &Estimator| {
        let mut drone = *drone;
        drone.predict(&CONFIG, dt, GYRO, ACCEL);
        drone
    };
    let nominal = predicted(&flying());
    let numeric = numeric(|drone| between(&nominal, &predicted(drone)));
    let analytic = transition(flying().velocity, flying().gravity, dt);
    let difference = (numeric - analytic).abs().max();
    assert!(difference < 5e-4, "{difference}: {numeric:.4} for {analytic:.4}");
}

/// A covariance with every correlation in it, as it comes about.
fn mixed() -> Covariance {
    let mut p = Covariance::diagonal([0.5, 0.4, 0.01], [0.04, 0.05, 0.03], [0.002, 0.003, 0.1]);
    let growth = Growth { velocity: 1e-4, climb: 2e-4, tilt: 1e-5, yaw: 2e-5 };
    for i in 0..20 {
        let way = [0.5, 0.1 * i as f32, -0.4];
        p.propagate(way, GRAVITY, 0.01, &growth);
        let sight = Sight { height: 0.3, velocity: [1.0, -0.2, 0.1 * i as f32], tilt: [0.1, 0.4] };
        let seen = p.seen_by(&sight);
        p.know(&seen, sight.of(&seen) + 0.5);
    }
    p
}

fn dense(p: &Covariance) -> Matrix {
    let rows = p.dense();
    Matrix::from_fn(|i, j| f64::from(rows[i][j]))
}

fn assert_near(is: &Matrix, should: &Matrix) {
    for i in 0..9 {
        for j in 0..9 {
            let scale = (should[(i, i)] * should[(j, j)]).sqrt();
            let off = (is[(i, j)] - should[(i, j)]).abs();
            assert!(off < 1e-5 * scale, "{i},{j}: {} for {}", is[(i, j)], should[(i, j)]);
        }
    }
}

#[test]
fn the_propagation_is_f_p_ft_plus_q() {
    let mut p = mixed();
    let (velocity, dt) = ([0.7, -0.4, 0.3], 0.005);
    let growth = Growth { velocity: 1e-4, climb: 2e-4, tilt: 1e-5, yaw: 2e-5 };
    let f = transition(velocity, GRAVITY, dt);
    let q = [0.0, 0.0, 0.0, 1e-4, 1e-4, 2e-4, 1e-5, 1e-5, 2e-5];
    let should = f * dense(&p) * f.transpose() + Matrix::from_diagonal(&Column::from(q));
    p.propagate(velocity, GRAVITY, dt, &growth);
    assert_near(&dense(&p), &should);
}

#[test]
fn a_measurement_does_what_josephs_form_does() {
    let mut p = mixed();
    let before = dense(&p);
    let sight = Sight { height: 0.4, velocity: [0.3, 1.0, -0.2], tilt: [0.5, -0.1] };
    let h =
        Column::from([0.0, 0.0, 0.4, 0.3, 1.0, -0.2, 0.5, -0.1, 0.0].map(|x: f32| f64::from(x)));
    let noise = 0.02f32;
    let s = (h.transpose() * before * h)[(0, 0)] + f64::from(noise);
    let gain = before * h / s;
    let rest = Matrix::identity() - gain * h.transpose();
    let should = rest * before * rest.transpose() + gain * f64::from(noise) * gain.transpose();
    let seen = p.seen_by(&sight);
    let variance = sight.of(&seen) + noise;
    assert!((f64::from(variance) - s).abs() < 1e-5 * s);
    p.know(&seen, variance);
    assert_near(&dense(&p), &should);
}

/// What passed under a drone that kept this state for `time`.
fn passed(drone: &Estimator, time: f32) -> Passed {
    let mut passed = Passed::NOTHING;
    let distance = drone.height() / drone.tilt_cosine();
    passed.pass(drone.velocity(), distance, scaled(GYRO, time), time);
    passed
}

fn row(sight: &Sight) -> Column {
    let Sight { height, velocity: [x, y, z], tilt: [tilt_x, tilt_y] } = *sight;
    Column::from([0.0, 0.0, height, x, y, z, tilt_x, tilt_y, 0.0].map(|x: f32| f64::from(x)))
}

#[test]
fn what_is_expected_of_the_flow_changes_as_its_jacobian_says() {
    let motion = Motion { squal: 80, shutter: 500, ..Motion::default() };
    let time = 0.01;
    let counts = |drone: &Estimator| {
        let passed = passed(drone, time);
        flow::counts(&CONFIG.flow, &motion, &passed, drone.height(), &drone.rotation)
    };
    let analytic = counts(&flying()).sight.map(|sight| row(&sight));
    for (axis, analytic) in analytic.into_iter().enumerate() {
        // The innovation falls as the expectation rises.
        let expected = |drone: &Estimator| {
            let mut column = Column::zeros();
            column[0] = -f64::from(counts(drone).innovation[axis]);
            column
        };
        let numeric = numeric(expected).row(0).transpose();
        let difference = (numeric - analytic).abs().max();
        assert!(difference < 5e-3 * analytic.abs().max(), "{numeric:.3} for {analytic:.3}");
    }
}

#[test]
fn what_is_expected_of_the_ranger_changes_as_its_jacobian_says() {
    let reading = Reading {
        distance: Metres(0.4),
        sigma: Metres(0.001),
        status: RangeStatus::Valid,
        signal: CountRate(1.0),
        ambient: CountRate(0.0),
        stream: 1,
    };
    let range =
        |drone: &Estimator| down::range(&CONFIG.down, &reading, drone.height(), &drone.rotation);
    let analytic = row(&range(&flying()).sight);
    let expected = |drone: &Estimator| {
        let mut column = Column::zeros();
        column[0] = -f64::from(range(drone).innovation);
        column
    };
    let numeric = numeric(expected).row(0).transpose();
    let difference = (numeric - analytic).abs().max();
    assert!(difference < 1e-3, "{numeric:.4} for {analytic:.4}");
}

/// Both counts at once in the textbook's way: S is two by two.
#[test]
fn two_counts_are_weighed_as_one_measurement_of_two() {
    let mut drone = flying();
    drone.covariance = mixed();
    let motion = Motion { x: 9, y: -4, squal: 80, shutter: 500, ..Motion::default() };
    let passed = passed(&drone, 0.01);
    let counts = flow::counts(&CONFIG.flow, &motion, &passed, drone.height(), &drone.rotation);
    let h = SMatrix::<f64, 2, 9>::from_rows(&counts.sight.map(|s| row(&s).transpose()));
    let p = dense(&drone.covariance);
    let r = SMatrix::<f64, 2, 2>::from_diagonal(&counts.variance.map(f64::from).into());
    let innovation = SVector::<f64, 2>::from(counts.innovation.map(f64::from));
    let s = (h * p * h.transpose() + r).try_inverse().unwrap();
    let nis = (innovation.transpose() * s * innovation)[(0, 0)];
    let gain = p * h.transpose() * s;

    let weighed = Weighed::new(&drone.covariance, &counts);
    assert!((f64::from(weighed.nis().value) - nis).abs() < 1e-3 * nis, "{nis}");
    let before = drone;
    drone.take(&weighed);
    let moved = between(&before, &drone);
    let should = gain * innovation;
    assert!((moved - should).abs().max() < 2e-3 * should.abs().max(), "{moved} for {should}");
    assert_near(&dense(&drone.covariance), &(p - gain * h * p));
}
