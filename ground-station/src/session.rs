//! Speaks CRTP to the base: learns its tables, starts the log blocks, gives orders, repeats a stop.
//!
//! A session owns no clock and no socket. [`Session::poll`] returns the packets to be sent,
//! [`Session::receive`] takes those that came.
//!
//! # Silence
//! A base takes every packet of its client for a sign that an operator is there, and lets the head
//! fly on. So a session sends something only while a page steers ([`Speech::Steered`]), with one
//! exception: a stop that was ordered is sent until it is answered.

#[cfg(test)]
mod tests;

use units::{Dbm, Duration, Instant, NodeId, Role};
use wire::crtp::{Packet, ParamRequest, Port, Request};

use crate::blocks::{Block, BlockSetup};
use crate::order::{Fate, Giving, Order};
use crate::stopping::Stopping;
use crate::table::{Rows, Service, TableReader};

/// The time between two questions for the order that the base gives, which also tell the base that
/// its operator is there: eight of them fit into the 2 s after which the base gives its client up
/// (`onboard`, `operator.rs`, `CLIENT_GONE`).
const ASK_TASK: Duration = Duration::from_millis(250);

/// The time after which a base that has sent nothing counts as lost. Its own block comes every
/// 200 ms.
pub const LOST: Duration = Duration::from_secs(1);

/// The time after which a question about the base without an answer is sent again.
const AGAIN: Duration = Duration::from_millis(300);

/// The parameters of the base that are asked for once, in the order of [`Facts`].
const FACTS: [&str; 4] =
    ["uchain.node", "uchain.role", "uchain.launchLimit", "uchain.retreatLimit"];

/// Whether the session may send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speech {
    /// A page steers: the session asks, and gives orders.
    Steered,
    /// No page steers: the session sends nothing but a stop that was ordered.
    StopOnly,
}

/// What is known about the base and its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// The base's number.
    pub node: NodeId,
    /// A link that is weaker calls for the next relay.
    pub launch_limit: Dbm,
    /// A link that is weaker sends its relay back.
    pub retreat_limit: Dbm,
}

/// News from the base.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// A log block came.
    Block(Block),
    /// The base printed this on its console.
    Console(String),
    /// This became of an order.
    Order(Order, Fate),
    /// The base gives this order, by the code of `uchain.task`.
    Task(u8),
    /// The session knows the base, and its blocks are on their way.
    Ready(Facts),
    /// The drone at this address is not a base but this node.
    NotBase(NodeId),
    /// The base's firmware has no log variable of this name, and cannot be used.
    Missing(String),
}

/// How far the session has come.
#[derive(Debug)]
enum Stage {
    Parameters(TableReader),
    Facts { rows: Rows, asking: Asking },
    Log { rows: Rows, facts: Facts, reader: TableReader },
    Blocks { known: Known, setup: BlockSetup },
    Ready(Known),
    Unusable,
}

/// What was learned of the base: both tables, and the facts.
#[derive(Clone, Debug)]
struct Known {
    log: Rows,
    rows: Rows,
    facts: Facts,
}

/// The questions for [`FACTS`].
#[derive(Debug, Default)]
struct Asking {
    answers: Vec<f32>,
    asked: Option<Instant>,
}

/// A session with a base.
#[derive(Debug)]
pub struct Session {
    stage: Stage,
    giving: Giving,
    /// The emergency stop.
    pub stopping: Stopping,
    asked_task: Option<Instant>,
    heard: Option<Instant>,
    news: Vec<News>,
}

impl Default for Session {
    fn default() -> Self {
        Self {
            stage: Stage::Parameters(TableReader::new(Service::Param)),
            giving: Giving::default(),
            stopping: Stopping::NotOrdered,
            asked_task: None,
            heard: None,
            news: Vec::new(),
        }
    }
}

impl Session {
    /// Whether the base was heard within the last second.
    #[must_use]
    pub fn hears_base(&self, now: Instant) -> bool {
        self.heard.is_some_and(|heard| now.since(heard) < LOST)
    }

