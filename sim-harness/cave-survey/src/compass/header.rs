//! Reads the head of a survey of Compass.

use crate::earth::Day;
use crate::survex::date;
use crate::survex::settings::{FOOT, Infer, Quantity, Settings};

/// What the head of a survey says of its lines.
pub(super) struct Header {
    pub(super) settings: Settings,
    /// The declination that the head gives, rad.
    pub(super) declination: f64,
    pub(super) date: Option<Day>,
    /// Whether lines have backsights after the dimensions.
    pub(super) has_backsights: bool,
    /// Whether dimensions are those at the second station.
    pub(super) is_at_second: bool,
}

impl Default for Header {
    fn default() -> Self {
        let infer = Infer { plumbs: true, equates: true, exports: false };
        let settings = Settings { infer, ..Settings::default() };
        Self { settings, declination: 0.0, date: None, has_backsights: false, is_at_second: false }
    }
}

impl Header {
    /// Reads the line `DECLINATION: d FORMAT: f CORRECTIONS: c b l CORRECTIONS2: c2 b2`. A file
    /// whose loops are closed has the corrections in its readings.
    pub(super) fn read(&mut self, line: &str, has_corrections: bool) {
        // Programs beside Compass leave out the blank behind a colon.
        let line = line.replace(':', ": ");
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |n: usize| words.get(n).and_then(|word| word.parse::<f64>().ok());
        let number = |n: usize| number(n).filter(|x| x.abs() < 1e6).unwrap_or(0.0);
        for (n, word) in words.iter().enumerate() {
            match *word {
                "DECLINATION:" => self.declination = number(n + 1).to_radians(),
                "FORMAT:" => self.format(words.get(n + 1).map_or(&b""[..], |it| it.as_bytes())),
                // Corrections are added, where a zero error is taken away.
                "CORRECTIONS:" if has_corrections => {
                    self.correct(Quantity::Bearing, number(n + 1).to_radians());
                    self.correct(Quantity::BackBearing, number(n + 1).to_radians());
                    self.correct(Quantity::Gradient, number(n + 2).to_radians());
                    self.correct(Quantity::BackGradient, number(n + 2).to_radians());
                    self.correct(Quantity::Length, number(n + 3) * FOOT);
                }
                "CORRECTIONS2:" if has_corrections => {
                    self.correct(Quantity::BackBearing, number(n + 1).to_radians());
                    self.correct(Quantity::BackGradient, number(n + 2).to_radians());
                }
                _ => {}
            }
        }
    }

    fn correct(&mut self, quantity: Quantity, by: f64) {
        self.settings.change(quantity).zero = -by;
    }

    /// Reads the letters of the format: four units, the order of the dimensions, the order of a
    /// shot's readings in three letters or, with those of backsights, in five; then whether there
    /// are backsights, and to which station the dimensions belong. Backsights that are shown
    /// "corrected" (C) stand in the file as they were read.
    fn format(&mut self, letters: &[u8]) {
        let is_long = letters.len() >= 15
            || letters.get(11..13).is_some_and(|pair| pair.iter().all(u8::is_ascii_lowercase));
        let at = if is_long { 13 } else { 11 };
        self.has_backsights = matches!(letters.get(at), Some(b'B' | b'C'));
        self.is_at_second = letters.get(at + 1) == Some(&b'T');
    }
}

/// Reads `month day year …`; a year of two digits is of the 20th century, and the first day of it is
/// what Compass writes where there is no date.
pub(super) fn date(text: &str) -> Option<Day> {
    let mut parts = text.split(|it: char| it.is_whitespace() || it == '/' || it == '-');
    let mut number = || parts.find(|part| !part.is_empty())?.parse::<u16>().ok();
    let (month, day, year) = (number()?, number()?, number()?);
    let year = if year < 100 { year.checked_add(1900)? } else { year };
    if (year, month, day) == (1901, 1, 1) {
        return None;
    }
    date::days(&format!("{year}.{month}.{day}")).ok().map(|[day, _]| day)
}
