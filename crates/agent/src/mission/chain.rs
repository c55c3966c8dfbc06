//! The chain mission: a head that explores and relays that keep its link alive, by the U-Chain paper.
//!
//! | module | holds |
//! |---|---|
//! | `duty` | the duties of a drone in the air, and the transitions between them |
//! | `homing` | the way home, and the spot at which the drone lands there |
//! | `links` | the drone's two links, as those transitions need them |
//! | `turn` | which relay on the ground flies next, and which in the air is no longer needed |
//! | `search` | the search of a relay for a better place |
//! | `siting` | the search for a spot at which to land for good |
//! | `speed` | how fast the drone flies along the tunnel at each duty |
//! | `junctions` | which branch the drone takes at junctions |
//! | `relayed` | what the drone's report passes on along the chain |

mod duty;
mod homing;
mod junctions;
mod links;
mod relayed;
mod search;
mod siting;
mod speed;
mod turn;

pub use duty::ChainDuty;

use core::ops::ControlFlow::Continue;

use chain::astray::AstrayWatch;
use chain::chain_wide::ChainWideState;
use chain::edge::EdgeWatch;
use chain::filter::LinkEstimate;
use chain::governor::Governor;
use chain::launch::LaunchWatch;
use chain::neighbours::{Ends, Heard, Neighbour, Neighbours};
use chain::retirement::RetirementWatch;
use chain::route::Route;
use chain::search::SearchWatch;
use tunnel_nav::{Diagonals, SpotSearch};
use units::{Dbm, Duration, LinkSum, Metres, MetresPerSecond, NodeId, Phase};

use super::{Next, Round, Wish};
use crate::{AgentConfig, Inputs, LandReason, LinkView};
use duty::Standing;
use homing::Row;

/// What a drone of a chain knows of the others.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    neighbours: Neighbours,
    /// The drone's two links in this round.
    ends: Ends,
    launch: LaunchWatch,
    /// The head's speed by its links, and its call for a relay.
    governor: Governor,
    /// The edge before which the head, or a relay, is held.
    edge: EdgeWatch,
    search: SearchWatch,
    retirement: RetirementWatch,
    /// Whether the drone was on the ground or climbed in the last round, and no link of the chain.
    was_low: bool,
    /// The strength of the base where this drone took off.
    home_rssi: Option<Dbm>,
    /// The others, as they stand at home.
    row: Row,
    /// The state of the chain-wide policy.
    chain_wide: ChainWideState,
    /// The head's velocity, smoothed at the head and passed on by the relays.
    head_velocity: MetresPerSecond,
    /// The sums over the links towards the head and towards the base, held while a drone searches.
    sums: [LinkSum; 2],
    /// Whether the signal does not fall evenly along the tunnel, as far as this drone has measured
    /// since its take-off or was told by the drone in front.
    is_uneven: bool,
    /// Whether this drone searches.
    is_searching: bool,
    /// Whether this drone flies home because it is not needed.
    is_retiring: bool,
    /// The pilot's choices at junctions.
    route: Route,
    astray: AstrayWatch,
    /// How far in the head was when the pilot began to fly it back.
    backed_from: Option<Metres>,
    /// The way to which this relay flew back last, to take another branch from there.
    came_back_to: Option<Metres>,
    /// How often the drone has flown back to a junction since it heard a drone in front.
    returns: u8,
    /// The place at which a search has ended that was worth it: the drone stays there, as an end of
    /// the chains on either side.
    found: Option<Metres>,
    /// How often the drone has searched anew from a place that it had found.
    renewals: u8,
    /// The search for a spot at which to land, while the drone is siting.
    spot: Option<SpotSearch>,
    /// The side beams of this round, and the height over ground.
    ranges: Diagonals,
    height: Option<Metres>,
    /// The drone's velocity in the last round, and its length.
    velocity: MetresPerSecond,
    dt: Duration,
}

impl Chain {
    /// A drone that has not heard any other.
    pub(crate) const fn new() -> Self {
        Self {
            neighbours: Neighbours::new(),
            ends: Ends::NONE,
            launch: LaunchWatch::new(),
            governor: Governor::new(),
            edge: EdgeWatch::new(),
            search: SearchWatch::new(),
            retirement: RetirementWatch::new(None),
            was_low: true,
            home_rssi: None,
            row: Row::new(),
            chain_wide: ChainWideState::new(),
            head_velocity: MetresPerSecond::ZERO,
            sums: [LinkSum::NONE; 2],
            is_uneven: false,
            is_searching: false,
            is_retiring: false,
            route: Route::new(),
            astray: AstrayWatch::new(),
            backed_from: None,
            came_back_to: None,
            returns: 0,
            found: None,
            renewals: 0,
            spot: None,
            ranges: Diagonals::UNKNOWN,
            height: None,
            velocity: MetresPerSecond::ZERO,
            dt: Duration::ZERO,
        }
    }

