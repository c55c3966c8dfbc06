//! Holds the clients at the port of one drone, so that each gets the answers that it asked for and
//! the rows of its own log blocks.
//!
//! A drone's server knows one client. Where several are at its port, the number that one gives to a
//! log block may be another's already: the drone then has the block under another number, and
//! packets are changed on their way. A drone that answers later than it is asked, because its radio
//! chip is polled, serves one client: the one that came last.

use std::net::SocketAddr;

use wire::crtp::Port;

/// The most clients of a drone that answers at once. They share its 16 log blocks.
pub(super) const MOST: usize = 4;

/// The most addresses that are remembered because a newer client has their place.
const DISPLACED: usize = 16;

/// The log's channel of requests about blocks.
const CONTROL: u8 = 1;
/// The log's channel of rows.
const ROWS: u8 = 2;

/// The log's commands that create a block, of the old kind and of the new.
const CREATE: [u8; 2] = [0, 6];
/// The log's command that deletes a block.
const DELETE: u8 = 2;
/// The log's command that deletes all blocks.
const RESET: u8 = 5;
/// The error of a block that exists already (`EEXIST`).
const EXISTS: u8 = 17;

/// A header of the log's requests about blocks, with the two bits that are always set.
const CONTROL_HEADER: u8 = (Port::Log as u8) << 4 | 0x0C | CONTROL;

/// How a datagram was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// The sender is no client: it scans, or tells positions.
    NoClient,
    /// The sender is a client of the drone.
    Client,
    /// A newer client has the sender's place: the datagram was dropped, unless it may stop the drone.
    Displaced {
        /// Whether it is the first datagram of the sender since then.
        is_first: bool,
    },
}

/// The receiver of the answers that a drone gives now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asker {
    /// No client: the request was the server's own.
    Server,
    /// The client that spoke last.
    Newest,
    /// The sender of the request.
    One(SocketAddr, Option<Renumbered>),
}

/// The number of a log block in a request and its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Renumbered {
    /// The number that the client gives it.
    pub(super) own: u8,
    /// The number that it has at the drone.
    pub(super) at_drone: u8,
    /// Whether the block is new.
    is_new: bool,
}

/// What to do with a client's packet.
pub(super) enum Step {
    /// The drone gets these bytes.
    Give(Vec<u8>, Option<Renumbered>),
    /// The drone deletes the client's own blocks, of these numbers, and the client is answered.
    DeleteOwn(Vec<u8>),
}

/// A client, and its log blocks.
#[derive(Debug)]
struct Session {
    address: SocketAddr,
    /// Whether the client has been silent for so long that it counts as gone.
    is_gone: bool,
    /// The numbers of its log blocks: the client's, and the drone's.
    blocks: Vec<(u8, u8)>,
}

/// The clients of one drone, the one that spoke last at the end.
#[derive(Debug)]
pub(super) struct Clients {
    most: usize,
    sessions: Vec<Session>,
    /// Addresses whose place a newer client has, and whether that was told.
    displaced: Vec<(SocketAddr, bool)>,
}

impl Clients {
    /// The clients of a drone that serves at most so many.
    pub(super) const fn new(most: usize) -> Self {
        Self { most, sessions: Vec::new(), displaced: Vec::new() }
    }

    /// Whether no client has come yet.
    pub(super) const fn is_empty(&self) -> bool {
        self.sessions.is_empty()
    }

    /// Whether each client has its own log blocks.
    const fn are_apart(&self) -> bool {
        self.most > 1
    }

    /// Takes the sender of a packet as a client, and returns the drone's numbers of the log blocks of
    /// clients that are no more.
    pub(super) fn admit(&mut self, from: SocketAddr, packet: &[u8]) -> (Taken, Vec<u8>) {
        // Positions, and the emergency stop of old clients.
        if is_of(packet, Port::Localization) {
            return (Taken::NoClient, Vec::new());
        }
        if let Some((_, told)) = self.displaced.iter_mut().find(|(address, _)| *address == from) {
            let is_first = !std::mem::replace(told, true);
            return (Taken::Displaced { is_first }, Vec::new());
        }
        let known = self.sessions.iter().position(|session| session.address == from);
        let mut session = match known {
            Some(place) => self.sessions.remove(place),
            None => Session { address: from, is_gone: false, blocks: Vec::new() },
        };
        session.is_gone = false;
        let mut orphans = Vec::new();
        if known.is_none() {
            orphans = self.make_room();
        }
        self.sessions.push(session);
        (Taken::Client, orphans)
    }

    /// Whether a displaced client's packet is taken all the same: it may be an emergency stop.
    pub(super) fn is_open_to_all(packet: &[u8]) -> bool {
        is_of(packet, Port::Supervisor)
    }

    /// Removes the clients that are gone and, where there is no room for one more, the one that has
    /// been silent for longest.
    fn make_room(&mut self) -> Vec<u8> {
        let mut orphans = self.remove_gone();
        if self.sessions.len() >= self.most && !self.sessions.is_empty() {
            let Session { address, blocks, .. } = self.sessions.remove(0);
            orphans.extend(blocks.iter().map(|(_, at_drone)| *at_drone));
            if self.displaced.len() == DISPLACED {
                self.displaced.remove(0);
            }
            self.displaced.push((address, false));
        }
        orphans
    }

    fn remove_gone(&mut self) -> Vec<u8> {
        let is_gone = |session: &mut Session| session.is_gone;
        self.sessions
            .extract_if(.., is_gone)
            .flat_map(|session| session.blocks)
            .map(|(_, at_drone)| at_drone)
            .collect()
    }

