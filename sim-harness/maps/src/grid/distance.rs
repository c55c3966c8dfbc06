//! The exact distance transform of a set of cells, after Felzenszwalb and Huttenlocher, "Distance
//! transforms of sampled functions" (2012): lower envelopes of parabolas, first along the columns,
//! then along the rows.

use super::mask::Mask;

/// The square of the distance from the middle of each cell to that of the nearest cell that does not
/// belong to the set, in cells.
pub(super) fn squares(mask: &Mask) -> Vec<f32> {
    let (width, height) = (mask.width, mask.cells.len() / mask.width);
    // Farther than any two cells are apart; the border belongs to no set.
    let far = (width * width + height * height) as f32;
    let mut squares: Vec<f32> =
        mask.cells.iter().map(|member| if *member { far } else { 0.0 }).collect();
    for column in 0..width {
        let line: Vec<f32> = (0..height).map(|row| squares[row * width + column]).collect();
        for (row, value) in envelope(&line).into_iter().enumerate() {
            squares[row * width + column] = value;
        }
    }
    for row in squares.chunks_exact_mut(width) {
        row.copy_from_slice(&envelope(row));
    }
    squares
}

/// The least of the parabolas `(x − n)² + line[n]` at each `x`.
fn envelope(line: &[f32]) -> Vec<f32> {
    let height = |n: usize| f64::from(line[n]) + (n * n) as f64;
    // Each parabola of the envelope, and where it begins.
    let mut parts: Vec<(usize, f64)> = Vec::new();
    for n in 0..line.len() {
        let mut begins = f64::NEG_INFINITY;
        while let Some(&(last, from)) = parts.last() {
            begins = (height(n) - height(last)) / (2.0 * (n - last) as f64);
            if begins > from {
                break;
            }
            parts.pop();
            begins = f64::NEG_INFINITY;
        }
        parts.push((n, begins));
    }
    let mut part = 0;
    let value = |x: usize| {
        while parts.get(part + 1).is_some_and(|(_, from)| *from <= x as f64) {
            part += 1;
        }
        let n = parts[part].0;
        let away = x.abs_diff(n) as f32;
        away * away + line[n]
    };
    (0..line.len()).map(value).collect()
}
