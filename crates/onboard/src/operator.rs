//! Holds the operator's orders: a state machine that turns the requests of clients, and their
//! silence, into the one order that the base gives to the whole mission.
//!
//! | the newest request | holds |
//! |---|---|
//! | a set-point | for half a second; then the head hovers |
//! | explore, by parameter | while the client is heard, and for 2 s more; then the head hovers |
//! | wait, return, land, perch | until the next request |
//! | stop | until the base is switched off |
//!
//! When a client disappears, no drone lands: the head hovers, and the relays hold the chain.

use units::{Branch, Course, Duration, Instant, MetresPerSecond, Order};

/// A set-point that is older is not flown any more: a Crazyflie levels out after as long
/// (crazyflie-firmware, supervisor.c, COMMANDER_WDT_TIMEOUT_STABILIZE).
const SETPOINT_HOLDS: Duration = Duration::from_millis(500);

/// A client that has been silent for as long counts as gone. cflib sends a packet at least once a
/// second (cflib, crazyflie/link_statistics.py), and a Crazyradio much more often.
pub(crate) const CLIENT_GONE: Duration = Duration::from_secs(2);

/// The emergency stop's watchdog must be fed within this time (crazyflie-firmware, supervisor.c,
/// DEFAULT_EMERGENCY_STOP_WATCHDOG_TIMEOUT).
const WATCHDOG: Duration = Duration::from_secs(1);

/// The state of the operator's orders.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Operator {
    /// The operator has not asked for anything since the drone was switched on.
    #[default]
    Silent,
    /// The head follows a set-point until that is too old.
    Setpoint {
        /// The speed along the tunnel.
        forward: MetresPerSecond,
        /// When the set-point was given.
        given: Instant,
    },
    /// The head explores at this speed as long as the client is heard.
    Explore(MetresPerSecond),
    /// The head hovers, since its set-points ended or its client is gone.
    Hover,
    /// All drones wait on the ground.
    Wait,
    /// All drones fly home.
    Return,
    /// All drones land where they are.
    Land,
    /// The drones of the chain relay from the ground.
    Perch,
    /// All drones have switched their motors off.
    Stopped,
}

/// A request of the operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Request {
    /// A client asks for this speed now.
    Setpoint(MetresPerSecond),
    /// A pilot's stick asks for this speed now, and for this branch at junctions.
    Stick {
        /// The speed along the tunnel.
        speed: MetresPerSecond,
        /// The choice for the junctions that the head comes to.
        branch: Option<Branch>,
    },
    /// A client asks for a lasting order.
    Order(Order),
    /// A client changes the speed at which the head explores by itself.
    Speed(MetresPerSecond),
    /// A client changes the choice for the junctions that the head comes to.
    Branch(Option<Branch>),
}

impl Request {
    /// The choice for junctions, if the request says one, also that there is none.
    pub(crate) const fn branch(self) -> Option<Option<Branch>> {
        match self {
            Self::Order(Order::Explore(Course { branch, .. }))
            | Self::Stick { branch, .. }
            | Self::Branch(branch) => Some(branch),
            Self::Order(Order::Wait | Order::Return | Order::Land | Order::Perch | Order::Stop)
            | Self::Setpoint(_)
            | Self::Speed(_) => None,
        }
    }
}

impl Operator {
    /// The orders after `request`.
    #[must_use]
    pub(crate) fn after(self, now: Instant, request: Request) -> Self {
        match (self, request) {
            (Self::Stopped, _) => Self::Stopped,
            (_, Request::Setpoint(forward) | Request::Stick { speed: forward, .. }) => {
                Self::Setpoint { forward, given: now }
            }
            (_, Request::Order(Order::Explore(Course { speed, .. }))) => Self::Explore(speed),
            (_, Request::Order(Order::Wait)) => Self::Wait,
            (_, Request::Order(Order::Return)) => Self::Return,
            (_, Request::Order(Order::Land)) => Self::Land,
            (_, Request::Order(Order::Perch)) => Self::Perch,
            (_, Request::Order(Order::Stop)) => Self::Stopped,
            (Self::Explore(_), Request::Speed(speed)) => Self::Explore(speed),
            (same, Request::Speed(_) | Request::Branch(_)) => same,
        }
    }

    /// The orders after time has passed. `has_client` says whether a client has been heard within
    /// the last 2 s.
    #[must_use]
    pub(crate) fn at(self, now: Instant, has_client: bool) -> Self {
        match self {
            Self::Setpoint { given, .. } if now.since(given) > SETPOINT_HOLDS => Self::Hover,
            Self::Explore(_) if !has_client => Self::Hover,
            Self::Silent
            | Self::Setpoint { .. }
            | Self::Explore(_)
            | Self::Hover
            | Self::Wait
            | Self::Return
            | Self::Land
            | Self::Perch
            | Self::Stopped => self,
        }
    }

