//! Simulates drones that run the firmware's ELF, in the same world as all others.
//!
//! An emulated drone has the body of one at flight level, without the flight code of the host: true
//! values go into the registers of its emulated sensors, the duties of its motors come from the
//! pins of its emulated timers, and its packets go over the emulated radio chip. For the record,
//! its agent's decisions are read from the firmware's probe in its memory.
//!
//! | module | what it holds |
//! |---|---|
//! | [`firmware`](Firmware) | an ELF, and the address of its probe |
//! | `coupling` | sensors' registers and motors' pins to and from a body |
//! | `decisions` | the inputs and outputs of the firmware's agent, step by step |
//! | `provision` | the keys and settings of a drone before its first flight |
//! | `radio` | the radio chip's own firmware, from a file |
//! | `shadow` | the agent of the host that follows the one of a drone that explores |
//! | `watch` | the log of a drone, and the account of its processor's time |

pub mod coupling;
mod decisions;
mod firmware;
mod provision;
mod radio;
mod shadow;
mod watch;

use std::fmt;
use std::io;
use std::net::TcpListener;
use std::sync::Arc;

use agent::{Exploration, Outputs};
use flight::Status;
use onboard::{Fix, mounting};
use units::{Dbm, Metres, NodeId, Order, Role};
use virtual_crazyflie::board::{Config, Crazyflie};
use virtual_crazyflie::gdb::Debugger;
use virtual_crazyflie::log::{LogLine, Messages};
use virtual_crazyflie::machine::{Halt, Machine, MachineConfig};
use virtual_crazyflie::profile::Report;
use wire::crtp::Positions;
use wire::p2p::{self, Counter};
use wire::radio::timing::{self, RAMP_UP_US};

use crate::craft::{Craft, Surroundings};
use scenario::Scenario;

pub use firmware::Firmware;
pub use provision::unfit;
pub use radio::open_radio;
pub use watch::{AGENT_STEP, CONTROL_STEP};

use decisions::Decisions;
use onboard::probe::Round;
use provision::provision;
use random::{Purpose, Stream};
use shadow::Shadow;
use watch::Watch;

/// Nanoseconds in a microsecond.
const US: u64 = 1_000;
/// The model of the radio chip has the times with which the link reckons.
const _: () = {
    use virtual_crazyflie::board::nrf51;
    assert!(nrf51::RAMP_UP == RAMP_UP_US * US);
    assert!(nrf51::ANSWERS_AFTER == timing::ANSWERS_AFTER_US * US);
    assert!(nrf51::LISTENS_AFTER == timing::LISTENS_AFTER_US * US);
    assert!(nrf51::ROUND == timing::ROUND_NS && nrf51::INTERRUPT == timing::INTERRUPT_NS);
    assert!(nrf51::PARSING == timing::PARSING_NS && nrf51::HANDLING == timing::HANDLING_NS);
    assert!(nrf51::COPYING == timing::COPYING_NS && nrf51::PASSING_ON == timing::PASSING_ON_NS);
    assert!(nrf51::BYTE == timing::LINE_IN_NS_PER_BYTE);
};
/// Drones are switched on at different times, up to so many µs apart.
const SWITCHED_ON_WITHIN_US: f32 = 200_000.0;

/// The reason why a mission with emulated drones cannot go on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Halted {
    /// The drone.
    pub node: NodeId,
    /// The event that stopped its machine.
    pub halt: Halt,
}

impl fmt::Display for Halted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "virtual drone {} {}", self.node.0, self.halt)
    }
}

impl std::error::Error for Halted {}

/// The program that advances the machine.
enum Core {
    /// The mission.
    Free(Box<Machine<Crazyflie>>),
    /// A GDB, which may hold the machine.
    Debugged(Box<Debugger<Machine<Crazyflie>>>),
}

impl Core {
    fn machine(&self) -> &Machine<Crazyflie> {
        match self {
            Self::Free(machine) => machine,
            Self::Debugged(debugger) => debugger.machine(),
        }
    }

    fn into_machine(self) -> Machine<Crazyflie> {
        match self {
            Self::Free(machine) => *machine,
            Self::Debugged(debugger) => debugger.into_machine(),
        }
    }

    fn machine_mut(&mut self) -> &mut Machine<Crazyflie> {
        match self {
            Self::Free(machine) => machine,
            Self::Debugged(debugger) => debugger.machine_mut(),
        }
    }
}

/// A packet of the chain that an emulated drone has sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OnAir {
    /// When its first bit was on the air, by the mission's clock.
    pub on_air_us: u64,
    /// The bytes of its data.
    pub bytes: usize,
}