    /// What is known about the base, once it is.
    #[must_use]
    pub const fn facts(&self) -> Option<Facts> {
        match self.known() {
            Some(known) => Some(known.facts),
            None => None,
        }
    }

    const fn known(&self) -> Option<&Known> {
        match &self.stage {
            Stage::Blocks { known, .. } | Stage::Ready(known) => Some(known),
            Stage::Parameters(_) | Stage::Facts { .. } | Stage::Log { .. } | Stage::Unusable => {
                None
            }
        }
    }

    /// Gives an order, of which nothing is sent from `until` on. Returns whether the session knows
    /// the base well enough to give it.
    pub fn order(&mut self, order: Order, until: Instant) -> bool {
        let (Stage::Blocks { known, .. } | Stage::Ready(known)) = &self.stage else { return false };
        let replaced = self.giving.order();
        if !self.giving.begin(order, until, &known.rows) {
            return false;
        }
        self.news.extend(replaced.map(|order| News::Order(order, Fate::Replaced)));
        true
    }

    fn drop_order(&mut self, fate: Fate) {
        if let Some(order) = self.giving.take_order() {
            self.news.push(News::Order(order, fate));
        }
    }

    /// The next packet to be sent. A stop comes before everything else.
    pub fn poll(&mut self, now: Instant, speech: Speech) -> Option<Packet> {
        if let Some(stop) = self.stopping.poll(now) {
            return Some(stop);
        }
        if speech == Speech::StopOnly {
            self.drop_order(Fate::Dropped);
            return None;
        }
        match self.giving.poll(now) {
            Ok(Some(packet)) => return Some(packet),
            Ok(None) => {}
            Err(order) => self.news.push(News::Order(order, Fate::NotAnswered)),
        }
        match &mut self.stage {
            Stage::Parameters(reader) | Stage::Log { reader, .. } => reader.poll(now),
            Stage::Facts { rows, asking, .. } => asking.poll(now, rows),
            Stage::Blocks { setup, .. } => setup.poll(now),
            Stage::Ready(Known { rows, .. }) => {
                if self.asked_task.is_some_and(|asked| now.since(asked) < ASK_TASK) {
                    return None;
                }
                self.asked_task = Some(now);
                rows.get("uchain.task").map(|row| read(*row))
            }
            Stage::Unusable => None,
        }
    }

    /// Takes a packet of the base. [`Session::take_news`] then has what it says.
    pub fn receive(&mut self, now: Instant, packet: &Packet) {
        let returned = self.heard.is_some_and(|heard| now.since(heard) >= LOST);
        self.heard = Some(now);
        // A base that was restarted has no blocks any more: they are asked for again.
        if returned
            && let Some(known) = self.known().cloned()
            && let Ok(setup) = BlockSetup::new(known.facts.node, &known.log)
        {
            self.stage = Stage::Blocks { known, setup };
        }
        self.stopping.receive(now, packet);
        if let Some((order, fate)) = self.giving.receive(packet) {
            self.news.push(News::Order(order, fate));
        }
        if packet.port() == Ok(Port::Console) {
            let text = String::from_utf8_lossy(packet.data());
            self.news.push(News::Console(text.trim_matches('\0').to_owned()));
        }
        self.read_log(now, packet);
        self.advance(packet);
    }

    /// What the base has said since the last call.
    pub fn take_news(&mut self) -> Vec<News> {
        std::mem::take(&mut self.news)
    }

    fn read_log(&mut self, now: Instant, packet: &Packet) {
        let Some(facts) = self.facts() else { return };
        let Some(block) = Block::decode(packet, facts.node) else { return };
        if let Block::Drone(node, report) = block {
            let said = before(now, report.age);
            self.stopping.hear(node, said, report.state, report.fault);
        }
        self.news.push(News::Block(block));
    }

