//! Reads what a line of Walls says of the variances of its readings.

use super::Reader;
use super::numbers;
use crate::error::Refusal;
use crate::matrix::{self, Matrix};
use crate::survex::measure::Measured;

/// A standard deviation that joins next to nothing, m: `cavern` floats legs and fixes with it.
const FLOATING_M: f64 = 1000.0;

/// The standard deviations that a line gives, m: across and up; `None` leaves those of the readings.
pub(super) type Deviations = [Option<f64>; 2];

impl Reader {
    /// Reads the variances `(horizontal,vertical)`, or one for both.
    pub(super) fn deviations(&mut self, text: &str) -> Result<Deviations, Refusal> {
        let (across, up) = text.split_once(',').unwrap_or((text, text));
        Ok([self.deviation(across)?, self.deviation(up)?])
    }

    fn deviation(&mut self, text: &str) -> Result<Option<f64>, Refusal> {
        let text = text.trim().to_ascii_lowercase();
        if text.is_empty() {
            return Ok(None);
        }
        if text == "?" || text == "*" {
            return Ok(Some(FLOATING_M));
        }
        let deviation = text.strip_prefix('r');
        let size = numbers::length(deviation.unwrap_or(&text), self.units.distance);
        let size = size.filter(|size| (0.0..1e6).contains(size));
        let size = size.ok_or_else(|| self.unread(&text, "variance"))?;
        if deviation.is_none() {
            self.remark("a variance that is given as a leg's length is passed over");
        }
        Ok(deviation.map(|_| size))
    }

    /// Puts the variances that the line and `UV=` give in the place of those of the readings.
    pub(super) fn weigh(&self, measured: &mut Measured, [across, up]: Deviations) {
        let [wide, high] = self.units.variance;
        let factor = [wide, wide, high].map(f64::sqrt);
        for (row, one) in measured.covariance.iter_mut().zip(factor) {
            for (entry, other) in row.iter_mut().zip(factor) {
                *entry *= one * other;
            }
        }
        replace(&mut measured.covariance, across, &[0, 1]);
        replace(&mut measured.covariance, up, &[2]);
    }
}

/// Replaces the variances along some axes of a covariance.
fn replace(covariance: &mut Matrix, deviation: Option<f64>, axes: &[usize]) {
    let Some(deviation) = deviation else { return };
    for &axis in axes {
        covariance[axis] = [0.0; 3];
        for row in &mut *covariance {
            row[axis] = 0.0;
        }
        // A horizontal deviation is that of the distance on the plan.
        covariance[axis][axis] = deviation.max(1e-3).powi(2) / axes.len() as f64;
    }
}

/// The covariance of a position whose deviations a line gives; `None` where it is exact.
pub(super) fn of_fix(deviations: Deviations) -> Option<Matrix> {
    let [across, up] = deviations.map(Option::unwrap_or_default);
    if across == 0.0 && up == 0.0 {
        return None;
    }
    // What is exact beside what is not is taken for a millimetre, as `cavern` takes it.
    let [across, up] = [across, up].map(|size: f64| size.max(1e-3).powi(2));
    Some(matrix::diagonal([across / 2.0, across / 2.0, up]))
}
