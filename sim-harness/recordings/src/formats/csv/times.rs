//! Reads the times of a table of packets: seconds, as the book has them, or what other programs write
//! into such a column, where it cannot be mistaken.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use units::Instant;

use super::super::instant;
use super::super::table::Table;

/// How the times of a table are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Times {
    /// Seconds from any origin.
    Seconds,
    /// Milliseconds since 1970.
    UnixMilliseconds,
    /// Microseconds since 1970.
    UnixMicroseconds,
    /// Nanoseconds since 1970.
    UnixNanoseconds,
    /// A date and a time of day by ISO 8601.
    Dates,
}

impl Times {
    /// How these times are written. As seconds, a number over 10^11 is later than the year 5138; as
    /// milliseconds, one from there to 10^14 lies between 1973 and 5138, and likewise with the smaller
    /// units. They are taken for that where all numbers of the column are of one size.
    pub(super) fn of<'t, const N: usize>(
        texts: impl Iterator<Item = &'t str>,
        table: &Table<'_, N>,
    ) -> Self {
        let mut found = None;
        for text in texts {
            let own = match table.number(text) {
                Some(number) => Self::of_size(number),
                None if date(text).is_some() => Self::Dates,
                None => continue,
            };
            if *found.get_or_insert(own) != own {
                return Self::Seconds;
            }
        }
        found.unwrap_or(Self::Seconds)
    }

    fn of_size(number: f64) -> Self {
        match number {
            1e11..1e14 => Self::UnixMilliseconds,
            1e14..1e17 => Self::UnixMicroseconds,
            1e17..1e20 => Self::UnixNanoseconds,
            _ => Self::Seconds,
        }
    }

    /// The time that a text names.
    pub(super) fn instant<const N: usize>(
        self,
        text: &str,
        table: &Table<'_, N>,
    ) -> Option<Instant> {
        let parts = match self {
            Self::Dates => return date(text),
            Self::Seconds => 1.0,
            Self::UnixMilliseconds => 1e3,
            Self::UnixMicroseconds => 1e6,
            Self::UnixNanoseconds => 1e9,
        };
        instant(table.number(text)? / parts)
    }

    /// What a time should be, for the error of one that is not.
    pub(super) const fn wanted(self) -> &'static str {
        match self {
            Self::Seconds => "number of seconds",
            Self::Dates => "date like those in other rows",
            _ => "number like those in other rows",
        }
    }

    /// What is said of times that are not in seconds.
    pub(super) const fn remark(self) -> Option<&'static str> {
        match self {
            Self::Seconds => None,
            Self::UnixMilliseconds => Some("its times are taken for milliseconds since 1970"),
            Self::UnixMicroseconds => Some("its times are taken for microseconds since 1970"),
            Self::UnixNanoseconds => Some("its times are taken for nanoseconds since 1970"),
            Self::Dates => Some("its times are dates by ISO 8601, and count as seconds since 1970"),
        }
    }
}

/// The time of a date; one without an offset is taken for universal time, since only differences
/// count.
fn date(text: &str) -> Option<Instant> {
    let text = text.trim();
    let here = || text.parse::<DateTime>().ok()?.to_zoned(TimeZone::UTC).ok();
    let timestamp: Timestamp = match text.parse() {
        Ok(timestamp) => timestamp,
        Err(_) => here()?.timestamp(),
    };
    u64::try_from(timestamp.as_microsecond()).ok().map(Instant::from_micros)
}
