//! The pilot's choices at junctions: the head notes them, and every drone follows them.

use chain::astray::{AstrayWatch, Front};
use chain::neighbours::Heard;
use chain::route::{JUNCTION, Route};
use tunnel_nav::{Guide, Homing};
use units::{Branch, Course, Metres, NodeId, Order, Phase, Role};

use super::speed::PAST_ROW;
use super::{Chain, ChainDuty};
use crate::AgentConfig;
use crate::mission::Round;

impl Chain {
    /// Takes in the entries of the list that came with the reports. The first head makes the list.
    pub(super) fn hear_route(&mut self, round: &Round, heard: &[Heard]) {
        if round.role == Role::Base {
            self.forget_route(round);
        }
        if round.id != NodeId::HEAD {
            heard.iter().filter_map(|heard| heard.report.signpost).for_each(|post| {
                self.route.hear(post);
            });
        }
    }

    /// Forgets the list of the last mission on the ground, where the operator lets all drones wait for
    /// the next one.
    pub(super) fn forget_route(&mut self, round: &Round) {
        if round.order() == Some(Order::Wait) {
            self.route = Route::new();
        }
    }

    /// Whether a relay at its `duty` is in another branch than the drone in front: it hears that drone
    /// ever worse, or has flown on for a while without finding it. Where the pilot has made no choice,
    /// the relay does not know of another branch.
    pub(super) fn is_astray(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> bool {
        let front = self.front().map(|front| Front {
            peer: front.report.from,
            rssi: front.rssi(),
            odometer: front.report.odometer,
        });
        let is_lost = match duty {
            ChainDuty::Reconnecting { from, .. } => {
                let may_return = self.returns < MOST_RETURNS;
                front.is_none() && may_return && round.way() - from >= config.astray.alone
            }
            ChainDuty::Relaying { .. } => false,
            _ => {
                self.astray = AstrayWatch::new();
                return false;
            }
        };
        if front.is_some() {
            self.returns = 0;
        }
        if !round.explores() || self.route.branch_at(round.way()).is_none() {
            self.astray = AstrayWatch::new();
            return false;
        }
        let is_astray =
            self.astray.step(&config.astray, round.way(), round.junction, front) || is_lost;
        self.returns += u8::from(is_lost);
        is_astray
    }

    /// How the drone at its `duty` is guided at the junctions near its place.
    pub(crate) fn guide(&mut self, config: &AgentConfig, round: &Round, duty: ChainDuty) -> Guide {
        let branch = self.branch(round, duty);
        let rejoins = matches!(duty, ChainDuty::Rejoining { .. });
        // The wall on the other side than the chosen branch leads out of a wrong one.
        let is_stray = rejoins && round.role == Role::Relay;
        let branch = if is_stray { branch.and_then(opposite) } else { branch };
        let has_company = self.has_company(config, round);
        let is_last = round.role == Role::Head || self.front().is_none();
        let homing = match duty {
            ChainDuty::Homing if is_last => Homing::Last,
            ChainDuty::Homing | ChainDuty::Retiring => Homing::Followed,
            _ => Homing::No,
        };
        let changed_from = self.route.take_change();
        Guide { branch, rejoins, changed_from, has_company, homing }
    }

    /// Whether any drone in the air is too near.
    fn has_company(&self, config: &AgentConfig, round: &Round) -> bool {
        let mut heard = self.neighbours.heard(round.now, config.retreat.lost_after);
        heard.any(|other| {
            let is_up =
                matches!(other.report.phase, Phase::Transit | Phase::Linked | Phase::Searching);
            is_up && config.policy.is_too_near(other.rssi())
        })
    }

    /// Notes how far in the head was when the pilot began to fly it back.
    pub(super) fn note_stick(&mut self, round: &Round) {
        let Some(Order::Explore(Course { speed, branch })) = round.order() else {
            self.backed_from = None;
            return;
        };
        if speed.0 < 0.0 {
            let from = self.backed_from.unwrap_or(round.way());
            self.backed_from = Some(if round.way() > from { round.way() } else { from });
        } else if speed.0 > 0.0 && self.route.branch_at(round.way()) == branch {
            self.backed_from = None;
        }
    }

    /// Where the junction began at which the first head must take another branch than it did: the pilot
    /// has flown it back into that junction, and has changed the choice. From there the head cannot turn
    /// into the other branch.
    pub(super) fn chosen_anew(&self, round: &Round) -> Option<Metres> {
        let Some(Order::Explore(Course { branch: Some(branch), .. })) = round.order() else {
            return None;
        };
        let is_back = self.backed_from.is_some_and(|from| from - round.way() >= BACK);
        let opened = self.route.passed_otherwise(round.way(), branch)?;
        let is_near = round.way() - opened <= JUNCTION && round.way() > Metres::ZERO;
        (round.id == NodeId::HEAD && is_back && is_near).then_some(opened)
    }

    /// Notes that the first head, which was to fly back to `to`, flies on, if the drone behind hovers at
    /// home: it leaves the head no room to come so far, and the pilot's choice counts from there on all the
    /// same. A drone at any other place makes room, and may be in the branch that the head has left.
    pub(super) fn note_rejoined(&mut self, round: &Round, to: Metres) {
        if let Some(Order::Explore(Course { speed, branch })) = round.order()
            && speed.0 > 0.0
            && round.id == NodeId::HEAD
            && self.back().is_some_and(|back| back.report.odometer <= PAST_ROW)
        {
            let way = if round.way() < to { round.way() } else { to };
            self.backed_from = None;
            self.route.lead(way, branch, round.junction);
        }
    }

    /// The branch that the drone takes at the junctions near its place.
    fn branch(&mut self, round: &Round, duty: ChainDuty) -> Option<Branch> {
        // Across a wide gallery, a drone flies from wall to wall on the stretch behind the place at which
        // the choice changes, out and home alike.
        let is_homeward = duty == ChainDuty::Retiring || round.order() == Some(Order::Return);
        let way = if is_homeward { round.way() - ACROSS } else { round.way() };
        let chosen = match round.order() {
            Some(Order::Explore(Course { branch, .. })) if round.role == Role::Head => Some(branch),
            _ => None,
        };
        match (chosen, duty) {
            (Some(branch), ChainDuty::Leading { .. }) if round.id == NodeId::HEAD => {
                self.route.come_back(round.way());
                // The choice counts from before the junction on, to where the head flies back first.
                let flies_back_first = self.chosen_anew(round).is_some();
                if !flies_back_first {
                    self.route.lead(round.way(), branch, round.junction);
                }
            }
            // Another explorer follows the pilot, and leaves the list to the first.
            (Some(Some(branch)), ChainDuty::Leading { .. }) => return Some(branch),
            _ => {}
        }
        self.route.branch_at(way)
    }
}

/// The length of the stretch on which a drone crosses a gallery of 5.2 m, the width of SubT's tunnel
/// tiles, from 0.8 m beside one wall to 0.8 m beside the other: half as long as it is wide, by the speeds
/// of `tunnel-nav`.
const ACROSS: Metres = Metres(1.8);

/// A head that the pilot has flown back by so much looks into another branch next, if it is to take
/// another one.
const BACK: Metres = Metres(0.5);

/// A relay that finds no drone in front flies back to the junction no more often than this: the drone
/// in front may be gone.
const MOST_RETURNS: u8 = 2;

const fn opposite(branch: Branch) -> Option<Branch> {
    match branch {
        Branch::Left => Some(Branch::Right),
        Branch::Right => Some(Branch::Left),
        Branch::Straight => None,
    }
}
