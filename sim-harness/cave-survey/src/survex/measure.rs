//! Turns the readings of a leg into a vector and its covariance.
//!
//! The covariances are the first-order propagation of the readings' variances. They follow
//! `cavern`, Survex 1.4, in what they leave out too, so that loops close where it closes them.

use super::settings::{Quantity, Settings};
use crate::draft::DraftLeg;
use crate::matrix::{self, Matrix, Vector};
use crate::survey::{LegFlags, Source, StationId};

/// A reading of the clinometer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Slope {
    /// Left out.
    #[default]
    Omitted,
    /// Measured with a level.
    Level,
    /// Measured with a plumb line, up or down.
    Plumb { up: bool, is_inferred: bool },
    /// An angle, rad.
    Angle(f64),
}

/// The readings of one leg, in metres and radians, without calibration.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Readings {
    pub(crate) tape: Option<f64>,
    pub(crate) back_tape: Option<f64>,
    pub(crate) compass: Option<f64>,
    pub(crate) back_compass: Option<f64>,
    pub(crate) clino: Slope,
    pub(crate) back_clino: Slope,
    /// The readings of a counter at both ends.
    pub(crate) counts: [Option<f64>; 2],
    /// The readings of a depth gauge at both ends.
    pub(crate) depths: [Option<f64>; 2],
    pub(crate) depth_change: Option<f64>,
    /// Easting, northing, altitude.
    pub(crate) steps: [Option<f64>; 3],
}

/// A measured leg.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub(crate) vector: Vector,
    pub(crate) covariance: Matrix,
    /// The calibrated reading of the tape, m.
    pub(crate) length: f64,
    /// Whether a depth gauge measured its height.
    pub(crate) by_depth: bool,
}

impl Measured {
    /// The leg that was measured between these stations, once.
    pub(crate) const fn leg(
        self,
        [from, to]: [StationId; 2],
        flags: LegFlags,
        source: Source,
    ) -> DraftLeg {
        let Self { vector, covariance, length, by_depth } = self;
        let flags = LegFlags { dived: by_depth, ..flags };
        DraftLeg { from, to, vector, covariance, length, flags, source, repeats: 1 }
    }

    /// The leg turned clockwise round the vertical by an angle in radians.
    pub(crate) fn turned(self, by: f64) -> Self {
        let (sin, cos) = by.sin_cos();
        let [x, y, z] = self.vector;
        let turn = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let half = matrix::product(&self.covariance, &matrix::transposed(&turn));
        let covariance = matrix::product(&turn, &half);
        Self { vector: [x * cos + y * sin, y * cos - x * sin, z], covariance, ..self }
    }
}

/// What is wrong with a leg, and how to mend it.
pub(crate) type Fault = (&'static str, &'static str);

/// Remarks about a leg.
pub(crate) type Remarks = Vec<String>;

/// The ratio of a difference to its standard deviation beyond which two readings of the same
/// quantity are said to disagree, as in `cavern`.
const DISAGREEMENT: f64 = 3.0;

