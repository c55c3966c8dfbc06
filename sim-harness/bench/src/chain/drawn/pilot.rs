//! Draws a pilot: how the stick is moved until the mission is called home.

use std::fmt::Write;

use random::Stream;
use units::Branch;

use super::place::{Choice, Place, between};

/// How a pilot moves the stick.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Style {
    /// The stick stays where it is.
    Steady,
    /// Forward for some seconds, then back for fewer.
    ToAndFro { forth_s: f32, back_s: f32 },
    /// Forward for some seconds, then nothing.
    Pausing { forth_s: f32, pause_s: f32 },
}

/// A pilot that was drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pilot {
    style: Style,
    speed: f32,
    /// How long the stick is held forward after there was time enough, s.
    push_s: f32,
    /// Where in the junction of a dead end the pilot turns round, and how far before it the head is
    /// flown back.
    looks_m: f32,
    backs_m: f32,
}

/// The first order, s.
pub(super) const BEGINS_S: f32 = 2.0;
/// The speed at which a pilot looks into a dead end, m/s.
const LOOKS_MPS: f32 = 0.2;
/// The climb and the settling of a head, s, rounded up.
const CLIMBS_S: f32 = 3.0;
/// The shortest time between two orders, s: a scenario's file gives them to this digit.
const SHORTEST_S: f32 = 0.1;

/// The speed and the branch that the pilot orders from a moment on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stick {
    pub(super) at_s: f32,
    pub(super) speed: f32,
    pub(super) branch: Option<Branch>,
}

impl Pilot {
    /// Draws a pilot with a speed between these, m/s, who pushes on for no longer than this, s.
    pub(super) fn draw(random: &mut Stream, [slowest, fastest]: [f32; 2], pushes_s: f32) -> Self {
        let speed = match random.uniform() {
            u if u < 0.25 => slowest,
            u if u < 0.50 => fastest,
            _ => between(random, slowest, fastest),
        };
        let forth_s = between(random, 8.0, 25.0);
        let style = match random.uniform() {
            u if u < 0.5 => Style::Steady,
            u if u < 0.75 => {
                let back_s = between(random, 0.15, 0.45) * forth_s;
                Style::ToAndFro { forth_s, back_s }
            }
            _ => Style::Pausing { forth_s, pause_s: between(random, 2.0, 15.0) },
        };
        let pushes = random.uniform() < 0.6;
        let push_s = if pushes { between(random, 0.2, 1.0) * pushes_s } else { 0.0 };
        Self {
            style,
            speed: (speed * 100.0).round() / 100.0,
            push_s,
            looks_m: between(random, 1.0, 3.0),
            backs_m: between(random, -0.3, 1.2),
        }
    }

    /// The metres that the stick asks for in a second, in the mean.
    pub(super) fn pace(&self) -> f32 {
        self.speed
            * match self.style {
                Style::Steady => 1.0,
                Style::ToAndFro { forth_s, back_s } => (forth_s - back_s) / (forth_s + back_s),
                Style::Pausing { forth_s, pause_s } => forth_s / (forth_s + pause_s),
            }
    }

    /// The orders that look into the dead end first, where the place has one, and the moment from
    /// which on the way leads on.
    pub(super) fn detour(&self, place: &Place, row_m: f32) -> (Vec<Stick>, f32) {
        let (Choice::Changed { first, .. }, Some(end)) = (place.choice, place.dead_ends.first())
        else {
            return (Vec::new(), BEGINS_S);
        };
        let branch = Some(first);
        let into = self.looks_m.min(end.length() - 1.0);
        let inwards = BEGINS_S + CLIMBS_S + (place.first_bend_m - row_m + into) / LOOKS_MPS;
        let outwards = (into + self.backs_m) / LOOKS_MPS;
        let sticks = vec![
            Stick { at_s: BEGINS_S, speed: LOOKS_MPS, branch },
            Stick { at_s: inwards, speed: 0.0, branch },
            Stick { at_s: inwards + 4.0, speed: -LOOKS_MPS, branch },
        ];
        (sticks, inwards + 4.0 + outwards)
    }

    /// The orders from this moment on until another, s.
    pub(super) fn sticks(&self, branch: Option<Branch>, from: f32, until: f32) -> Vec<Stick> {
        let stick = |at_s, speed| Stick { at_s, speed, branch };
        let mut sticks = vec![stick(from, self.speed)];
        let last = until - self.push_s.max(SHORTEST_S);
        let (forth_s, other_s, other) = match self.style {
            Style::Steady => return sticks,
            Style::ToAndFro { forth_s, back_s } => (forth_s, back_s, -self.speed),
            Style::Pausing { forth_s, pause_s } => (forth_s, pause_s, 0.0),
        };
        let mut at = from + forth_s;
        while at + other_s < last {
            sticks.push(stick(at, other));
            sticks.push(stick(at + other_s, self.speed));
            at += other_s + forth_s;
        }
        sticks
    }

    /// When the exploration ends for an oracle that is as deep as it gets at this moment: half as
    /// much time again, and the push.
    pub(super) fn ends(&self, begins: f32, deepest_at: f32) -> f32 {
        begins + 1.5 * (deepest_at - begins).max(0.0) + 20.0 + self.push_s
    }
}

/// The orders as tables.
pub(super) fn text(sticks: &[Stick], holds_s: f32, returns_s: f32) -> String {
    let mut text = String::new();
    let mut explore = |at: f32, speed: f32, branch: Option<Branch>| {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[[pilot]]\nat_s = {at:.1}\norder = \"explore\"\nspeed_mps = {speed:.2}\n"
        );
        if let Some(branch) = branch {
            let _ = writeln!(text, "branch = \"{}\"", name(branch));
        }
    };
    for stick in sticks {
        explore(stick.at_s, stick.speed, stick.branch);
    }
    explore(holds_s, 0.0, sticks.last().and_then(|stick| stick.branch));
    let _ = write!(text, "\n[[pilot]]\nat_s = {returns_s:.1}\norder = \"return\"\n");
    text
}

const fn name(branch: Branch) -> &'static str {
    match branch {
        Branch::Left => "left",
        Branch::Right => "right",
        Branch::Straight => "straight",
    }
}
