//! The duties of a drone of a chain, and the one function that moves it from one duty to the next.

use core::ops::ControlFlow::{Break, Continue};

use chain::route::{BEFORE, JUNCTION};
use chain::search::{Place, Search};
use units::{Course, Db, Duration, Instant, Metres, Order, Phase, Role};

use super::homing::{Berth, is_home};
use super::links::Links;
use crate::mission::{Next, Round, Task};
use crate::{AgentConfig, LandReason};

/// What a drone of a chain does in the air, at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ChainDuty {
    /// The head flies as the pilot says.
    Leading {
        /// Until then the head bears a weak or missing link.
        patient_until: Instant,
    },
    /// A relay makes its two links equal.
    Relaying {
        /// Until then the relay bears a weak or missing link.
        patient_until: Instant,
    },
    /// A relay that no longer hears a drone in front flies on to find one.
    Reconnecting {
        /// When the relay lost its front neighbour.
        since: Instant,
        /// The odometer at that moment.
        from: Metres,
    },
    /// A relay whose links are too weak looks for a better place.
    Searching {
        /// The search, with the part of it that is done.
        search: Search,
    },
    /// A relay that is no longer needed flies home. The relays in front take it for the end of
    /// their chain, as they take the base.
    Retiring,
    /// The drone was called home, or its base side stayed silent over the whole of a retreat: it flies
    /// home, whatever it hears.
    Homing,
    /// A relay that took another branch than the drone in front flies back to the junction, and so does
    /// a head that the pilot has flown back and that is to take another branch than it did.
    Rejoining {
        /// When it began to fly back.
        since: Instant,
        /// The odometer at which it is before the junction.
        to: Metres,
        /// The way at which the tunnel last opened, if that is not the junction.
        passed: Option<Metres>,
    },
    /// A drone that is to relay from the ground looks for a spot at which to land.
    Siting {
        /// When it began to look.
        since: Instant,
    },
    /// The drone flies back towards a neighbour that it hears too weakly, or not at all.
    BackingUp {
        /// When it began to fly back.
        since: Instant,
        /// The odometer at that moment.
        from: Metres,
    },
}

/// Everything that a transition between duties depends on.
pub(super) struct Standing<'a> {
    pub(super) config: &'a AgentConfig,
    pub(super) round: &'a Round,
    pub(super) links: Links,
    /// What the row at home leaves the drone to do.
    pub(super) berth: Berth,
    /// When its odometer came home, if it is there.
    pub(super) home_since: Option<Instant>,
    /// Whether a relay should look for a better place now.
    pub(super) searches: bool,
    /// Whether the chain no longer needs a relay.
    pub(super) retires: bool,
    /// Whether a relay is in another branch than the drone in front.
    pub(super) is_astray: bool,
    /// Where the junction began at which the head is to take another branch than it did.
    pub(super) chosen_anew: Option<Metres>,
    /// The way to which this relay flew back last, to take another branch from there.
    pub(super) came_back_to: Option<Metres>,
    /// Whether a drone that looks for a spot at which to land is there.
    pub(super) is_sited: bool,
}

impl Standing<'_> {
    /// Whether the operator, or a drone whose battery is needed for its way home, calls the chain home.
    fn is_called_home(&self) -> bool {
        self.round.order() == Some(Order::Return)
    }
}

impl ChainDuty {
    /// The duty of a head or a relay at its place, which bears with its links until `patient_until`.
    pub(crate) const fn at_place(role: Role, patient_until: Instant) -> Self {
        match role {
            Role::Head => Self::Leading { patient_until },
            Role::Relay | Role::Base => Self::Relaying { patient_until },
        }
    }

