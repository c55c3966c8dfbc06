//! The chain loop: five times a second the agent is told what happened and says what to do.
//!
//! Its set-point is left for the control loop to take ([`COMMAND`]), its report goes to the radio,
//! and what it thinks is left for whoever looks ([`latest`]). It waits for nothing but its tick.

use core::mem::discriminant;

use agent::{Agent, AgentConfig, Fitness, Inputs, Outputs, Role, State, mounting};
use chain::neighbours::Heard;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Ticker};
use flight::{Command, Mode};
use heapless::Vec;
use static_cell::StaticCell;
use units::Instant;
use wire::settings::{self, Settings};

use crate::health::{self, Tally, Task};
use crate::latest::Latest;
use crate::{clock, control, panic, radio, rangers, store};

/// One round: 5 Hz, the rate of the reports (`crates/agent`).
const ROUND: Duration = Duration::from_millis(200);

/// The agent is too large for a stack; here the linker accounts for it.
static AGENT: StaticCell<Agent> = StaticCell::new();

/// The last round's outputs.
static LATEST: Latest<Option<Outputs>> = Latest::new(None);

/// The set-point, for the control loop.
pub(crate) static COMMAND: Latest<Command> =
    Latest::new(Command { setpoint: flight::Setpoint::Off, given: Instant::ZERO });

/// Reports that may come in between two rounds: one of each other drone of a chain.
const MAILBOX: usize = chain::neighbours::MAX_NEIGHBOURS + 1;
static HEARD: Channel<CriticalSectionRawMutex, Heard, MAILBOX> = Channel::new();

/// Reports that were dropped because the mailbox was full.
pub(crate) static MAILBOX_FULL: Tally = Tally::new();

/// What the agent decided last, or `None` before its first round.
pub(crate) fn latest() -> Option<Outputs> {
    LATEST.get()
}

/// Puts a report into the mailbox. When it is full, the oldest goes.
pub(crate) fn hear(heard: Heard) {
    if HEARD.is_full() {
        let _ = HEARD.try_receive();
        MAILBOX_FULL.count();
    }
    let _ = HEARD.try_send(heard);
}

/// The task.
#[embassy_executor::task]
pub(crate) async fn run() -> ! {
    let mut ticker = Ticker::every(ROUND);
    let settings = loop {
        ticker.next().await;
        health::sign(Task::Mind);
        if let Some(settings) = store::settings() {
            break settings;
        }
    };
    let (agent, config) = wake(&settings);
    defmt::info!("node {=u8}, {}", settings.node.0, settings.role);
    let mut state = agent.state();
    loop {
        ticker.next().await;
        health::sign(Task::Mind);
        let outputs = round(agent, &config);
        log_change(state, &outputs);
        state = outputs.status.state;
    }
}

/// The one agent, and what the settings change of its configuration.
fn wake(settings: &Settings) -> (&'static mut Agent, AgentConfig) {
    let role = match settings.role {
        settings::Role::Head => Role::Head,
        settings::Role::Relay => Role::Relay,
        settings::Role::Base => Role::Base,
    };
    let Some(agent) = AGENT.try_init_with(|| Agent::new(settings.node, role)) else {
        panic::give_up("the agent was made twice");
    };
    let mut config = AgentConfig::DEFAULT;
    if let Some(height) = settings.height {
        config.flight.height = height;
    }
    (agent, config)
}

/// One round: listen, think, speak.
fn round(agent: &mut Agent, config: &AgentConfig) -> Outputs {
    let mut heard = Vec::<Heard, MAILBOX>::new();
    // One more than there is room for would stay in the mailbox.
    while !heard.is_full()
        && let Ok(report) = HEARD.try_receive()
    {
        let _ = heard.push(report);
    }
    let now = clock::now();
    let outputs = step(agent, config, now, &inputs(now, &heard));
    COMMAND.set(Command { setpoint: mounting::to_board(outputs.setpoint), given: now });
    radio::REPORT.signal(outputs.report);
    LATEST.set(Some(outputs));
    outputs
}

/// What the drone senses and hears. Before the first step of the control loop it senses nothing.
fn inputs(now: Instant, heard: &[Heard]) -> Inputs<'_> {
    let status = control::STATUS.get();
    Inputs {
        ranges: rangers::sides(now).diagonals(),
        velocity: status.and_then(|status| status.velocity).map(mounting::from_board),
        heading: status.map(|status| mounting::heading(status.attitude.yaw)),
        height: status.and_then(|status| status.height),
        heard,
        order: None,
        fitness: status.map_or(Fitness::Unfit, |status| fitness(status.mode, now)),
        endurance: status.and_then(|status| status.battery.endurance),
        emergency: false,
    }
}

/// To the navigator a beam that says nothing is one that sees nothing, so a drone that misses one
/// does not take off.
fn fitness(mode: Mode, now: Instant) -> Fitness {
    match mode {
        Mode::Grounded { .. } if !rangers::all_sides(now) => Fitness::Unfit,
        mode => mounting::fitness(mode),
    }
}

/// One round of the agent. Kept whole, with everything that it calls and nothing else, so that
/// `.ci/sizes` can weigh it.
#[inline(never)]
fn step(agent: &mut Agent, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
    agent.step(config, now, inputs)
}

fn log_change(before: State, outputs: &Outputs) {
    let status = &outputs.status;
    if discriminant(&before) != discriminant(&status.state) {
        defmt::info!(
            "{=str} -> {=str}, front {} dBm, back {} dBm, odometer {=f32} m",
            before.name(),
            status.state.name(),
            status.front.map(|link| link.rssi.0),
            status.back.map(|link| link.rssi.0),
            status.odometer.0,
        );
        defmt::debug!("{}", status.state);
    }
}
