//! The grid of a campaign: the values that keys take one after the other, and the part of all
//! missions that one machine flies.

use std::fmt;

use input::InputError;
use toml::Value;

use scenario::{Setting, value_of};

/// A key and the values that it takes. It displays as the option `--vary` has it, with all values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    key: String,
    values: Vec<Value>,
}

/// The most values of one key.
const MOST_VALUES: usize = 10_000;
/// The most places of a grid.
pub const MOST_POINTS: usize = 10_000;

impl Axis {
    /// Makes an axis of these values.
    ///
    /// # Errors
    /// [`InputError`] where there are none, or too many.
    pub fn new(key: impl Into<String>, values: Vec<Value>) -> Result<Self, InputError> {
        let key = key.into();
        if (1..=MOST_VALUES).contains(&values.len()) {
            return Ok(Self { key, values });
        }
        let wrong = format!("{} values", values.len());
        Err(InputError::new(wrong, format!("give 1 to {MOST_VALUES}")).at_key(&key))
    }

    /// Reads `KEY=A:B:N`, N values evenly from A to B, or `KEY=a,b,c`.
    ///
    /// # Errors
    /// [`InputError`] where it is of neither form.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let formless = || {
            let remedy = "give KEY=A:B:N for N values from A to B, or KEY=a,b,c";
            InputError::new("these are no values of a key", remedy).at_key(text)
        };
        let (key, values) = text.split_once('=').ok_or_else(formless)?;
        let (key, values) = (key.trim(), values.trim());
        if key.is_empty() || values.is_empty() {
            return Err(formless());
        }
        let parts: Vec<&str> = values.split(':').collect();
        if let [from, to, count] = parts.as_slice() {
            let count = count.trim().parse().ok().filter(|n| (1..=MOST_VALUES).contains(n));
            let ends = value_of(from.trim()).zip(value_of(to.trim()));
            let even = ends.zip(count).and_then(|((from, to), count)| evenly(&from, &to, count));
            return Self::new(key, even.ok_or_else(formless)?);
        }
        let values = listed(values).into_iter().map(|value| value_of(value.trim()));
        Self::new(key, values.collect::<Option<Vec<_>>>().ok_or_else(formless)?)
    }

    /// The key.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The values.
    #[must_use]
    pub fn values(&self) -> &[Value] {
        &self.values
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<_> = self.values.iter().map(Value::to_string).collect();
        write!(f, "{}={}", self.key, values.join(","))
    }
}

/// So many values evenly from one to the other; whole numbers where all of them are.
fn evenly(from: &Value, to: &Value, count: usize) -> Option<Vec<Value>> {
    let number = |value: &Value| match value {
        Value::Integer(whole) => Some(*whole as f64),
        Value::Float(number) if number.is_finite() => Some(*number),
        _ => None,
    };
    let (first, last) = (number(from)?, number(to)?);
    let steps = count.saturating_sub(1).max(1) as f64;
    // Twelve decimals: 0.6 and not 0.6000000000000001.
    let value =
        |n: usize| format!("{:.12}", first + (last - first) * n as f64 / steps).parse::<f64>().ok();
    let values = (0..count).map(value).collect::<Option<Vec<f64>>>()?;
    let are_whole = matches!((from, to), (Value::Integer(_), Value::Integer(_)))
        && values.iter().all(|value| value.fract() == 0.0);
    let made = |value: f64| match are_whole {
        true => Value::Integer(value as i64),
        false => Value::Float(value),
    };
    Some(values.into_iter().map(made).collect())
}

/// The parts between commas, but for those within brackets.
fn listed(text: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut begin) = (Vec::new(), 0_i32, 0);
    for (at, letter) in text.char_indices() {
        match letter {
            '[' | '{' => depth += 1,
            ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[begin..]);
    parts
}

