//! The chain loop: five times a second the agent is told what happened and says what to do.
//!
//! Its set-point is left for the control loop to take ([`COMMAND`]), its report, and what the base
//! is to know of it, go to the link, and what it thinks is left for whoever looks ([`latest`]). It
//! waits for nothing but its tick.
//!
//! A drone whose link is shut, or that was refused by the chain, does not take off: nobody could
//! order it down again. Nor does one whose last run ended by a fault or in the air, before it was
//! told to wait. The base never does.

use core::mem::discriminant;

use agent::air::{self, Machine};
use agent::{Agent, AgentConfig, Fitness, Inputs, Outputs, State, mounting};
use chain::neighbours::Heard;
use chain::policy::Policy;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Ticker};
use flight::{Command, Mode};
use heapless::Vec;
use static_cell::StaticCell;
use storage::settings::Settings;
use units::{Instant, Order, Role};
use wire::p2p::Beacon;

use crate::health::{self, Tally, Task};
use crate::latest::Latest;
use crate::link::{Link, Standing};
use crate::{clock, control, panic, rangers, store};

/// One round: 5 Hz, the rate of the reports (`crates/agent`).
const ROUND: Duration = Duration::from_millis(200);

/// The agent is too large for a stack; here the linker accounts for it.
static AGENT: StaticCell<Agent> = StaticCell::new();

/// The last round's outputs.
static LATEST: Latest<Option<Outputs>> = Latest::new(None);

/// The set-point, for the control loop.
pub(crate) static COMMAND: Latest<Command> =
    Latest::new(Command { setpoint: units::Setpoint::Off, given: Instant::ZERO });

/// Reports that may come in between two rounds: one of each other drone of a chain.
const MAILBOX: usize = chain::neighbours::MAX_NEIGHBOURS + 1;
static HEARD: Channel<CriticalSectionRawMutex, Heard, MAILBOX> = Channel::new();

/// Reports that were dropped because the mailbox was full.
pub(crate) static MAILBOX_FULL: Tally = Tally::new();

/// The order that the agent is to hear of next.
static ORDER: Latest<Option<Order>> = Latest::new(None);

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

/// Orders something. A newer order goes before one that the agent has not heard of yet, except
/// before one to stop.
pub(crate) fn order(task: Order) {
    if ORDER.get() != Some(Order::Stop) {
        ORDER.set(Some(task));
    }
}

/// The task. `fault` says that the last run ended by one, or in the air.
#[embassy_executor::task]
pub(crate) async fn run(link: &'static Link, fault: bool) -> ! {
    let mut ticker = Ticker::every(ROUND);
    let settings = loop {
        ticker.next().await;
        health::sign(Task::Mind);
        if let Some(settings) = store::settings() {
            break settings;
        }
    };
    let (agent, config) = wake(&settings, fault);
    let me = Me { config, role: settings.role, link };
    defmt::info!("node {=u8}, {}", settings.node.0, settings.role);
    let mut state = agent.state();
    loop {
        ticker.next().await;
        health::sign(Task::Mind);
        let outputs = round(agent, &me);
        log_change(state, &outputs);
        state = outputs.status.state;
    }
}

/// The one agent, and what the settings change of its configuration.
fn wake(settings: &Settings, fault: bool) -> (&'static mut Agent, AgentConfig) {
    let role = settings.role;
    let new = || match fault {
        true => Agent::restarted(settings.node, role),
        false => Agent::new(settings.node, role),
    };
    let Some(agent) = AGENT.try_init_with(new) else {
        panic::give_up("the agent was made twice");
    };
    let mut config = AgentConfig::DEFAULT;
    if let Some(height) = settings.height {
        config.flight.height = height;
    }
    if let Some(code) = settings.policy {
        match Policy::with_code(code) {
            Some(policy) => config.policy = policy.config,
            None => defmt::error!("the default is flown instead of the unknown {}", code),
        }
    }
    let limited = config.with_limits(settings.limits.launch, settings.limits.retreat);
    match limited.check() {
        Ok(()) => config = limited,
        Err(why) => defmt::error!("the limits that were set are not used: {}", why),
    }
    (agent, config)
}

/// What does not change from round to round.
struct Me {
    config: AgentConfig,
    role: Role,
    link: &'static Link,
}

/// One round: listen, think, speak.
fn round(agent: &mut Agent, me: &Me) -> Outputs {
    let mut heard = Vec::<Heard, MAILBOX>::new();
    // One more than there is room for would stay in the mailbox.
    while !heard.is_full()
        && let Ok(report) = HEARD.try_receive()
    {
        let _ = heard.push(report);
    }
    let now = clock::now();
    let inputs = inputs(now, &heard, me.link);
    let outputs = step(agent, &me.config, now, &inputs);
    let setpoint = match me.role {
        Role::Base => units::Setpoint::Off,
        Role::Head | Role::Relay => mounting::to_board(outputs.setpoint),
    };
    COMMAND.set(Command { setpoint, given: now });
    speak(me, &outputs, &inputs);
    LATEST.set(Some(outputs));
    outputs
}

/// Tells the others by the link.
fn speak(me: &Me, outputs: &Outputs, inputs: &Inputs<'_>) {
    let status = control::STATUS.get();
    let battery = status.map(|status| status.battery.volts).filter(|volts| volts.0 > 0.0);
    let machine = Machine {
        fitness: inputs.fitness,
        battery,
        endurance: inputs.endurance,
        height: inputs.height,
        // The link fills it in.
        heeded: None,
    };
    me.link.tell(|end| {
        end.beacon(Beacon { role: me.role, state: outputs.status.state.code(), battery });
        end.report(air::report_to_air(outputs));
        if me.role != Role::Base {
            end.telemeter(air::telemetry(outputs, &machine));
        }
    });
}

/// What the drone senses and hears. Before the first step of the control loop it senses nothing.
fn inputs<'a>(now: Instant, heard: &'a [Heard], link: &Link) -> Inputs<'a> {
    let status = control::STATUS.get();
    let standing = link.standing();
    let fitness = |status: flight::Status| fitness(status.mode, now, standing);
    Inputs {
        ranges: rangers::sides(now).diagonals(),
        velocity: status.and_then(|status| status.velocity).map(mounting::from_board),
        heading: status.map(|status| mounting::heading(status.attitude.yaw)),
        height: status.and_then(|status| status.height),
        heard,
        order: ORDER.take(),
        fitness: status.map_or(Fitness::Unfit, fitness),
        endurance: status.and_then(|status| status.battery.endurance),
        emergency: false,
    }
}

/// To the navigator a beam that says nothing is one that sees nothing, so a drone that misses one
/// does not take off; nor one that nobody would hear.
fn fitness(mode: Mode, now: Instant, standing: Standing) -> Fitness {
    match mode {
        Mode::Grounded { .. } if standing != Standing::Fine || !rangers::all_sides(now) => {
            Fitness::Unfit
        }
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
