//! The width of the passage at each station, from its dimensions, from splays, or assumed.

use cave_survey::{CrossSection, StationId, Survey};

/// The width that is assumed where nothing was measured, m: half as much again as that of the
/// corridors that the paper's drones flew in, which were 1 m wide; cavers do not measure what they
/// can walk through.
pub const ASSUMED_WIDTH: f64 = 1.5;

/// The widest side that counts, m: beyond it a chamber is larger than any beam of a drone sees.
const WIDEST_SIDE: f64 = 8.0;

/// The steepest splay that measures a wall and no ceiling or floor: the tangent of 35°.
const STEEPEST_SPLAY: f64 = 0.7;

/// The passage at a station, seen along a direction, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sides {
    pub(super) left: f64,
    pub(super) right: f64,
    /// From floor to ceiling, where both were measured.
    pub(super) height: Option<f64>,
    /// Whether left and right are assumed.
    pub(super) is_assumed: bool,
}

/// What was measured at each node.
pub(super) struct Widths {
    sections: Vec<Option<CrossSection>>,
    /// The horizontal vectors of the splays that meet walls.
    splays: Vec<Vec<[f64; 2]>>,
}

impl Widths {
    /// Gathers the measurements of a survey of this many nodes.
    pub(super) fn of(survey: &Survey, nodes: usize, node: impl Fn(StationId) -> usize) -> Self {
        let mut sections = vec![None; nodes];
        for section in survey.passages.iter().flatten() {
            let known: &mut Option<CrossSection> = &mut sections[node(section.station)];
            let width = |it: &CrossSection| it.left.unwrap_or(0.0) + it.right.unwrap_or(0.0);
            // Of several passages through a station, the widest is the one that is open there.
            if known.as_ref().is_none_or(|known| width(section) > width(known)) {
                *known = Some(*section);
            }
        }
        let mut splays = vec![Vec::new(); nodes];
        for leg in survey.legs.iter().filter(|leg| leg.flags.splay) {
            let [x, y, z] = survey.vector(leg);
            if z.abs() <= STEEPEST_SPLAY * x.hypot(y) {
                splays[node(leg.from)].push([x, y]);
            }
        }
        Self { sections, splays }
    }

    /// The passage at a node, along a horizontal direction of length 1.
    pub(super) fn at(&self, node: usize, direction: [f64; 2]) -> Sides {
        let section = self.sections.get(node).copied().flatten();
        let height = section.and_then(|it| Some(it.up? + it.down?)).filter(|height| *height > 0.0);
        let measured = section.and_then(|it| Some((it.left?, it.right?)));
        // Zeros on both sides stand for a passage that was not measured: it had a surveyor in it.
        let measured = measured.filter(|(left, right)| left + right > 0.0);
        let sides = measured.or_else(|| self.splayed(node, direction));
        // Where one side alone was measured, the other is assumed.
        let one = |side: fn(&CrossSection) -> Option<f64>| {
            section.as_ref().and_then(side).unwrap_or(ASSUMED_WIDTH / 2.0)
        };
        let (left, right) = sides.unwrap_or_else(|| (one(|it| it.left), one(|it| it.right)));
        let is_zero = left + right <= 0.0;
        let [left, right] = if is_zero { [ASSUMED_WIDTH / 2.0; 2] } else { [left, right] };
        let [left, right] = [left, right].map(|side| side.min(WIDEST_SIDE));
        Sides { left, right, height, is_assumed: sides.is_none() }
    }

    /// The sides by splays: the farthest on each, across the direction.
    fn splayed(&self, node: usize, [x, y]: [f64; 2]) -> Option<(f64, f64)> {
        let splays = self.splays.get(node)?;
        let across = splays.iter().map(|[sx, sy]| x * sy - y * sx);
        let (left, right) =
            across.fold((0.0f64, 0.0f64), |(left, right), side| (left.max(side), right.max(-side)));
        (left > 0.0 && right > 0.0).then_some((left, right))
    }
}
