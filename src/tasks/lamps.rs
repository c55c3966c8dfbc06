//! The LEDs, which show the drone's state to a person beside it without a computer.
//!
//! | LED | tells |
//! |---|---|
//! | blue, left | what the drone is doing |
//! | green, right | whether the drone may fly and transmit, and if not, why |
//! | red, right | battery and charger |
//! | green, left | reports of the chain, as they come in |
//! | red, left | faults |
//!
//! A LED repeats a frame of two seconds as long as nothing changes: flashes or gaps to be counted,
//! or a flicker. The blue LED is never dark or lit for a whole frame while the firmware runs.

use embassy_stm32::gpio::{Level, Output};
use embassy_time::{Duration, Ticker};
use flight::{Mode, NotReady};
use onboard::{ChainDuty, Duty, ExploreDuty, LinkHealth, State, SwarmDuty};
use units::Role;

use crate::board::Lamps;
use crate::board::clock;
use crate::tasks::drone::Shared;
use crate::tasks::health::{self, Task};
use crate::tasks::{control, radio, rangers, store};

/// Two seconds in 32 slots, the first in the highest bit; a one is lit.
type Frame = u32;

/// One of the 32 slots of two seconds.
const SLOT: Duration = Duration::from_micros(62_500);

/// The task. `fault` says that the last run ended in a fault.
#[embassy_executor::task]
pub(crate) async fn run(lamps: Lamps, fault: bool, shared: &'static Shared) -> ! {
    let mut blue_left = Lamp::new(lamps.blue_left, Level::High);
    let mut green_left = Lamp::new(lamps.green_left, Level::Low);
    let mut red_left = Lamp::new(lamps.red_left, Level::Low);
    let mut green_right = Lamp::new(lamps.green_right, Level::Low);
    let mut red_right = Lamp::new(lamps.red_right, Level::Low);
    let mut heard = 0;
    let mut ticker = Ticker::every(SLOT);
    loop {
        ticker.next().await;
        health::sign(Task::Lamps);
        let mode = control::STATUS.get().map(|status| status.mode);
        blue_left.step(of_state(shared.state()));
        green_right.step(mode.map_or(DARK, |mode| of_readiness(mode, shared.health())));
        red_right.step(of_battery());
        red_left.step(of_faults(mode, fault));
        let news = radio::HEARD.get();
        green_left.step(if news == heard { DARK } else { LIT });
        heard = news;
    }
}

/// A LED, and the frame that it shows, turned so that the slot that comes next is its highest bit.
struct Lamp {
    led: Output<'static>,
    lit_when_high: bool,
    whole: Frame,
    rest: Frame,
}

impl Lamp {
    /// A dark LED, which is lit at this level of its pin.
    fn new(led: Output<'static>, lit: Level) -> Self {
        Self { led, lit_when_high: lit == Level::High, whole: DARK, rest: DARK }
    }

    /// Shows the next slot; a new frame begins at once, with its first slot.
    fn step(&mut self, wanted: Frame) {
        if wanted != self.whole {
            self.whole = wanted;
            self.rest = wanted;
        }
        let is_lit = self.rest.leading_ones() > 0;
        self.rest = self.rest.rotate_left(1);
        self.led.set_level(Level::from(is_lit == self.lit_when_high));
    }
}

// The tables in the book's chapter "The first flight" describe the functions below.

const DARK: Frame = 0;
const LIT: Frame = u32::MAX;
const FLASH_1: Frame = 0b1000_0000_0000_0000_0000_0000_0000_0000;
const FLASH_2: Frame = 0b1000_1000_0000_0000_0000_0000_0000_0000;
const FLASH_3: Frame = 0b1000_1000_1000_0000_0000_0000_0000_0000;
const FLASH_4: Frame = 0b1000_1000_1000_1000_0000_0000_0000_0000;
const FLASH_5: Frame = 0b1000_1000_1000_1000_1000_0000_0000_0000;
const FLASH_6: Frame = 0b1000_1000_1000_1000_1000_1000_0000_0000;
const FLASH_7: Frame = 0b1000_1000_1000_1000_1000_1000_1000_0000;
const LONG_1: Frame = 0b1111_1111_1111_0000_1000_0000_0000_0000;
const LONG_2: Frame = 0b1111_1111_1111_0000_1000_1000_0000_0000;
const LONG_3: Frame = 0b1111_1111_1111_0000_1000_1000_1000_0000;
const LONG_4: Frame = 0b1111_1111_1111_0000_1000_1000_1000_1000;
const GAP_1: Frame = 0b0011_1111_1111_1111_1111_1111_1111_1111;
const GAP_2: Frame = 0b0011_0011_1111_1111_1111_1111_1111_1111;
const GAP_3: Frame = 0b0011_0011_0011_1111_1111_1111_1111_1111;
const GAP_4: Frame = 0b0011_0011_0011_0011_1111_1111_1111_1111;
const FAST: Frame = 0b1010_1010_1010_1010_1010_1010_1010_1010;
const SLOW: Frame = 0b1100_1100_1100_1100_1100_1100_1100_1100;
const HALF: Frame = 0b1111_1111_1111_1111_0000_0000_0000_0000;

