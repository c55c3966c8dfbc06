//! The true strength of a link between two places of the tunnel.
//!
//! Equation (19) measures distance along the tunnel and counts walls on the straight line between
//! two points of the centre-line. The attenuation exponent is tabulated once for all pairs of
//! places, 0.1 m apart; between them a continuous model is interpolated, a wall count is taken
//! from the nearest pair. What is tabulated is the exponent, not the loss: the logarithm is steep
//! and exact.
//!
//! Between walls of paper it is simpler: nothing stands in the way, and the distance is the
//! straight line.

use radio_model::{Attenuation, Obstruction, PathLoss};
use units::{Dbm, Metres};

use super::{CentreLine, Tunnel};

/// What the walls are to the radio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// Waves go round by the tunnel, and through with a loss.
    #[default]
    Rock,
    /// Waves go straight through, as in the circuit of section V-B.
    Paper,
}

/// The radio in one tunnel.
pub struct Radio {
    law: PathLoss,
    /// The line on which places are, where its walls are paper.
    straight: Option<CentreLine>,
    /// α for the pair (row, column), rows and columns 0.1 m apart from abscissa 0.
    exponents: Vec<f32>,
    places: usize,
}

impl Radio {
    /// Distance between tabulated places, in metres.
    pub const STEP: f32 = 0.1;

    /// Surveys the tunnel.
    #[must_use]
    pub fn survey(tunnel: &Tunnel, law: PathLoss, walls: Walls) -> Self {
        let line = tunnel.centre_line();
        if walls == Walls::Paper {
            let straight = Some(line.clone());
            return Self { law, straight, exponents: Vec::new(), places: 0 };
        }
        let places = (line.length() / Self::STEP) as usize + 2;
        let points: Vec<_> = (0..places).map(|n| line.at(n as f32 * Self::STEP).0).collect();
        let mut exponents = vec![law.exponent(Obstruction::NONE); places * places];
        for row in 0..places {
            for column in 0..row {
                let alpha = law.exponent(tunnel.obstruction(points[row], points[column]));
                exponents[row * places + column] = alpha;
                exponents[column * places + row] = alpha;
            }
        }
        Self { law, straight: None, exponents, places }
    }

    /// The strength of a link between the abscissae `a` and `b` in metres, without noise.
    #[must_use]
    pub fn strength(&self, a: f32, b: f32) -> Dbm {
        if let Some(line) = &self.straight {
            let distance = Metres(super::centre_line::distance(line.at(a).0, line.at(b).0));
            return Dbm::after_loss(self.law.loss(distance, Obstruction::NONE));
        }
        let distance = Metres((a - b).abs());
        Dbm::after_loss(self.law.loss_with_exponent(distance, self.exponent(a, b)))
    }

    fn exponent(&self, a: f32, b: f32) -> f32 {
        let last = (self.places - 1) as f32;
        let (row, column) = ((a / Self::STEP).clamp(0.0, last), (b / Self::STEP).clamp(0.0, last));
        match self.law.attenuation {
            Attenuation::WallCount => self.tabulated((row + 0.5) as usize, (column + 0.5) as usize),
            Attenuation::RockDepth => {
                let (r, c) = (row as usize, column as usize);
                let (fr, fc) = (row - r as f32, column - c as f32);
                let mix = |f: f32, a: f32, b: f32| a + f * (b - a);
                let near = mix(fc, self.tabulated(r, c), self.tabulated(r, c + 1));
                let far = mix(fc, self.tabulated(r + 1, c), self.tabulated(r + 1, c + 1));
                mix(fr, near, far)
            }
        }
    }

    fn tabulated(&self, row: usize, column: usize) -> f32 {
        let last = self.places - 1;
        self.exponents[row.min(last) * self.places + column.min(last)]
    }
}
