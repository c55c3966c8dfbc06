//! Reads a table of the base, of log variables or of parameters, row by row.

use std::collections::BTreeMap;

use units::{Duration, Instant};
use wire::crtp::{LogRequest, Packet, ParamRequest, Port, Request};

/// The number of rows that are asked for at the same time. A drone's server queues 16 answers
/// (`crtp`, `server.rs`), of which the other requests need some.
const WINDOW: usize = 8;

/// The time after which a question without an answer is asked again. At 100 polls a second, eight
/// answers through a Crazyradio take 0.1 s.
const AGAIN: Duration = Duration::from_millis(300);

/// The service that a table belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// The log.
    Log,
    /// The parameters.
    Param,
}

impl Service {
    const fn port(self) -> Port {
        match self {
            Self::Log => Port::Log,
            Self::Param => Port::Param,
        }
    }

    fn ask_size(self) -> Packet {
        match self {
            Self::Log => Request::Log(LogRequest::TableInfo).packet(),
            Self::Param => Request::Param(ParamRequest::TableInfo).packet(),
        }
    }

    fn ask_row(self, row: u16) -> Packet {
        match self {
            Self::Log => Request::Log(LogRequest::TableItem(row)).packet(),
            Self::Param => Request::Param(ParamRequest::TableItem(row)).packet(),
        }
    }
}

/// A table that was read: the row of each name, which is written `group.name`.
pub type Rows = BTreeMap<String, u16>;

/// The reading of one table.
#[derive(Debug)]
pub struct TableReader {
    service: Service,
    progress: Progress,
}

/// How much of the table is known.
#[derive(Debug)]
enum Progress {
    /// The number of rows was asked for at this time, or not yet.
    Size(Option<Instant>),
    Rows {
        count: u16,
        /// The next row to be asked for.
        next: u16,
        /// The rows that were asked for and have not come, with the time of the question.
        open: BTreeMap<u16, Instant>,
        read: Rows,
    },
}

impl TableReader {
    /// A reader that has asked for nothing yet.
    #[must_use]
    pub const fn new(service: Service) -> Self {
        Self { service, progress: Progress::Size(None) }
    }

    /// The next question to be sent, if one is due.
    pub fn poll(&mut self, now: Instant) -> Option<Packet> {
        let service = self.service;
        match &mut self.progress {
            Progress::Size(asked) => {
                if asked.is_some_and(|asked| now.since(asked) < AGAIN) {
                    return None;
                }
                *asked = Some(now);
                Some(service.ask_size())
            }
            Progress::Rows { count, next, open, .. } => {
                let late = open.iter().find(|(_, asked)| now.since(**asked) >= AGAIN);
                let row = match late {
                    Some((row, _)) => *row,
                    None if open.len() < WINDOW && *next < *count => {
                        *next += 1;
                        *next - 1
                    }
                    None => return None,
                };
                open.insert(row, now);
                Some(service.ask_row(row))
            }
        }
    }

    /// Takes a packet of the base. Returns the whole table with its last row.
    pub fn receive(&mut self, packet: &Packet) -> Option<Rows> {
        if packet.port() != Ok(self.service.port()) || packet.channel() != 0 {
            return None;
        }
        match (&mut self.progress, packet.data()) {
            (Progress::Size(_), [3, a, b, ..]) => {
                let count = u16::from_le_bytes([*a, *b]);
                let (open, read) = (BTreeMap::new(), Rows::new());
                self.progress = Progress::Rows { count, next: 0, open, read };
                None
            }
            (Progress::Rows { count, open, read, .. }, [2, a, b, _kind, name @ ..]) => {
                let row = u16::from_le_bytes([*a, *b]);
                open.remove(&row)?;
                read.insert(full_name(name)?, row);
                (read.len() == usize::from(*count)).then(|| std::mem::take(read))
            }
            _ => None,
        }
    }
}

/// The name of a row, which is laid out as `group 0 name 0`.
fn full_name(bytes: &[u8]) -> Option<String> {
    let mut parts = bytes.split(|byte| *byte == 0);
    let group = std::str::from_utf8(parts.next()?).ok()?;
    let name = std::str::from_utf8(parts.next()?).ok()?;
    Some(format!("{group}.{name}"))
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use crtp::{Access, Outcome, Parameters, Server, Snapshot};
    use proptest::prelude::*;

    use super::*;

    /// Reads a table from the server that the drones run; `lost` says which packets do not arrive.
    fn read(service: Service, mut lost: impl FnMut() -> bool) -> Rows {
        let (mut server, mut parameters) = (Server::new(), Parameters::DEFAULT);
        let mut reader = TableReader::new(service);
        let mut answers = VecDeque::new();
        for step in 0..10_000 {
            let now = Instant::from_millis(10 * step);
            while let Some(question) = reader.poll(now) {
                if !lost() {
                    let bytes = question.bytes();
                    server.receive(now, bytes, Access::Full, &mut parameters, |_, _| Outcome::Done);
                }
                while let Some(answer) = server.poll(now, &Snapshot::DEFAULT, &parameters) {
                    answers.push_back(answer);
                }
            }
            while let Some(answer) = answers.pop_front() {
                if !lost()
                    && let Some(rows) = reader.receive(&answer)
                {
                    return rows;
                }
            }
        }
        panic!("the table was not read within 100 s");
    }

    #[test]
    fn both_tables_are_read_whole() {
        let log = read(Service::Log, || false);
        assert!(log.contains_key("node15.backRssi") && log.contains_key("uchain.state"));
        let parameters = read(Service::Param, || false);
        assert_eq!(parameters.len(), crtp::parameters().count());
        assert_eq!(parameters["uchain.task"], crtp::ParameterId::TASK.row());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

        /// A table is read whole whichever half of the packets is lost.
        #[test]
        fn lost_packets_are_asked_for_again(pattern in prop::collection::vec(any::<bool>(), 97)) {
            prop_assume!(pattern.iter().any(|lost| !lost));
            let mut packets = pattern.iter().cycle();
            let mut turn = 0_u32;
            let rows = read(Service::Param, || {
                turn += 1;
                *packets.next().unwrap() && !turn.is_multiple_of(3)
            });
            prop_assert_eq!(rows.len(), crtp::parameters().count());
        }
    }
}