    /// The order that the base gives; `None` while the operator has not asked for anything.
    #[must_use]
    pub const fn order(self) -> Option<Order> {
        match self {
            Self::Silent => None,
            Self::Setpoint { forward, .. } => Some(Order::explore(forward)),
            Self::Explore(speed) => Some(Order::explore(speed)),
            Self::Hover => Some(Order::explore(MetresPerSecond::ZERO)),
            Self::Wait => Some(Order::Wait),
            Self::Return => Some(Order::Return),
            Self::Land => Some(Order::Land),
            Self::Perch => Some(Order::Perch),
            Self::Stopped => Some(Order::Stop),
        }
    }
}

/// The watchdog of the emergency stop: once a client has fed it, its silence stops the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Watchdog(Option<Instant>);

impl Watchdog {
    /// A watchdog that no client has fed.
    pub(crate) const UNFED: Self = Self(None);

    /// Feeds the watchdog: from now on the client's silence stops the motors.
    pub(crate) const fn feed(&mut self, now: Instant) {
        self.0 = Some(now);
    }

    /// Whether the watchdog has been fed once, and not in time since.
    pub(crate) fn is_starved(self, now: Instant) -> bool {
        self.0.is_some_and(|fed| now.since(fed) > WATCHDOG)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED: MetresPerSecond = MetresPerSecond(0.3);
    const OTHER: MetresPerSecond = MetresPerSecond(-0.2);

    fn at(ms: u64) -> Instant {
        Instant::from_millis(ms)
    }

    const fn setpoint(given_ms: u64) -> Operator {
        Operator::Setpoint { forward: SPEED, given: Instant::from_millis(given_ms) }
    }

    const ALL: [Operator; 9] = [
        Operator::Silent,
        setpoint(0),
        Operator::Explore(SPEED),
        Operator::Hover,
        Operator::Wait,
        Operator::Return,
        Operator::Land,
        Operator::Perch,
        Operator::Stopped,
    ];

    /// The state after each request in each state, by rows: a speed changes nothing but a speed, and
    /// no request replaces a stop.
    #[test]
    fn the_newest_request_counts_but_after_a_stop() {
        use Operator::{Explore, Hover, Land, Perch, Return, Silent, Stopped, Wait};
        let table = [
            (Request::Setpoint(SPEED), [setpoint(7); 9]),
            (Request::Order(Order::explore(OTHER)), [Explore(OTHER); 9]),
            (Request::Order(Order::Wait), [Wait; 9]),
            (Request::Order(Order::Return), [Return; 9]),
            (Request::Order(Order::Land), [Land; 9]),
            (Request::Order(Order::Perch), [Perch; 9]),
            (Request::Order(Order::Stop), [Stopped; 9]),
            (
                Request::Speed(OTHER),
                [Silent, setpoint(0), Explore(OTHER), Hover, Wait, Return, Land, Perch, Stopped],
            ),
        ];
        for (request, mut wanted) in table {
            wanted[8] = Stopped;
            for (from, wanted) in ALL.into_iter().zip(wanted) {
                assert_eq!(from.after(at(7), request), wanted, "{from:?}, {request:?}");
            }
        }
    }

    /// The state after a time in each state, by rows, with a client and without.
    #[test]
    fn time_ends_what_needs_a_client_and_takes_no_drone_down() {
        use Operator::{Explore, Hover, Land, Perch, Return, Silent, Stopped, Wait};
        let lasting =
            [Silent, setpoint(0), Explore(SPEED), Hover, Wait, Return, Land, Perch, Stopped];
        let with = |changed: &[(usize, Operator)]| {
            let mut row = lasting;
            changed.iter().for_each(|(place, to)| row[*place] = *to);
            row
        };
        let table = [
            (500, true, lasting),
            (501, true, with(&[(1, Hover)])),
            (500, false, with(&[(2, Hover)])),
            (3_600_000, false, with(&[(1, Hover), (2, Hover)])),
        ];
        for (ms, has_client, wanted) in table {
            for (from, wanted) in ALL.into_iter().zip(wanted) {
                assert_eq!(from.at(at(ms), has_client), wanted, "{from:?} after {ms} ms");
            }
        }
    }

    #[test]
    fn a_head_without_a_pilot_hovers() {
        assert_eq!(Operator::Hover.order(), Some(Order::explore(MetresPerSecond::ZERO)));
        assert_eq!(Operator::Silent.order(), None);
    }

    #[test]
    fn a_watchdog_that_was_never_fed_never_starves() {
        let mut watchdog = Watchdog::UNFED;
        assert!(!watchdog.is_starved(at(3_600_000)));
        watchdog.feed(at(100));
        assert!(!watchdog.is_starved(at(1_100)));
        assert!(watchdog.is_starved(at(1_101)));
    }
}
