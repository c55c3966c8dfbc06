//! The links of one moment, and the key to their colours.

use plotters::element::PathElement;
use units::{MissionKind, NodeId};

use super::axes::stroke;
use super::palette::{SPARE_DB, WEAK_DBM, link_colour};
use super::series::state_name;
use super::sheet::{Area, Fault, Look, px, size_of, text_width, write};
use mission::trace::{DroneFrame, Frame, TeamLink, Trace};

/// The colours of the key, from the weakest to the strongest.
const STEPS: u32 = 6;
/// The width of each of them in the key, in pixels.
const STEP: f64 = 16.0;

/// A link at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Linked {
    /// The places of both ends in the list of nodes.
    pub(super) ends: [usize; 2],
    /// The true strength, dBm.
    pub(super) dbm: f64,
}

/// The links by which all nodes hang together at this moment: in a chain those that the drones keep towards the
/// base, in other missions the strongest between the members.
pub(super) fn links_at(trace: &Trace, frame: &Frame) -> Vec<Linked> {
    if trace.mission != MissionKind::Chain {
        return strongest(&frame.team_links, trace.nodes.len());
    }
    let place = |id: NodeId| trace.nodes.iter().position(|node| node.id == id);
    let is_up = |drone: &DroneFrame| state_name(drone) != "down";
    let link = |(index, drone): (usize, &DroneFrame)| {
        let back = drone.back.filter(|_| is_up(drone))?;
        let peer = place(back.peer)?;
        let dbm = f64::from(back.truth.0);
        let other = frame.drones.get(peer).filter(|other| is_up(other));
        (other.is_some() && dbm.is_finite()).then_some(Linked { ends: [index, peer], dbm })
    };
    frame.drones.iter().enumerate().filter_map(link).collect()
}

/// The links that connect all members that hear one another, so chosen that the weakest of them is as strong as
/// it can be: from the strongest on, each that joins two parts (Kruskal's rule).
fn strongest(links: &[TeamLink], nodes: usize) -> Vec<Linked> {
    let mut sorted: Vec<&TeamLink> = links.iter().collect();
    sorted.sort_by(|one, other| other.strength.0.total_cmp(&one.strength.0));
    let mut part_of: Vec<usize> = (0..nodes).collect();
    let mut chosen = Vec::new();
    for link in sorted {
        let ends = link.ends.map(usize::from);
        let parts = ends.map(|end| part_of.get(end).copied());
        let [Some(kept), Some(joined)] = parts else { continue };
        if kept == joined {
            continue;
        }
        part_of.iter_mut().filter(|part| **part == joined).for_each(|part| *part = kept);
        chosen.push(Linked { ends, dbm: f64::from(link.strength.0) });
    }
    chosen
}

/// Writes what the colours of links mean, at the right end of the foot of a map.
pub(super) fn key(area: &Area<'_>, limit: Option<f64>) -> Result<(), Fault> {
    let (width, height) = size_of(area);
    let weakest = limit.unwrap_or(WEAK_DBM);
    let minus = |dbm: f64| format!("{dbm:.0}").replace('-', "\u{2212}");
    let from = match limit {
        Some(limit) => format!("link of {} dBm, the limit, or less", minus(limit)),
        None => format!("link of {} dBm or less", minus(weakest)),
    };
    let to = format!("{} dBm or more", minus(weakest + SPARE_DB));
    let y = height - 12.0;
    let mut x = width - text_width(&to, Look::LABEL);
    write(area, &to, (x, y), Look::LABEL)?;
    for step in (0..STEPS).rev() {
        x -= STEP;
        let at = f64::from(step) / f64::from(STEPS - 1);
        let colour = link_colour(weakest + at * SPARE_DB, limit);
        let rule = vec![(px(x - 8.0), px(y)), (px(x - 8.0 + STEP), px(y))];
        area.draw(&PathElement::new(rule, stroke(&colour, 3.4)))?;
    }
    write(area, &from, (x - 16.0, y), Look::LABEL.right())
}

#[cfg(test)]
mod tests {
    use units::Dbm;

    use super::*;
    use crate::synthetic;

    #[test]
    fn a_chain_has_a_link_from_each_drone_that_is_up_towards_the_base() {
        let mut trace = synthetic::mission();
        let frame = trace.frames.pop().unwrap();
        let ends: Vec<_> = links_at(&trace, &frame).iter().map(|link| link.ends).collect();
        assert_eq!(ends, [[0, 1], [1, 2], [2, 3], [3, 4]]);
        let mut down = frame.clone();
        down.drones[2].height = 0.0;
        let ends: Vec<_> = links_at(&trace, &down).iter().map(|link| link.ends).collect();
        assert_eq!(ends, [[0, 1], [3, 4]], "relay 2 is down");
    }

    #[test]
    fn the_strongest_links_connect_all_members_and_no_two_twice() {
        let link = |one, other, dbm| TeamLink { ends: [one, other], strength: Dbm(dbm) };
        let all = [link(0, 1, -50.0), link(0, 2, -70.0), link(1, 2, -60.0), link(2, 3, -80.0)];
        let ends: Vec<_> = strongest(&all, 5).iter().map(|link| link.ends).collect();
        assert_eq!(ends, [[0, 1], [1, 2], [2, 3]], "and none to the one that none hears");
    }
}
