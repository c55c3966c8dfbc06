//! The mission loop: steps the drone five times a second with its sensors' values.
//!
//! The control loop takes the set-point from [`COMMAND`]; the link sends report and telemetry. The
//! loop waits for its tick only.

use core::mem::discriminant;

use agent::{AgentConfig, Exploration, Inputs};
use embassy_time::{Duration, Ticker};
use flight::Command;
use onboard::{Outputs, Sensed, State};
use units::{Instant, Metres, Setpoint};

use crate::board::clock;
use crate::probe::UCHAIN_PROBE;
use crate::tasks::drone::{Drone, Shared};
use crate::tasks::health::{self, Task};
use crate::tasks::latest::Latest;
use crate::tasks::{control, radio, rangers};

/// The period of the loop: 5 Hz, the rate of the reports (`crates/agent`).
const ROUND: Duration = Duration::from_millis(200);

/// The reach of the side beams: the agent takes a longer range for clear.
const REACH: Metres = AgentConfig::DEFAULT.nav.reach;

/// The set-point, for the control loop.
pub(crate) static COMMAND: Latest<Command> =
    Latest::new(Command { setpoint: Setpoint::Off, given: Instant::ZERO });

/// Stops the motors for good.
pub(crate) fn stop_motors() {
    COMMAND.set(Command { setpoint: Setpoint::Stop, given: clock::now() });
}

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(shared: &'static Shared, exploration: &'static mut Exploration) -> ! {
    let mut ticker = Ticker::every(ROUND);
    let mut state = State::Idle;
    loop {
        ticker.next().await;
        health::sign(Task::Mission);
        if let Some(outputs) = shared.tell(|drone| round(drone, exploration)) {
            log_change(state, &outputs);
            state = outputs.agent.status.state;
        }
    }
}

/// One round: sense, decide, publish.
fn round(drone: &mut Drone, exploration: &mut Exploration) -> Outputs {
    let now = clock::now();
    drone.note_hardware(radio::hardware_fault());
    drone.note_radio(radio::release());
    let outputs = step(drone, now, &sensed(now), exploration);
    COMMAND.set(Command { setpoint: outputs.board_setpoint(), given: now });
    outputs
}

/// The values of the drone's sensors.
fn sensed(now: Instant) -> Sensed {
    let status = control::STATUS.get();
    status.map_or(Sensed::NOT_YET, |status| Sensed::by_board(&status, &rangers::sides(now), REACH))
}

/// Steps the drone. It is not inlined, so that `.ci/sizes` can measure it and all that it calls.
#[inline(never)]
fn step(
    drone: &mut Drone,
    now: Instant,
    sensed: &Sensed,
    exploration: &mut Exploration,
) -> Outputs {
    let show = |inputs: &Inputs<'_>, outputs: &_| UCHAIN_PROBE.show_round(now, inputs, outputs);
    drone.step_shown(now, sensed, Some(exploration), show)
}

fn log_change(before: State, outputs: &Outputs) {
    let status = &outputs.agent.status;
    if discriminant(&before) != discriminant(&status.state) {
        defmt::info!(
            "{=str} -> {=str}, front {} dBm, back {} dBm, odometer {=f32} m",
            before.name(),
            status.state.name(),
            status.front.map(|link| link.rssi.0),
            status.back.map(|link| link.rssi.0),
            status.here.odometer.0,
        );
        defmt::debug!("{}", status.state);
    }
}