    /// The duty's name, without its data.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Leading { .. } => "leading",
            Self::Relaying { .. } => "relaying",
            Self::Reconnecting { .. } => "reconnecting",
            Self::Searching { .. } => "searching",
            Self::Retiring => "retiring",
            Self::Homing => "homing",
            Self::Rejoining { .. } => "rejoining",
            Self::Siting { .. } => "siting",
            Self::BackingUp { .. } => "backing-up",
        }
    }

    /// The duty's number on the air, among those of all states.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Leading { .. } => 3,
            Self::Relaying { .. } => 4,
            Self::Reconnecting { .. } => 5,
            Self::BackingUp { .. } => 6,
            Self::Searching { .. } => 10,
            Self::Retiring => 11,
            Self::Rejoining { .. } => 12,
            Self::Siting { .. } => 22,
            Self::Homing => 24,
        }
    }

    /// What the other drones of the mission are told of the duty.
    pub(crate) const fn phase(&self) -> Phase {
        match self {
            Self::Leading { .. }
            | Self::Relaying { .. }
            | Self::Reconnecting { .. }
            | Self::Retiring
            | Self::Homing
            | Self::Rejoining { .. }
            | Self::Siting { .. }
            | Self::BackingUp { .. } => Phase::Linked,
            Self::Searching { .. } => Phase::Searching,
        }
    }

    /// The transition function: the duty after this one's round, or the landing that ends it.
    pub(super) fn next(self, at: &Standing<'_>) -> Next<Self> {
        dismissed(at)?;
        match self {
            Self::Homing => homing(at),
            _ if at.is_called_home() => Continue(Self::Homing),
            Self::Siting { since } => siting(since, at),
            // The drone looks for a spot from where it can relay from the ground.
            _ if at.round.order() == Some(Order::Perch) && at.links.bear_ground => {
                Continue(Self::Siting { since: at.round.now })
            }
            Self::Leading { patient_until } => Continue(leading(patient_until, at)),
            Self::Relaying { patient_until } => Continue(relaying(patient_until, at)),
            Self::Reconnecting { since, from } => Continue(reconnecting(since, from, at)),
            Self::Searching { search } => Continue(searching(search, at)),
            Self::Retiring => retiring(at),
            Self::Rejoining { since, to, passed } => Continue(rejoining(since, to, passed, at)),
            Self::BackingUp { since, from } => backing_up(since, from, at),
        }
    }
}

/// What ends every duty: an order to land, or having come home when called.
fn dismissed(at: &Standing<'_>) -> Next<()> {
    match at.round.order() {
        Some(Order::Land) => Break(LandReason::Ordered),
        Some(Order::Return) if is_home(at) => Break(LandReason::Home),
        _ => Continue(()),
    }
}

/// A drone that no order calls home, but a silent base side, has its place again where it hears that
/// side well.
fn homing(at: &Standing<'_>) -> Next<ChainDuty> {
    if at.is_called_home() {
        Continue(ChainDuty::Homing)
    } else if !at.config.retreat.wanted(at.links.front, at.links.back, true) {
        Continue(ChainDuty::at_place(at.round.role, at.round.now))
    } else if is_home(at) {
        Break(LandReason::LinkLost)
    } else {
        Continue(ChainDuty::Homing)
    }
}

/// Whether links call for a retreat. A drone whose neighbour searches bears a weak one.
fn retreats(at: &Standing<'_>) -> bool {
    let links = &at.links;
    let bears = links.is_searched && links.back.is_some();
    !bears && at.config.retreat.wanted(links.front, links.back, false)
}

/// The duty of a drone that flies back from where it is.
fn backs_up(at: &Standing<'_>) -> ChainDuty {
    ChainDuty::BackingUp { since: at.round.now, from: at.round.way() }
}

fn leading(patient_until: Instant, at: &Standing<'_>) -> ChainDuty {
    if at.round.now >= patient_until && retreats(at) {
        backs_up(at)
    } else if let Some(opened) = at.chosen_anew.filter(|_| is_pushed(at)) {
        ChainDuty::Rejoining { since: at.round.now, to: opened - BEFORE, passed: None }
    } else {
        ChainDuty::Leading { patient_until }
    }
}

/// Whether the pilot pushes the stick forward.
fn is_pushed(at: &Standing<'_>) -> bool {
    let limit = at.config.flight.pilot_timeout;
    at.round.task.is_some_and(|Task { order, given }| {
        let is_forward = matches!(order, Order::Explore(Course { speed, .. }) if speed.0 > 0.0);
        is_forward && at.round.now.since(given) <= limit
    })
}

fn relaying(patient_until: Instant, at: &Standing<'_>) -> ChainDuty {
    let (now, way) = (at.round.now, at.round.way());
    let is_patient = now < patient_until;
    if at.is_astray {
        rejoins(at)
    } else if !is_patient && retreats(at) {
        backs_up(at)
    } else if !is_patient && at.links.front.is_none() {
        ChainDuty::Reconnecting { since: now, from: way }
    } else if at.retires {
        ChainDuty::Retiring
    } else if let (true, Some(weaker)) = (at.searches, at.links.view().weaker) {
        ChainDuty::Searching { search: Search::begin(now, Place { way, weaker }) }
    } else {
        ChainDuty::Relaying { patient_until }
    }
}

