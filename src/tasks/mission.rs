//! The mission loop: five times a second the drone is told what it senses and decides what to do.
//!
//! Its set-point is left for the control loop to take ([`COMMAND`]); its report and its telemetry
//! leave by the link. The loop waits for nothing but its tick.

use core::mem::discriminant;

use agent::AgentConfig;
use embassy_time::{Duration, Ticker};
use flight::Command;
use onboard::{Outputs, Sensed, State};
use units::{Instant, Metres, Setpoint};

use crate::board::clock;
use crate::probe::UCHAIN_PROBE;
use crate::tasks::drone::{Drone, Shared};
use crate::tasks::health::{self, Task};
use crate::tasks::latest::Latest;
use crate::tasks::{control, rangers};

/// One round: 5 Hz, the rate of the reports (`crates/agent`).
const ROUND: Duration = Duration::from_millis(200);

/// Farther than this no drone steers by a side beam.
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
pub(crate) async fn run(shared: &'static Shared) -> ! {
    let mut ticker = Ticker::every(ROUND);
    let mut state = State::Idle;
    loop {
        ticker.next().await;
        health::sign(Task::Mission);
        if let Some(outputs) = shared.tell(round) {
            log_change(state, &outputs);
            state = outputs.agent.status.state;
        }
    }
}

/// One round: sense, decide, publish.
fn round(drone: &mut Drone) -> Outputs {
    let now = clock::now();
    let outputs = step(drone, now, &sensed(now));
    COMMAND.set(Command { setpoint: outputs.board_setpoint(), given: now });
    outputs
}

/// What the drone senses.
fn sensed(now: Instant) -> Sensed {
    let status = control::STATUS.get();
    status.map_or(Sensed::NOT_YET, |status| Sensed::by_board(&status, &rangers::sides(now), REACH))
}

/// One round of the drone. Kept whole, with everything that it calls and nothing else, so that
/// `.ci/sizes` can weigh it.
#[inline(never)]
fn step(drone: &mut Drone, now: Instant, sensed: &Sensed) -> Outputs {
    drone.step_shown(now, sensed, |inputs, outputs| UCHAIN_PROBE.show_round(now, inputs, outputs))
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
            status.odometer.0,
        );
        defmt::debug!("{}", status.state);
    }
}
