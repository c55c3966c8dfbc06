//! The chain loop: five times a second the agent is told what happened and says what to do.
//!
//! What it said last is kept in one place, [`latest`], from which the control loop will take its
//! set-point and the radio its report, each at its own pace; neither side ever waits for the
//! other.

use core::cell::Cell;
use core::mem::discriminant;

use agent::{Agent, AgentConfig, Inputs, Outputs, Role, Setpoint, State};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::{Duration, Ticker};
use static_cell::StaticCell;
use units::{Instant, NodeId};

use crate::made_up::MadeUp;

/// Who this drone is. It will be read from the EEPROM; the made-up world has a place for number 1.
const ME: NodeId = NodeId(1);

/// What this drone is.
const ROLE: Role = Role::Relay;

/// One round: 5 Hz, the rate of the reports (`crates/agent`).
const ROUND: Duration = Duration::from_millis(200);

/// The agent is too large for a stack; here the linker accounts for it.
static AGENT: StaticCell<Agent> = StaticCell::new();

/// The last round's outputs. A cell, because nobody waits for them and a cell cannot be borrowed
/// twice.
static LATEST: Mutex<CriticalSectionRawMutex, Cell<Option<Outputs>>> = Mutex::new(Cell::new(None));

/// What the agent decided last, or `None` before its first round.
pub(crate) fn latest() -> Option<Outputs> {
    LATEST.lock(Cell::get)
}

/// The one agent; `None` when it has been given out already.
pub(crate) fn new_agent() -> Option<&'static mut Agent> {
    AGENT.try_init_with(|| Agent::new(ME, ROLE))
}

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(agent: &'static mut Agent) -> ! {
    let mut ticker = Ticker::every(ROUND);
    let mut made_up = MadeUp::new();
    let mut setpoint = Setpoint::Off;
    let mut state = agent.state();
    loop {
        ticker.next().await;
        let now = Instant::from_micros(embassy_time::Instant::now().as_micros());
        let outputs = step(agent, now, &made_up.inputs(setpoint));
        log_change(state, &outputs);
        (setpoint, state) = (outputs.setpoint, outputs.status.state);
        LATEST.lock(|latest| latest.set(Some(outputs)));
    }
}

/// One round of the agent. Kept whole, with everything that it calls and nothing else, so that
/// `.ci/sizes` can weigh it.
#[inline(never)]
fn step(agent: &mut Agent, now: Instant, inputs: &Inputs<'_>) -> Outputs {
    agent.step(&AgentConfig::DEFAULT, now, inputs)
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
