//! The chain mission: a head that explores and relays that keep its link alive, by the U-Chain paper.

mod search;

use chain::chain_wide::{ChainWideState, Side};
use chain::launch::{LaunchConfig, LaunchWatch};
use chain::neighbours::{Ends, Heard, Neighbour, Neighbours};
use chain::policy::SpeedLaw;
use chain::retirement::{RetirementWatch, with_one_link_less};
use chain::search::{Place, Search, SearchWatch, View};
use units::{
    Dbm, Duration, Instant, LinkSpan, LinkSum, Metres, MetresPerSecond, Order, Phase, Role,
};

use super::{Call, PassedOn, Round, Task};
use crate::state::Situation;
use crate::{AgentConfig, LandReason, LinkView, State};
use search::{is_searching, searching};

/// What a drone of a chain knows of the others.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    neighbours: Neighbours,
    /// The drone's two links in this round.
    ends: Ends,
    launch: LaunchWatch,
    search: SearchWatch,
    retirement: RetirementWatch,
    /// The strength of the base where this drone took off.
    home_rssi: Option<Dbm>,
    /// The state of the chain-wide policy.
    chain_wide: ChainWideState,
    /// The head's velocity, smoothed at the head and passed on by the relays.
    head_velocity: MetresPerSecond,
    /// The sums over the links towards the head and towards the base, held while a drone searches.
    sums: [LinkSum; 2],
    /// Whether this drone searches.
    is_searching: bool,
    /// Whether this drone flies home because it is not needed.
    is_retiring: bool,
    /// The place at which a search has ended that was worth it: the drone stays there, as an end of
    /// the chains on either side.
    found: Option<Metres>,
    /// How often the drone has searched anew from a place that it had found.
    renewals: u8,
    /// The drone's velocity in the last round, and its length.
    velocity: MetresPerSecond,
    dt: Duration,
}

/// A drone's two links, as the transitions of the chain's duties need them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Links {
    /// The filtered strength of the front link, if there is one.
    pub(crate) front: Option<Dbm>,
    /// The filtered strength of the back link, if there is one.
    pub(crate) back: Option<Dbm>,
    /// The same, where the base is that neighbour.
    pub(crate) base: Option<Dbm>,
    /// The strength of the base where the drone took off.
    pub(crate) home_rssi: Option<Dbm>,
    /// Whether the drone in front leaves no room to come nearer.
    pub(crate) is_front_near: bool,
    /// Whether the drone behind leaves no room to come nearer.
    pub(crate) is_back_near: bool,
    /// Whether a neighbour has left its place to look for a better one.
    pub(crate) is_searched: bool,
    /// The same of the neighbour in front.
    pub(crate) is_front_searching: bool,
}

impl Links {
    /// Both links, as a search needs them.
    fn view(&self) -> View {
        let weaker = self.front.zip(self.back).map(|(front, back)| Dbm(front.0.min(back.0)));
        View { weaker, is_front_near: self.is_front_near, is_back_near: self.is_back_near }
    }
}