    /// Takes that a client is gone, and returns the drone's numbers of the blocks to delete. The
    /// blocks of the only client stay until the next one comes, as on a Crazyflie.
    pub(super) fn gone(&mut self, from: SocketAddr) -> Vec<u8> {
        self.displaced.clear();
        for session in self.sessions.iter_mut().filter(|session| session.address == from) {
            session.is_gone = true;
        }
        if self.sessions.iter().all(|session| session.is_gone) {
            return Vec::new();
        }
        self.remove_gone()
    }

    /// Returns what the drone is to get for a packet of the client that spoke last.
    pub(super) fn step(&mut self, packet: &[u8]) -> Step {
        let as_it_is = || Step::Give(packet.to_owned(), None);
        if !self.are_apart() || !is_log(packet, CONTROL) {
            return as_it_is();
        }
        let is_alone = self.sessions.len() == 1;
        let Some(session) = self.sessions.last_mut() else { return as_it_is() };
        match packet {
            [_, RESET, ..] => {
                let blocks = std::mem::take(&mut session.blocks);
                if is_alone {
                    return as_it_is();
                }
                Step::DeleteOwn(blocks.iter().map(|(_, at_drone)| *at_drone).collect())
            }
            [header, command, own, rest @ ..] => {
                let renumbered = self.renumber(*own, CREATE.contains(command));
                let bytes = [&[*header, *command, renumbered.at_drone], rest].concat();
                Step::Give(bytes, Some(renumbered))
            }
            _ => as_it_is(),
        }
    }

    /// The number at the drone of a block of the client that spoke last. A block that the client does
    /// not have gets a number that no block has, so that the drone finds none either.
    fn renumber(&mut self, own: u8, creates: bool) -> Renumbered {
        let is_taken = |number: u8| {
            self.sessions.iter().flat_map(|session| &session.blocks).any(|(_, n)| *n == number)
        };
        let free = std::iter::once(own).chain(0..=u8::MAX).find(|number| !is_taken(*number));
        let free = free.unwrap_or(own);
        let Some(session) = self.sessions.last_mut() else {
            return Renumbered { own, at_drone: own, is_new: false };
        };
        let known = session.blocks.iter().find(|(number, _)| *number == own).map(|(_, n)| *n);
        let is_new = creates && known.is_none();
        if is_new {
            session.blocks.push((own, free));
        }
        Renumbered { own, at_drone: known.unwrap_or(free), is_new }
    }

    /// Notes the drone's answer to a request about a block: one that was not created, or is deleted,
    /// belongs to no client. Returns whether the drone may have a part of it that is to be deleted.
    pub(super) fn note(&mut self, answer: &[u8], renumbered: Renumbered) -> bool {
        let [_, command, _, error, ..] = *answer else { return false };
        let failed = renumbered.is_new && error != 0 && error != EXISTS;
        if (command == DELETE && error == 0) || failed {
            let own = renumbered.own;
            if let Some(session) = self.sessions.last_mut() {
                session.blocks.retain(|(number, _)| *number != own);
            }
        }
        failed
    }

    /// Gives `send` the receivers of a packet of the drone, with the bytes for each.
    pub(super) fn route(
        &self,
        packet: &[u8],
        asker: Asker,
        send: &mut dyn FnMut(SocketAddr, &[u8]),
    ) {
        if is_of(packet, Port::Console) {
            return self.sessions.iter().for_each(|session| send(session.address, packet));
        }
        if self.are_apart() && is_log(packet, ROWS) {
            if let Some((address, own)) = packet.get(1).and_then(|number| self.owner(*number)) {
                send(address, &with(packet, 1, own));
            }
            return;
        }
        match asker {
            Asker::Server => {}
            Asker::Newest => {
                if let Some(session) = self.sessions.last() {
                    send(session.address, packet);
                }
            }
            Asker::One(address, Some(Renumbered { own, .. })) if is_log(packet, CONTROL) => {
                send(address, &with(packet, 2, own));
            }
            Asker::One(address, _) => send(address, packet),
        }
    }

    /// The client that has the block of a number at the drone, and the client's number of it.
    fn owner(&self, number: u8) -> Option<(SocketAddr, u8)> {
        self.sessions.iter().find_map(|session| {
            let (own, _) = session.blocks.iter().find(|(_, at_drone)| *at_drone == number)?;
            Some((session.address, *own))
        })
    }
}

/// The request to delete the block of a number.
pub(super) const fn delete(number: u8) -> [u8; 3] {
    [CONTROL_HEADER, DELETE, number]
}

/// The answer to a client that has deleted all its blocks.
pub(super) const IS_RESET: [u8; 4] = [CONTROL_HEADER, RESET, 0, 0];

/// Whether a packet is of this port, which stands in the high half of its header.
fn is_of(packet: &[u8], port: Port) -> bool {
    packet.first().is_some_and(|header| header >> 4 == port as u8)
}

/// Whether a packet is of this channel of the log.
fn is_log(packet: &[u8], channel: u8) -> bool {
    is_of(packet, Port::Log) && packet.first().is_some_and(|header| header & 3 == channel)
}

/// Whether a packet answers a request about a log block.
pub(super) fn is_of_control(packet: &[u8]) -> bool {
    is_log(packet, CONTROL)
}

fn with(packet: &[u8], place: usize, byte: u8) -> Vec<u8> {
    let mut bytes = packet.to_owned();
    if let Some(at) = bytes.get_mut(place) {
        *at = byte;
    }
    bytes
}
