//! The blue LED: what the drone is doing, for whoever stands beside it without a computer.
//!
//! A frame of two seconds is repeated as long as the state lasts. On the ground the LED is mostly
//! dark and its flashes are counted, at work in the air it is mostly lit and its gaps are counted,
//! and on the way between the two it flickers. No frame is all dark or all lit: a LED that stays
//! as it is means that the firmware does not run.

use agent::State;
use embassy_stm32::gpio::{Level, Output};
use embassy_time::{Duration, Ticker};

use crate::mind;

/// Two seconds in 32 slots, the first in the highest bit; a one is lit.
type Frame = u32;

/// One of the 32 slots of two seconds.
const SLOT: Duration = Duration::from_micros(62_500);

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(mut led: Output<'static>) -> ! {
    let mut ticker = Ticker::every(SLOT);
    let mut lamp = Lamp::new();
    loop {
        ticker.next().await;
        let state = mind::latest().map_or(State::Idle, |outputs| outputs.status.state);
        led.set_level(lamp.step(frame(state)));
    }
}

/// The frame being shown, turned so that the slot that comes next is its highest bit.
struct Lamp {
    whole: Frame,
    rest: Frame,
}

impl Lamp {
    const fn new() -> Self {
        Self { whole: 0, rest: 0 }
    }

    /// The next slot; a new frame begins at once, at its first.
    fn step(&mut self, wanted: Frame) -> Level {
        if wanted != self.whole {
            *self = Self { whole: wanted, rest: wanted };
        }
        let lit = self.rest.leading_ones() > 0;
        self.rest = self.rest.rotate_left(1);
        if lit { Level::High } else { Level::Low }
    }
}

/// The table in the book's chapter "The firmware" is this function.
fn frame(state: State) -> Frame {
    match state {
        State::Idle => 0b1000_0000_0000_0000_0000_0000_0000_0000,
        State::Armed { .. } => 0b1000_1000_0000_0000_0000_0000_0000_0000,
        State::Landed { .. } => 0b1000_1000_1000_0000_0000_0000_0000_0000,
        State::TakingOff { .. } => 0b1010_1010_1010_1010_1010_1010_1010_1010,
        State::Landing { .. } => 0b1100_1100_1100_1100_1100_1100_1100_1100,
        State::Leading { .. } => 0b0011_1111_1111_1111_1111_1111_1111_1111,
        State::Relaying { .. } => 0b0011_0011_1111_1111_1111_1111_1111_1111,
        State::Reconnecting { .. } => 0b0011_0011_0011_1111_1111_1111_1111_1111,
        State::BackingUp { .. } => 0b0011_0011_0011_0011_1111_1111_1111_1111,
        State::Stopped => 0b1111_1111_1111_1111_0000_0000_0000_0000,
    }
}
