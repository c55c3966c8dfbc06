//! Reads the shots of a survey of Compass.

use super::Reader;
use crate::error::Refusal;
use crate::matrix;
use crate::survex::characters::Cursor;
use crate::survex::measure::{self, Readings, Slope};
use crate::survex::settings::FOOT;
use crate::survey::{CrossSection, LegFlags, StationId, names_squeeze};

/// The size of an angle that is none, degrees: Compass writes −999 where a reading was left out,
/// programs of old 999, and a correction may be added to either.
const NO_ANGLE: f64 = 999.0 - 360.0;

/// A length at or below this is one that was left out, feet.
const NO_LENGTH: f64 = -900.0;

/// A dimension that is one of these was left out, feet, as is a negative one.
const NO_DIMENSION: [f64; 2] = [999.0, 9999.0];

/// The variance of a shot that is not to be adjusted, m²: that of a millimetre, as in `cavern`, so
/// that loops of nothing but such shots close too.
const UNADJUSTED_M2: f64 = 1e-6;

/// The flags of a shot.
#[derive(Clone, Copy, Default)]
struct Flags {
    leg: LegFlags,
    /// Whether the shot is left out.
    is_excluded: bool,
    /// Whether loops leave the shot as it is.
    is_unadjusted: bool,
}

impl Flags {
    /// Reads `#|letters#`; what is not so written is a comment.
    fn read(text: &str) -> Self {
        let inside = text.strip_prefix("#|").and_then(|rest| rest.split_once('#'));
        let letters = inside.map_or("", |(letters, _)| letters);
        if !letters.bytes().all(|letter| letter.is_ascii_uppercase()) {
            let leg = LegFlags { squeeze: names_squeeze(text), ..LegFlags::default() };
            return Self { leg, ..Self::default() };
        }
        let leg = LegFlags {
            // Such a shot is not to be plotted: Compass's help advises it for shots over ground.
            surface: letters.contains('P'),
            duplicate: letters.contains('L'),
            splay: letters.contains('S'),
            dived: false,
            squeeze: names_squeeze(text),
        };
        Self { leg, is_excluded: letters.contains('X'), is_unadjusted: letters.contains('C') }
    }
}

impl Reader<'_> {
    /// Reads `FROM TO LENGTH BEARING INC LEFT UP DOWN RIGHT [AZM2 INC2] [#|flags#] [comment]`.
    pub(super) fn shot(&mut self, mut cursor: Cursor<'_>, declination: f64) -> Result<(), Refusal> {
        let names = [self.name(&mut cursor)?, self.name(&mut cursor)?];
        let numbers = self.numbers(&mut cursor)?;
        let flags = Flags::read(String::from_utf8_lossy(cursor.rest()).trim_start());
        if flags.is_excluded {
            self.last = None;
            return Ok(());
        }
        let [from, to] = names.map(|name| self.draft.station(&name, self.source).0);
        self.dimensions([from, to], &numbers, flags.leg);
        let length = numbers[0];
        if length == Some(0.0) {
            if from != to {
                self.draft.equate(from, to, self.source);
            }
            return Ok(());
        }
        if from == to {
            self.draft.warn(self.source, 0, "the shot leads from a station to itself");
            return Ok(());
        }
        let mut remarks = Vec::new();
        let readings = readings(&numbers);
        let mut measured =
            measure::normal(&readings, &self.header.settings, declination, &mut remarks)
                .map_err(|(wrong, remedy)| self.draft.wrong(self.source, wrong, remedy))?;
        for remark in remarks {
            self.draft.warn(self.source, 0, remark);
        }
        measured.by_depth = self.header.is_dived;
        if flags.is_unadjusted {
            measured.covariance = matrix::diagonal([UNADJUSTED_M2; 3]);
        }
        self.draft.leg(measured.leg([from, to], flags.leg, self.source), false)
    }

    fn name(&self, cursor: &mut Cursor<'_>) -> Result<String, Refusal> {
        let word = String::from_utf8_lossy(cursor.word(&self.characters)).into_owned();
        if word.is_empty() {
            let wrong = "the name of a station is missing";
            return Err(self.draft.wrong(self.source, wrong, "give it"));
        }
        Ok(word)
    }

    fn numbers(&self, cursor: &mut Cursor<'_>) -> Result<[Option<f64>; 9], Refusal> {
        let count = if self.header.has_backsights { 9 } else { 7 };
        let mut numbers = [None; 9];
        for number in numbers.iter_mut().take(count) {
            cursor.skip_blanks(&self.characters);
            let column = cursor.column();
            if let Some(read) = cursor.number(&self.characters) {
                *number = Some(read);
                continue;
            }
            let word = String::from_utf8_lossy(cursor.word(&self.characters)).into_owned();
            let refusal = Refusal::new(
                format!("\"{word}\" is no number, where the line wants {count} after the names"),
                "give it, or -999 where it was not measured",
            );
            return Err(match self.draft.place(self.source, column) {
                Some(place) => refusal.at(place),
                None => refusal,
            });
        }
        cursor.skip_blanks(&self.characters);
        Ok(numbers)
    }

    /// Notes the dimensions of the passage, in the order left, up, down, right.
    fn dimensions(
        &mut self,
        [from, to]: [StationId; 2],
        numbers: &[Option<f64>; 9],
        flags: LegFlags,
    ) {
        let is_none = |size: &f64| *size < 0.0 || NO_DIMENSION.contains(size);
        let [left, up, down, right] =
            [3, 4, 5, 6].map(|n| numbers[n].filter(|size| !is_none(size)).map(|x| x * FOOT));
        let [station, before] = if self.header.is_at_second { [to, from] } else { [from, from] };
        let section = CrossSection { station, left, right, up, down };
        if section.is_measured() {
            let goes_on = self.last == Some(before);
            self.draft.cross_section(section, self.source, goes_on);
        }
        // A splay leads to no station at which the passage goes on.
        if !flags.splay {
            self.last = section.is_measured().then_some(to);
        }
    }
}

/// The readings of a shot, in metres and radians, of its numbers.
fn readings(numbers: &[Option<f64>; 9]) -> Readings {
    let angle = |n: usize| numbers[n].filter(|angle| angle.abs() <= NO_ANGLE);
    let slope = |n: usize| match angle(n) {
        None => Slope::Omitted,
        Some(slope) if slope.abs() == 90.0 => Slope::Plumb { up: slope > 0.0, is_inferred: true },
        Some(slope) => Slope::Angle(slope.to_radians()),
    };
    Readings {
        tape: numbers[0].filter(|length| *length > NO_LENGTH).map(|length| length * FOOT),
        compass: angle(1).map(f64::to_radians),
        clino: slope(2),
        back_compass: angle(7).map(f64::to_radians),
        back_clino: slope(8),
        ..Readings::default()
    }
}
