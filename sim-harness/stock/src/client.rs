//! Simulates a ground station: it polls the drone as a Crazyradio does, and uses CRTP
//! (crazyflie-firmware, `docs/functional-areas/crtp`).

use std::collections::{HashMap, VecDeque};

use virtual_crazyflie::machine::Halt;

use super::StockDrone;

/// Milliseconds between two packets of the ground station: half of a Crazyradio's rate.
const POLL_MS: u64 = 2;
/// The null packet, and the bits of a header that make a packet one.
const NULL: u8 = 0xFF;
const NULL_MASK: u8 = 0xF3;
/// An answer comes within so many milliseconds, or the packet is sent again.
const PATIENCE_MS: u64 = 200;
const TRIES: usize = 5;

/// Services of CRTP.
mod port {
    pub(super) const CONSOLE: u8 = 0;
    pub(super) const PARAMETER: u8 = 2;
    pub(super) const LOG: u8 = 5;
    pub(super) const HIGH_LEVEL: u8 = 8;
    pub(super) const PLATFORM: u8 = 13;
}

/// The reason why an exchange with the drone failed.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// The emulator stopped the machine.
    Halted(Halt),
    /// The drone did not answer this.
    NoAnswer(&'static str),
    /// The drone has no variable of this name.
    NoVariable(&'static str),
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Halted(halt) => halt.fmt(f),
            Self::NoAnswer(what) => write!(f, "the drone did not answer: {what}"),
            Self::NoVariable(name) => write!(f, "the drone has no variable {name}"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<Halt> for Failure {
    fn from(halt: Halt) -> Self {
        Self::Halted(halt)
    }
}

/// A table of contents: the type and number of each variable, by `group.name`.
pub type Contents = HashMap<String, (u8, u16)>;

/// The ground station, and the drone to which it is connected.
pub struct Client {
    drone: StockDrone,
    /// Packets that wait to be sent, the first of which is on its way.
    waiting: VecDeque<Vec<u8>>,
    /// The first packet that waits has been sent and is not acknowledged.
    sent: bool,
    /// Packets of the drone but for those of the console and of log blocks.
    inbox: VecDeque<Vec<u8>>,
    console: Vec<u8>,
    /// The latest row of the log block, and how many there were.
    row: Vec<u8>,
    rows: u32,
}

impl Client {
    /// Makes a ground station that has not sent anything yet.
    #[must_use]
    pub const fn new(drone: StockDrone) -> Self {
        Self {
            drone,
            waiting: VecDeque::new(),
            sent: false,
            inbox: VecDeque::new(),
            console: Vec::new(),
            row: Vec::new(),
            rows: 0,
        }
    }

    /// The drone.
    #[must_use]
    pub const fn drone(&self) -> &StockDrone {
        &self.drone
    }

    /// The drone, to record its buses.
    pub const fn drone_mut(&mut self) -> &mut StockDrone {
        &mut self.drone
    }

    /// The text of the drone's console so far.
    #[must_use]
    pub fn console(&self) -> String {
        String::from_utf8_lossy(&self.console).into_owned()
    }

    /// The number of rows of the log block that were received.
    #[must_use]
    pub const fn rows(&self) -> u32 {
        self.rows
    }

    /// The float at a place in the latest row of the log block.
    #[must_use]
    pub fn float(&self, place: usize) -> Option<f32> {
        let bytes = self.row.get(4 * place..)?;
        bytes.first_chunk().map(|bytes| f32::from_le_bytes(*bytes))
    }

    /// Simulates a millisecond.
    ///
    /// # Errors
    /// When the emulator stops the machine.
    pub fn advance(&mut self) -> Result<(), Failure> {
        self.drone.advance()?;
        for packet in self.drone.take_answers() {
            if std::mem::take(&mut self.sent) {
                self.waiting.pop_front();
            }
            self.take(packet);
        }
        if self.drone.now_ms().is_multiple_of(POLL_MS) {
            let packet = self.waiting.front().cloned();
            self.sent = packet.is_some();
            self.drone.hear(&packet.unwrap_or_else(|| vec![NULL]));
        }
        Ok(())
    }

    fn take(&mut self, packet: Vec<u8>) {
        const LOG_DATA: u8 = port::LOG << 4 | 2;
        match packet.as_slice() {
            [header, ..] if header & NULL_MASK == NULL & NULL_MASK => {}
            [header, text @ ..] if header & NULL_MASK == port::CONSOLE << 4 => {
                self.console.extend_from_slice(text);
            }
            [header, _, _, _, _, row @ ..] if header & NULL_MASK == LOG_DATA => {
                self.row = row.to_vec();
                self.rows += 1;
            }
            _ => self.inbox.push_back(packet),
        }
    }

    /// Runs until the console has said this, or the time is over; whether it has.
    ///
    /// # Errors
    /// When the emulator stops the machine.
    pub fn wait_for(&mut self, text: &str, limit_ms: u64) -> Result<bool, Failure> {
        let until = self.drone.now_ms() + limit_ms;
        while self.drone.now_ms() < until {
            if self.console().contains(text) {
                return Ok(true);
            }
            for _ in 0..10 {
                self.advance()?;
            }
        }
        Ok(self.console().contains(text))
    }

    /// Puts a packet in the queue.
    fn send(&mut self, port: u8, channel: u8, data: &[u8]) {
        let mut packet = vec![port << 4 | 0x0C | channel];
        packet.extend_from_slice(data);
        self.waiting.push_back(packet);
    }

    /// Sends a request until the drone answers with the same service and `echo` first; the rest of
    /// the answer.
    fn ask(
        &mut self,
        (port, channel): (u8, u8),
        data: &[u8],
        echo: &[u8],
        what: &'static str,
    ) -> Result<Vec<u8>, Failure> {
        let wanted = port << 4 | channel;
        for _ in 0..TRIES {
            self.inbox.clear();
            self.send(port, channel, data);
            for _ in 0..PATIENCE_MS {
                self.advance()?;
                while let Some(packet) = self.inbox.pop_front() {
                    let body = packet.get(1..).unwrap_or_default();
                    if packet[0] & NULL_MASK == wanted && body.starts_with(echo) {
                        return Ok(body[echo.len()..].to_vec());
                    }
                }
            }
        }
        Err(Failure::NoAnswer(what))
    }

    /// The version of the drone's protocol.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn protocol(&mut self) -> Result<u8, Failure> {
        let answer = self.ask((port::PLATFORM, 1), &[0], &[0], "its protocol's version")?;
        answer.first().copied().ok_or(Failure::NoAnswer("its protocol's version"))
    }

    /// The table of the log's variables.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn log_contents(&mut self) -> Result<Contents, Failure> {
        self.contents(port::LOG)
    }

    /// The table of the parameters.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn parameters(&mut self) -> Result<Contents, Failure> {
        self.contents(port::PARAMETER)
    }

    fn contents(&mut self, port: u8) -> Result<Contents, Failure> {
        const INFO: u8 = 3;
        const ITEM: u8 = 2;
        const WHAT: &str = "a table of contents";
        let info = self.ask((port, 0), &[INFO], &[INFO], WHAT)?;
        let count = info.first_chunk().map(|count| u16::from_le_bytes(*count));
        let mut contents = Contents::new();
        for number in 0..count.ok_or(Failure::NoAnswer(WHAT))? {
            let [low, high] = number.to_le_bytes();
            let request = [ITEM, low, high];
            let item = self.ask((port, 0), &request, &request, WHAT)?;
            let (kind, names) = item.split_first().ok_or(Failure::NoAnswer(WHAT))?;
            let mut names = names.split(|byte| *byte == 0).map(String::from_utf8_lossy);
            let name = format!(
                "{}.{}",
                names.next().unwrap_or_default(),
                names.next().unwrap_or_default()
            );
            contents.insert(name, (*kind, number));
        }
        Ok(contents)
    }

    /// Begins a log block of these variables, each sent as a float, with a row every 10 ms.
    ///
    /// # Errors
    /// When there is no such variable, or the drone does not answer.
    pub fn log(&mut self, contents: &Contents, names: &[&'static str]) -> Result<(), Failure> {
        const CREATE: u8 = 6;
        const START: u8 = 8;
        const RESET: u8 = 5;
        const BLOCK: u8 = 1;
        const FLOAT: u8 = 7;
        const WHAT: &str = "a log block";
        self.ask((port::LOG, 1), &[RESET], &[RESET], WHAT)?;
        let mut create = vec![CREATE, BLOCK];
        for name in names {
            let (_, number) = contents.get(*name).ok_or(Failure::NoVariable(name))?;
            create.push(FLOAT);
            create.extend_from_slice(&number.to_le_bytes());
        }
        self.ask((port::LOG, 1), &create, &[CREATE, BLOCK, 0], WHAT)?;
        let [low, high] = 10_u16.to_le_bytes();
        self.ask((port::LOG, 1), &[START, BLOCK, low, high], &[START, BLOCK, 0], WHAT)?;
        self.rows = 0;
        Ok(())
    }

    /// Arms the drone; whether it is armed then.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn arm(&mut self) -> Result<bool, Failure> {
        const ARM: u8 = 1;
        let answer = self.ask((port::PLATFORM, 0), &[ARM, 1], &[ARM], "the request to arm")?;
        Ok(answer.last() == Some(&1))
    }

    /// Orders the drone's high-level commander to take off to a height, or to land at one, within a
    /// time.
    ///
    /// # Errors
    /// When it does not answer.
    pub fn climb(&mut self, to_m: f32, seconds: f32, lands: bool) -> Result<(), Failure> {
        const TAKE_OFF: u8 = 7;
        const LAND: u8 = 8;
        const ALL: u8 = 0;
        const KEEP_YAW: u8 = 1;
        let command = if lands { LAND } else { TAKE_OFF };
        let mut packet = vec![command, ALL];
        packet.extend_from_slice(&to_m.to_le_bytes());
        packet.extend_from_slice(&0.0_f32.to_le_bytes());
        packet.push(KEEP_YAW);
        packet.extend_from_slice(&seconds.to_le_bytes());
        self.ask((port::HIGH_LEVEL, 0), &packet, &[command], "the order to climb")?;
        Ok(())
    }
}
