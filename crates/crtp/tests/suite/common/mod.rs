//! A client's side of the line: bytes out, bytes in.

#![allow(dead_code, reason = "each test takes what it needs")]

use crtp::{Access, Event, Outcome, Parameters, Server, Snapshot};
use proptest::test_runner::{Config, RngSeed};
use units::{Duration, Instant};

/// Settings for a property, the same on each machine.
pub(crate) fn seeded() -> Config {
    Config { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// A drone, and what a client does with it.
pub(crate) struct Line {
    pub(crate) server: Server,
    pub(crate) parameters: Parameters,
    pub(crate) snapshot: Snapshot,
    pub(crate) access: Access,
    pub(crate) now: Instant,
    /// What the drone says to every event.
    pub(crate) outcome: Outcome,
}

impl Line {
    pub(crate) fn new() -> Self {
        Self {
            server: Server::new(),
            parameters: Parameters::DEFAULT,
            snapshot: Snapshot::DEFAULT,
            access: Access::Full,
            now: Instant::from_millis(1_000),
            outcome: Outcome::Done,
        }
    }

    pub(crate) fn send(&mut self, header: u8, data: &[u8]) -> Option<Event> {
        self.receive(&[&[header], data].concat())
    }

    /// Sends any bytes; what the drone is asked to do for them.
    pub(crate) fn receive(&mut self, bytes: &[u8]) -> Option<Event> {
        let Self { server, parameters, now, access, outcome, .. } = self;
        let mut events = Vec::new();
        server.receive(*now, bytes, *access, parameters, |event, _| {
            events.push(event);
            *outcome
        });
        assert!(events.len() <= 1, "{events:?}");
        events.pop()
    }

    /// The next packet that comes: its header and its data.
    pub(crate) fn next(&mut self) -> Option<(u8, Vec<u8>)> {
        self.snapshot.taken = self.now;
        let packet = self.server.poll(self.now, &self.snapshot, &self.parameters)?;
        let (header, data) = packet.bytes().split_first()?;
        Some((*header, data.to_vec()))
    }

    /// Everything that comes now.
    pub(crate) fn all(&mut self) -> Vec<(u8, Vec<u8>)> {
        let all: Vec<_> = std::iter::from_fn(|| self.next()).take(10_000).collect();
        assert!(all.len() < 10_000, "there is no end to what is sent");
        all
    }

    /// Asks, and takes the one answer, which comes with the header that was asked with.
    pub(crate) fn ask(&mut self, header: u8, data: &[u8]) -> Vec<u8> {
        self.send(header, data);
        let answers: Vec<_> = self.all().into_iter().filter(|(port, _)| port >> 4 != 0).collect();
        let [(answered, data)] = &answers[..] else { panic!("{answers:?}") };
        assert_eq!(*answered, header);
        data.clone()
    }

    /// What the console says now.
    pub(crate) fn console(&mut self) -> String {
        self.all()
            .into_iter()
            .filter(|(header, _)| header >> 4 == 0)
            .map(|(_, text)| String::from_utf8(text).expect("each packet is text by itself"))
            .collect()
    }

    pub(crate) fn pass(&mut self, span: Duration) {
        self.now = self.now + span;
    }

    /// The errno of a control request to the log.
    pub(crate) fn control(&mut self, data: &[u8]) -> u8 {
        let answer = self.ask(0x5D, data);
        assert_eq!(answer.len(), 3);
        assert_eq!(answer[0], data[0]);
        answer[2]
    }

    /// The rows of a table as a client reads them: type, group, name.
    pub(crate) fn table(&mut self, header: u8) -> Vec<(u8, String, String)> {
        let info = self.ask(header, &[3]);
        let count = u16::from_le_bytes([info[1], info[2]]);
        (0..count)
            .map(|id| {
                let [a, b] = id.to_le_bytes();
                let row = self.ask(header, &[2, a, b]);
                assert_eq!(row[..3], [2, a, b]);
                let mut names = row[4..].split(|byte| *byte == 0);
                let mut name = || String::from_utf8(names.next().unwrap().to_vec()).unwrap();
                let (group, name) = (name(), name());
                assert_eq!(row.len(), 4 + group.len() + name.len() + 2);
                (row[3], group, name)
            })
            .collect()
    }

    /// The row of `group.name`.
    pub(crate) fn id_of(&mut self, header: u8, full_name: &str) -> [u8; 2] {
        let found = self
            .table(header)
            .iter()
            .position(|(_, group, name)| format!("{group}.{name}") == full_name);
        u16::try_from(found.expect(full_name)).unwrap().to_le_bytes()
    }
}

/// The headers of the ports, with their channels.
pub(crate) mod port {
    pub(crate) const PARAM_TABLE: u8 = 0x2C;
    pub(crate) const PARAM_READ: u8 = 0x2D;
    pub(crate) const PARAM_WRITE: u8 = 0x2E;
    pub(crate) const PARAM_MISC: u8 = 0x2F;
    pub(crate) const RPYT: u8 = 0x3C;
    pub(crate) const MEMORY: u8 = 0x4C;
    pub(crate) const LOG_TABLE: u8 = 0x5C;
    pub(crate) const LOG_CONTROL: u8 = 0x5D;
    pub(crate) const LOG_DATA: u8 = 0x5E;
    pub(crate) const SETPOINT: u8 = 0x7C;
    pub(crate) const HIGH_LEVEL: u8 = 0x8C;
    pub(crate) const SUPERVISOR: u8 = 0x9C;
    pub(crate) const COMMAND: u8 = 0x9D;
    pub(crate) const PLATFORM: u8 = 0xDC;
    pub(crate) const VERSION: u8 = 0xDD;
    pub(crate) const ECHO: u8 = 0xFC;
    pub(crate) const SOURCE: u8 = 0xFD;
}
