//! Reads the YAML file of a map.

use std::fmt;

use cave_survey::{Refusal, Warning};
use serde::Deserialize;
use serde_saphyr::options;
use serde_saphyr::options::NonFiniteFloatPolicy;

use crate::open::{line_of, whole};

/// The way in which pixels are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Occupied, free or unknown.
    Trinary,
    /// The same, with probabilities between the thresholds.
    Scale,
    /// The pixel is the probability in per cent.
    Raw,
}

/// What the YAML file says of a map.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) image: String,
    /// The line that names the image.
    pub(super) image_line: usize,
    pub(super) resolution_m: f64,
    pub(super) origin: [f64; 3],
    pub(super) occupied_thresh: f64,
    pub(super) free_thresh: f64,
    /// The line that gives it.
    pub(super) free_thresh_line: usize,
    pub(super) negate: bool,
    pub(super) mode: Mode,
}

/// The keys of the file. Keys of other versions are passed over, as map_server does.
#[derive(Deserialize)]
struct Keys {
    image: Option<String>,
    resolution: Option<f64>,
    origin: Option<Vec<Coordinate>>,
    occupied_thresh: Option<f64>,
    free_thresh: Option<f64>,
    negate: Option<Negate>,
    mode: Option<String>,
}

/// A number of the origin, or what stands in its place: `-nan`, which is no number of YAML, is what
/// map_saver writes as the yaw where the SLAM gave it no rotation.
#[derive(Deserialize)]
#[serde(untagged)]
enum Coordinate {
    Number(f64),
    Text(String),
}

impl Coordinate {
    /// Whether it is not a number by its own word: `nan`, `-nan`, `-nan(ind)`, `.NaN`.
    fn is_nan(&self) -> bool {
        match self {
            Self::Number(number) => number.is_nan(),
            Self::Text(text) => {
                let text = text.trim().trim_start_matches(['-', '+', '.']).to_ascii_lowercase();
                text == "nan" || (text.starts_with("nan(") && text.ends_with(')'))
            }
        }
    }

    /// The number; what YAML takes for a text may be one for map_server, such as `"0"`.
    fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => text.trim().parse().ok(),
        }
    }
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) => write!(f, "{text:?}"),
        }
    }
}

/// `negate` is 0 or 1 in ROS 1, and may be a truth value in ROS 2.
#[derive(Deserialize)]
#[serde(untagged)]
enum Negate {
    Truth(bool),
    Number(f64),
}

/// The thresholds that `map_saver` of ROS 1 writes, for a file without them.
const USUAL: (f64, f64) = (0.65, 0.196);

/// What a reader of YAML says is wrong, without the place, which stands before it, and without advice for
/// programmers.
fn said(error: &serde_saphyr::Error) -> String {
    let told = error.to_string();
    let first = told.lines().next().unwrap_or_default();
    let first = first.strip_prefix("error: ").unwrap_or(first);
    let said = match first.strip_prefix("line ").and_then(|rest| rest.split_once(": ")) {
        Some((_, said)) => said,
        None => first,
    };
    said.split(", set ").next().unwrap_or(said).to_owned()
}

