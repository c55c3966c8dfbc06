//! Refines the map of signal strength from readings.
//!
//! For each reference, a relay on the ground or the base, the difference of a reading to the model
//! is a Gaussian process: a constant offset, of the reference's antenna and place, and a part that
//! changes over space, the shadowing, whose correlation falls exponentially with distance (M.
//! Gudmundson, "Correlation model for shadow fading in mobile radio systems", Electronics Letters
//! 27(23), 1991). Readings near each other are put together as one place, so that the memory and
//! the time are bounded: a fit takes the cube of the number of places.

use core::fmt;

use heapless::Vec;
use units::{Db, Metres, Point2};

use crate::network::distance;

/// The correlation of the shadowing over so many times its distance of decorrelation counts as none: it is
/// 0.0003 there.
const FAR: f32 = 8.0;

/// The spread of what a reading is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineConfig {
    /// The standard deviation of the offsets of the references.
    pub offset: Db,
    /// The standard deviation of the shadowing.
    pub shadowing: Db,
    /// The distance at which the correlation of the shadowing has fallen to 1/e.
    pub decorrelation: Metres,
    /// The standard deviation of a reading at one place, unless the readings themselves tell more.
    pub noise: Db,
    /// Readings nearer to each other than this are one place.
    pub spacing: Metres,
}

impl RefineConfig {
    /// A choice, made before any recording was looked at and not tuned since, but for the noise: the
    /// readings of an nRF52 over a still link have a standard deviation of 3 to 7 dB (MIT Lincoln
    /// Laboratory, data set "BLE-RSSI-Various-Static-Configurations").
    pub const DEFAULT: Self = Self {
        offset: Db(6.0),
        shadowing: Db(4.0),
        decorrelation: Metres(2.0),
        noise: Db(5.0),
        spacing: Metres(0.5),
    };
    /// The weight of [`RefineConfig::noise`] against the readings, in readings.
    const NOISE_WEIGHT: f32 = 20.0;
}

/// The error of a reading that is no number, or at a point that is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFinite;

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a reading of the signal strength or its place is not a finite number")
    }
}

/// Readings of one place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    at: Point2,
    mean: f32,
    count: f32,
}

/// The readings of one reference, at no more than `SPOTS` places.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings<const SPOTS: usize> {
    config: RefineConfig,
    spots: Vec<Spot, SPOTS>,
    /// The sum of the squares of the deviations from the means of the places, and the number of
    /// readings beyond the first of each place.
    squares: f32,
    freedom: f32,
}

impl<const SPOTS: usize> Readings<SPOTS> {
    /// No readings.
    #[must_use]
    pub const fn new(config: RefineConfig) -> Self {
        Self { config, spots: Vec::new(), squares: 0.0, freedom: 0.0 }
    }

    /// Adds a reading: by how much the strength at a point is over the model's. Where there is no
    /// room for another place, it is added to the nearest one.
    ///
    /// # Errors
    /// [`NotFinite`]; nothing is changed.
    pub fn add(&mut self, at: Point2, over: Db) -> Result<(), NotFinite> {
        if !at.is_finite() || !over.0.is_finite() {
            return Err(NotFinite);
        }
        let is_full = self.spots.is_full();
        let far = |spot: &Spot| distance(spot.at, at).0;
        let nearest = self.spots.iter_mut().min_by(|a, b| far(a).total_cmp(&far(b)));
        match nearest.filter(|spot| is_full || far(spot) < self.config.spacing.0) {
            Some(spot) => {
                // Welford's update of a mean and a sum of squares.
                let before = over.0 - spot.mean;
                spot.count += 1.0;
                spot.mean += before / spot.count;
                self.squares += before * (over.0 - spot.mean);
                self.freedom += 1.0;
            }
            // There is room, or a nearest place would have been found.
            None => drop(self.spots.push(Spot { at, mean: over.0, count: 1.0 })),
        }
        Ok(())
    }

    /// The variance of a reading at one place, dB²: that of the configuration and of the readings,
    /// each with its weight.
    fn noise(&self) -> f32 {
        let weight = RefineConfig::NOISE_WEIGHT;
        let own = self.config.noise.0 * self.config.noise.0;
        ((weight * own + self.squares) / (weight + self.freedom)).max(1e-3)
    }

    /// The covariance of what is over the model at two places, dB².
    fn covariance(&self, a: Point2, b: Point2) -> f32 {
        let RefineConfig { offset, shadowing, decorrelation, .. } = self.config;
        let correlation = libm::expf(-distance(a, b).0 / decorrelation.0.max(1e-3));
        offset.0 * offset.0 + shadowing.0 * shadowing.0 * correlation
    }

