//! Turns the bearings of a centreline from the compass's north to that of the positions.

use super::Reader;
use super::centreline::North;
use super::words::number;
use crate::earth::{Base, Day};
use crate::matrix;
use crate::survex::date;
use crate::survex::measure::Measured;

/// What is known of the north of a leg.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bearing {
    /// The number of the leg.
    pub(super) leg: usize,
    /// The declination that its centreline gives, or the surveys around it.
    pub(super) given: Option<North>,
    pub(super) date: Option<Day>,
}

/// The declinations of a survey: days and angles in radians, of which those of other days follow.
#[derive(Clone, Debug, Default)]
pub(super) struct Declinations(std::rc::Rc<[(f64, f64)]>);

impl Declinations {
    /// Reads one angle, or angles each behind its date.
    pub(super) fn read(words: &[String], radians: f64) -> Option<Self> {
        if let [one] = words {
            return Some(Self([(0.0, number(one)? * radians)].into()));
        }
        let mut all: Vec<(f64, f64)> = Vec::new();
        for pair in words.chunks(2) {
            let [date, angle] = pair else { return None };
            let [first, last] = date::days(date).ok()?;
            all.push((first.middle(last)?.julian()?.into(), number(angle)? * radians));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(Self(all.into()))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The declination on a day, between those of the days around it; without a day, in the middle of
    /// all.
    pub(super) fn on(&self, day: Option<Day>) -> Option<f64> {
        let (first, last) = (self.0.first()?, self.0.last()?);
        let day = day.and_then(Day::julian).map_or((first.0 + last.0) / 2.0, f64::from);
        let after = self.0.partition_point(|it| it.0 < day);
        let before = after.checked_sub(1).and_then(|before| self.0.get(before));
        Some(match (before, self.0.get(after)) {
            (None, _) => first.1,
            (_, None) => last.1,
            (Some(a), Some(b)) => a.1 + (day - a.0) / (b.0 - a.0) * (b.1 - a.1),
        })
    }
}

impl Reader<'_> {
    /// Turns every leg. Where stations are fixed on the earth, a declination that is not given is that
    /// of the middle of these stations on the day of the survey, and that of the earliest day where a
    /// survey has none, as in Therion.
    pub(super) fn turn_bearings(&mut self) {
        let mut base = self.output.as_ref().and_then(|output| {
            let middle = matrix::scaled(output.sum, 1.0 / output.count.max(1.0));
            Base::new(&output.system, &output.system, middle)
        });
        let earliest = self.bearings.iter().filter_map(|bearing| bearing.date).min();
        if base.is_some()
            && let Some(undated) =
                self.bearings.iter().find(|it| it.given.is_none() && it.date.is_none())
        {
            let source = self.draft.legs.get(undated.leg).map(|leg| leg.source);
            let text = match earliest {
                Some(day) => {
                    format!("the survey has no date: its declination is that of {}", day.year)
                }
                None => "the survey has no date, so that its declination is taken for 0".into(),
            };
            self.draft.warn(source.unwrap_or_default(), 0, text);
        }
        for bearing in std::mem::take(&mut self.bearings) {
            let angle = match (bearing.given, &mut base) {
                (Some(North::Grid(angle)), _) => angle,
                (Some(North::True(angle)), Some(base)) => angle - base.convergence(),
                (Some(North::True(angle)), None) => angle,
                (None, Some(base)) => base.declination(bearing.date.or(earliest)),
                (None, None) => 0.0,
            };
            let Some(leg) = self.draft.legs.get_mut(bearing.leg).filter(|_| angle != 0.0) else {
                continue;
            };
            let measured = Measured {
                vector: leg.vector,
                covariance: leg.covariance,
                length: leg.length,
                by_depth: leg.flags.dived,
            };
            let turned = measured.turned(angle);
            (leg.vector, leg.covariance) = (turned.vector, turned.covariance);
        }
    }
}
