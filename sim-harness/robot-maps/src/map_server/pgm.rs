//! Reads grey images of the formats PGM (P5, and P2 as plain text), after Netpbm's manual page pgm(5).

use cave_survey::Refusal;

use crate::occupancy::MOST_CELLS;
use crate::open::{line_of, whole};

/// An image.
pub(super) struct Image {
    /// The number of pixels in a row.
    pub(super) columns: usize,
    /// The value of white; 0 is black.
    most: u16,
    /// The pixels row by row from the upper left one.
    pixels: Vec<u16>,
}

impl Image {
    /// Reads an image, with a remark on bytes that it does not need.
    pub(super) fn read(bytes: &[u8], file: &str) -> Result<(Self, Option<String>), Refusal> {
        let mut cursor = Cursor { bytes, at: 0, file };
        let is_plain = match bytes.get(..2) {
            Some(b"P5") => false,
            Some(b"P2") => true,
            _ => {
                let remedy = "save it as PGM (P5 or P2)";
                return Err(Refusal::new("the image is no PGM", remedy).at(whole(file)));
            }
        };
        cursor.at = 2;
        let columns = cursor.number("width", 1..=MOST_CELLS)?;
        let rows = cursor.number("height", 1..=MOST_CELLS)?;
        let most = cursor.number("largest value", 1..=65_535)?;
        let count = columns.checked_mul(rows).filter(|count| *count <= MOST_CELLS);
        let Some(count) = count else {
            let wrong = format!("the header says {columns} by {rows} pixels");
            let remedy = format!("give an image of at most {MOST_CELLS} pixels");
            return Err(cursor.refusal(wrong, remedy));
        };
        let pixels =
            if is_plain { cursor.plain(count, most)? } else { cursor.binary(count, most)? };
        let rest = cursor.bytes.get(cursor.at..).unwrap_or_default();
        let spare = rest.iter().filter(|byte| !byte.is_ascii_whitespace()).count();
        let remark = (spare > 0).then(|| format!("{spare} bytes behind the image are not read"));
        Ok((Self { columns, most: most as u16, pixels }, remark))
    }

    /// The rows from the lowest one, as brightness from 0 for black to 1 for white.
    pub(super) fn upwards(&self) -> impl Iterator<Item = f64> {
        let rows = self.pixels.chunks_exact(self.columns).rev();
        rows.flatten().map(|pixel| f64::from(*pixel) / f64::from(self.most))
    }
}

/// A place in the bytes of an image.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    file: &'a str,
}

impl Cursor<'_> {
    fn refusal(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        let before = self.bytes.get(..self.at).unwrap_or_default();
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        Refusal::new(wrong, remedy).at(line_of(self.file, line))
    }

    /// Passes over white space and comments, which reach from `#` to the end of a line.
    fn skip(&mut self) {
        let mut comment = false;
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' | b'\r' => comment = false,
                b'#' => comment = true,
                _ if comment || byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.at += 1;
        }
    }

    /// The next number in plain text.
    fn number(
        &mut self,
        name: &str,
        range: std::ops::RangeInclusive<usize>,
    ) -> Result<usize, Refusal> {
        self.skip();
        let digits = self.bytes.get(self.at..).unwrap_or_default();
        let count = digits.iter().take(10).take_while(|byte| byte.is_ascii_digit()).count();
        let number = digits.get(..count).and_then(|it| std::str::from_utf8(it).ok());
        let number = number.and_then(|it| it.parse::<usize>().ok());
        match number.filter(|number| range.contains(number)) {
            Some(number) => {
                self.at += count;
                Ok(number)
            }
            None => {
                let wrong = format!("the image has no {name} here");
                let remedy =
                    format!("give a whole number from {} to {}", range.start(), range.end());
                Err(self.refusal(wrong, remedy))
            }
        }
    }

    fn plain(&mut self, count: usize, most: usize) -> Result<Vec<u16>, Refusal> {
        // Every pixel takes at least a digit and a space.
        if self.bytes.len().saturating_sub(self.at) < 2 * count - 1 {
            return Err(self.short(count));
        }
        let mut pixels = Vec::with_capacity(count);
        for _ in 0..count {
            pixels.push(self.number("pixel", 0..=most)? as u16);
        }
        Ok(pixels)
    }

    fn binary(&mut self, count: usize, most: usize) -> Result<Vec<u16>, Refusal> {
        // One byte of white space ends the header.
        self.at += 1;
        let width = if most > 255 { 2 } else { 1 };
        let end = self.at.saturating_add(count * width);
        let Some(pixels) = self.bytes.get(self.at..end) else {
            return Err(self.short(count * width));
        };
        let value = |pixel: &[u8]| pixel.iter().fold(0, |sum, byte| sum * 256 + usize::from(*byte));
        let pixels = pixels.chunks_exact(width).map(|it| value(it).min(most) as u16).collect();
        self.at = end;
        Ok(pixels)
    }

    fn short(&self, needed: usize) -> Refusal {
        let left = self.bytes.len().saturating_sub(self.at);
        let wrong = format!("the header needs {needed} bytes of pixels, and {left} are left");
        Refusal::new(wrong, "save the image again; it was cut off, or its header is wrong")
            .at(whole(self.file))
    }
}