fn reconnecting(since: Instant, from: Metres, at: &Standing<'_>) -> ChainDuty {
    if at.is_astray {
        rejoins(at)
    } else if at.config.retreat.wanted(at.links.front, at.links.back, false) {
        backs_up(at)
    } else if at.links.front.is_some() {
        ChainDuty::Relaying { patient_until: at.round.now }
    } else {
        ChainDuty::Reconnecting { since, from }
    }
}

/// The way that a relay flies back at most, m, and the way to an opening that may be the junction.
/// This and the next are our own numbers, for galleries of 1.2 to 1.6 m, tuned in the simulator.
const FARTHEST_BACK: Metres = Metres(12.0);
/// A relay that flies back past the far side of an opening is before it by [`BEFORE`] after so much: the
/// width of a gallery more on either side.
const BEFORE_FAR_SIDE: Metres = Metres(3.6);
/// The time after which a relay no longer flies back: 12 m at 0.2 m/s take 60 s.
const LONGEST_BACK: Duration = Duration::from_secs(75);

/// The duty of a relay that has noticed that it is in a wrong branch: back to the last opening of the
/// tunnel or, where it knows of none, to the next that it sees. One that has come back to the same place
/// before, and has taken the same branch again, flies farther back each time: what it took for the
/// junction's near side was not.
fn rejoins(at: &Standing<'_>) -> ChainDuty {
    let way = at.round.way();
    let near = |opened: &Metres| *opened <= way && way - *opened <= FARTHEST_BACK;
    let (to, passed) = match at.round.junction.filter(near) {
        Some(opened) => {
            let to = opened - BEFORE;
            let again = at.came_back_to.filter(|last| (to - *last).abs() <= JUNCTION);
            let farther = again.map_or(to, |last| last - BEFORE);
            (if farther < to { farther } else { to }, None)
        }
        None => (way - FARTHEST_BACK, Some(at.round.junction.unwrap_or(Metres(f32::INFINITY)))),
    };
    ChainDuty::Rejoining { since: at.round.now, to, passed }
}

/// A drone that is back before the junction flies out again, by the pilot's choice, and so does one that
/// is back where it took off: no junction lies behind that. The head stops as soon as the pilot releases
/// the stick.
fn rejoining(since: Instant, to: Metres, passed: Option<Metres>, at: &Standing<'_>) -> ChainDuty {
    let (now, way) = (at.round.now, at.round.way());
    let is_seen = |opened: &Metres| passed.is_some_and(|passed| passed != *opened);
    let (to, passed) = match at.round.junction.filter(is_seen) {
        Some(opened) => (opened - BEFORE_FAR_SIDE, None),
        None => (to, passed),
    };
    let is_head = at.round.role == Role::Head;
    let is_released = is_head && !is_pushed(at);
    let is_spent = now.since(since) > LONGEST_BACK;
    // Before the junction a relay behind the head, which stands at home, may leave it no room to fly
    // farther back.
    let is_held = is_head && at.links.is_back_near && way <= to + BEFORE;
    let is_back = way <= to || way <= Metres::ZERO || is_held;
    if is_back || is_spent || is_released || !at.round.explores() {
        ChainDuty::at_place(at.round.role, now + at.config.retreat.rest)
    } else {
        ChainDuty::Rejoining { since, to, passed }
    }
}

/// A search ends with an order other than to explore. Of two neighbours that began at once, the one
/// behind goes back.
fn searching(search: Search, at: &Standing<'_>) -> ChainDuty {
    let (now, way) = (at.round.now, at.round.way());
    let relaying = ChainDuty::Relaying { patient_until: now };
    if !at.round.explores() {
        return relaying;
    }
    let search = if at.links.is_front_searching { search.given_up(now) } else { search };
    let next = search.step(&at.config.search, now, way, &at.links.view());
    next.map_or(relaying, |search| ChainDuty::Searching { search })
}

/// A link that becomes weaker than the limit by this much needs the relay again, dB: the standard
/// deviation of a filtered link at rest, twice.
const BORNE: Db = Db(0.5);

