//! Shapes to PNG, with the font that comes along and nothing from the machine.

use dejavu::sans;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::PictureError;
use super::canvas::{Form, Shape};

/// Draws shapes on a picture of this many pixels, `scale` pixels to a unit of the shapes.
pub(super) fn png(
    shapes: &[Shape],
    (width, height): (u32, u32),
    scale: f32,
) -> Result<Vec<u8>, PictureError> {
    let fonts = Fonts::new()?;
    let mut pixels =
        Pixmap::new(width, height).ok_or_else(|| PictureError::new("the picture is too large"))?;
    for shape in shapes {
        draw(&mut pixels, shape, &fonts, Transform::from_scale(scale, scale));
    }
    pixels.encode_png().map_err(PictureError::new)
}

/// A shape without extent has no path and draws nothing.
fn draw(pixels: &mut Pixmap, shape: &Shape, fonts: &Fonts<'_>, scale: Transform) {
    let path = match &shape.form {
        Form::Line { points, .. } => polyline(points).finish(),
        Form::Polygon(corners) => {
            let mut path = polyline(corners);
            path.close();
            path.finish()
        }
        Form::Disc { centre, radius } | Form::Ring { centre, radius, .. } => {
            PathBuilder::from_circle(centre.0 as f32, centre.1 as f32, *radius as f32)
        }
        Form::Text { text, at, size, bold, anchor } => {
            let face = if *bold { &fonts.bold } else { &fonts.regular };
            written(face, text, (at.0 as f32, at.1 as f32), *size as f32, anchor)
        }
    };
    let Some(path) = path else { return };
    let mut paint = Paint::default();
    paint.set_color_rgba8(
        shape.colour.0,
        shape.colour.1,
        shape.colour.2,
        (shape.opacity * 255.0).round() as u8,
    );
    match shape.form {
        Form::Line { width, .. } | Form::Ring { width, .. } => {
            // Round joins, so that noise draws no spikes.
            let line_join = LineJoin::Round;
            let stroke = Stroke { width: width as f32, line_join, ..Stroke::default() };
            pixels.stroke_path(&path, &paint, &stroke, scale, None);
        }
        Form::Polygon(_) | Form::Disc { .. } | Form::Text { .. } => {
            pixels.fill_path(&path, &paint, FillRule::Winding, scale, None);
        }
    }
}

fn polyline(points: &[(i32, i32)]) -> PathBuilder {
    let mut path = PathBuilder::new();
    for (index, (x, y)) in points.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if index == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    path
}

struct Fonts<'a> {
    regular: Face<'a>,
    bold: Face<'a>,
}

impl Fonts<'static> {
    fn new() -> Result<Self, PictureError> {
        let face = |data| Face::parse(data, 0).map_err(PictureError::new);
        Ok(Self { regular: face(sans::regular())?, bold: face(sans::bold())? })
    }
}

/// The outlines of a line of text in a font of this height, placed as SVG places it.
fn written(
    face: &Face<'_>,
    text: &str,
    (x, y): (f32, f32),
    size: f32,
    anchor: &Pos,
) -> Option<Path> {
    let scale = size / f32::from(face.units_per_em());
    let glyphs: Vec<_> = text.chars().map(|c| face.glyph_index(c).unwrap_or_default()).collect();
    let advances: Vec<_> = advances(face, &glyphs).collect();
    let width = advances.iter().sum::<f32>() * scale;
    let left = match anchor.h_pos {
        HPos::Left => x,
        HPos::Center => x - width / 2.0,
        HPos::Right => x - width,
    };
    // plotters' SVG writer moves the baseline down by these: half an `ex` is a quarter of the size.
    let baseline = match anchor.v_pos {
        VPos::Top => y + 0.76 * size,
        VPos::Center => y + 0.25 * size,
        VPos::Bottom => y - 0.25 * size,
    };
    let mut pen = Pen { path: PathBuilder::new(), x: left, y: baseline, scale };
    for (glyph, advance) in glyphs.iter().zip(advances) {
        face.outline_glyph(*glyph, &mut pen);
        pen.x += advance * scale;
    }
    pen.path.finish()
}

/// The advance from each glyph to the next, kerning included, in units of the font.
fn advances(face: &Face<'_>, glyphs: &[GlyphId]) -> impl Iterator<Item = f32> {
    glyphs.iter().enumerate().map(|(index, glyph)| {
        let own = face.glyph_hor_advance(*glyph).unwrap_or_default();
        let next = glyphs.get(index + 1);
        let kerned = next.and_then(|next| kerning(face, *glyph, *next)).unwrap_or_default();
        f32::from(own) + f32::from(kerned)
    })
}

fn kerning(face: &Face<'_>, left: GlyphId, right: GlyphId) -> Option<i16> {
    let tables = face.tables().kern?.subtables.into_iter();
    tables
        .filter(|table| table.horizontal && !table.has_state_machine)
        .find_map(|table| table.glyphs_kerning(left, right))
}

/// Appends a glyph's outline to a path, at the place and size of the text.
struct Pen {
    path: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Pen {
    /// A font's y axis points up.
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, self.y - y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2)) = (self.place(x1, y1), self.place(x2, y2));
        let (x, y) = self.place(x, y);
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
