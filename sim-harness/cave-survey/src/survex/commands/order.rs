//! Carries out `*data`, which says what the lines of data hold.

use std::rc::Rc;

use crate::error::Refusal;
use crate::survex::Reader;
use crate::survex::characters::Cursor;
use crate::survex::settings::{DEFAULT_ORDER, Quantity, Reading, Style};

impl Reader<'_> {
    pub(super) fn default_order(&mut self) {
        self.settings.style = Style::Normal;
        self.settings.order = DEFAULT_ORDER.into();
        self.end_passage();
    }

    pub(super) fn order(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        self.end_passage();
        if cursor.is_done(&characters) {
            return Ok(());
        }
        let place = *cursor;
        let word = cursor.keyword(&characters);
        let style = match &*word {
            "default" => {
                self.default_order();
                return Ok(());
            }
            "normal" | "topofil" => Style::Normal,
            "diving" => Style::Diving,
            "cartesian" => Style::Cartesian,
            "cylpolar" => Style::Cylpolar,
            "nosurvey" => Style::NoSurvey,
            "passage" => Style::Passage,
            "ignore" => Style::Ignore,
            _ => {
                let wrong = format!("there is no style of data \"{word}\"");
                return Err(self.wrong(&place, wrong, "give one such as normal or passage"));
            }
        };
        let before = *cursor;
        if self.is_omitted(cursor) {
            self.warn(&before, "the - for a survey's grade is out of use, and passed over");
        }
        let mut order = Vec::new();
        while !cursor.is_done(&characters) && style != Style::Ignore {
            let place = *cursor;
            let word = cursor.keyword(&characters);
            let Some(reading) = reading(&word) else {
                let wrong = format!("there is no reading \"{word}\"");
                return Err(self.wrong(&place, wrong, "correct it, or give ignore for it"));
            };
            if !allows(style, reading) {
                let wrong = format!("style {style:?} has no reading \"{word}\"").to_lowercase();
                return Err(self.wrong(&place, wrong, "remove it, or give another style"));
            }
            let may_repeat = matches!(reading, Reading::Ignore | Reading::IgnoreAll);
            if !may_repeat && order.contains(&reading) {
                let wrong = format!("the reading \"{word}\" is there twice");
                return Err(self.wrong(&place, wrong, "remove one of them"));
            }
            if reading == Reading::Newline && order.is_empty() {
                return Err(self.wrong(&place, "newline is the first reading", "remove it"));
            }
            order.push(reading);
            let ends_line = matches!(reading, Reading::IgnoreAll | Reading::NoteAll);
            if ends_line && !cursor.is_done(&characters) {
                let mut ahead = *cursor;
                if ahead.keyword(&characters) != "newline" {
                    let wrong = format!("{word} is not the last reading");
                    return Err(self.wrong(&place, wrong, "remove what follows"));
                }
            }
        }
        if order.last() == Some(&Reading::Newline) {
            return Err(self.wrong(&place, "newline is the last reading", "remove it"));
        }
        if let Some(missing) = missing(style, &order) {
            let wrong = format!("the order of readings lacks {missing}");
            return Err(self.wrong(&place, wrong, "add it"));
        }
        self.settings.style = style;
        self.settings.order = order.into();
        Ok(())
    }
}

/// The reading of that name, in lower case.
fn reading(name: &str) -> Option<Reading> {
    Some(match name {
        "from" => Reading::From,
        "to" => Reading::To,
        "station" => Reading::Station,
        "direction" => Reading::Direction,
        "fromdepth" => Reading::FromDepth,
        "todepth" => Reading::ToDepth,
        "depth" => Reading::Depth,
        "depthchange" => Reading::DepthChange,
        "fromcount" => Reading::FromCount,
        "tocount" => Reading::ToCount,
        "count" | "counter" => Reading::Count,
        "newline" => Reading::Newline,
        "note" => Reading::Note,
        "noteall" => Reading::NoteAll,
        "ignore" => Reading::Ignore,
        "ignoreall" | "notes" | "remarks" => Reading::IgnoreAll,
        "declination" | "plumb" | "level" | "position" => return None,
        _ => Reading::Value(Quantity::named(name)?),
    })
}