impl Chain {
    /// A drone that has not heard any other.
    pub(crate) const fn new() -> Self {
        Self {
            neighbours: Neighbours::new(),
            ends: Ends::NONE,
            launch: LaunchWatch::new(),
            search: SearchWatch::new(),
            retirement: RetirementWatch::new(),
            home_rssi: None,
            chain_wide: ChainWideState::new(),
            head_velocity: MetresPerSecond::ZERO,
            sums: [LinkSum::NONE; 2],
            is_searching: false,
            is_retiring: false,
            found: None,
            renewals: 0,
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
        heard: &[Heard],
    ) {
        let smoothing = &config.policy.smoothing;
        let lost_after = config.retreat.lost_after;
        (self.velocity, self.dt) = (velocity, dt);
        self.neighbours.listen(round.id, round.now, (velocity, dt), heard, smoothing, lost_after);
        self.ends = self.neighbours.ends(round.id, round.now, lost_after);
        self.sums = self.sums(config, round);
        self.chain_wide.listen(self.sums);
        self.head_velocity = match round.role {
            Role::Head => smoothed(self.head_velocity, velocity, dt),
            Role::Relay | Role::Base => {
                let front = self.front();
                front.map_or(MetresPerSecond::ZERO, |front| front.report.head_velocity)
            }
        };
    }

    /// The sums over the links towards the head, and over those towards the base.
    fn sums(&self, config: &AgentConfig, round: &Round) -> [LinkSum; 2] {
        let SpeedLaw::ChainWide(law) = &config.policy.law else { return [LinkSum::NONE; 2] };
        if self.is_retiring || self.found.is_some() && !self.is_searching {
            return [LinkSum::NONE; 2];
        }
        let sum = |neighbour: Option<&Neighbour>, beyond: usize| {
            // A search moves one drone: the others need not know how its links change.
            if self.is_searching || neighbour.is_some_and(is_searching) {
                return self.sums.get(beyond).copied().unwrap_or(LinkSum::NONE);
            }
            let side = neighbour.and_then(|n| side(n, beyond));
            side.map_or(LinkSum::NONE, |side| self.chain_wide.sum(law, &side))
        };
        // An explorer is an end of the chain, also where it hears another one.
        let front = self.front().filter(|_| round.role != Role::Head);
        [sum(front, AHEAD), sum(self.back(), BEHIND)]
    }

    /// What the drone's report passes on along the chain.
    pub(crate) fn passed_on(&self, config: &AgentConfig, round: &Round) -> PassedOn {
        PassedOn {
            sums: self.sums(config, round),
            waiting: self.waiting(config, round),
            head_velocity: self.head_velocity,
        }
    }

    /// How many relays wait on the ground or climb: the base and the last drone in the air hear them, all
    /// others are told by the drone behind.
    fn waiting(&self, config: &AgentConfig, round: &Round) -> u8 {
        let heard = || self.neighbours.heard(round.now, config.retreat.lost_after);
        let is_coming = |n: &&Neighbour| matches!(n.report.phase, Phase::Waiting | Phase::Transit);
        let on_ground = heard().filter(is_coming).count();
        let told = heard().filter(|n| n.report.from > round.id).map(|n| n.report.waiting).max();
        u8::try_from(on_ground).unwrap_or(u8::MAX).max(told.unwrap_or(0)).min(3)
    }

    /// The strength that all links would have if they were equal, and the links' span, as the base
    /// reports them to a relay on the ground.
    fn told_by_base(&self) -> Option<(Dbm, LinkSpan)> {
        let base = self.back().filter(|n| n.report.phase == Phase::Base)?;
        let ahead = base.report.sums[0];
        (ahead.links > 0).then_some(())?;
        let level = LinkSum::REFERENCE + ahead.level()?;
        Some((Dbm::after_loss(level), base.report.links?))
    }

    fn front(&self) -> Option<&Neighbour> {
        self.neighbours.front(self.ends)
    }

    fn back(&self) -> Option<&Neighbour> {
        self.neighbours.back(self.ends)
    }

    /// The link towards the head.
    pub(crate) fn front_view(&self) -> Option<LinkView> {
        self.front().map(LinkView::of)
    }

    /// The link towards the base.
    pub(crate) fn back_view(&self) -> Option<LinkView> {
        self.back().map(LinkView::of)
    }

    /// The two links of this round.
    pub(crate) fn links(&self, config: &AgentConfig) -> Links {
        let (front, back) = (self.front(), self.back());
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
        }
    }

    /// Whether the chain calls for this drone, which is in `state` on the ground.
    pub(crate) fn call(&mut self, config: &AgentConfig, round: &Round, state: State) -> Call {
        let (lower_waits, lower_linked) = self
            .neighbours
            .heard(round.now, config.retreat.lost_after)
            .filter(|n| n.report.from < round.id)
            .fold((false, false), |(waits, linked), n| {
                let phase = n.report.phase;
                (
                    waits || matches!(phase, Phase::Waiting | Phase::Transit),
                    linked || phase.is_link(),
                )
            });
        let launch = match state {
            State::Armed { since } if round.now.since(since) >= config.launch.arm_delay => {
                if let Some((level, chain)) = self.told_by_base() {
                    self.launch.step_level(round.now, &config.launch, level, chain)
                } else {
                    let front = self.front().copied();
                    let ahead = front.and_then(|n| n.report.links);
                    self.launch.step(round.now, &config.launch, front.map(|n| n.rssi()), ahead)
                }
            }
            _ => {
                self.launch = LaunchWatch::new();
                false
            }
        };
        let head = round.role == Role::Head;
        Call {
            arms: head || (!lower_waits && lower_linked),
            stays_armed: head || !lower_waits,
            takes_off: head || launch,
        }
    }

