//! The grey image of a map, of any format that is read.

use cave_survey::Refusal;

use super::{bmp, pgm, png};
use crate::occupancy::MOST_CELLS;
use crate::open::whole;

/// How the file begins that stands for one which Git LFS keeps elsewhere (its specification, "The pointer").
const LFS_POINTER: &[u8] = b"version https://git-lfs";

/// An image.
pub(super) struct Image {
    /// The number of pixels in a row.
    pub(super) columns: usize,
    /// The value of white; 0 is black.
    pub(super) most: u16,
    /// The pixels row by row from the upper left one; `None` where one is transparent.
    pub(super) pixels: Vec<Option<u16>>,
}

impl Image {
    /// Reads an image, with a remark on bytes that it does not need.
    pub(super) fn read(bytes: &[u8], file: &str) -> Result<(Self, Option<String>), Refusal> {
        match bytes {
            [b'P', b'2' | b'3' | b'5' | b'6', ..] => pgm::read(bytes, file),
            [0x89, b'P', b'N', b'G', ..] => png::read(bytes, file).map(|image| (image, None)),
            [] => {
                let wrong = "the image is empty";
                Err(Refusal::new(wrong, "copy or save it again").at(whole(file)))
            }
            _ if bytes.starts_with(LFS_POINTER) => {
                let wrong = "this is no image but the pointer that Git LFS leaves in its place";
                Err(Refusal::new(wrong, "fetch the image with git lfs pull").at(whole(file)))
            }
            [b'B', b'M', ..] => bmp::read(bytes, file).map(|image| (image, None)),
            _ => {
                let kind = match bytes {
                    [0xff, 0xd8, ..] => "a JPEG",
                    [b'G', b'I', b'F', ..] => "a GIF",
                    [b'I', b'I', ..] | [b'M', b'M', ..] => "a TIFF",
                    [b'P', b'1' | b'4' | b'7', ..] => "another kind of Netpbm",
                    _ => "none of them",
                };
                let wrong = format!("only PGM, PPM, PNG and BMP are read, and the image is {kind}");
                Err(Refusal::new(wrong, "save it as PGM, PNG or BMP").at(whole(file)))
            }
        }
    }

    /// The number of pixels of an image of this size, if it is not too large.
    pub(super) fn count(columns: usize, rows: usize) -> Option<usize> {
        columns.checked_mul(rows).filter(|count| (1..=MOST_CELLS).contains(count))
    }

    /// The rows from the lowest one, as brightness from 0 for black to 1 for white.
    pub(super) fn upwards(&self) -> impl Iterator<Item = Option<f64>> {
        let rows = self.pixels.chunks_exact(self.columns).rev();
        rows.flatten().map(|pixel| pixel.map(|pixel| f64::from(pixel) / f64::from(self.most)))
    }
}

/// The refusal of an image that is too large.
pub(super) fn too_large(columns: usize, rows: usize) -> Refusal {
    let wrong = format!("the header says {columns} by {rows} pixels");
    Refusal::new(wrong, format!("give an image of at most {MOST_CELLS} pixels"))
}

/// The mean of the colours of a pixel; `None` where it is not quite opaque.
pub(super) fn grey(
    samples: impl ExactSizeIterator<Item = u16>,
    has_alpha: bool,
    most: u16,
) -> Option<u16> {
    let colours = samples.len() - usize::from(has_alpha);
    let (mut sum, mut alpha) = (0, most);
    for (n, sample) in samples.enumerate() {
        if n < colours {
            sum += u32::from(sample);
        } else {
            alpha = sample;
        }
    }
    let mean = u16::try_from(sum / (colours.max(1) as u32)).ok();
    mean.filter(|_| alpha == most)
}

/// What a decoder says, on one line.
pub(super) fn one_line(error: &impl std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