/// The settings of every place of the grid: the first key varies slowest. Without a key it is one place
/// without settings.
///
/// # Errors
/// [`InputError`] where a key is there twice, or there are too many places.
pub fn points(axes: &[Axis]) -> Result<Vec<Vec<Setting>>, InputError> {
    for (n, axis) in axes.iter().enumerate() {
        if axes[..n].iter().any(|other| other.key == axis.key) {
            let error = InputError::new("this key is varied twice", "give its values at once");
            return Err(error.at_key(&axis.key));
        }
    }
    let count = axes.iter().fold(1_usize, |count, axis| count.saturating_mul(axis.values.len()));
    if count > MOST_POINTS {
        let wrong = format!("the grid has {count} places");
        return Err(InputError::new(
            wrong,
            format!("give keys fewer values: {MOST_POINTS} at most"),
        ));
    }
    let mut points = vec![Vec::new()];
    for axis in axes {
        let with = |point: &Vec<Setting>| {
            let point = point.clone();
            axis.values.iter().map(move |value| {
                let mut point = point.clone();
                point.push(Setting::new(axis.key.clone(), value.clone()));
                point
            })
        };
        points = points.iter().flat_map(with).collect();
    }
    Ok(points)
}

/// One of several parts of a campaign. It displays as `I/N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 1 on.
    pub number: usize,
    /// How many there are.
    pub of: usize,
}

impl Shard {
    /// The whole campaign.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Reads `I/N`.
    ///
    /// # Errors
    /// [`InputError`] where it is not of that form.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let read = text.split_once('/').and_then(|(number, of)| {
            Some(Self { number: number.trim().parse().ok()?, of: of.trim().parse().ok()? })
        });
        read.filter(|it| (1..=1_000_000).contains(&it.of) && (1..=it.of).contains(&it.number))
            .ok_or_else(|| {
                let wrong = format!("\"{text}\" is no part of a campaign");
                InputError::new(wrong, "give --shard I/N, such as 2/8 for the second of eight")
            })
    }

    /// Whether the mission of this number, over all places of the grid, belongs to it.
    #[must_use]
    pub const fn has(self, mission: usize) -> bool {
        mission % self.of == self.number - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> Result<String, String> {
        let axis = Axis::parse(text).map_err(|error| error.to_string())?;
        Ok(axis.to_string())
    }

    #[test]
    fn values_are_even_or_listed() {
        for (text, values) in [
            ("radio.packet_loss=0:0.6:4", "radio.packet_loss=0.0,0.2,0.4,0.6"),
            ("drones.relays=1:5:3", "drones.relays=1,3,5"),
            ("drones.relays=1:2:3", "drones.relays=1.0,1.5,2.0"),
            ("a=3:9:1", "a=3"),
            ("policy.name=t0, k-tuned", "policy.name=\"t0\",\"k-tuned\""),
            ("drones.at_m=[1, 2],[3, 4]", "drones.at_m=[1, 2],[3, 4]"),
        ] {
            assert_eq!(told(text), Ok(values.to_owned()));
        }
        for wrong in
            ["a", "a=", "=1", "a=0:1", "a=0:1:0", "a=0:x:3", "a=0:1:x", "a=[1,2", "a=0:inf:3"]
        {
            let told = told(wrong);
            // Two numbers and a colon are a string, which no number of a scenario takes.
            if wrong == "a=0:1" {
                assert_eq!(told, Ok("a=\"0:1\"".to_owned()));
                continue;
            }
            assert!(told.as_ref().is_err_and(|it| it.lines().count() == 1), "{wrong}: {told:?}");
        }
    }

    #[test]
    fn the_first_key_varies_slowest() {
        let axes = ["a=1,2", "b=x,y,z"].map(|text| Axis::parse(text).unwrap());
        let told = |point: &Vec<Setting>| {
            point.iter().map(Setting::to_string).collect::<Vec<_>>().join(" ")
        };
        let told: Vec<_> = points(&axes).unwrap().iter().map(told).collect();
        assert_eq!(told, ["a=1 b=x", "a=1 b=y", "a=1 b=z", "a=2 b=x", "a=2 b=y", "a=2 b=z"]);
        assert_eq!(points(&[]).unwrap(), [Vec::new()]);
        assert!(points(&[axes[0].clone(), axes[0].clone()]).is_err());
    }

    #[test]
    fn every_mission_is_in_one_part() {
        let parts = [1, 2, 3].map(|number| Shard { number, of: 3 });
        for mission in 0..20 {
            assert_eq!(parts.iter().filter(|part| part.has(mission)).count(), 1);
        }
        for wrong in ["0/3", "4/3", "1", "1/0", "a/b", "1/3/5", "-1/3"] {
            assert!(Shard::parse(wrong).is_err(), "{wrong}");
        }
        assert_eq!(Shard::parse("2/3").unwrap().to_string(), "2/3");
    }
}