    /// Whether the chain no longer needs this drone, which is in `state`: the relay next to the base
    /// that was launched in this mission.
    pub(crate) fn retires(&mut self, config: &AgentConfig, round: &Round, state: State) -> bool {
        let is_last = self.back().is_some_and(|back| back.report.phase == Phase::Base);
        let is_free = matches!(state, State::Relaying { .. })
            && matches!(round.order(), Some(Order::Explore(_)))
            && self.front().is_some_and(|front| !is_searching(front))
            && self.found.is_none();
        let [ahead, behind] = self.sums;
        let without = with_one_link_less(ahead.and(behind))
            .filter(|_| is_last && is_free && self.home_rssi.is_some());
        let wanted = config.launch.limit + config.launch.margin;
        let head_way = self.head_velocity * self.dt;
        self.retirement.step(&config.retirement, round.now, head_way, without, wanted)
    }

    /// Notes where the drone takes off.
    pub(crate) const fn note_home(&mut self, links: &Links) {
        self.home_rssi = links.base;
        self.retirement = RetirementWatch::new();
    }

    /// The span of the links from the head down to this drone, which its report tells.
    pub(crate) fn span(&self, front: Option<LinkView>) -> Option<LinkSpan> {
        let ahead = self.front().and_then(|n| n.report.links);
        front.map(|link| LinkSpan::extended(ahead, link.rssi))
    }

    /// How fast the drone is to fly along the tunnel at a duty of the chain.
    pub(crate) fn speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: Duty,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        self.is_searching = matches!(duty, Duty::Searching { .. });
        if self.is_retiring && duty != Duty::Retiring {
            // It is needed after all: the head has to come back as far again.
            self.retirement = RetirementWatch::new();
        }
        self.is_retiring = duty == Duty::Retiring;
        let relays = matches!(duty, Duty::Relaying { .. })
            && matches!(round.order(), Some(Order::Explore(_)));
        self.found = self.found.filter(|_| relays);
        match duty {
            Duty::Leading { .. } => self.leading_speed(config, round, back),
            Duty::Relaying { .. } => self.relaying_speed(config, round, front, back),
            Duty::Reconnecting { since, from } => {
                let waited = round.now.since(since);
                reconnecting_speed(config, waited, round.way - from, back)
            }
            Duty::Searching { search } => {
                self.note_search(round);
                self.found = search.found();
                search.velocity(&config.search, round.way)
            }
            Duty::Retiring => homeward(config, back),
            Duty::BackingUp { .. } => -config.retreat.speed,
        }
    }

    /// The pilot's stick while it is alive and the link can spare it, or the way home.
    fn leading_speed(
        &self,
        config: &AgentConfig,
        round: &Round,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let Some(Task { order, given }) = round.task else { return MetresPerSecond::ZERO };
        match order {
            Order::Explore(speed) if round.now.since(given) <= config.flight.pilot_timeout => {
                let speed = speed.limited_to(config.policy.max_speed);
                if speed.0 >= 0.0 {
                    let freedom = config.retreat.freedom(back.map(|link| link.rssi));
                    self.speed_at_limit(&config.launch, speed * freedom, back)
                } else {
                    behind_clear(config, back, speed)
                }
            }
            Order::Return => homeward(config, back),
            Order::Explore(_) | Order::Wait | Order::Land | Order::Stop => MetresPerSecond::ZERO,
        }
    }

    /// The pilot's forward `speed` as far as the links can spare it. The head slows down as the
    /// links, were they equal, come near to the launch limit, and where its own link falls steeply
    /// flies no faster than what is spare lasts for [`LaunchConfig::foresight`]; at the limit it
    /// waits for the next relay, and from where the links are weaker it comes back at half the speed.
    /// While the relay behind it searches the head stays.
    fn speed_at_limit(
        &self,
        config: &LaunchConfig,
        speed: MetresPerSecond,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let Some(level) = self.chain_wide.level() else { return speed };
        if self.back().is_some_and(is_searching) {
            return MetresPerSecond::ZERO;
        }
        let level = Dbm::after_loss(level);
        let weakest = back.map_or(level, |link| Dbm(link.rssi.0.min(level.0)));
        let spare = weakest - config.limit;
        let fall = self.back().and_then(Neighbour::state).map_or(0.0, |link| {
            let [own, other] = link.slopes;
            own.0.max(other.0) * speed.0 * config.foresight.as_secs_f32()
        });
        speed * (spare.0 / config.slows_from.0.max(fall)).clamp(-0.5, 1.0)
    }

    /// The velocity by Algorithm 1; a relay that is called home and has no drone in front any more flies
    /// home.
    fn relaying_speed(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let called_home = round.order() == Some(Order::Return);
        match (front, back) {
            (None, _) if called_home => homeward(config, back),
            // The base is not to be kept clear of by who goes home to it.
            (_, Some(back)) if called_home && back.is_base && is_too_near(config, back) => {
                homeward(config, Some(back))
            }
            (Some(front), Some(back)) => self
                .staying_speed(config, round)
                .or_else(|| self.chain_wide_speed(config))
                .unwrap_or_else(|| config.policy.velocity(front.end(), back.end())),
            _ => MetresPerSecond::ZERO,
        }
    }

    /// The speed by the chain-wide policy; `None` where another one flies, and where a neighbour is
    /// too near.
    fn chain_wide_speed(&mut self, config: &AgentConfig) -> Option<MetresPerSecond> {
        let SpeedLaw::ChainWide(law) = &config.policy.law else { return None };
        let (front, back) = (self.front()?, self.back()?);
        if [front, back].into_iter().any(is_searching) {
            return Some(MetresPerSecond::ZERO);
        }
        if [front, back].into_iter().any(|n| config.policy.is_too_near(n.rssi())) {
            return None;
        }
        // A neighbour without sums is an end of the chain: the base, an explorer, or a relay of
        // another policy, between which and the base the chain is equal at least.
        let (ahead, behind) = (side(front, AHEAD)?, side(back, BEHIND)?);
        let speed = self.chain_wide.step(law, self.dt, [&ahead, &behind], self.head_velocity);
        Some(speed.limited_to(config.policy.max_speed))
    }
}

