//! Reads PNG images of any colours and depth, as map_server does: a pixel is the mean of its colours.

use std::io::Cursor;

use cave_survey::Refusal;
use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use super::image::{Image, grey, one_line, too_large};
use crate::open::whole;

/// The most that the decoder sets aside beside the pixels, bytes.
const LARGEST_BUFFER: usize = 64 << 20;

pub(super) fn read(bytes: &[u8], file: &str) -> Result<Image, Refusal> {
    let damaged = |error: DecodingError| {
        let wrong = format!("the PNG image cannot be read: {}", one_line(&error));
        Refusal::new(wrong, "save it again").at(whole(file))
    };
    let limits = Limits { bytes: LARGEST_BUFFER };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    // Palettes and pixels of less than a byte become bytes.
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(damaged)?;
    let (columns, rows) = (info.width as usize, info.height as usize);
    let Some(count) = Image::count(columns, rows) else {
        return Err(too_large(columns, rows).at(whole(file)));
    };
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (colours, depth) = reader.output_color_type();
    let width = colours.samples() * if depth == BitDepth::Sixteen { 2 } else { 1 };
    let mut buffer = vec![0; count * width];
    reader.next_frame(&mut buffer).map_err(damaged)?;
    let has_alpha = matches!(colours, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let most = if depth == BitDepth::Sixteen { u16::MAX } else { u16::from(u8::MAX) };
    let pixel = |bytes: &[u8]| match depth {
        BitDepth::Sixteen => {
            grey(bytes.as_chunks::<2>().0.iter().map(|it| u16::from_be_bytes(*it)), has_alpha, most)
        }
        _ => grey(bytes.iter().map(|it| u16::from(*it)), has_alpha, most),
    };
    Ok(Image { columns, most, pixels: buffer.chunks_exact(width).map(pixel).collect() })
}
