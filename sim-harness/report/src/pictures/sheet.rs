//! The sheet that panels are drawn on, and the picture that it becomes.
//!
//! `plotters` places everything on whole units. A curve snapped to whole pixels looks jagged, so
//! a unit here is a tenth of a pixel: the SVG's view box is ten times its size. [`px`] converts.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, RGBColor, TextStyle};

use super::PictureError;
use super::canvas::{Canvas, FONT_SCALE, Shape};
use super::raster;
use super::style::{INK, PAPER, QUIET};

/// Units to a pixel.
const UNITS: f64 = 10.0;

/// Pixels of the PNG to one of the SVG, for sharp text on sharp screens.
const ZOOM: f64 = 2.0;

/// The built-in font first; then its twin of the same widths where browsers have no DejaVu.
const FONT: FontFamily<'static> = FontFamily::Name("DejaVu Sans, Verdana, sans-serif");

/// A rectangle to draw in.
pub(super) type Area<'a> = DrawingArea<Canvas<'a>, Shift>;
/// The error of a drawing.
pub(super) type Fault = DrawingAreaErrorKind<std::io::Error>;
/// The result of a panel: the frame of each time axis that it drew.
pub(super) type Drawn = Result<Vec<PlotFrame>, Fault>;

/// Pixels in units.
pub(super) fn px(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

/// Widths and radii in units.
pub(super) fn upx(pixels: f64) -> u32 {
    (pixels * UNITS).round().max(0.0) as u32
}

/// A finished picture.
#[derive(Clone)]
pub struct Picture {
    svg: String,
    shapes: Vec<Shape>,
    /// Width and height in units.
    size: (u32, u32),
    frames: Vec<PlotFrame>,
}

/// The place of a time axis on a picture, in pixels from the top left, for cursors drawn over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotFrame {
    /// The left edge, in pixels; here is [`from`](Self::from).
    pub left: f64,
    /// The right edge, in pixels; here is [`to`](Self::to).
    pub right: f64,
    /// The top edge, in pixels.
    pub top: f64,
    /// The bottom edge, in pixels.
    pub bottom: f64,
    /// The time at the left edge, in seconds.
    pub from: f64,
    /// The time at the right edge, in seconds.
    pub to: f64,
}

impl Picture {
    /// Draws on an empty sheet of this many pixels. `title` names the picture for screen readers.
    pub(super) fn draw(
        (width, height): (f64, f64),
        title: &str,
        panel: impl FnOnce(&Area<'_>) -> Drawn,
    ) -> Result<Self, PictureError> {
        let (mut text, mut shapes) = (String::new(), Vec::new());
        let size = (upx(width), upx(height));
        let frames = {
            let root = Canvas::new(&mut text, &mut shapes, size).into_drawing_area();
            root.fill(&PAPER).map_err(PictureError::new)?;
            let frames = panel(&root).map_err(PictureError::new)?;
            root.present().map_err(PictureError::new)?;
            frames
        };
        Ok(Self { svg: with_header(&text, (width, height), title), shapes, size, frames })
    }

    /// The picture as an SVG document.
    #[must_use]
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The picture as a PNG of twice as many pixels.
    ///
    /// # Errors
    /// See [`PictureError`].
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        let scale = ZOOM / UNITS;
        let pixels = |units: u32| (f64::from(units) * scale).ceil() as u32;
        raster::png(&self.shapes, (pixels(self.size.0), pixels(self.size.1)), scale as f32)
    }

    /// The places of the time axes.
    #[must_use]
    pub fn frames(&self) -> &[PlotFrame] {
        &self.frames
    }
}

/// Replaces plotters' opening tag: pixels outside, units inside, a name for screen readers, and
/// round joins so that noise draws no spikes.
fn with_header(svg: &str, (width, height): (f64, f64), title: &str) -> String {
    let body = svg.split_once('\n').map_or(svg, |(_, body)| body);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" stroke-linejoin=\"round\">\n{body}",
        upx(width),
        upx(height),
        escaped(title)
    )
}

/// Text as XML and HTML take it.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML has no way to write the other control characters.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// The style of a text: size in pixels, colour, weight and which of its points is placed.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub(super) size: f64,
    pub(super) colour: RGBColor,
    pub(super) bold: bool,
    pub(super) anchor: (HPos, VPos),
}

