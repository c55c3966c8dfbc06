//! Reads grey images of the formats PGM (P5, and P2 as plain text) and coloured ones of the formats PPM
//! (P6, and P3 as plain text), after Netpbm's manual pages pgm(5) and ppm(5).

use cave_survey::Refusal;

use super::image::{Image, grey, too_large};
use crate::occupancy::MOST_CELLS;
use crate::open::{line_of, whole};

/// Reads an image, with a remark on bytes that it does not need.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<(Image, Option<String>), Refusal> {
    let mut cursor = Cursor { bytes, at: 2, file };
    let columns = cursor.number("width", 1..=MOST_CELLS)?;
    let rows = cursor.number("height", 1..=MOST_CELLS)?;
    let most = cursor.number("largest value", 1..=65_535)?;
    let Some(count) = Image::count(columns, rows) else {
        return Err(too_large(columns, rows).at(line_of(file, cursor.line())));
    };
    let is_plain = matches!(bytes.get(1), Some(b'2' | b'3'));
    let colours = if matches!(bytes.get(1), Some(b'3' | b'6')) { 3 } else { 1 };
    let count = count * colours;
    let samples = if is_plain { cursor.plain(count, most)? } else { cursor.binary(count, most)? };
    let rest = cursor.bytes.get(cursor.at..).unwrap_or_default();
    let spare = rest.iter().filter(|byte| !byte.is_ascii_whitespace()).count();
    let remark = (spare > 0).then(|| format!("{spare} bytes behind the image are not read"));
    let most = most as u16;
    let pixel = |samples: &[u16]| grey(samples.iter().copied(), false, most);
    let pixels = samples.chunks_exact(colours).map(pixel).collect();
    Ok((Image { columns, most, pixels }, remark))
}

/// A place in the bytes of an image.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    file: &'a str,
}

impl Cursor<'_> {
    fn line(&self) -> usize {
        let before = self.bytes.get(..self.at).unwrap_or_default();
        1 + before.iter().filter(|byte| **byte == b'\n').count()
    }

    fn refusal(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        Refusal::new(wrong, remedy).at(line_of(self.file, self.line()))
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