/// The places of both directions in a report's sums.
const AHEAD: usize = 0;
const BEHIND: usize = 1;

/// A neighbour as one side of this drone, for a smoothing that estimates slopes.
fn side(neighbour: &Neighbour, beyond: usize) -> Option<Side> {
    Some(Side { link: neighbour.state()?, beyond: *neighbour.report.sums.get(beyond)? })
}

/// The head's velocity, smoothed: its noise would move every relay.
fn smoothed(before: MetresPerSecond, measured: MetresPerSecond, dt: Duration) -> MetresPerSecond {
    let part = dt.as_secs_f32() / (dt.as_secs_f32() + 1.0);
    before + (measured - before) * part
}

/// Flying home, but not into the next drone that has not landed yet.
fn homeward(config: &AgentConfig, back: Option<LinkView>) -> MetresPerSecond {
    behind_clear(config, back, -config.flight.return_speed)
}

/// `speed`, a backward one, unless a drone is too near behind.
fn behind_clear(
    config: &AgentConfig,
    back: Option<LinkView>,
    speed: MetresPerSecond,
) -> MetresPerSecond {
    match back {
        Some(back) if !back.is_base && is_too_near(config, back) => MetresPerSecond::ZERO,
        _ => speed,
    }
}

fn is_too_near(config: &AgentConfig, link: LinkView) -> bool {
    config.policy.is_too_near(link.rssi)
}

/// With the front neighbour lost, a relay advances while its own back link can spare it, and
/// waits where that, or the bound on its advance, ends. Half of all relays that only hover are
/// found after 20 s, of those that advance after 12 s (the book, "Lost neighbours").
fn reconnecting_speed(
    config: &AgentConfig,
    waited: Duration,
    advanced: Metres,
    back: Option<LinkView>,
) -> MetresPerSecond {
    let retreat = &config.retreat;
    let spare = !retreat.wanted(None, back.map(|link| link.rssi), true);
    if spare && waited <= retreat.max_time && advanced < retreat.max_distance {
        retreat.speed
    } else {
        MetresPerSecond::ZERO
    }
}

/// What a drone of the chain does in the air, at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Duty {
    /// The head: flies as the pilot says, and bears a weak or missing link until a time.
    Leading { patient_until: Instant },
    /// A relay: makes its two links equal, and bears a weak or missing one until a time.
    Relaying { patient_until: Instant },
    /// A relay that no longer hears a neighbour in front, since a time and a place.
    Reconnecting { since: Instant, from: Metres },
    /// A relay that looks for a better place.
    Searching { search: Search },
    /// A relay that is no longer needed and flies home. The relays in front take it for the end of
    /// their chain, as they take the base.
    Retiring,
    /// A drone that flies back towards a neighbour that it hears too weakly, or not at all.
    BackingUp { since: Instant, from: Metres },
}

impl Duty {
    /// The duty of a drone in this state, if it has one.
    pub(crate) const fn of(state: State) -> Option<Self> {
        match state {
            State::Leading { patient_until } => Some(Self::Leading { patient_until }),
            State::Relaying { patient_until } => Some(Self::Relaying { patient_until }),
            State::Reconnecting { since, from } => Some(Self::Reconnecting { since, from }),
            State::Searching { search } => Some(Self::Searching { search }),
            State::Retiring => Some(Self::Retiring),
            State::BackingUp { since, from } => Some(Self::BackingUp { since, from }),
            State::Idle
            | State::Armed { .. }
            | State::TakingOff { .. }
            | State::Landing { .. }
            | State::Landed { .. }
            | State::Stopped => None,
        }
    }

