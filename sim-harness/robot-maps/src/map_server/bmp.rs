//! Reads BMP images of any colours, as map_server does: a pixel is the mean of its colours.

use std::io::Cursor;

use ::image::codecs::bmp::BmpDecoder;
use ::image::{ColorType, ImageDecoder as _, ImageError};
use cave_survey::Refusal;

use super::image::{Image, grey, one_line, too_large};
use crate::open::whole;

pub(super) fn read(bytes: &[u8], file: &str) -> Result<Image, Refusal> {
    let damaged = |error: ImageError| {
        let wrong = format!("the BMP image cannot be read: {}", one_line(&error));
        Refusal::new(wrong, "save it again").at(whole(file))
    };
    let decoder = BmpDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let (columns, rows) = decoder.dimensions();
    let (columns, rows) = (columns as usize, rows as usize);
    let Some(count) = Image::count(columns, rows) else {
        return Err(too_large(columns, rows).at(whole(file)));
    };
    let colours = decoder.color_type();
    let width = usize::from(colours.bytes_per_pixel());
    let mut buffer = vec![0; count * width];
    decoder.read_image(&mut buffer).map_err(damaged)?;
    let has_alpha = colours == ColorType::Rgba8;
    let most = u16::from(u8::MAX);
    let pixel = |bytes: &[u8]| grey(bytes.iter().map(|it| u16::from(*it)), has_alpha, most);
    Ok(Image { columns, most, pixels: buffer.chunks_exact(width).map(pixel).collect() })
}
