//! Checks the hand-written algebra: the Jacobians against numeric differences, the block-wise
//! covariance against dense matrices in double precision.

use nalgebra::{SMatrix, SVector};
use sensors::pmw3901::Motion;
use sensors::vl53l1x::{CountRate, RangeStatus, Reading};
use units::Metres;

use super::covariance::{Covariance, ErrorState, MeasurementRow, ProcessNoise};
use super::flow::FlowIntegral;
use super::*;

type Matrix = SMatrix<f64, 9, 9>;
type Column = SVector<f64, 9>;

const CONFIG: EstimatorConfig = EstimatorConfig {
    inertial: InertialConfig { drag: 0.0, ..InertialConfig::BMI088 },
    ..EstimatorConfig::DEFAULT
};
const GYRO: Vector = [0.7, -0.4, 1.1];
const ACCEL: Vector = [0.3, -0.2, 10.4];

/// A drone in the air that moves, leans and is yawed.
fn flying() -> Estimator {
    let mut drone = Estimator::new();
    drone.settle(&CONFIG, [0.0, 0.0, GRAVITY]);
    drone.position = [1.0, -2.0, 0.4];
    drone.velocity = [0.6, -0.3, 0.2];
    drone.turn_to(Quaternion::from_rotation_vector([0.2, -0.15, 0.8]));
    drone
}

/// The same drone with these errors added to its state.
fn off(drone: &Estimator, errors: &ErrorState) -> Estimator {
    let mut off = *drone;
    off.correct(errors);
    off
}

fn errors(values: &[f32; 9]) -> ErrorState {
    let [px, py, pz, vx, vy, vz, tx, ty, tz] = *values;
    ErrorState { position: [px, py, pz], velocity: [vx, vy, vz], turn: [tx, ty, tz] }
}

/// The errors that lead from the first state to the second.
fn between(from: &Estimator, to: &Estimator) -> Column {
    let Quaternion { w, x, y, z } = from.quaternion;
    let turn = to.quaternion.times(Quaternion { w, x: -x, y: -y, z: -z });
    let turn = scaled([turn.x, turn.y, turn.z], 2.0 * turn.w.signum());
    let undone = Quaternion::from_rotation_vector(scaled(turn, -1.0)).normalised().rotation();
    let velocity = undone.to_world(to.velocity);
    let parts = [minus(to.position, from.position), minus(velocity, from.velocity), turn];
    Column::from_iterator(parts.into_iter().flatten().map(f64::from))
}

fn minus(one: Vector, other: Vector) -> Vector {
    add(one, scaled(other, -1.0))
}

/// The matrix F as the documentation of `covariance` defines it.
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

/// Numeric Jacobian from single-precision states: the step is small enough for the second order and
/// large enough for the rounding.
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

