//! By how much a battery's voltage falls with the thrust of the motors.

use super::course::Step;

/// Time constant of the thrust's mean, s: the voltage is smoothed by the radio chip that measures it,
/// and follows the current by about this time.
const FOLLOWS_WITHIN: f64 = 0.1;
/// Fewer moments say nothing.
const LEAST: usize = 1_000;
/// Thrust that varies less than this says nothing, N: its standard deviation.
const LEAST_SPREAD: f64 = 2e-3;

/// The slope of the voltage over the thrust in these moments, V/N, positive where it
/// falls: of the least squares of V = a + b t + c t² − s T, in which the first three stand for the
/// discharge. `None` where they are too few or too much alike.
pub(super) fn per_newton<'a>(steps: impl Iterator<Item = &'a Step>) -> Option<f32> {
    let mut smooth = None;
    let mut last = 0.0;
    let mut rows: Vec<([f64; 4], f64)> = Vec::new();
    for Step { time, thrust, volts, .. } in steps {
        let (Some(thrust), Some(volts)) = (thrust, volts) else { continue };
        let thrust = f64::from(*thrust);
        let part = ((time - last) / FOLLOWS_WITHIN).clamp(0.0, 1.0);
        last = *time;
        let mean = smooth.map_or(thrust, |mean: f64| mean + part * (thrust - mean));
        smooth = Some(mean);
        rows.push(([1.0, *time, time * time, mean], f64::from(*volts)));
    }
    let count = rows.len() as f64;
    let mean = rows.iter().map(|(row, _)| row[3]).sum::<f64>() / count;
    let variance = rows.iter().map(|(row, _)| (row[3] - mean).powi(2)).sum::<f64>() / count;
    let says = rows.len() >= LEAST && variance.sqrt() >= LEAST_SPREAD;
    says.then(|| least_squares(&rows)).flatten().map(|[_, _, _, slope]| -slope as f32)
}

/// The coefficients that reproduce the values best; `None` where the rows do not determine them.
fn least_squares<const N: usize>(rows: &[([f64; N], f64)]) -> Option<[f64; N]> {
    let mut matrix = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (row, value) in rows {
        for (line, a) in matrix.iter_mut().zip(row) {
            for (cell, b) in line.iter_mut().zip(row) {
                *cell += a * b;
            }
        }
        for (sum, a) in right.iter_mut().zip(row) {
            *sum += a * value;
        }
    }
    solve(matrix, right)
}

/// Gauss's elimination of a positive definite matrix.
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for pivot in 0..N {
        let row = matrix[pivot];
        if row[pivot].abs() < 1e-12 {
            return None;
        }
        for line in 0..N {
            if line == pivot {
                continue;
            }
            let factor = matrix[line][pivot] / row[pivot];
            for (cell, of) in matrix[line].iter_mut().zip(row) {
                *cell -= factor * of;
            }
            right[line] -= factor * right[pivot];
        }
    }
    let mut solution = right;
    for (place, value) in solution.iter_mut().enumerate() {
        *value /= matrix[place][place];
    }
    Some(solution)
}
