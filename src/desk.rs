//! What cfclient and cflib talk to, and what becomes of what they want: `crtp::Server` answers,
//! and here it is decided who may do what.
//!
//! | the drone | may be read | may be set | may give orders |
//! |---|---|---|---|
//! | the base, provisioned for it | yes | yes | yes |
//! | any other with keys | yes | no | no |
//! | one without keys, on the ground | yes | yes | there is nobody to order |
//!
//! CRTP has no authentication: whoever has a Crazyradio may say what he likes. So nobody steers a
//! drone by it. The base makes orders of what it is told, and these go to the drones sealed.
//!
//! An order to explore holds only as long as somebody stands behind it: a set-point reaches the
//! head once, and `uchain.task` again and again only while the client is heard. The head that hears
//! no more of it hovers. All other orders hold until the next.

use airlink::Refused;
use crtp::{
    Access, Event, LinkState, Node, ParameterId, Parameters, Power, Radio, Server, Setpoint,
    Snapshot,
};
use embassy_stm32::uid;
use units::{Duration, Instant, MetresPerSecond, NODES, NodeId, Order, Role};
use wire::crtp::Packet;
use wire::p2p::Telemetry;

use crate::link::{Link, Standing};
use crate::store::{self, KeysState};
use crate::{control, flow, mind, radio, rangers};

/// A client that has not been heard for as long is gone. cflib asks for something at least once a
/// second (`cflib/crazyflie/link_statistics.py`), and a Crazyradio much oftener.
const GONE: Duration = Duration::from_secs(2);

/// Between two orders to explore that a parameter stands for: the rate at which the base sends
/// them on (`crates/airlink`, `LinkConfig::stick_every`).
const AGAIN: Duration = Duration::from_millis(200);

/// The emergency stop's watchdog must be fed within this time (crazyflie-firmware,
/// `supervisor.c`).
const WATCHDOG: Duration = Duration::from_secs(1);

/// In the air, less than this much flying left is little.
const SCARCE: Duration = Duration::from_secs(60);

/// Where client and drone meet.
pub(crate) struct Desk {
    server: Server,
    parameters: Parameters,
    /// All that is read of the settings stands in the parameters.
    is_described: bool,
    /// When the client was last heard.
    client: Option<Instant>,
    /// When `uchain.task` was last passed on, if it says to explore.
    explores: Option<Instant>,
    /// When the emergency stop's watchdog was last fed, if it ever was.
    watchdog: Option<Instant>,
    /// What the client has been told that the mind is doing.
    said: u8,
    /// It has been told that only the speed is flown.
    warned: bool,
    /// Packets of clients, and orders of the base.
    packets: u32,
    orders: u32,
    nodes: [Option<Node>; NODES],
}

impl Desk {
    pub(crate) const fn new() -> Self {
        Self {
            server: Server::new(),
            parameters: Parameters::DEFAULT,
            is_described: false,
            client: None,
            explores: None,
            watchdog: None,
            said: u8::MAX,
            warned: false,
            packets: 0,
            orders: 0,
            nodes: [None; NODES],
        }
    }

    /// A node has told the base of itself.
    pub(crate) fn hear(&mut self, now: Instant, from: NodeId, telemetry: Telemetry) {
        if let Some(place) = self.nodes.get_mut(usize::from(from.0)) {
            *place = Some(Node { telemetry, heard: now });
        }
    }

    /// An order of the base has come in.
    pub(crate) fn heed(&mut self) {
        self.orders = self.orders.wrapping_add(1);
    }

    /// A packet of a client: the answer to it, or to one before it.
    pub(crate) fn answer(&mut self, now: Instant, packet: &[u8], link: &Link) -> Option<Packet> {
        self.packets = self.packets.wrapping_add(1);
        if !self.is_connected(now) {
            self.greet(link);
        }
        self.client = Some(now);
        self.describe();
        let access = access();
        if let Some(event) = self.server.receive(now, packet, access, &mut self.parameters) {
            self.act(now, event, link);
        }
        let snapshot = self.snapshot(now, link);
        self.server.poll(now, &snapshot, &self.parameters)
    }

    /// What passing time brings. To be called often.
    pub(crate) fn look(&mut self, now: Instant, link: &Link) {
        if let Some(at) = self.explores
            && now.since(at) >= AGAIN
        {
            self.explores = None;
            if self.is_connected(now) {
                self.explore(now, link);
            }
        }
        if let Some(fed) = self.watchdog
            && now.since(fed) > WATCHDOG
        {
            self.watchdog = None;
            order(now, Order::Stop, link);
        }
        if let Some(state) = mind::latest().map(|outputs| outputs.status.state)
            && state.code() != self.said
            && self.is_connected(now)
        {
            self.said = state.code();
            self.server.say(state.name());
        }
    }

    fn is_connected(&self, now: Instant) -> bool {
        self.client.is_some_and(|at| now.since(at) < GONE)
    }

    /// A client is there that was not.
    fn greet(&mut self, link: &Link) {
        self.said = u8::MAX;
        self.server.say(match link.standing() {
            Standing::Fine => "The link of the chain is open.",
            Standing::NoKeys => "This drone has no keys: it does not fly.",
            Standing::Shut => "This drone cannot use its keys: it does not fly.",
            Standing::Out => "The chain has refused this drone: it does not fly.",
        });
    }