/// A relay that flies home stays where it is needed again: where a link is missing or becomes too weak.
fn retiring(at: &Standing<'_>) -> Next<ChainDuty> {
    let least = at.config.launch.limit - BORNE;
    let can_go = at.round.explores()
        && at.links.base.is_some()
        && at.links.front.is_some_and(|front| front >= least);
    if !can_go {
        Continue(ChainDuty::Relaying { patient_until: at.round.now })
    } else if is_home(at) {
        Break(LandReason::Retired)
    } else {
        Continue(ChainDuty::Retiring)
    }
}

/// A drone that is at its spot lands in the first round in which its links bear the loss on the ground.
fn siting(since: Instant, at: &Standing<'_>) -> Next<ChainDuty> {
    let links = &at.links;
    let is_front_lost = at.round.role == Role::Relay && links.front.is_none();
    let is_over = at.round.order() != Some(Order::Perch) || links.back.is_none() || is_front_lost;
    let is_spent = at.round.now.since(since) >= at.config.spot.most_time;
    if at.is_sited && links.bear_ground && !is_over {
        Break(LandReason::Perched)
    } else if is_over || at.is_sited && is_spent {
        Continue(ChainDuty::at_place(at.round.role, at.round.now))
    } else {
        Continue(ChainDuty::Siting { since })
    }
}

fn backing_up(since: Instant, from: Metres, at: &Standing<'_>) -> Next<ChainDuty> {
    let (now, way) = (at.round.now, at.round.way());
    let retreat = &at.config.retreat;
    let is_spent = now.since(since) >= retreat.max_time || from - way >= retreat.max_distance;
    if !retreat.wanted(at.links.front, at.links.back, true) {
        Continue(ChainDuty::at_place(at.round.role, now))
    } else if !is_spent {
        Continue(ChainDuty::BackingUp { since, from })
    } else if at.links.back.is_some() {
        Continue(ChainDuty::at_place(at.round.role, now + retreat.rest))
    } else {
        Continue(ChainDuty::Homing)
    }
}

#[cfg(test)]
mod tests {
    use units::{Dbm, MetresPerSecond, NodeId};

    use super::*;
    use crate::Reckoning;

    const EXPLORE: Order = Order::explore(MetresPerSecond(0.2));
    const NOW: Instant = Instant::from_millis(100_000);
    /// Where the drone is.
    const HERE: Metres = Metres(5.0);
    const CONFIG: AgentConfig = AgentConfig::DEFAULT;

    const GOOD: Links = Links {
        front: Some(Dbm(-50.0)),
        back: Some(Dbm(-50.0)),
        base: Some(Dbm(-50.0)),
        home_rssi: Some(Dbm(-40.0)),
        is_front_near: false,
        is_back_near: false,
        is_searched: false,
        is_front_searching: false,
        over_ground: [None; 2],
        bear_ground: false,
    };
    const AT_HOME: Links = Links { base: Some(Dbm(-40.0)), ..GOOD };
    const WEAK: Dbm = Dbm(-95.0);

    fn search() -> Search {
        Search::begin(NOW, Place { way: HERE, weaker: Dbm(-70.0) })
    }

    fn duties() -> [ChainDuty; 9] {
        [
            ChainDuty::Leading { patient_until: Instant::ZERO },
            ChainDuty::Relaying { patient_until: Instant::ZERO },
            ChainDuty::Reconnecting { since: NOW, from: HERE },
            ChainDuty::Searching { search: search() },
            ChainDuty::Retiring,
            ChainDuty::Rejoining { since: NOW, to: HERE - Metres(1.0), passed: None },
            ChainDuty::Siting { since: NOW },
            ChainDuty::BackingUp { since: NOW, from: HERE },
            ChainDuty::Homing,
        ]
    }

    fn after(duty: ChainDuty, order: Order, links: Links) -> Next<ChainDuty> {
        after_asking(duty, order, links, [false; 2])
    }

    /// The same where the chain asks for a search, or no longer needs the relay.
    fn after_asking(
        duty: ChainDuty,
        order: Order,
        links: Links,
        [searches, retires]: [bool; 2],
    ) -> Next<ChainDuty> {
        let role = if duty.name() == "leading" { Role::Head } else { Role::Relay };
        let task = Some(Task { order, given: NOW });
        let here = Reckoning { odometer: HERE, ..Reckoning::default() };
        let phase = Phase::Linked;
        let round = Round { now: NOW, id: NodeId(1), role, phase, task, here, junction: None };
        duty.next(&Standing {
            config: &CONFIG,
            round: &round,
            links,
            berth: Berth::Unknown,
            home_since: None,
            searches,
            retires,
            is_astray: false,
            chosen_anew: None,
            came_back_to: None,
            is_sited: false,
        })
    }

