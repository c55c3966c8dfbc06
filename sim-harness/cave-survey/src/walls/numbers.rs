//! Reads the numbers of Walls: lengths, bearings and slopes, each with the letters of its unit.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::survex::settings::FOOT;

/// A unit in which an angle is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AngleUnit {
    /// Degrees, 360 to the circle.
    Degrees,
    /// Grads, 400 to the circle.
    Grads,
    /// Mils, 6400 to the circle.
    Mils,
    /// The tangent of a slope, in percent.
    Percent,
}

impl AngleUnit {
    /// The unit that begins with this letter, the only one at which Walls looks.
    pub(super) fn of(letter: char) -> Option<Self> {
        Some(match letter.to_ascii_lowercase() {
            'd' => Self::Degrees,
            'g' => Self::Grads,
            'm' => Self::Mils,
            'p' => Self::Percent,
            _ => return None,
        })
    }

    /// The angle of a number in this unit, rad.
    fn radians(self, number: f64) -> f64 {
        match self {
            Self::Degrees => number.to_radians(),
            Self::Grads => number * PI / 200.0,
            Self::Mils => number * PI / 3200.0,
            Self::Percent => (number / 100.0).atan(),
        }
    }
}

/// Whether the text stands for a reading that was left out: nothing, or nothing but dashes.
pub(super) fn is_omitted(text: &str) -> bool {
    text.bytes().all(|byte| byte == b'-')
}

/// A number of digits with at most one point and one sign.
pub(super) fn number(text: &str) -> Option<f64> {
    let sound = |byte: u8| byte.is_ascii_digit() || b"+-.".contains(&byte);
    text.bytes().all(sound).then(|| text.parse().ok()).flatten().filter(|it: &f64| it.is_finite())
}

/// The number at the beginning of a text, and what follows it.
pub(super) fn leading(text: &str) -> Option<(f64, &str)> {
    let is_part = |it: char| it.is_ascii_digit() || "+-.".contains(it);
    let (digits, rest) = text.split_at(text.find(|it| !is_part(it)).unwrap_or(text.len()));
    number(digits).map(|number| (number, rest))
}

/// A length in metres: a number in `unit`, metres, or with `m` or `f` behind it, or feet and inches
/// such as `5i6`, whose feet may be missing.
pub(super) fn length(text: &str, unit: f64) -> Option<f64> {
    let text = text.to_ascii_lowercase();
    if let Some((feet, inches)) = text.split_once('i') {
        // Only the last part may have a fraction.
        if feet.contains('.') {
            return None;
        }
        let (sign, feet) = feet.strip_prefix('-').map_or((1.0, feet), |feet| (-1.0, feet));
        let feet = if feet.is_empty() { 0.0 } else { number(feet)? };
        return Some(sign * (feet + number(inches)? / 12.0) * FOOT);
    }
    if let Some(metres) = text.strip_suffix('m') {
        return number(metres);
    }
    match text.strip_suffix('f') {
        Some(feet) => Some(number(feet)? * FOOT),
        None => Some(number(&text)? * unit),
    }
}

/// An angle in radians: a number in `unit` or with the letter of another behind it, or degrees,
/// minutes and seconds such as `35:30`.
pub(super) fn angle(text: &str, unit: AngleUnit) -> Option<f64> {
    let (sign, size) = match text.strip_prefix('-') {
        Some(size) => (-1.0, size),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    if size.starts_with(['+', '-']) {
        return None;
    }
    if size.contains(':') {
        let mut degrees = 0.0;
        let size = size.strip_suffix(['d', 'D']).unwrap_or(size);
        let last = size.split(':').count() - 1;
        for (place, part) in size.split(':').enumerate() {
            let share = [1.0, 60.0, 3600.0].get(place)?;
            if place < last && part.contains('.') {
                return None;
            }
            degrees += if part.is_empty() { 0.0 } else { number(part)? } / share;
        }
        return Some(sign * AngleUnit::Degrees.radians(degrees));
    }
    let last = size.chars().last()?;
    if !last.is_ascii_alphabetic() {
        return Some(sign * unit.radians(number(size)?));
    }
    let size = size.strip_suffix(last)?;
    Some(sign * AngleUnit::of(last)?.radians(number(size)?))
}

/// A bearing in radians: an [`angle`], or one from north or south such as `N45E`.
pub(super) fn bearing(text: &str, unit: AngleUnit) -> Option<f64> {
    let upper = text.to_ascii_uppercase();
    let Some(is_south) = pole(&upper) else { return angle(text, unit) };
    let inner = upper.get(1..)?;
    let (size, is_west) = match inner.strip_suffix('W') {
        Some(size) => (size, true),
        None => (inner.strip_suffix('E')?, false),
    };
    let size = angle(size, unit).filter(|size| (0.0..=FRAC_PI_2 + 1e-9).contains(size))?;
    let eastward = if is_south { PI - size } else { size };
    Some(if is_west { TAU - eastward } else { eastward })
}

/// Whether a bearing is counted from the south, where it is counted from a pole.
fn pole(upper: &str) -> Option<bool> {
    match upper.as_bytes().first()? {
        b'N' => Some(false),
        b'S' => Some(true),
        _ => None,
    }
}