impl Readings {
    /// The length by tape or counter with its variance.
    fn length(&self, settings: &Settings, remarks: &mut Remarks) -> Result<(f64, f64), Fault> {
        if let [Some(from), Some(to)] = self.counts {
            let counter = settings.of(Quantity::Count);
            let length = (to - from) * counter.scale;
            if length < 0.0 {
                remarks.push("the calibrated length is negative".into());
            }
            return Ok((length, counter.variance));
        }
        let read = |quantity, reading: Option<f64>| {
            let tape = settings.of(quantity);
            reading.map(|reading| ((reading - tape.zero) * tape.scale, tape.variance))
        };
        let fore = read(Quantity::Length, self.tape);
        let back = read(Quantity::BackLength, self.back_tape);
        let (length, variance) = match (fore, back) {
            (Some((fore, a)), Some((back, b))) => {
                if ((fore - back) / DISAGREEMENT).powi(2) > a + b {
                    let by = (fore - back).abs();
                    remarks.push(format!("tape and backtape disagree by {by:.2} m"));
                }
                ((fore * b + back * a) / (a + b), (a + b) / 4.0)
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => return Err(("the tape's reading is left out", "give it")),
        };
        if length < 0.0 {
            remarks.push("the calibrated length is negative".into());
        }
        Ok((length, variance))
    }

    /// The bearing from the grid's north with its variance, rad; `None` where there is none.
    fn bearing(
        &self,
        settings: &Settings,
        declination: f64,
        remarks: &mut Remarks,
    ) -> Option<(f64, f64)> {
        let read = |quantity, reading: Option<f64>| {
            let compass = settings.of(quantity);
            let corrected = |reading| (reading - compass.zero) * compass.scale + declination;
            reading.map(|reading| (corrected(reading), compass.variance))
        };
        let turned = |(back, variance)| (back - std::f64::consts::PI, variance);
        match (
            read(Quantity::Bearing, self.compass),
            read(Quantity::BackBearing, self.back_compass).map(turned),
        ) {
            (Some((fore, a)), Some((back, b))) => {
                let apart = wrapped(fore - back);
                if (apart / DISAGREEMENT).powi(2) > a + b {
                    let by = apart.abs().to_degrees();
                    remarks.push(format!("compass and backcompass disagree by {by:.1}°"));
                }
                Some((fore - apart * a / (a + b), (a + b) / 4.0))
            }
            (one, None) | (None, one) => one,
        }
    }
}

/// The same angle between −π and π.
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle + PI).rem_euclid(TAU) - PI
}

/// The part of a variance that is the station's: a third of the sphere's, on each axis.
fn position(settings: &Settings) -> f64 {
    settings.of(Quantity::Position).variance / 3.0
}

/// A leg by tape, compass and clinometer.
pub(crate) fn normal(
    readings: &Readings,
    settings: &Settings,
    declination: f64,
    remarks: &mut Remarks,
) -> Result<Measured, Fault> {
    let (tape, tape_variance) = readings.length(settings, remarks)?;
    let (mut clino, mut back) = (readings.clino, readings.back_clino);
    // A plumb that was inferred is a reading beside another reading.
    for (one, other) in [(&mut clino, back), (&mut back, readings.clino)] {
        if let (Slope::Plumb { up, is_inferred: true }, Slope::Angle(_)) = (*one, other) {
            *one = Slope::Angle(if up { 1.0 } else { -1.0 } * std::f64::consts::FRAC_PI_2);
        }
    }
    let here = position(settings);
    let plumb = match (clino, back) {
        (Slope::Plumb { up, .. }, Slope::Omitted) => Some(up),
        (Slope::Omitted, Slope::Plumb { up, .. }) => Some(!up),
        (Slope::Plumb { up, .. }, Slope::Plumb { up: back, .. }) if up != back => Some(up),
        (Slope::Plumb { .. }, Slope::Plumb { .. }) => {
            return Err(("clino and backclino are plumbed in the same direction", "correct one"));
        }
        (Slope::Plumb { .. }, _) | (_, Slope::Plumb { .. }) => {
            return Err(("only one of clino and backclino is plumbed", "correct one of them"));
        }
        _ => None,
    };
    if let Some(up) = plumb {
        let given = [readings.compass, readings.back_compass];
        let inferred = matches!(clino, Slope::Plumb { is_inferred: true, .. });
        if given.into_iter().flatten().any(|compass| !inferred || compass != 0.0) {
            remarks.push("a plumbed leg has a compass reading, which is not used".into());
        }
        let dz = if up { tape } else { -tape };
        let sideways = here + dz * dz * settings.of(Quantity::Plumb).variance;
        let covariance = matrix::diagonal([sideways, sideways, here + tape_variance]);
        return Ok(Measured { vector: [0.0, 0.0, dz], covariance, length: tape, by_depth: false });
    }
    let Some((bearing, bearing_variance)) = readings.bearing(settings, declination, remarks) else {
        return Err(("a leg that is not plumbed has no compass reading", "give it, or UP or DOWN"));
    };
    if tape == 0.0 {
        let covariance = matrix::diagonal([here; 3]);
        return Ok(Measured { vector: [0.0; 3], covariance, length: 0.0, by_depth: false });
    }
    let (slope, slope_variance) = slope(clino, back, settings, remarks);
    let (sin_b, cos_b) = bearing.sin_cos();
    let (sin_g, cos_g) = slope.sin_cos();
    let [dx, dy, dz] = [tape * cos_g * sin_b, tape * cos_g * cos_b, tape * sin_g];
    // Along the leg by the tape, across it by the compass, and up by the clinometer.
    let along = tape_variance / (tape * tape);
    let lift = dz * dz * slope_variance;
    let height = match (clino, back) {
        // Without a slope, three deviations are 0.95 of the tape.
        (Slope::Omitted, Slope::Omitted) => tape * tape * 0.1,
        _ => dz * dz * along + tape * tape * cos_g * cos_g * slope_variance,
    };
    let xx = here + dx * dx * along + dy * dy * bearing_variance + sin_b * sin_b * lift;
    let yy = here + dy * dy * along + dx * dx * bearing_variance + cos_b * cos_b * lift;
    let xy = sin_b * cos_b * (tape_variance * cos_g * cos_g + lift) - bearing_variance * dx * dy;
    let xz = tape_variance * sin_b * sin_g * cos_g - slope_variance * dx * dz;
    let yz = tape_variance * cos_b * sin_g * cos_g - slope_variance * dy * dz;
    let covariance = [[xx, xy, xz], [xy, yy, yz], [xz, yz, here + height]];
    Ok(Measured { vector: [dx, dy, dz], covariance, length: tape, by_depth: false })
}