    /// A drone with these links, of which nothing else is known.
    fn standing<'a>(round: &'a Round, links: Links) -> Standing<'a> {
        Standing {
            config: &CONFIG,
            round,
            links,
            berth: Berth::Unknown,
            home_since: None,
            searches: false,
            retires: false,
            is_astray: false,
            chosen_anew: None,
            came_back_to: None,
            is_sited: false,
        }
    }

    /// The duty, or the landing, after the round in which a siting drone has come to its spot.
    fn after_siting(since: Instant, order: Order, links: Links) -> Next<ChainDuty> {
        let task = Some(Task { order, given: NOW });
        let (role, phase, here) = (Role::Relay, Phase::Linked, Reckoning::default());
        let round = Round { now: NOW, id: NodeId(1), role, phase, task, here, junction: None };
        let standing = Standing { is_sited: true, ..standing(&round, links) };
        ChainDuty::Siting { since }.next(&standing)
    }

    #[test]
    fn a_relay_that_took_the_wrong_branch_again_flies_farther_back() {
        let to = |came_back_to: Option<Metres>| {
            let here = Reckoning { odometer: Metres(9.0), ..Reckoning::default() };
            let task = Some(Task { order: EXPLORE, given: NOW });
            let (id, role, phase) = (NodeId(1), Role::Relay, Phase::Linked);
            let junction = Some(Metres(7.0));
            let round = Round { now: NOW, id, role, phase, task, here, junction };
            let standing = Standing { is_astray: true, came_back_to, ..standing(&round, GOOD) };
            let duty = ChainDuty::Relaying { patient_until: NOW };
            match duty.next(&standing) {
                Continue(ChainDuty::Rejoining { to, .. }) => to,
                other => panic!("{other:?}"),
            }
        };
        let first = to(None);
        assert_eq!(first, Metres(7.0) - BEFORE);
        assert_eq!(to(Some(first)), first - BEFORE);
        assert_eq!(to(Some(first - BEFORE)), first - BEFORE - BEFORE);
        assert_eq!(to(Some(Metres(1.0))), first, "that was another junction");
    }

    #[test]
    fn a_head_that_a_relay_behind_it_holds_before_the_junction_flies_out_again() {
        let duty = ChainDuty::Rejoining { since: NOW, to: Metres(1.0), passed: None };
        let name_after = |role: Role, way: f32, is_back_near: bool| {
            let here = Reckoning { odometer: Metres(way), ..Reckoning::default() };
            let task = Some(Task { order: EXPLORE, given: NOW });
            let (id, phase) = (NodeId(0), Phase::Linked);
            let round = Round { now: NOW, id, role, phase, task, here, junction: None };
            let next = duty.next(&standing(&round, Links { is_back_near, ..GOOD }));
            next.continue_value().map(|duty| duty.name())
        };
        assert_eq!(name_after(Role::Head, 2.0, true), Some("leading"));
        assert_eq!(name_after(Role::Head, 2.0, false), Some("rejoining"));
        assert_eq!(name_after(Role::Head, 1.0 + BEFORE.0 + 0.1, true), Some("rejoining"));
        assert_eq!(name_after(Role::Relay, 2.0, true), Some("rejoining"), "relays wait");
    }

    const RELAYING: Next<ChainDuty> = Continue(ChainDuty::Relaying { patient_until: NOW });

    #[test]
    fn every_duty_ends_by_an_order_to_land_and_at_home_when_called_there() {
        for duty in duties() {
            assert_eq!(after(duty, Order::Land, GOOD), Break(LandReason::Ordered));
            assert_eq!(after(duty, Order::Return, AT_HOME), Break(LandReason::Home));
            assert!(after(duty, Order::Return, GOOD).is_continue(), "away from home");
        }
    }

    #[test]
    fn names_and_codes_are_of_one_duty_each() {
        let duties = duties();
        for (n, one) in duties.iter().enumerate() {
            for other in duties.iter().skip(n + 1) {
                assert_ne!(one.name(), other.name());
                assert_ne!(one.code(), other.code());
            }
        }
    }

    #[test]
    fn a_relay_searches_when_the_chain_asks_it_to_and_retires_rather() {
        let [_, relaying, ..] = duties();
        let weaker = Dbm(-50.0);
        let search = Search::begin(NOW, Place { way: HERE, weaker });
        let after = |asks| after_asking(relaying, EXPLORE, GOOD, asks);
        assert_eq!(after([true, false]), Continue(ChainDuty::Searching { search }));
        assert_eq!(after([true, true]), Continue(ChainDuty::Retiring));
        assert_eq!(after([false, false]), Continue(relaying));
    }

    #[test]
    fn a_search_ends_with_the_order_to_explore_and_gives_way_to_the_neighbour_in_front() {
        let searching = ChainDuty::Searching { search: search() };
        assert_eq!(after(searching, Order::Return, GOOD), Continue(ChainDuty::Homing));
        assert_eq!(after(searching, Order::Wait, GOOD), RELAYING);
        let links = Links { is_searched: true, is_front_searching: true, ..GOOD };
        assert_eq!(after(searching, EXPLORE, links), RELAYING, "it has not left its place yet");
        let away = Place { way: HERE - Metres(3.0), weaker: Dbm(-70.0) };
        let searching = ChainDuty::Searching { search: Search::begin(NOW, away) };
        let given_up = Search::begin(NOW, away).given_up(NOW);
        let goes_back = Continue(ChainDuty::Searching { search: given_up });
        assert_eq!(after(searching, EXPLORE, links), goes_back);
    }

    #[test]
    fn a_relay_that_is_not_needed_flies_home_and_stays_where_it_is_needed_again() {
        let retires = |links| after(ChainDuty::Retiring, EXPLORE, links);
        assert_eq!(retires(GOOD), Continue(ChainDuty::Retiring));
        assert_eq!(retires(AT_HOME), Break(LandReason::Retired));
        assert_eq!(retires(Links { front: Some(WEAK), ..GOOD }), RELAYING);
        assert_eq!(retires(Links { front: None, ..GOOD }), RELAYING);
        assert_eq!(retires(Links { base: None, ..GOOD }), RELAYING);
        assert_eq!(after(ChainDuty::Retiring, Order::Wait, GOOD), RELAYING);
    }

    #[test]
    fn a_drone_whose_neighbour_searches_bears_a_weak_link_but_not_a_lost_one() {
        let [leading, ..] = duties();
        let weak = Links { back: Some(WEAK), base: None, ..GOOD };
        let backs_up = Continue(ChainDuty::BackingUp { since: NOW, from: HERE });
        assert_eq!(after(leading, EXPLORE, weak), backs_up);
        let searched = Links { is_searched: true, ..weak };
        assert_eq!(after(leading, EXPLORE, searched), Continue(leading));
        assert_eq!(after(leading, EXPLORE, Links { back: None, ..searched }), backs_up);
    }

    #[test]
    fn a_drone_that_is_to_perch_looks_for_a_spot_and_lands_there() {
        let [_, relaying, ..] = duties();
        let bears = Links { bear_ground: true, ..GOOD };
        let siting = Continue(ChainDuty::Siting { since: NOW });
        assert_eq!(after(relaying, Order::Perch, bears), siting);
        assert_eq!(
            after(relaying, Order::Perch, GOOD),
            Continue(relaying),
            "on weak links it stays up"
        );
        assert_eq!(after(ChainDuty::Siting { since: NOW }, Order::Perch, bears), siting);
        assert_eq!(after_siting(NOW, Order::Perch, bears), Break(LandReason::Perched));
        assert_eq!(after_siting(NOW, Order::Perch, GOOD), siting, "it waits for its links");
        assert_eq!(after_siting(Instant::ZERO, Order::Perch, GOOD), RELAYING, "but not for ever");
        assert_eq!(after_siting(NOW, EXPLORE, bears), RELAYING);
        assert_eq!(after_siting(NOW, Order::Perch, Links { front: None, ..bears }), RELAYING);
    }

    #[test]
    fn patience_outlasts_a_weak_link_for_a_while() {
        let patient_until = NOW + Duration::from_secs(1);
        let weak = Links { front: Some(Dbm(-50.0)), back: Some(WEAK), base: None, ..GOOD };
        for duty in [ChainDuty::Leading { patient_until }, ChainDuty::Relaying { patient_until }] {
            assert_eq!(after(duty, EXPLORE, weak), Continue(duty));
        }
    }
}