/// One emulated drone.
pub struct Emulated {
    node: NodeId,
    core: Core,
    watch: Watch,
    firmware: Firmware,
    /// When it is switched on, by the mission's clock.
    on_us: u64,
    last_order: Option<Counter>,
    packets: Vec<OnAir>,
    decisions: Option<Decisions>,
    shadow: Option<Shadow>,
}

impl Emulated {
    /// A drone of this scenario, provisioned and switched off.
    #[must_use]
    pub fn new(scenario: &Scenario, firmware: &Firmware, node: NodeId, seed: u64) -> Self {
        Self::on(scenario, firmware, node, seed, MachineConfig::default())
    }

    /// Makes a drone as [`new`](Self::new) does, with another configuration of the machine.
    #[must_use]
    pub fn on(
        scenario: &Scenario,
        firmware: &Firmware,
        node: NodeId,
        seed: u64,
        config: MachineConfig,
    ) -> Self {
        // A base has no decks.
        let flies = scenario.drones.role(node.0.into()) != Role::Base;
        let board = Config { flow_deck: flies, multi_ranger: flies, ..Config::default() };
        Self::with_board(scenario, firmware, node, seed, config, board)
    }

    /// Makes a drone as [`on`](Self::on) does, with another board; its EEPROM is the provisioned
    /// drone's.
    #[must_use]
    pub fn with_board(
        scenario: &Scenario,
        firmware: &Firmware,
        node: NodeId,
        seed: u64,
        config: MachineConfig,
        board: Config,
    ) -> Self {
        let mut random = Stream::new(seed, Purpose::Radio(node.0));
        let provisions = provision(scenario, node, seed);
        let radio = firmware.radio().cloned();
        let board = Crazyflie::new(&Config { eeprom: provisions.eeprom, radio, ..board });
        let mut machine = firmware.machine(board, config);
        machine.memory_mut().program(storage::keys::PAGE_ADDRESS, &provisions.page);
        let on_us = (random.uniform() * SWITCHED_ON_WITHIN_US) as u64;
        let watch = Watch::none(&machine);
        let core = Core::Free(Box::new(machine));
        Self {
            node,
            core,
            watch,
            firmware: firmware.clone(),
            on_us,
            last_order: None,
            packets: Vec::new(),
            decisions: None,
            shadow: Shadow::of(scenario, node),
        }
    }

    /// The machine, for observation.
    #[must_use]
    pub fn machine(&self) -> &Machine<Crazyflie> {
        self.core.machine()
    }

    /// The machine, to inject a fault.
    pub fn machine_mut(&mut self) -> &mut Machine<Crazyflie> {
        self.core.machine_mut()
    }

    /// The machine by itself, without a mission.
    #[must_use]
    pub fn into_machine(self) -> Machine<Crazyflie> {
        self.core.into_machine()
    }

    /// The drone's number.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Keeps the log of the drone from now on.
    pub fn read_log(&mut self, messages: &Arc<Messages>) {
        self.watch.read_log(messages);
    }

    /// The log of the drone.
    #[must_use]
    pub fn log(&self) -> &[LogLine] {
        self.watch.lines()
    }

    /// The lines of the log since the last call.
    pub fn new_lines(&mut self) -> &[LogLine] {
        self.watch.new_lines()
    }

    /// Records the inputs and outputs of its agent from now on.
    pub fn record_decisions(&mut self) {
        self.decisions = Some(Decisions::default());
    }

    /// The inputs and outputs of its agent since [`record_decisions`](Self::record_decisions);
    /// `None` where that was not called, or a round was missed.
    #[must_use]
    pub fn decisions(&self) -> Option<&[Round]> {
        self.decisions.as_ref()?.rounds()
    }

    /// The map of a drone that explores, by the same agent on the host.
    pub fn exploration(&self) -> Option<&Exploration> {
        self.shadow.as_ref().map(Shadow::exploration)
    }

    /// The rounds in which a drone that explores has decided as the agent on the host does of the same
    /// inputs, and those in which it has not; `None` for another mission.
    #[must_use]
    pub fn alike(&self) -> Option<[u32; 2]> {
        self.shadow.as_ref().map(Shadow::rounds)
    }

    /// Measures the processor's time, by function, from now on.
    pub fn profile(&mut self) {
        self.watch.profile(self.core.machine_mut());
    }

    /// Sets the measured times to zero.
    pub fn restart_profile(&mut self) {
        self.watch.restart(self.core.machine());
    }

    /// The account of the processor's time; `None` where none is kept.
    #[must_use]
    pub fn account(&self) -> Option<Report> {
        self.watch.report(self.core.machine())
    }

    /// Hands the machine to a GDB, and waits until one has connected.
    ///
    /// # Errors
    /// When no debugger can connect.
    pub fn debug(self, listener: TcpListener) -> io::Result<Self> {
        let mut debugger = Debugger::new(self.core.into_machine(), listener, None)?;
        debugger.wait_for_gdb()?;
        Ok(Self { core: Core::Debugged(Box::new(debugger)), ..self })
    }