    /// Fits the process to the readings.
    #[must_use]
    pub fn fit(&self) -> Refined<'_, SPOTS> {
        let mut refined = Refined {
            readings: self,
            noise: self.noise(),
            factor: [[0.0; SPOTS]; SPOTS],
            weights: [0.0; SPOTS],
            far: None,
        };
        refined.factorise();
        let offset = self.config.offset.0;
        let mut means = [0.0; SPOTS];
        for (slot, spot) in means.iter_mut().zip(&self.spots) {
            *slot = spot.mean;
        }
        refined.weights = refined.solve(means);
        refined.far = Some(refined.by([offset * offset; SPOTS]));
        refined
    }
}

/// A Gaussian process that is fitted to readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined<'a, const SPOTS: usize> {
    readings: &'a Readings<SPOTS>,
    noise: f32,
    /// The lower Cholesky factor of the covariance of the places' means.
    factor: [[f32; SPOTS]; SPOTS],
    /// The factor's solution for these means.
    weights: [f32; SPOTS],
    /// The correction where no shadowing is known any more, once it is computed.
    far: Option<Correction>,
}

/// How much the strength at a point is over the model's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// The mean.
    pub over: Db,
    /// The standard deviation of the mean.
    pub deviation: Db,
    /// The standard deviation of a single reading there.
    pub reading_deviation: Db,
}

impl Correction {
    /// The correction of a reference of which nothing was read: its spread is that of offset and
    /// shadowing of [`RefineConfig::DEFAULT`], and with the noise that of a reading.
    pub const NONE: Self =
        Self { over: Db(0.0), deviation: Db(7.211_103), reading_deviation: Db(8.774_964) };
}

impl<const SPOTS: usize> Refined<'_, SPOTS> {
    /// The correction at a point; without readings that of the configuration.
    #[must_use]
    pub fn at(&self, point: Point2) -> Correction {
        let decorrelation = self.readings.config.decorrelation;
        let reach = FAR * decorrelation.0;
        let is_far = |spot: &Spot| distance(spot.at, point).0 > reach;
        if let Some(far) = self.far.filter(|_| self.readings.spots.iter().all(is_far)) {
            return far;
        }
        let mut shared = [0.0; SPOTS];
        for (slot, spot) in shared.iter_mut().zip(&self.readings.spots) {
            *slot = self.readings.covariance(spot.at, point);
        }
        self.by(shared)
    }

    /// The correction at a point with these covariances with the places.
    fn by(&self, shared: [f32; SPOTS]) -> Correction {
        let part = self.solve(shared);
        let known = dot(&part, &part);
        let RefineConfig { offset, shadowing, .. } = self.readings.config;
        let unknown = offset.0 * offset.0 + shadowing.0 * shadowing.0;
        let variance = (unknown - known).max(0.0);
        Correction {
            over: Db(dot(&part, &self.weights)),
            deviation: Db(libm::sqrtf(variance)),
            reading_deviation: Db(libm::sqrtf(variance + self.noise)),
        }
    }

    /// Cholesky's factorisation, row by row.
    fn factorise(&mut self) {
        for (n, spot) in self.readings.spots.iter().enumerate() {
            let mut shared = [0.0; SPOTS];
            for (slot, other) in shared.iter_mut().zip(self.readings.spots.iter().take(n)) {
                *slot = self.readings.covariance(spot.at, other.at);
            }
            let mut row = self.solve(shared);
            let own = self.readings.covariance(spot.at, spot.at) + self.noise / spot.count;
            // The noise keeps the rest above 0, but for rounding.
            let rest = (own - dot(&row, &row)).max(1e-3);
            if let Some(diagonal) = row.get_mut(n) {
                *diagonal = libm::sqrtf(rest);
            }
            if let Some(slot) = self.factor.get_mut(n) {
                *slot = row;
            }
        }
    }

    /// Solves the triangular system of the rows that there are; beyond them the result is 0.
    fn solve(&self, right: [f32; SPOTS]) -> [f32; SPOTS] {
        let mut solution = [0.0; SPOTS];
        for (n, (row, right)) in self.factor.iter().zip(right).enumerate() {
            let diagonal = row.get(n).copied().unwrap_or(0.0);
            if diagonal == 0.0 {
                break;
            }
            let rest = right - dot(row, &solution);
            if let Some(slot) = solution.get_mut(n) {
                *slot = rest / diagonal;
            }
        }
        solution
    }
}

fn dot<const SPOTS: usize>(a: &[f32; SPOTS], b: &[f32; SPOTS]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