impl Header {
    /// Reads the text, with remarks on keys that are missing.
    pub(super) fn read(text: &str, file: &str) -> Result<(Self, Vec<Warning>), Refusal> {
        // A number that is none is judged with its key.
        let options = options! { non_finite_float_policy: NonFiniteFloatPolicy::PassThrough };
        let keys: Keys = serde_saphyr::from_str_with_options(text, options).map_err(|error| {
            let line = error.location().map_or(0, |at| at.line() as usize);
            let wrong = format!("this is no map of map_server: {}", said(&error));
            Refusal::new(wrong, "give the YAML file that map_saver wrote").at(line_of(file, line))
        })?;
        let reader = Reader { text, file };
        let mut remarks = Vec::new();
        let mut usual = |key: Option<f64>, name: &str, usual: f64| match key {
            Some(value) => reader.number(value, name, 0.0..=1.0),
            None => {
                let text = format!("it has no {name}: {usual} is taken");
                remarks.push(Warning { place: Some(whole(file)), text });
                Ok(usual)
            }
        };
        let occupied_thresh = usual(keys.occupied_thresh, "occupied_thresh", USUAL.0)?;
        let free_thresh = usual(keys.free_thresh, "free_thresh", USUAL.1)?;
        if free_thresh > occupied_thresh {
            let wrong =
                format!("free_thresh = {free_thresh} is above occupied_thresh = {occupied_thresh}");
            return Err(reader.refusal("free_thresh", wrong, "exchange them"));
        }
        let image = keys.image.ok_or_else(|| reader.missing("image"))?;
        let resolution_m = reader.number(
            keys.resolution.ok_or_else(|| reader.missing("resolution"))?,
            "resolution",
            0.001..=100.0,
        )?;
        let header = Self {
            image,
            image_line: reader.line("image"),
            resolution_m,
            origin: reader.origin(keys.origin.as_deref(), &mut remarks)?,
            occupied_thresh,
            free_thresh,
            free_thresh_line: reader.line("free_thresh"),
            negate: match keys.negate {
                None => false,
                Some(Negate::Truth(truth)) => truth,
                Some(Negate::Number(number)) => number != 0.0,
            },
            mode: reader.mode(keys.mode.as_deref())?,
        };
        Ok((header, remarks))
    }
}

/// Checks values, and refuses them with the line of their key.
struct Reader<'a> {
    text: &'a str,
    file: &'a str,
}

impl Reader<'_> {
    /// The line on which a key stands; 0 where it is not found at the beginning of one.
    fn line(&self, key: &str) -> usize {
        let stands = |line: &str| {
            let rest = line.trim_start().strip_prefix(key);
            rest.is_some_and(|rest| rest.trim_start().starts_with(':'))
        };
        self.text.lines().position(stands).map_or(0, |line| line + 1)
    }

    fn refusal(&self, key: &str, wrong: String, remedy: impl Into<String>) -> Refusal {
        Refusal::new(wrong, remedy).at(line_of(self.file, self.line(key)))
    }

    fn missing(&self, key: &str) -> Refusal {
        let remedy = "give the YAML file that map_saver wrote";
        Refusal::new(format!("it has no {key}"), remedy).at(whole(self.file))
    }

    fn number(
        &self,
        value: f64,
        key: &str,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f64, Refusal> {
        if range.contains(&value) {
            return Ok(value);
        }
        let remedy = format!("give a number from {} to {}", range.start(), range.end());
        Err(self.refusal(key, format!("{key} = {value} is out of range"), remedy))
    }

    fn origin(
        &self,
        keys: Option<&[Coordinate]>,
        remarks: &mut Vec<Warning>,
    ) -> Result<[f64; 3], Refusal> {
        /// Farther from the origin than this, coordinates in metres are no longer exact, m.
        const FARTHEST: f64 = 1e7;
        let keys = keys.ok_or_else(|| self.missing("origin"))?;
        if !(2..=3).contains(&keys.len()) {
            let wrong = format!("origin has {} numbers", keys.len());
            return Err(self.refusal("origin", wrong, "give [x, y, yaw]"));
        }
        let mut origin = [0.0; 3];
        for ((name, number), key) in ["x", "y", "yaw"].into_iter().zip(&mut origin).zip(keys) {
            if name == "yaw" && key.is_nan() {
                let text = format!("the yaw of the origin is {key}, no number: 0 is taken");
                let place = Some(line_of(self.file, self.line("origin")));
                remarks.push(Warning { place, text });
                continue;
            }
            let found = key.number().filter(|number| number.abs() <= FARTHEST);
            *number = found.ok_or_else(|| {
                let wrong = format!("the {name} of the origin is {key}, which is no place");
                self.refusal("origin", wrong, "give [x, y, yaw] in metres and radians")
            })?;
        }
        Ok(origin)
    }

    fn mode(&self, key: Option<&str>) -> Result<Mode, Refusal> {
        match key.map(str::to_ascii_lowercase).as_deref() {
            None | Some("trinary") => Ok(Mode::Trinary),
            Some("scale") => Ok(Mode::Scale),
            Some("raw") => Ok(Mode::Raw),
            Some(_) => {
                let wrong = format!("there is no mode \"{}\"", key.unwrap_or_default());
                Err(self.refusal("mode", wrong, "give trinary, scale or raw"))
            }
        }
    }
}
