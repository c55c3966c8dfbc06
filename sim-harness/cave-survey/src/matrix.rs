//! Computes with vectors and matrices of three rows, which a leg and its covariance are.

/// A vector: metres east, north and up.
pub type Vector = [f64; 3];

/// A matrix, row by row.
pub(crate) type Matrix = [[f64; 3]; 3];

pub(crate) const ZERO: Matrix = [[0.0; 3]; 3];

pub(crate) fn diagonal([x, y, z]: Vector) -> Matrix {
    [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scaled(a: Vector, by: f64) -> Vector {
    a.map(|x| x * by)
}

/// The length of a vector.
#[must_use]
pub fn norm(a: Vector) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

pub(crate) fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    [add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2])]
}

pub(crate) fn difference(a: &Matrix, b: &Matrix) -> Matrix {
    [sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])]
}

pub(crate) fn times(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub(crate) fn transposed(m: &Matrix) -> Matrix {
    let column = |c: usize| [m[0][c], m[1][c], m[2][c]];
    [column(0), column(1), column(2)]
}

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transposed(b);
    a.map(|row| times(&columns, row))
}

pub(crate) fn share(m: &Matrix, by: f64) -> Matrix {
    m.map(|row| scaled(row, by))
}

/// The inverse of a symmetric matrix that is positive definite; where rounding or a weightless
/// measurement has left it singular, that of its diagonal, with the least variance kept from 0.
pub(crate) fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |r: usize, c: usize| {
        let [a, b] = [(r + 1) % 3, (r + 2) % 3];
        let [d, e] = [(c + 1) % 3, (c + 2) % 3];
        m[a][d] * m[b][e] - m[a][e] * m[b][d]
    };
    let determinant = (0..3).map(|c| m[0][c] * cofactor(0, c)).sum::<f64>();
    let size = m[0][0].abs() * m[1][1].abs() * m[2][2].abs();
    if determinant > 1e-12 * size && determinant.is_finite() {
        let mut inverse = ZERO;
        for (r, row) in inverse.iter_mut().enumerate() {
            for (c, entry) in row.iter_mut().enumerate() {
                *entry = cofactor(c, r) / determinant;
            }
        }
        return inverse;
    }
    /// The least variance, m².
    const LEAST: f64 = 1e-12;
    diagonal([m[0][0], m[1][1], m[2][2]].map(|v| 1.0 / v.max(LEAST)))
}
