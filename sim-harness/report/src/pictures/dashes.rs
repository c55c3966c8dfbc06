//! Cutting a path into dashes, which plotters' backends cannot draw by themselves.

/// A path in pixels cut into dashes of `dash` pixels with gaps of `gap`.
pub(super) fn cut(path: &[(f64, f64)], dash: f64, gap: f64) -> Vec<Vec<(f64, f64)>> {
    let mut dashes = Vec::new();
    let mut drawing = true;
    let mut left = dash;
    let mut current: Vec<(f64, f64)> = path.first().copied().into_iter().collect();
    for (from, to) in path.iter().zip(path.iter().skip(1)) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = libm::hypot(dx, dy);
        let mut gone = 0.0;
        while length.is_finite() && gone + left < length {
            gone += left;
            let point = (from.0 + dx * gone / length, from.1 + dy * gone / length);
            if drawing {
                current.push(point);
                dashes.push(std::mem::take(&mut current));
            } else {
                current = vec![point];
            }
            drawing = !drawing;
            left = if drawing { dash } else { gap };
        }
        left -= length - gone;
        if drawing {
            current.push(*to);
        }
    }
    dashes.push(current);
    dashes.retain(|dash| dash.len() > 1);
    dashes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_go_around_corners() {
        let dashes = cut(&[(0.0, 0.0), (4.0, 0.0), (4.0, 20.0)], 6.0, 5.0);
        assert_eq!(dashes[0], [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0)]);
        assert_eq!(dashes[1], [(4.0, 7.0), (4.0, 13.0)]);
    }

    #[test]
    fn a_point_has_no_dash() {
        assert!(cut(&[(1.0, 1.0)], 6.0, 5.0).is_empty());
        assert!(cut(&[], 6.0, 5.0).is_empty());
    }
}