/// The slope with its variance.
fn slope(clino: Slope, back: Slope, settings: &Settings, remarks: &mut Remarks) -> (f64, f64) {
    let read = |quantity, slope| match slope {
        Slope::Angle(angle) => {
            let clino = settings.of(quantity);
            Some(((angle - clino.zero) * clino.scale, clino.variance))
        }
        _ => None,
    };
    match (read(Quantity::Gradient, clino), read(Quantity::BackGradient, back)) {
        (Some((fore, a)), Some((back, b))) => {
            if ((fore + back) / DISAGREEMENT).powi(2) > a + b {
                let by = (fore + back).abs().to_degrees();
                remarks.push(format!("clino and backclino disagree by {by:.1}°"));
            }
            ((fore * b - back * a) / (a + b), (a + b) / 4.0)
        }
        (Some(fore), None) => fore,
        (None, Some((back, variance))) => (-back, variance),
        (None, None) => (0.0, settings.of(Quantity::Level).variance),
    }
}

/// The change of height by a depth gauge: with the default calibration it reads upwards.
fn depth_change(readings: &Readings, settings: &Settings) -> Result<f64, Fault> {
    let gauge = settings.of(Quantity::Depth);
    match (readings.depths, readings.depth_change) {
        (_, Some(change)) => Ok((change - gauge.zero) * gauge.scale),
        ([Some(from), Some(to)], None) => Ok((to - from) * gauge.scale),
        _ => Err(("a depth is left out", "give it")),
    }
}