    /// What the drone says of itself. Some of it is known only a second after boot.
    fn describe(&mut self) {
        let about = &mut self.parameters.about;
        about.has_flow = flow::is_there();
        about.has_rangers = rangers::are_there();
        about.selftest_passed = about.has_flow && about.has_rangers;
        if self.is_described {
            return;
        }
        let Some(settings) = store::settings() else { return };
        self.is_described = true;
        about.node = settings.node;
        about.role = settings.role;
        let number = uid::uid();
        for (place, word) in about.unique.iter_mut().zip(number.as_chunks::<4>().0) {
            *place = u32::from_le_bytes(*word);
        }
        if let Some(height) = settings.height {
            self.parameters.height = height;
        }
        self.parameters.set_limits(settings.limits);
    }

    /// Does what a client may have done.
    fn act(&mut self, now: Instant, event: Event, link: &Link) {
        let task = match event {
            Event::ParameterSet(ParameterId::HEIGHT) => {
                return store::keep_height(self.parameters.height);
            }
            Event::ParameterSet(ParameterId::LAUNCH_LIMIT | ParameterId::RETREAT_LIMIT) => {
                return store::keep_limits(self.parameters.limits());
            }
            Event::ParameterSet(ParameterId::TASK) => match self.parameters.order() {
                Order::Explore(_) => return self.explore(now, link),
                task => task,
            },
            // The next order to explore has it.
            Event::ParameterSet(_) | Event::Arm(_) => return,
            Event::Setpoint(Setpoint::Hover { forward, lateral, yaw_rate, .. }) => {
                if (lateral.0 != 0.0 || yaw_rate.0 != 0.0) && !self.warned {
                    self.warned = true;
                    self.server.say("Only forward is flown: the head steers itself.");
                }
                Order::Explore(forward)
            }
            Event::TakeOff => Order::Explore(MetresPerSecond::ZERO),
            Event::Setpoint(Setpoint::Stop) | Event::Land => Order::Land,
            Event::EmergencyStop => Order::Stop,
            Event::EmergencyStopWatchdog => {
                self.watchdog = Some(now);
                return;
            }
        };
        self.explores = None;
        order(now, task, link);
    }

    /// Orders what `uchain.task` and `uchain.speed` say, now and again.
    fn explore(&mut self, now: Instant, link: &Link) {
        self.explores = Some(now);
        order(now, self.parameters.order(), link);
    }

    fn snapshot(&self, now: Instant, link: &Link) -> Snapshot {
        let felt = control::FELT.get();
        let mut snapshot =
            Snapshot::of(now, mind::latest().as_ref(), control::STATUS.get().as_ref());
        snapshot.duties = felt.duties;
        snapshot.gyro = felt.gyro;
        snapshot.accel = felt.accel;
        snapshot.ranges = rangers::seen(now);
        snapshot.flow = flow::latest();
        snapshot.power = power(&snapshot);
        snapshot.radio = Radio {
            rssi: radio::RSSI.get(),
            connected: self.is_connected(now),
            broadcasts: radio::HEARD.get(),
            unicasts: self.packets,
        };
        snapshot.link = self.link(link);
        snapshot.nodes = self.nodes;
        snapshot
    }

    fn link(&self, link: &Link) -> crtp::Link {
        use airlink::Standing::{Exhausted, Left, Listening, Member, Refused};
        let (Some(status), Some(counters)) = (link.status(), link.counters()) else {
            return crtp::Link::SILENT;
        };
        crtp::Link {
            state: match status.standing {
                Listening => LinkState::Listening,
                Member => LinkState::Member,
                Refused => LinkState::Refused,
                Left => LinkState::Off,
                Exhausted => LinkState::Exhausted,
            },
            accepted: counters.taken.total(),
            refused: all(&counters.refused),
            sent: counters.sent.total(),
            orders: self.orders,
        }
    }
}

/// What a client may do.
fn access() -> Access {
    match store::keys_state() {
        KeysState::Held { may_fly: true } if is_base() => Access::Full,
        KeysState::Missing if !control::is_airborne() => Access::Full,
        KeysState::Held { .. } | KeysState::Missing | KeysState::Unread | KeysState::Shut(_) => {
            Access::Read
        }
    }
}

fn is_base() -> bool {
    store::settings().is_some_and(|settings| settings.role == Role::Base)
}

/// Orders something of the whole chain. At any other than the base this is nobody's order.
fn order(now: Instant, task: Order, link: &Link) {
    if is_base() && link.tell(|end| end.order(now, task)).is_some() {
        mind::order(task);
    }
}

fn all(refused: &Refused) -> u32 {
    let Refused { malformed, no_slot, tag, own, twin, replayed, stale, body, forged, outdated } =
        *refused;
    [malformed, no_slot, tag, own, twin, replayed, stale, body, forged, outdated]
        .into_iter()
        .fold(0, u32::wrapping_add)
}

fn power(snapshot: &Snapshot) -> Power {
    match radio::BATTERY.get() {
        _ if radio::is_shutting_down() => Power::ShuttingDown,
        Some(battery) if battery.charging => Power::Charging,
        Some(battery) if battery.usb => Power::Charged,
        _ if snapshot.endurance.is_some_and(|left| left < SCARCE) => Power::Low,
        _ => Power::Battery,
    }
}
