//! Finds passages that lie above one another, which a floor plan would join.

/// Two passages that overlap in plan are apart where their heights differ by more than this, m: the
/// height of a tunnel.
const APART: f64 = 3.0;

/// The distance between the places at which passages are compared, m.
const STEP: f64 = 1.0;

/// The passages that are on the floor plan.
pub(super) struct Levels {
    /// Points of their lines, with half of the width there.
    points: Vec<([f64; 3], f64)>,
}

impl Levels {
    pub(super) const fn new() -> Self {
        Self { points: Vec::new() }
    }

    /// Adds a passage along these places with these half widths.
    pub(super) fn add(&mut self, line: &[[f64; 3]], halves: &[f64]) {
        self.points.extend(sampled(line, halves));
    }

    /// Whether a passage overlaps one that is above or below it.
    pub(super) fn clash(&self, line: &[[f64; 3]], halves: &[f64]) -> bool {
        let meets = |(a, half_a): &([f64; 3], f64)| {
            self.points.iter().any(|(b, half_b)| {
                let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
                apart < half_a + half_b && (a[2] - b[2]).abs() > APART
            })
        };
        sampled(line, halves).iter().any(meets)
    }
}

/// Points along a line.
fn sampled(line: &[[f64; 3]], halves: &[f64]) -> Vec<([f64; 3], f64)> {
    let pairs = line.windows(2).zip(halves);
    let points = pairs.flat_map(|(pair, &half)| {
        let [from, to] = [pair[0], pair[1]];
        let steps = ((from[0] - to[0]).hypot(from[1] - to[1]) / STEP).clamp(1.0, 1000.0) as u32;
        (0..=steps).map(move |step| {
            let part = f64::from(step) / f64::from(steps);
            ([0, 1, 2].map(|axis| from[axis] + part * (to[axis] - from[axis])), half)
        })
    });
    points.collect()
}
