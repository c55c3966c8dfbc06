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
    /// Whether slopes are those of a depth gauge.
    pub(super) is_dived: bool,
}

impl Default for Header {
    fn default() -> Self {
        let infer = Infer { plumbs: true, equates: true, exports: false };
        let settings = Settings { infer, ..Settings::default() };
        Self {
            settings,
            declination: 0.0,
            date: None,
            has_backsights: false,
            is_at_second: false,
            is_dived: false,
        }
    }
}

impl Header {
    /// Reads the line `DECLINATION: d FORMAT: f CORRECTIONS: c b l CORRECTIONS2: c2 b2`. A file
    /// whose loops are closed has the corrections in its readings.
    ///
    /// # Errors
    /// The word that should be a number, or the one before which it is missing.
    pub(super) fn read(&mut self, line: &str, has_corrections: bool) -> Result<(), String> {
        // Programs beside Compass leave out the blank behind a colon.
        let line = line.replace(':', ": ");
        let mut words = line.split_whitespace().peekable();
        while let Some(key) = words.next() {
            let count = match key {
                "DECLINATION:" => 1,
                "CORRECTIONS:" => 3,
                "CORRECTIONS2:" => 2,
                "FORMAT:" => {
                    self.format(words.next().unwrap_or_default().as_bytes());
                    continue;
                }
                _ => continue,
            };
            let mut numbers = [0.0; 3];
            for number in numbers.iter_mut().take(count) {
                // The next key comes early where programs leave out what is 0.
                let Some(word) = words.next_if(|word| !word.ends_with(':')) else { break };
                let read = word.parse::<f64>().ok().filter(|read| read.abs() < 1e6);
                *number = read.ok_or_else(|| word.to_owned())?;
            }
            self.set(key, numbers, has_corrections);
        }
        Ok(())
    }

    /// Sets what the numbers behind a key say. Corrections are added, where a zero error is taken away.
    fn set(&mut self, key: &str, [first, second, third]: [f64; 3], has_corrections: bool) {
        let (bearing, slope) = (first.to_radians(), second.to_radians());
        match key {
            "DECLINATION:" => self.declination = bearing,
            _ if !has_corrections => {}
            "CORRECTIONS:" => {
                self.correct(Quantity::Bearing, bearing);
                self.correct(Quantity::BackBearing, bearing);
                self.correct(Quantity::Gradient, slope);
                self.correct(Quantity::BackGradient, slope);
                self.correct(Quantity::Length, third * FOOT);
            }
            _ => {
                self.correct(Quantity::BackBearing, bearing);
                self.correct(Quantity::BackGradient, slope);
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
        // The fourth letter is the unit of slopes: W is a depth gauge.
        self.is_dived = letters.get(3) == Some(&b'W');
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