/// A covariance in which all errors are correlated.
fn mixed() -> Covariance {
    let mut p = Covariance::diagonal([0.5, 0.4, 0.01], [0.04, 0.05, 0.03], [0.002, 0.003, 0.1]);
    let process_noise = ProcessNoise { velocity: 1e-4, climb: 2e-4, tilt: 1e-5, yaw: 2e-5 };
    for i in 0..20 {
        let displacement = [0.5, 0.1 * i as f32, -0.4];
        p.propagate(displacement, GRAVITY, 0.01, &process_noise);
        let row =
            MeasurementRow { height: 0.3, velocity: [1.0, -0.2, 0.1 * i as f32], tilt: [0.1, 0.4] };
        let p_ht = p.p_h_transpose(&row);
        p.update(&p_ht, row.times(&p_ht) + 0.5);
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
    let process_noise = ProcessNoise { velocity: 1e-4, climb: 2e-4, tilt: 1e-5, yaw: 2e-5 };
    let f = transition(velocity, GRAVITY, dt);
    let q = [0.0, 0.0, 0.0, 1e-4, 1e-4, 2e-4, 1e-5, 1e-5, 2e-5];
    let should = f * dense(&p) * f.transpose() + Matrix::from_diagonal(&Column::from(q));
    p.propagate(velocity, GRAVITY, dt, &process_noise);
    assert_near(&dense(&p), &should);
}

#[test]
fn an_update_agrees_with_josephs_form() {
    let mut p = mixed();
    let before = dense(&p);
    let row = MeasurementRow { height: 0.4, velocity: [0.3, 1.0, -0.2], tilt: [0.5, -0.1] };
    let h =
        Column::from([0.0, 0.0, 0.4, 0.3, 1.0, -0.2, 0.5, -0.1, 0.0].map(|x: f32| f64::from(x)));
    let noise = 0.02f32;
    let s = (h.transpose() * before * h)[(0, 0)] + f64::from(noise);
    let gain = before * h / s;
    let rest = Matrix::identity() - gain * h.transpose();
    let should = rest * before * rest.transpose() + gain * f64::from(noise) * gain.transpose();
    let p_ht = p.p_h_transpose(&row);
    let variance = row.times(&p_ht) + noise;
    assert!((f64::from(variance) - s).abs() < 1e-5 * s);
    p.update(&p_ht, variance);
    assert_near(&dense(&p), &should);
}

/// The integral of a drone that kept this state for `time` seconds.
fn integral_of(drone: &Estimator, time: f32) -> FlowIntegral {
    let mut flow_integral = FlowIntegral::ZERO;
    let distance = drone.height() / drone.tilt_cosine();
    flow_integral.add(drone.velocity(), distance, scaled(GYRO, time), time);
    flow_integral
}

fn dense_row(row: &MeasurementRow) -> Column {
    let MeasurementRow { height, velocity: [x, y, z], tilt: [tilt_x, tilt_y] } = *row;
    Column::from([0.0, 0.0, height, x, y, z, tilt_x, tilt_y, 0.0].map(|x: f32| f64::from(x)))
}

#[test]
fn the_flow_jacobian_is_the_derivative_of_the_flow_model() {
    let motion = Motion { squal: 80, shutter: 500, ..Motion::default() };
    let time = 0.01;
    let counts = |drone: &Estimator| {
        let flow_integral = integral_of(drone, time);
        flow::measurement(&CONFIG.flow, &motion, &flow_integral, drone.height(), &drone.rotation)
    };
    let analytic = counts(&flying()).row.map(|row| dense_row(&row));
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
fn the_range_jacobian_is_the_derivative_of_the_range_model() {
    let reading = Reading {
        distance: Metres(0.4),
        sigma: Metres(0.001),
        status: RangeStatus::Valid,
        signal: CountRate(1.0),
        ambient: CountRate(0.0),
        stream: 1,
    };
    let range = |drone: &Estimator| {
        down::measurement(&CONFIG.down, &reading, drone.height(), &drone.rotation)
    };
    let analytic = dense_row(&range(&flying()).row);
    let expected = |drone: &Estimator| {
        let mut column = Column::zeros();
        column[0] = -f64::from(range(drone).innovation);
        column
    };
    let numeric = numeric(expected).row(0).transpose();
    let difference = (numeric - analytic).abs().max();
    assert!(difference < 1e-3, "{numeric:.4} for {analytic:.4}");
}

/// Compares with the textbook's update by both counts at once, with S a 2 × 2 matrix.
#[test]
fn two_counts_update_as_one_measurement_of_two() {
    let mut drone = flying();
    drone.covariance = mixed();
    let motion = Motion { x: 9, y: -4, squal: 80, shutter: 500, ..Motion::default() };
    let flow_integral = integral_of(&drone, 0.01);
    let counts =
        flow::measurement(&CONFIG.flow, &motion, &flow_integral, drone.height(), &drone.rotation);
    let h = SMatrix::<f64, 2, 9>::from_rows(&counts.row.map(|s| dense_row(&s).transpose()));
    let p = dense(&drone.covariance);
    let r = SMatrix::<f64, 2, 2>::from_diagonal(&counts.variance.map(f64::from).into());
    let innovation = SVector::<f64, 2>::from(counts.innovation.map(f64::from));
    let s = (h * p * h.transpose() + r).try_inverse().unwrap();
    let nis = (innovation.transpose() * s * innovation)[(0, 0)];
    let gain = p * h.transpose() * s;

    let decorrelated = Decorrelated::new(&drone.covariance, &counts);
    assert!((f64::from(decorrelated.nis().value) - nis).abs() < 1e-3 * nis, "{nis}");
    let before = drone;
    drone.apply_flow(&decorrelated);
    let moved = between(&before, &drone);
    let should = gain * innovation;
    assert!((moved - should).abs().max() < 2e-3 * should.abs().max(), "{moved} for {should}");
    assert_near(&dense(&drone.covariance), &(p - gain * h * p));
}