    /// Takes in `dt` of motion at `velocity` along the tunnel, and the reports that came in
    /// meanwhile.
    pub(crate) fn listen(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        dt: Duration,
        velocity: MetresPerSecond,
        inputs: &Inputs<'_>,
    ) {
        let heard = inputs.heard;
        (self.ranges, self.height) = (inputs.ranges, inputs.height);
        if self.was_low && !round.phase.is_low() {
            self.neighbours.begin_anew();
        }
        self.was_low = round.phase.is_low();
        self.row.listen(config, round, self.height, heard);
        let smoothing = &config.policy.smoothing;
        let lost_after = config.retreat.lost_after;
        (self.velocity, self.dt) = (velocity, dt);
        let in_air = heard.iter().map(|heard| {
            let lift = config.perch.lift(round.phase, heard.report.phase);
            let reverse = heard.reverse.map(|rssi| rssi + lift);
            let rssi = heard.rssi.map(|rssi| rssi + lift);
            Heard { rssi, reverse, ..*heard }
        });
        self.neighbours.listen(round.id, round.now, (velocity, dt), in_air, smoothing, lost_after);
        self.ends = self.neighbours.ends(round.id, round.now, lost_after);
        if self.home_rssi.is_some() && !self.was_low && round.way() <= config.flight.home {
            self.note_base();
        }
        self.hear_route(round, heard);
        self.is_uneven = !self.was_low && self.has_uneven_links(config);
        self.sums = self.sums(config, round);
        self.chain_wide.listen(self.sums);
        self.head_velocity = self.head_velocity(round);
        self.retirement.follow_head(self.head_velocity * dt);
    }

    /// Notes where the drone takes off.
    pub(crate) fn note_home(&mut self) {
        self.note_base();
        self.retirement = RetirementWatch::new(self.chain_at_launch());
    }

    /// Notes the strength of the base where the drone is, its home.
    fn note_base(&mut self) {
        let base = self.back().filter(|back| back.report.phase == Phase::Base);
        self.home_rssi = base.map(Neighbour::rssi).or(self.home_rssi);
    }

    /// The duty after a round of `duty`, or the landing that ends it.
    pub(crate) fn next_duty(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: ChainDuty,
    ) -> Next<ChainDuty> {
        self.note_stick(round);
        let next = duty.next(&Standing {
            config,
            round,
            links: self.links(config, round.role),
            berth: self.row.berth(round),
            home_since: self.row.home_since(),
            searches: self.searches(config, round, duty),
            retires: self.retires(config, round, duty),
            is_astray: self.is_astray(config, round, duty),
            chosen_anew: self.chosen_anew(round),
            came_back_to: self.came_back_to,
            is_sited: self.is_sited(config, round, duty),
        });
        if let (ChainDuty::Rejoining { to, .. }, Continue(ChainDuty::Leading { .. })) = (duty, next)
        {
            self.note_rejoined(round, to);
        }
        if let (ChainDuty::Rejoining { to, .. }, Continue(ChainDuty::Relaying { .. })) =
            (duty, next)
        {
            self.came_back_to = Some(to);
        }
        next
    }

    /// Where a drone is that lands at home.
    pub(crate) fn settled(&self, round: &Round, why: LandReason) -> Option<Metres> {
        let is_home = matches!(why, LandReason::Home | LandReason::Retired | LandReason::LinkLost);
        is_home.then(|| self.row.settled(round.way()))
    }

    /// How the drone is to fly at a duty of the chain.
    pub(crate) fn wish(&mut self, config: &AgentConfig, round: &Round, duty: ChainDuty) -> Wish {
        let speed = self.speed(config, round, duty);
        let (height, guide) = (config.flight.height, self.guide(config, round, duty));
        match self.siting_command(config, round, duty) {
            Some(command) => Wish::Beside { command, height },
            None => Wish::Along { speed, height, guide },
        }
    }

    fn front(&self) -> Option<&Neighbour> {
        self.neighbours.front(self.ends)
    }

    fn back(&self) -> Option<&Neighbour> {
        self.neighbours.back(self.ends)
    }

    /// The estimates of the links to all drones that were heard.
    pub(crate) fn estimates(&self) -> impl Iterator<Item = (NodeId, LinkEstimate)> {
        self.neighbours.estimates()
    }

    /// Whether the strength of a link to a neighbour is only reckoned.
    pub(crate) fn is_blind(&self) -> bool {
        [self.front(), self.back()].into_iter().flatten().any(Neighbour::is_reckoned)
    }

    /// The links to the neighbours in front and behind, as others may look at them.
    pub(crate) fn views(&self) -> [Option<LinkView>; 2] {
        [self.front(), self.back()].map(|end| end.map(LinkView::of))
    }
}