    /// The state after this duty's round: another duty, or the landing that ends it.
    pub(crate) fn next(self, config: &AgentConfig, role: Role, at: &Situation) -> State {
        match self {
            Self::Leading { patient_until } => leading(patient_until, config, at),
            Self::Relaying { patient_until } => relaying(patient_until, config, at),
            Self::Reconnecting { since, from } => reconnecting(since, from, config, at),
            Self::Searching { search } => searching(search, config, at),
            Self::Retiring => retiring(config, at),
            Self::BackingUp { since, from } => backing_up(since, from, config, role, at),
        }
    }
}

/// Head or relay at its work, bearing with its links until `patient_until`.
pub(crate) fn on_duty(role: Role, patient_until: Instant) -> State {
    match role {
        Role::Head => State::Leading { patient_until },
        Role::Relay | Role::Base => State::Relaying { patient_until },
    }
}

/// What ends every duty: an order to land, or having come home when called.
fn dismissed(config: &AgentConfig, at: &Situation) -> Option<State> {
    let why = match at.task {
        Some(Order::Land) => LandReason::Ordered,
        Some(Order::Return) if is_home(config, at) => LandReason::Home,
        _ => return None,
    };
    Some(State::Landing { since: at.now, why })
}

/// Next to the base, and where it took off by odometer or by signal: ways flown round bends
/// differ out and back, and the base is nowhere stronger than at home.
fn is_home(config: &AgentConfig, at: &Situation) -> bool {
    let Some(base) = at.links.base else { return false };
    at.odometer <= config.flight.home || at.links.home_rssi.is_some_and(|home| base >= home)
}

/// Whether links call for a retreat. A drone whose neighbour searches bears a weak one.
fn retreats(config: &AgentConfig, links: &Links) -> bool {
    let bears = links.is_searched && links.back.is_some();
    !bears && config.retreat.wanted(links.front, links.back, false)
}

fn leading(patient_until: Instant, config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if at.now >= patient_until && retreats(config, &at.links) {
        State::BackingUp { since: at.now, from: at.odometer }
    } else {
        State::Leading { patient_until }
    }
}

fn relaying(patient_until: Instant, config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if at.now >= patient_until && retreats(config, &at.links) {
        State::BackingUp { since: at.now, from: at.odometer }
    } else if at.now >= patient_until && at.links.front.is_none() && at.task != Some(Order::Return)
    {
        State::Reconnecting { since: at.now, from: at.odometer }
    } else if at.retires {
        State::Retiring
    } else if let (true, Some(weaker)) = (at.searches, at.links.view().weaker) {
        State::Searching { search: Search::begin(at.now, Place { way: at.odometer, weaker }) }
    } else {
        State::Relaying { patient_until }
    }
}

/// A relay that flies home stays where it is needed again: where a link is missing or becomes too weak.
fn retiring(config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        return landing;
    }
    let least = config.launch.limit + config.launch.margin;
    let can_go = matches!(at.task, Some(Order::Explore(_)))
        && at.links.base.is_some()
        && at.links.front.is_some_and(|front| front >= least);
    if !can_go {
        State::Relaying { patient_until: at.now }
    } else if is_home(config, at) {
        State::Landing { since: at.now, why: LandReason::Retired }
    } else {
        State::Retiring
    }
}

fn reconnecting(since: Instant, from: Metres, config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if config.retreat.wanted(at.links.front, at.links.back, false) {
        State::BackingUp { since: at.now, from: at.odometer }
    } else if at.links.front.is_some() || at.task == Some(Order::Return) {
        State::Relaying { patient_until: at.now }
    } else {
        State::Reconnecting { since, from }
    }
}

fn backing_up(
    since: Instant,
    from: Metres,
    config: &AgentConfig,
    role: Role,
    at: &Situation,
) -> State {
    let retreat = &config.retreat;
    let spent =
        at.now.since(since) >= retreat.max_time || (from - at.odometer) >= retreat.max_distance;
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if !retreat.wanted(at.links.front, at.links.back, true) {
        on_duty(role, at.now)
    } else if !spent {
        State::BackingUp { since, from }
    } else if at.links.back.is_some() {
        on_duty(role, at.now + retreat.rest)
    } else {
        State::Landing { since: at.now, why: LandReason::LinkLost }
    }
}
