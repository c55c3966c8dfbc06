//! Carries out `data`, which says what the lines of data hold.

use super::Reader;
use super::centreline::DataStyle;
use super::options::quantities;
use crate::error::Refusal;
use crate::survex::settings::{Quantity, Reading};

/// The most readings of a line.
const MOST_READINGS: usize = 100;

impl Reader<'_> {
    pub(super) fn order(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let Some((style, words)) = arguments.split_first() else {
            return Err(self.wrong("data names no style", "give one such as normal"));
        };
        let style = match style.as_str() {
            "normal" | "topofil" => DataStyle::Normal,
            "diving" => DataStyle::Diving,
            "cylpolar" => DataStyle::Cylpolar,
            "cartesian" => DataStyle::Cartesian,
            "nosurvey" => DataStyle::NoSurvey,
            "dimensions" => DataStyle::Dimensions,
            _ => {
                let wrong = format!("there is no style of data \"{style}\"");
                return Err(self.wrong(wrong, "give one such as normal or dimensions"));
            }
        };
        if words.len() > MOST_READINGS {
            return Err(self.wrong("the order has too many readings", "remove some"));
        }
        let mut order = Vec::new();
        for word in words {
            let Some(reading) = reading(word) else {
                let wrong = format!("there is no reading \"{word}\"");
                return Err(self.wrong(wrong, "give one such as from, length or ignore"));
            };
            let may_repeat = matches!(reading, Reading::Ignore | Reading::IgnoreAll);
            if !may_repeat && order.contains(&reading) {
                let wrong = format!("the reading \"{word}\" is there twice");
                return Err(self.wrong(wrong, "remove one of them"));
            }
            order.push(reading);
        }
        if let Some(missing) = missing(style, &order) {
            let wrong = format!("the order of readings lacks {missing}");
            return Err(self.wrong(wrong, "add it"));
        }
        let centreline = self.settings();
        centreline.style = style;
        centreline.order = order.into();
        centreline.traverse = Default::default();
        Ok(())
    }
}

/// The reading of that name.
fn reading(name: &str) -> Option<Reading> {
    Some(match name {
        "station" => Reading::Station,
        "from" => Reading::From,
        "to" => Reading::To,
        "direction" => Reading::Direction,
        "fromdepth" => Reading::FromDepth,
        "todepth" => Reading::ToDepth,
        "depth" => Reading::Depth,
        "depthchange" => Reading::DepthChange,
        "fromcount" | "fromcounter" => Reading::FromCount,
        "tocount" | "tocounter" => Reading::ToCount,
        "count" | "counter" => Reading::Count,
        "newline" => Reading::Newline,
        "ignore" => Reading::Ignore,
        "ignoreall" => Reading::IgnoreAll,
        "dimensions" | "x" | "y" | "z" | "position" | "gps" => return None,
        _ => Reading::Value(*quantities(name).first()?),
    })
}

/// What lines of this style must have and this order lacks.
fn missing(style: DataStyle, order: &[Reading]) -> Option<&'static str> {
    use Quantity::{BackBearing, BackGradient, BackLength, Bearing, Dx, Dy, Dz, Gradient, Length};
    let has = |reading| order.contains(&reading);
    let value = |quantity| has(Reading::Value(quantity));
    let stations = has(Reading::Station) || has(Reading::From) && has(Reading::To);
    let counts = has(Reading::Count) || has(Reading::FromCount) && has(Reading::ToCount);
    let tape = value(Length) || value(BackLength) || counts;
    let compass = value(Bearing) || value(BackBearing);
    let slope = value(Gradient) || value(BackGradient);
    let depths = has(Reading::FromDepth) && has(Reading::ToDepth);
    let depth = has(Reading::Depth) || has(Reading::DepthChange) || depths;
    let first = [(stations, "the stations"), (tape, "the length"), (compass, "the bearing")];
    let needs: Vec<(bool, &str)> = match style {
        DataStyle::Normal => first.into_iter().chain([(slope, "the gradient")]).collect(),
        DataStyle::Diving | DataStyle::Cylpolar => {
            first.into_iter().chain([(depth, "the depth")]).collect()
        }
        DataStyle::Cartesian => vec![
            (stations, "the stations"),
            (value(Dx), "the easting"),
            (value(Dy), "the northing"),
            (value(Dz), "the altitude"),
        ],
        DataStyle::NoSurvey => vec![(stations, "the stations")],
        DataStyle::Dimensions => vec![(has(Reading::Station), "the station")],
    };
    let by_station = [Reading::Station, Reading::Depth, Reading::Count];
    let is_interleaved = style != DataStyle::Dimensions && by_station.into_iter().any(has);
    if is_interleaved && !has(Reading::Newline) && style != DataStyle::NoSurvey {
        return Some("newline, which data by station needs");
    }
    if has(Reading::Newline) && !has(Reading::Station) {
        return Some("the station before newline");
    }
    needs.into_iter().find(|(there, _)| !there).map(|(_, name)| name)
}