fn of_state(state: State) -> Frame {
    match state {
        State::Idle => FLASH_1,
        State::Armed { .. } => FLASH_2,
        State::Landed { .. } => FLASH_3,
        State::Perched => FLASH_4,
        State::TakingOff { .. } | State::Rising { .. } => FAST,
        State::Landing { .. } => SLOW,
        State::OnMission(Duty::Swarm(duty)) => match duty {
            SwarmDuty::Surveying => GAP_1,
            SwarmDuty::Gathering | SwarmDuty::Crossing | SwarmDuty::Returning => GAP_2,
            SwarmDuty::Hovering { .. } => GAP_3,
        },
        State::OnMission(Duty::Explore(duty)) => match duty {
            ExploreDuty::Exploring { .. } => GAP_1,
            ExploreDuty::Waiting | ExploreDuty::Returning { .. } => GAP_2,
            ExploreDuty::Lost { .. } => GAP_3,
        },
        State::OnMission(Duty::Chain(duty)) => match duty {
            ChainDuty::Leading { .. } => GAP_1,
            ChainDuty::Relaying { .. }
            | ChainDuty::Searching { .. }
            | ChainDuty::Retiring
            | ChainDuty::Homing
            | ChainDuty::Siting { .. } => GAP_2,
            ChainDuty::Reconnecting { .. } | ChainDuty::Rejoining { .. } => GAP_3,
            ChainDuty::BackingUp { .. } => GAP_4,
        },
        State::Stopped => HALF,
    }
}

/// The frame of the green LED on the right. The base shows only whether it may transmit.
fn of_readiness(mode: Mode, health: LinkHealth) -> Frame {
    let is_base = store::settings().is_some_and(|settings| settings.role == Role::Base);
    match mode {
        Mode::Grounded { .. } if radio::hardware_fault().is_some() => LONG_4,
        Mode::Grounded { .. } if is_base => of_link(health),
        Mode::Grounded { waits_for: None } if !rangers::sides(clock::now()).are_all_there() => {
            FLASH_7
        }
        Mode::Grounded { waits_for: None } => of_link(health),
        Mode::Grounded { waits_for: Some(reason) } => match reason {
            NotReady::Calibrating => FAST,
            NotReady::NoImu => FLASH_1,
            NotReady::NoFlow => FLASH_2,
            NotReady::NoHeight => FLASH_3,
            NotReady::NoBattery => FLASH_4,
            NotReady::BatteryLow => FLASH_5,
            NotReady::Tilted => FLASH_6,
        },
        Mode::Flying { .. } => GAP_2,
        Mode::Landing { .. } => SLOW,
        Mode::Landed { .. } => HALF,
        Mode::Stopped { .. } => DARK,
    }
}

fn of_link(health: LinkHealth) -> Frame {
    match health {
        LinkHealth::Fine => GAP_1,
        LinkHealth::NoKeys => LONG_1,
        LinkHealth::Shut => LONG_2,
        LinkHealth::Out => LONG_3,
    }
}

/// A drone in the air with less than this much flying left shows it.
const SCARCE: units::Duration = units::Duration::from_secs(60);

fn of_battery() -> Frame {
    let charger = radio::BATTERY.get();
    let left = control::STATUS.get().and_then(|status| status.battery.endurance);
    match charger {
        None => DARK,
        Some(battery) if battery.charging => HALF,
        Some(battery) if battery.usb => GAP_1,
        Some(_) if left.is_some_and(|left| left < SCARCE) => SLOW,
        Some(_) => DARK,
    }
}

fn of_faults(mode: Option<Mode>, fault: bool) -> Frame {
    match mode {
        Some(Mode::Stopped { .. }) => FAST,
        _ if fault => LIT,
        _ => DARK,
    }
}
