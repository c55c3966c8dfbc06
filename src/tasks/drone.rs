//! The one `onboard::Drone`, which the tasks of the thread share.
//!
//! They need no lock for it: one executor runs them, one at a time, and no task waits while it has
//! borrowed the drone. So its long operations, encryption and authentication, run with interrupts
//! enabled, and delay no control step.

use core::cell::{Cell, RefCell};

use airlink::Sealed;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use onboard::{Config, LinkHealth, Setup, State};
use static_cell::StaticCell;
use units::{Instant, Role};

use crate::safety::restart_mark;
use crate::tasks::{mission, radio};

/// The drone of this firmware.
pub(crate) type Drone = onboard::Drone<Sealed>;

/// The memory of the drone.
static DRONE: StaticCell<Drone> = StaticCell::new();

/// Makes the drone in its memory, once, switched off. It begins as a constant, of which the compiler
/// writes most parts in place; a drone of a setup would be made on the stack, and take half of it.
#[inline(never)]
pub(crate) fn make() -> Option<&'static mut Drone> {
    DRONE.try_init_with(Drone::switched_off)
}

/// The use that the firmware makes of the drone.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The number and the settings were not read yet.
    Unread,
    /// The drone takes part in the mission.
    Runs,
    /// The drone replays recorded packets, and nothing else.
    Replays,
}

/// The drone, which runs once [`crate::tasks::store`] has read its number and settings.
pub(crate) struct Shared {
    drone: RefCell<&'static mut Drone>,
    stage: Cell<Stage>,
    news: Signal<NoopRawMutex, ()>,
}

impl Shared {
    pub(crate) const fn new(drone: &'static mut Drone) -> Self {
        Self { drone: RefCell::new(drone), stage: Cell::new(Stage::Unread), news: Signal::new() }
    }

    /// Begins the run of the drone.
    #[inline(never)]
    pub(crate) fn begin(&self, config: Config, setup: &Setup) {
        if let Ok(mut drone) = self.drone.try_borrow_mut() {
            drone.begin(config, setup);
            self.stage.set(Stage::Runs);
        }
    }

    /// Does something with the drone, once it runs, and unless it replays.
    pub(crate) fn with<R>(&self, act: impl FnOnce(&mut Drone) -> R) -> Option<R> {
        // No other task has borrowed it now: see above.
        let mut drone = self.drone.try_borrow_mut().ok()?;
        (self.stage.get() == Stage::Runs).then(|| act(&mut drone))
    }

    /// Reserves the drone for the replay's task, until the next reset.
    pub(crate) fn reserve_for_replay(&self) {
        self.stage.set(Stage::Replays);
    }

    /// Whether the drone replays recorded packets.
    pub(crate) fn replays(&self) -> bool {
        self.stage.get() == Stage::Replays
    }

    /// Does something with the drone in a replay. What the drone decides is shown to the host; no
    /// task acts on it, not even on a stop.
    pub(crate) fn replay<R>(&self, act: impl FnOnce(&mut Drone) -> R) -> Option<R> {
        let mut drone = self.drone.try_borrow_mut().ok()?;
        self.replays().then(|| act(&mut drone))
    }

    /// The same, for calls after which there may be a packet to send or a stop to obey.
    pub(crate) fn tell<R>(&self, act: impl FnOnce(&mut Drone) -> R) -> Option<R> {
        let result = self.with(|drone| {
            let result = act(drone);
            obey_stop(drone);
            result
        });
        self.news.signal(());
        result
    }

    /// Lets the drone's link act on the time.
    pub(crate) fn attend(&self, now: Instant) {
        let changes = self.with(|drone| {
            let before = drone.operator();
            drone.attend(now);
            obey_stop(drone);
            before != drone.operator()
        });
        if changes == Some(true) {
            self.news.signal(());
        }
    }

    /// Waits for [`tell`](Self::tell). One task does.
    pub(crate) async fn news(&self) {
        self.news.wait().await;
    }

    /// When the next packet to the chain is due, if there is one.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.with(|drone| drone.due()).flatten()
    }

    /// Whether the drone may take part in the chain.
    pub(crate) fn health(&self) -> LinkHealth {
        self.with(|drone| drone.link_health()).unwrap_or(LinkHealth::NoKeys)
    }

    /// The state of the agent.
    pub(crate) fn state(&self) -> State {
        self.with(|drone| drone.state()).unwrap_or(State::Idle)
    }
}

/// Hands a stop to the motors at once, instead of in the next round of the mission, and marks it for
/// the next boot. Switching the drone off by its button clears the mark.
fn obey_stop(drone: &Drone) {
    let stops = drone.is_stopped();
    restart_mark::note_stopped(stops && !radio::is_shutting_down());
    if stops && drone.identity().role != Role::Base {
        mission::stop_motors();
    }
}
