//! The drawing surface below every picture: writes SVG and keeps the shapes for the PNG.

use std::io;

use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::RGBColor;
use plotters::style::text_anchor::Pos;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind, FontStyle,
};

/// plotters' SVG writer divides font sizes by this.
pub(super) const FONT_SCALE: f64 = 1.24;

/// One thing that was drawn, in units of the sheet.
#[derive(Clone)]
pub(super) struct Shape {
    pub(super) form: Form,
    pub(super) colour: RGBColor,
    /// The opacity, from 0, invisible, to 1.
    pub(super) opacity: f32,
}

/// The style of a shape without its colour.
#[derive(Clone)]
pub(super) enum Form {
    /// A line through points.
    Line { points: Vec<BackendCoord>, width: u32 },
    /// A filled polygon.
    Polygon(Vec<BackendCoord>),
    /// A filled circle.
    Disc { centre: BackendCoord, radius: u32 },
    /// The outline of a circle.
    Ring { centre: BackendCoord, radius: u32, width: u32 },
    /// A line of text, with the height of its font and which of its points is placed.
    Text { text: String, at: BackendCoord, size: f64, bold: bool, anchor: Pos },
}

/// A `plotters` backend of one picture.
pub(super) struct Canvas<'a> {
    svg: SVGBackend<'a>,
    shapes: &'a mut Vec<Shape>,
}

impl<'a> Canvas<'a> {
    /// An empty canvas of this many units that writes into `svg` and `shapes`.
    pub(super) fn new(svg: &'a mut String, shapes: &'a mut Vec<Shape>, size: (u32, u32)) -> Self {
        Self { svg: SVGBackend::with_string(svg, size), shapes }
    }

    fn keep(&mut self, colour: BackendColor, form: Form) {
        let (r, g, b) = colour.rgb;
        if colour.alpha > 0.0 {
            let opacity = colour.alpha as f32;
            self.shapes.push(Shape { form, colour: RGBColor(r, g, b), opacity });
        }
    }
}

type Done = Result<(), DrawingErrorKind<io::Error>>;

impl DrawingBackend for Canvas<'_> {
    type ErrorType = io::Error;

    fn get_size(&self) -> (u32, u32) {
        self.svg.get_size()
    }

    fn ensure_prepared(&mut self) -> Done {
        self.svg.ensure_prepared()
    }

    fn present(&mut self) -> Done {
        self.svg.present()
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Done {
        let corners = vec![(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        self.keep(colour, Form::Polygon(corners));
        self.svg.draw_pixel((x, y), colour)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Done {
        let line = Form::Line { points: vec![from, to], width: style.stroke_width() };
        self.keep(style.color(), line);
        self.svg.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        let ((left, top), (right, bottom)) = (upper_left, bottom_right);
        let mut corners = vec![(left, top), (right, top), (right, bottom), (left, bottom)];
        let form = if fill {
            Form::Polygon(corners)
        } else {
            corners.push(upper_left);
            Form::Line { points: corners, width: style.stroke_width() }
        };
        self.keep(style.color(), form);
        self.svg.draw_rect(upper_left, bottom_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done {
        let points: Vec<_> = path.into_iter().collect();
        self.svg.draw_path(points.iter().copied(), style)?;
        self.keep(style.color(), Form::Line { points, width: style.stroke_width() });
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done {
        let form = if fill {
            Form::Disc { centre, radius }
        } else {
            Form::Ring { centre, radius, width: style.stroke_width() }
        };
        self.keep(style.color(), form);
        self.svg.draw_circle(centre, radius, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Done {
        let corners: Vec<_> = corners.into_iter().collect();
        self.svg.fill_polygon(corners.iter().copied(), style)?;
        self.keep(style.color(), Form::Polygon(corners));
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let form = Form::Text {
            text: text.to_owned(),
            at,
            size: style.size() / FONT_SCALE,
            bold: matches!(style.style(), FontStyle::Bold),
            anchor: style.anchor(),
        };
        self.keep(style.color(), form);
        self.svg.draw_text(text, style, at)
    }
}