impl Look {
    /// The picture's title.
    pub(super) const TITLE: Self =
        Self { size: 16.0, colour: INK, bold: true, anchor: (HPos::Left, VPos::Center) };
    /// A panel's title.
    pub(super) const HEADING: Self = Self { size: 12.0, ..Self::TITLE };
    /// Everything else.
    pub(super) const LABEL: Self = Self { size: 11.0, colour: QUIET, bold: false, ..Self::TITLE };

    pub(super) fn centred(self) -> Self {
        Self { anchor: (HPos::Center, self.anchor.1), ..self }
    }

    pub(super) fn right(self) -> Self {
        Self { anchor: (HPos::Right, self.anchor.1), ..self }
    }

    pub(super) fn coloured(self, colour: RGBColor) -> Self {
        Self { colour, ..self }
    }

    pub(super) fn sized(self, size: f64) -> Self {
        Self { size, ..self }
    }

    /// The style in the type of plotters.
    pub(super) fn style(self) -> TextStyle<'static> {
        let weight = if self.bold { FontStyle::Bold } else { FontStyle::Normal };
        let size = self.size * FONT_SCALE * UNITS;
        let font = FontDesc::new(FONT, size, weight);
        let (h_pos, v_pos) = self.anchor;
        TextStyle { font, color: self.colour.to_backend_color(), pos: Pos::new(h_pos, v_pos) }
    }
}

/// The width of a text in pixels, to the accuracy that placing labels needs.
pub(super) fn text_width(text: &str, look: Look) -> f64 {
    // Advance widths of DejaVu Sans, as shares of its size, by kind of letter.
    let ems: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | '|' | '.' | ',' | ':' | ';' | '\'' | 'I' | '!' => 0.3,
            ' ' | 'f' | 'r' | 't' | '(' | ')' | '-' | '/' => 0.38,
            'm' | 'w' | 'M' | 'W' | '@' | '%' | '\u{2026}' | '\u{2003}' => 0.95,
            'a'..='z' => 0.6,
            _ => 0.65,
        })
        .sum();
    ems * look.size * if look.bold { 1.1 } else { 1.0 }
}

/// Cuts a text to the width, with an ellipsis for the rest.
fn fitted(text: &str, width: f64, look: Look) -> String {
    if text_width(text, look) <= width {
        return text.to_owned();
    }
    let mut short = String::new();
    for c in text.chars() {
        short.push(c);
        if text_width(&short, look) > width - look.size {
            break;
        }
    }
    short.push('\u{2026}');
    short
}

/// Text at this point of the area, in pixels.
pub(super) fn write(
    area: &Area<'_>,
    text: &str,
    (x, y): (f64, f64),
    look: Look,
) -> Result<(), Fault> {
    // SVG allows no control characters, not even escaped.
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    area.draw(&Text::new(clean, (px(x), px(y)), look.style()))
}

/// An area's size in pixels.
pub(super) fn size_of(area: &Area<'_>) -> (f64, f64) {
    let (width, height) = area.dim_in_pixel();
    (f64::from(width) / UNITS, f64::from(height) / UNITS)
}

/// A rectangle within an area: left, top, width, height in pixels.
pub(super) fn part<'a>(
    area: &Area<'a>,
    (left, top): (f64, f64),
    (width, height): (f64, f64),
) -> Area<'a> {
    area.clone().shrink((px(left), px(top)), (upx(width), upx(height)))
}

/// Title and subtitle at the top of a sheet; returns what is left below them.
pub(super) fn headed<'a>(area: &Area<'a>, title: &str, subtitle: &str) -> Result<Area<'a>, Fault> {
    let (width, height) = size_of(area);
    let title = fitted(title, width - 48.0, Look::TITLE);
    let subtitle = fitted(subtitle, width - 48.0, Look::LABEL);
    write(area, &title, (24.0, 26.0), Look::TITLE)?;
    write(area, &subtitle, (24.0, 46.0), Look::LABEL)?;
    Ok(part(area, (24.0, 62.0), (width - 48.0, height - 78.0)))
}