/// A leg by tape, compass and depth gauge.
pub(crate) fn diving(
    readings: &Readings,
    settings: &Settings,
    declination: f64,
    remarks: &mut Remarks,
) -> Result<Measured, Fault> {
    let (tape, tape_variance) = readings.length(settings, remarks)?;
    let dz = depth_change(readings, settings)?;
    let depth_variance = 2.0 * settings.of(Quantity::Depth).variance;
    let here = position(settings);
    if tape < dz.abs() {
        remarks.push("the tape is shorter than the change of depth".into());
    }
    if tape == 0.0 && dz == 0.0 {
        let covariance = matrix::diagonal([here; 3]);
        return Ok(Measured { vector: [0.0; 3], covariance, length: 0.0, by_depth: true });
    }
    let bearing = readings.bearing(settings, declination, remarks);
    let flat = tape * tape - dz * dz;
    let Some((bearing, bearing_variance)) = bearing.filter(|_| flat > 0.0) else {
        // Tape and gauge both measure the height.
        let both = tape_variance + depth_variance;
        let signed = if dz < 0.0 { -tape } else { tape };
        let height = (dz * tape_variance + signed * depth_variance) / both;
        let sideways = here + height * height * settings.of(Quantity::Plumb).variance;
        let up = here + tape_variance * depth_variance / both;
        let covariance = matrix::diagonal([sideways, sideways, up]);
        return Ok(Measured {
            vector: [0.0, 0.0, height],
            covariance,
            length: tape,
            by_depth: true,
        });
    };
    let (sin_b, cos_b) = bearing.sin_cos();
    let along = (tape_variance * tape * tape + depth_variance * dz * dz) / flat;
    let [dx, dy] = [flat.sqrt() * sin_b, flat.sqrt() * cos_b];
    let xx = here + sin_b * sin_b * along + bearing_variance * dy * dy;
    let yy = here + cos_b * cos_b * along + bearing_variance * dx * dx;
    let xy = sin_b * cos_b * along - bearing_variance * dx * dy;
    let (xz, yz) = (-depth_variance * dz * dx / flat, -depth_variance * dz * dy / flat);
    let covariance = [[xx, xy, xz], [xy, yy, yz], [xz, yz, here + depth_variance]];
    Ok(Measured { vector: [dx, dy, dz], covariance, length: tape, by_depth: true })
}

/// A leg whose tape is level, with compass and depth gauge.
pub(crate) fn cylpolar(
    readings: &Readings,
    settings: &Settings,
    declination: f64,
    remarks: &mut Remarks,
) -> Result<Measured, Fault> {
    let (tape, tape_variance) = readings.length(settings, remarks)?;
    let dz = depth_change(readings, settings)?;
    let here = position(settings);
    let up = here + 2.0 * settings.of(Quantity::Depth).variance;
    let Some((bearing, variance)) = readings.bearing(settings, declination, remarks) else {
        let sideways = here + dz * dz * settings.of(Quantity::Plumb).variance;
        let covariance = matrix::diagonal([sideways, sideways, up]);
        return Ok(Measured {
            vector: [0.0, 0.0, dz],
            covariance,
            length: dz.abs(),
            by_depth: true,
        });
    };
    let (sin_b, cos_b) = bearing.sin_cos();
    let [dx, dy] = [tape * sin_b, tape * cos_b];
    let xx = here + tape_variance * sin_b * sin_b + variance * dy * dy;
    let yy = here + tape_variance * cos_b * cos_b + variance * dx * dx;
    let xy = (tape_variance - variance * tape * tape) * sin_b * cos_b;
    let covariance = [[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, up]];
    Ok(Measured { vector: [dx, dy, dz], covariance, length: tape.hypot(dz), by_depth: true })
}

/// A leg by its coordinates.
pub(crate) fn cartesian(readings: &Readings, settings: &Settings) -> Result<Measured, Fault> {
    let [Some(x), Some(y), Some(z)] = readings.steps else {
        return Err(("a coordinate is left out", "give all three"));
    };
    let axes = [(Quantity::Dx, x), (Quantity::Dy, y), (Quantity::Dz, z)];
    let calibrated = |(quantity, reading): (Quantity, f64)| {
        let axis = settings.of(quantity);
        (reading - axis.zero) * axis.scale
    };
    let vector = axes.map(calibrated);
    let covariance = matrix::diagonal(axes.map(|(quantity, _)| settings.of(quantity).variance));
    Ok(Measured { vector, covariance, length: matrix::norm(vector), by_depth: false })
}