/// Whether lines of this style can hold the reading.
fn allows(style: Style, reading: Reading) -> bool {
    use Quantity::{
        BackBearing, BackGradient, BackLength, Bearing, Down, Dx, Dy, Dz, Gradient, Left,
    };
    use Quantity::{Length, Right, Up};
    let is_tape = matches!(reading, Reading::Value(Length | BackLength));
    let is_count = matches!(reading, Reading::FromCount | Reading::ToCount | Reading::Count);
    let is_compass = matches!(reading, Reading::Value(Bearing | BackBearing));
    let is_clino = matches!(reading, Reading::Value(Gradient | BackGradient));
    let is_depth = matches!(
        reading,
        Reading::FromDepth | Reading::ToDepth | Reading::Depth | Reading::DepthChange
    );
    match reading {
        Reading::Note | Reading::NoteAll => return style != Style::Ignore,
        Reading::Ignore | Reading::IgnoreAll | Reading::Station => return true,
        Reading::From | Reading::To => return style != Style::Passage,
        Reading::Newline => return !matches!(style, Style::Passage | Style::NoSurvey),
        _ => {}
    }
    let is_direction = reading == Reading::Direction;
    match style {
        Style::Normal => is_tape || is_count || is_compass || is_clino || is_direction,
        Style::Diving => is_tape || is_count || is_compass || is_clino || is_depth || is_direction,
        Style::Cylpolar => is_tape || is_count || is_compass || is_depth || is_direction,
        Style::Cartesian => matches!(reading, Reading::Value(Dx | Dy | Dz)) || is_direction,
        Style::Passage => matches!(reading, Reading::Value(Left | Right | Up | Down)),
        Style::NoSurvey | Style::Ignore => false,
    }
}

/// What lines of this style must have and this order lacks.
fn missing(style: Style, order: &[Reading]) -> Option<&'static str> {
    use Quantity::{BackBearing, BackLength, Bearing, Dx, Dy, Dz, Length};
    let has = |reading| order.contains(&reading);
    let value = |quantity| has(Reading::Value(quantity));
    let stations = has(Reading::Station) || has(Reading::From) && has(Reading::To);
    let counts = has(Reading::Count) || has(Reading::FromCount) && has(Reading::ToCount);
    let tape = value(Length) || value(BackLength) || counts;
    let compass = value(Bearing) || value(BackBearing);
    let depths = has(Reading::FromDepth) && has(Reading::ToDepth);
    let depth = has(Reading::Depth) || has(Reading::DepthChange) || depths;
    let needs = match style {
        Style::Ignore => return None,
        Style::NoSurvey => vec![(stations, "the stations")],
        Style::Normal => {
            vec![(stations, "the stations"), (tape, "the tape"), (compass, "the compass")]
        }
        Style::Diving | Style::Cylpolar => vec![
            (stations, "the stations"),
            (tape, "the tape"),
            (compass, "the compass"),
            (depth, "the depth"),
        ],
        Style::Cartesian => vec![
            (stations, "the stations"),
            (value(Dx), "the easting"),
            (value(Dy), "the northing"),
            (value(Dz), "the altitude"),
        ],
        Style::Passage => vec![(has(Reading::Station), "the station")],
    };
    let by_station = [Reading::Station, Reading::Note, Reading::NoteAll];
    let interleaved = order.iter().any(|reading| by_station.contains(reading))
        && matches!(style, Style::Normal | Style::Diving | Style::Cylpolar | Style::Cartesian);
    if interleaved && !has(Reading::Newline) {
        return Some("newline, which data by station needs");
    }
    needs.into_iter().find(|(there, _)| !there).map(|(_, name)| name)
}
