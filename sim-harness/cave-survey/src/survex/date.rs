//! Reads the dates of surveys.

use crate::earth::Day;

/// What is wrong with a date.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DateError {
    /// It is no date.
    NoDate,
    /// It is none of the calendar, or too long ago; the text says which.
    Odd(&'static str),
    /// The range ends before it begins.
    Backwards,
}

/// Reads `year[.month[.day]]`, or a range of two of these with `-` between them; returns the first
/// and the last day.
pub(crate) fn days(text: &str) -> Result<[Day; 2], DateError> {
    if let Some(day) = iso(text) {
        return Ok([day, day]);
    }
    let (begin, end) = text.split_once('-').unwrap_or((text, text));
    let (begin, end) = (span(begin)?, span(end)?);
    if end[1] < begin[0] {
        return Err(DateError::Backwards);
    }
    Ok([begin[0], end[1]])
}

/// A day such as 2021-06-13, which newer versions of Survex read.
fn iso(text: &str) -> Option<Day> {
    let parts: Vec<&str> = text.split('-').collect();
    let [year, month, day] = parts.as_slice() else { return None };
    if year.len() != 4 {
        return None;
    }
    span(&format!("{year}.{month}.{day}")).ok().map(|[day, _]| day)
}

fn span(text: &str) -> Result<[Day; 2], DateError> {
    let parts: Vec<&str> = text.split('.').collect();
    let number = |part: Option<&&str>| -> Result<Option<u16>, DateError> {
        part.map(|part| part.parse().map_err(|_| DateError::NoDate)).transpose()
    };
    if parts.len() > 3 {
        return Err(DateError::NoDate);
    }
    let year = number(parts.first())?.ok_or(DateError::NoDate)?;
    let (month, day) = (number(parts.get(1))?, number(parts.get(2))?);
    let year = if year < 100 { year + 1900 } else { year };
    if !(1900..=2078).contains(&year) {
        return Err(DateError::Odd("the year is not from 1900 to 2078"));
    }
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days_of = |month| match month {
        2 => 28 + u16::from(leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    if month.is_some_and(|month| !(1..=12).contains(&month)) {
        return Err(DateError::Odd("there is no such month"));
    }
    let last = days_of(month.unwrap_or(12));
    if day.is_some_and(|day| !(1..=last).contains(&day)) {
        return Err(DateError::Odd("there is no such day in that month"));
    }
    let of = |month: u16, day: u16| Day { year, month: month as u8, day: day as u8 };
    let begin = of(month.unwrap_or(1), day.unwrap_or(1));
    Ok([begin, of(month.unwrap_or(12), day.unwrap_or(last))])
}