    /// The ELF that it runs.
    #[must_use]
    pub const fn firmware(&self) -> &Firmware {
        &self.firmware
    }

    /// Runs up to a moment of its own clock, in ns, without a world; returns whether the control
    /// loop runs by then.
    pub fn has_booted_by(&mut self, nanos: u64) -> bool {
        self.core.machine_mut().run_until(nanos).is_ok() && self.status().is_some()
    }

    /// Converts a moment of the mission to the drone's own clock, in ns.
    #[must_use]
    pub const fn nanos(&self, mission_us: u64) -> u64 {
        mission_us.saturating_sub(self.on_us) * US
    }

    /// Runs up to this moment of the mission.
    pub fn run_until(&mut self, mission_us: u64) -> Result<(), Halted> {
        let until = self.nanos(mission_us);
        let ran = match &mut self.core {
            Core::Free(machine) => machine.run_until(until),
            Core::Debugged(debugger) => debugger.run_until(until),
        };
        self.watch.look(self.core.machine_mut());
        if let Some(decisions) = &mut self.decisions {
            decisions.look(&self.firmware, self.core.machine().memory());
        }
        if let Some(shadow) = &mut self.shadow {
            shadow.look(&self.firmware, self.core.machine().memory());
        }
        let ran = ran.and_then(|()| self.core.machine().radio_runs());
        ran.map_err(|halt| Halted { node: self.node, halt })
    }

    /// The packets that its radio has sent since the last call, with the moment at which each goes
    /// on the air.
    pub fn take_sent(&mut self, mut take: impl FnMut(u64, Vec<u8>)) {
        for sent in self.core.machine_mut().board_mut().take_packets() {
            let on_air_us = self.on_us + (sent.at + RAMP_UP_US * US).div_ceil(US);
            if sent.port == p2p::PORT {
                self.packets.push(OnAir { on_air_us, bytes: sent.data.len() });
                take(on_air_us, sent.data);
            }
        }
    }

    /// The packets of the chain that it has sent.
    #[must_use]
    pub fn packets(&self) -> &[OnAir] {
        &self.packets
    }

    /// Delivers a packet of the chain.
    pub fn hear(&mut self, mission_us: u64, rssi: Dbm, data: &[u8]) {
        let at = self.nanos(mission_us);
        self.core.machine_mut().board_mut().hear(at, p2p::PORT, data, rssi);
    }

    /// Delivers a packet of a client, with the strength of a sender across the room.
    pub fn client(&mut self, mission_us: u64, packet: &[u8]) {
        const ACROSS_A_ROOM: Dbm = Dbm(-50.0);
        let at = self.nanos(mission_us);
        self.core.machine_mut().board_mut().hear_crtp(at, packet, ACROSS_A_ROOM);
    }

    /// Delivers a fix of a positioning system, as cflib's `send_extpose` sends it.
    pub fn locate(&mut self, mission_us: u64, fix: &Fix, height: Metres) {
        let at = [Metres(fix.at.x), Metres(fix.at.y), height];
        let yaw = fix.yaw.map(mounting::board_heading);
        let position = Positions::Own(wire::crtp::Fix { at, yaw });
        self.client(mission_us, wire::crtp::Request::Positions(position).packet().bytes());
    }

    /// The packets with which its radio chip has acknowledged those of clients.
    pub fn take_answers(&mut self, mut take: impl FnMut(&[u8])) {
        for answer in self.core.machine_mut().board_mut().take_crtp() {
            take(&answer.data);
        }
    }

    /// Returns the number of the last order received, if it has changed since the last call.
    pub fn newly_heeded(&mut self) -> Option<Counter> {
        let last = self.firmware.last_order(self.core.machine().memory());
        if last == self.last_order {
            return None;
        }
        self.last_order = last;
        last
    }

    /// The outputs of its agent's last step.
    pub fn outputs(&self) -> Option<Outputs> {
        Some(self.firmware.round(self.core.machine().memory())?.1.outputs)
    }

    /// The operator's order, as its agent had it in its last round.
    pub fn order(&self) -> Option<Order> {
        self.firmware.round(self.core.machine().memory())?.1.inputs.order
    }

    /// Moves its body by a millisecond: reads the motors' duties, and gives the sensors new values.
    pub fn fly(&mut self, craft: &mut Craft, around: Surroundings<'_>) {
        let board = self.core.machine_mut().board_mut();
        let observed = craft.observe(around, coupling::wants(board));
        coupling::show(board, &observed);
        craft.obey(around, coupling::duties(self.core.machine()), self.status());
    }

    fn status(&self) -> Option<Status> {
        self.firmware.status(self.core.machine().memory())
    }
}
