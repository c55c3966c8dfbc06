//! The two links of a drone of a chain, as the transitions between its duties need them.

use chain::neighbours::Neighbour;
use chain::search::View;
use units::{Db, Dbm, Phase, Role};

use super::Chain;
use super::search::is_searching;
use crate::AgentConfig;

/// A drone's two links.
#[derive(Clone, Copy, Debug)]
pub(super) struct Links {
    /// The filtered strength of the front link, if there is one.
    pub(super) front: Option<Dbm>,
    /// The filtered strength of the back link, if there is one.
    pub(super) back: Option<Dbm>,
    /// The same, where the base is that neighbour.
    pub(super) base: Option<Dbm>,
    /// The strength of the base where the drone took off.
    pub(super) home_rssi: Option<Dbm>,
    /// Whether the drone in front leaves no room to come nearer.
    pub(super) is_front_near: bool,
    /// Whether the drone behind leaves no room to come nearer.
    pub(super) is_back_near: bool,
    /// Whether a neighbour has left its place to look for a better one.
    pub(super) is_searched: bool,
    /// The same of the neighbour in front.
    pub(super) is_front_searching: bool,
    /// By how much the front link and the back link are stronger than they have to be to stay links
    /// when the drones at their ends are on the ground.
    pub(super) over_ground: [Option<Db>; 2],
    /// Whether the links stay links when the drones at their ends are on the ground.
    pub(super) bear_ground: bool,
}

impl Links {
    /// Both links, as a search needs them.
    pub(super) fn view(&self) -> View {
        let weaker = self.front.zip(self.back).map(|(front, back)| Dbm(front.0.min(back.0)));
        View { weaker, is_front_near: self.is_front_near, is_back_near: self.is_back_near }
    }
}

impl Chain {
    /// The two links of this round.
    pub(super) fn links(&self, config: &AgentConfig, role: Role) -> Links {
        let (front, back) = (self.front(), self.back());
        let limit = config.retreat.limit;
        let over = |n: &Neighbour| config.perch.over(n.rssi(), n.report.phase, limit);
        let over_ground = [front.filter(|_| role != Role::Head), back].map(|end| end.map(over));
        let bears = |over: Option<Db>| over.is_some_and(|over| over >= Db(0.0));
        let [over_front, over_back] = over_ground.map(bears);
        let is_near = |n: &Neighbour| config.policy.is_too_near(n.rssi());
        Links {
            front: front.map(Neighbour::rssi),
            back: back.map(Neighbour::rssi),
            base: back.filter(|n| n.report.phase == Phase::Base).map(Neighbour::rssi),
            home_rssi: self.home_rssi,
            is_front_near: front.is_some_and(is_near),
            is_back_near: back.is_some_and(is_near),
            is_searched: [front, back].into_iter().flatten().any(is_searching),
            is_front_searching: front.is_some_and(is_searching),
            over_ground,
            bear_ground: over_back && (role == Role::Head || over_front),
        }
    }
}
