//! A cave that a user draws on the page: its galleries as lines from corner to corner, in metres. This module
//! checks them, and writes the scenario whose `[tunnel]` they are.

use serde::{Deserialize, Serialize};
use sim_harness::scenario::{Changes, Scenario};
use units::Point2;
use world::{Gallery, GeometryError, Polyline};

use crate::legs::{Clash, Leg, first_clash, legs};

/// The galleries of a cave as they are drawn.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drawing {
    /// The width of all galleries from wall to wall, m.
    pub width_m: f32,
    /// The corners of each gallery, m. The first corner of the first gallery is the mouth, where the base stands;
    /// every other gallery begins at a corner of one before it.
    pub galleries: Vec<Vec<[f32; 2]>>,
}

/// What is wrong with a drawing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mistake {
    /// One line which says what is wrong and how to mend it.
    pub line: String,
    /// The legs that the line is about: for each, the number of its gallery and its own number in the gallery,
    /// counted from 0.
    pub legs: Vec<[usize; 2]>,
}

impl Mistake {
    fn of(legs: &[[usize; 2]], line: impl Into<String>) -> Self {
        Self { line: line.into(), legs: legs.to_vec() }
    }
}

/// How fast the pilot of the scenario flies the head in, m/s.
const SPEED_MPS: f32 = 0.2;
/// The longest that the pilot flies in, s; the user's own orders may lead farther.
const LONGEST_S: f32 = 300.0;
/// How long the head hovers before the pilot calls all drones home, s.
const HOLD_S: f32 = 40.0;

impl Drawing {
    /// Reads a drawing from JSON; lengths are rounded to the centimetre.
    ///
    /// # Errors
    /// One line for JSON that is no drawing.
    pub fn read(json: &str) -> Result<Self, String> {
        let mut drawing: Self = serde_json::from_str(json)
            .map_err(|error| format!("this is no drawing of galleries: {error}"))?;
        let corners = drawing.galleries.iter_mut().flatten().flatten();
        for length in corners.chain([&mut drawing.width_m]) {
            *length = (*length * 100.0).round() / 100.0;
        }
        Ok(drawing)
    }

    /// The text of a scenario in which a chain flies into the drawn cave; it is a file for `uchain run`.
    ///
    /// # Errors
    /// The first mistake of the drawing.
    pub fn scenario(&self) -> Result<String, Mistake> {
        if self.galleries.first().is_none_or(|main| main.len() < 2) {
            return Err(Mistake::of(
                &[],
                "put the mouth of the cave, and then at least one corner more",
            ));
        }
        let legs = legs(&self.galleries);
        legs.iter().try_for_each(|leg| self.check_length(leg))?;
        self.check_joints()?;
        if let Some((legs, clash)) = first_clash(&legs, self.width_m) {
            return Err(Mistake::of(&legs.map(|leg| leg.number), self.words_for(clash)));
        }
        (0..self.galleries.len()).try_for_each(|number| self.check_walls(number))?;
        let text = self.text();
        // What the simulator itself refuses is told without the line of a text that the user does not see.
        let scenario = Scenario::of_text_with("drawing", &text, &Changes::default());
        scenario.map(|_| text).map_err(|error| Mistake::of(&[], error.without_place().to_string()))
    }

    fn check_length(&self, leg: &Leg) -> Result<(), Mistake> {
        let (length, width) = (leg.length(), self.width_m);
        // Corners are rounded, so that a leg may miss its length by as much.
        if length >= width - 0.01 {
            return Ok(());
        }
        let line = format!(
            "a leg of {length:.1} m is shorter than its gallery is wide ({width} m): move its corner, undo it, or \
             make the gallery narrower"
        );
        Err(Mistake::of(&[leg.number], line))
    }

    fn check_joints(&self) -> Result<(), Mistake> {
        let begins_apart = |(n, gallery): &(usize, &Vec<[f32; 2]>)| {
            *n > 0 && !self.galleries[..*n].iter().flatten().any(|at| gallery.first() == Some(at))
        };
        let apart = self.galleries.iter().enumerate().find(begins_apart);
        apart.map_or(Ok(()), |(n, _)| {
            Err(Mistake::of(&[[n, 0]], "a branch begins at no corner of another gallery: undo it"))
        })
    }

    fn words_for(&self, clash: Clash) -> String {
        let width = self.width_m;
        match clash {
            Clash::Cross => "two legs cross: move a corner, or undo one of them".into(),
            Clash::Angle(degrees) => format!(
                "two legs overlap, since there are {degrees:.0}° between them: make it 30° at least, or undo one of them"
            ),
            Clash::Near(apart) => format!(
                "two legs that are {apart:.1} m apart overlap, since their galleries are {width} m wide: move a \
                 corner, undo one of them, or make the galleries narrower"
            ),
        }
    }

    /// Whether the simulator can build the walls of a gallery.
    fn check_walls(&self, number: usize) -> Result<(), Mistake> {
        let centre_line = points(&self.galleries[number]);
        let gallery = Gallery { name: String::new(), centre_line, width: self.width_m };
        gallery.check(&[]).map_err(|error| match error {
            GeometryError::TooSharp(leg) => Mistake::of(
                &[[number, leg]],
                "a leg is too short for the bends at its ends: make it longer, the bends wider, or the gallery narrower",
            ),
            other => Mistake::of(&[], format!("{other}: undo the last corner")),
        })
    }

    /// The scenario. Its radio and its limits are those of the built-in scenario `demo`.
    fn text(&self) -> String {
        let Self { width_m, galleries } = self;
        let way_m = Polyline::new(points(&galleries[0])).length();
        let hold_at_s = 2.0 + (way_m / SPEED_MPS).min(LONGEST_S).ceil();
        let home_at_s = hold_at_s + HOLD_S;
        // Homing drones wait for each other.
        let duration_s = home_at_s + 2.0 * hold_at_s + 60.0;
        let branch = |corners| {
            format!("[[tunnel.branch]]\nwidth_m = {width_m:?}\ncentre_line_m = {corners:?}\n\n")
        };
        let branches: String = galleries[1..].iter().map(branch).collect();
        format!(
            r#"# A cave that was drawn on the page in the browser.
title = "A chain follows its head into a drawn cave, and comes home"
duration_s = {duration_s:?}

[tunnel]
width_m = {width_m:?}
centre_line_m = {main:?}

{branches}[radio]
loss_at_1m_db = 40.0

[drones]
relays = 4

[launch]
limit_dbm = -68.0
[retreat]
limit_dbm = -76.0

[[pilot]]
at_s = 2.0
order = "explore"
speed_mps = {SPEED_MPS:?}

[[pilot]]
at_s = {hold_at_s:?}
order = "explore"
speed_mps = 0.0

[[pilot]]
at_s = {home_at_s:?}
order = "return"
"#,
            main = galleries[0],
        )
    }
}

fn points(corners: &[[f32; 2]]) -> Vec<Point2> {
    corners.iter().map(|&[x, y]| Point2::new(x, y)).collect()
}