    /// Takes the session a stage further, if the packet does.
    fn advance(&mut self, packet: &Packet) {
        match &mut self.stage {
            Stage::Parameters(reader) => {
                if let Some(rows) = reader.receive(packet) {
                    self.stage = Stage::Facts { rows, asking: Asking::default() };
                }
            }
            Stage::Facts { rows, asking } => {
                if let Some(answers) = asking.receive(packet, rows) {
                    let rows = std::mem::take(rows);
                    self.learn_facts(rows, answers);
                }
            }
            Stage::Log { rows, facts, reader } => {
                if let Some(log) = reader.receive(packet) {
                    let known = Known { log, rows: std::mem::take(rows), facts: *facts };
                    self.learn_log(known);
                }
            }
            Stage::Blocks { known, setup } => {
                setup.receive(packet);
                if setup.is_done() {
                    self.news.push(News::Ready(known.facts));
                    self.stage = Stage::Ready(known.clone());
                }
            }
            Stage::Ready(Known { rows, .. }) => {
                if let (Ok(Port::Param), 1, [a, b, 0, task]) =
                    (packet.port(), packet.channel(), packet.data())
                    && rows.get("uchain.task") == Some(&u16::from_le_bytes([*a, *b]))
                {
                    self.stopping.hear_task(*task);
                    self.news.push(News::Task(*task));
                }
            }
            Stage::Unusable => {}
        }
    }

    /// Goes on to the log's table, if the drone is a base.
    fn learn_facts(&mut self, rows: Rows, [node, role, launch, retreat]: [f32; 4]) {
        let facts = Facts {
            node: NodeId(node as u8),
            launch_limit: Dbm(launch),
            retreat_limit: Dbm(retreat),
        };
        self.stage = if role as u8 == role_code(Role::Base) {
            Stage::Log { rows, facts, reader: TableReader::new(Service::Log) }
        } else {
            self.news.push(News::NotBase(facts.node));
            Stage::Unusable
        };
    }

    /// Goes on to the log blocks, if the base has their variables.
    fn learn_log(&mut self, known: Known) {
        self.stage = match BlockSetup::new(known.facts.node, &known.log) {
            Ok(setup) => Stage::Blocks { known, setup },
            Err(name) => {
                self.news.push(News::Missing(name));
                Stage::Unusable
            }
        };
    }

    /// Begins anew with a drone at another address. A stop that was ordered goes on.
    pub fn begin_anew(&mut self) {
        let mut stopping = std::mem::take(&mut self.stopping);
        stopping.begin_anew();
        *self = Self { stopping, ..Self::default() };
    }
}

/// The code of a role in `uchain.role` (`crtp`, `parameter_table.rs`).
const fn role_code(role: Role) -> u8 {
    match role {
        Role::Head => 0,
        Role::Relay => 1,
        Role::Base => 2,
    }
}

/// The moment that lies this long before `now`.
fn before(now: Instant, age: Duration) -> Instant {
    Instant::from_micros(now.as_micros().saturating_sub(age.as_micros()))
}

fn read(row: u16) -> Packet {
    Request::Param(ParamRequest::Read(row)).packet()
}

impl Asking {
    fn row(&self, rows: &Rows) -> Option<u16> {
        rows.get(*FACTS.get(self.answers.len())?).copied()
    }

    fn poll(&mut self, now: Instant, rows: &Rows) -> Option<Packet> {
        if self.asked.is_some_and(|asked| now.since(asked) < AGAIN) {
            return None;
        }
        self.asked = Some(now);
        self.row(rows).map(read)
    }

    /// Takes an answer. Returns all of them with the last one.
    fn receive(&mut self, packet: &Packet, rows: &Rows) -> Option<[f32; 4]> {
        let (Ok(Port::Param), 1, [a, b, 0, value @ ..]) =
            (packet.port(), packet.channel(), packet.data())
        else {
            return None;
        };
        if Some(u16::from_le_bytes([*a, *b])) != self.row(rows) {
            return None;
        }
        self.answers.push(match value {
            [byte] => f32::from(*byte),
            [a, b, c, d] => f32::from_le_bytes([*a, *b, *c, *d]),
            _ => return None,
        });
        self.asked = None;
        self.answers.as_slice().try_into().ok()
    }
}
