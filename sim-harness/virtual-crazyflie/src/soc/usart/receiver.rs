//! Receives bytes: samples at this end's rate a line that is driven at the other end's.
//!
//! The line is reconstructed from the byte and from the sender's bit time, and sampled where the
//! receiver samples it: three times in the middle of each of our bits, of which the majority counts
//! (RM0090, "Noise detection"). So a rate that is far off reads other bits, as it does on a wire. A
//! rate that is off by more than what the manual says the receiver tolerates is a framing error
//! even where the samples happen to be right.

use super::{Usart, cr1, cr3, place, sr};
use crate::soc::context::Context;
use crate::soc::wiring::{Board, Nanos, UartByte};

/// The state of the receiver. Moments are cycles.
#[derive(Clone, Copy, Debug)]
enum State {
    Quiet,
    /// A byte comes in: its stop bit is sampled then.
    Taking {
        byte: UartByte,
        until: u64,
    },
    /// The line has been high since the last byte, and it is an idle frame then.
    Waiting {
        until: u64,
    },
}

/// The receiving half.
pub(super) struct Receiver {
    state: State,
    /// A byte that began before this moment was not received from its start bit on.
    since: Nanos,
}

/// The byte that was sampled, with its errors.
struct Frame {
    data: u8,
    noise: bool,
    framing: bool,
}

impl Receiver {
    pub(super) const fn new() -> Self {
        Self { state: State::Quiet, since: 0 }
    }

    pub(super) const fn due(&self) -> u64 {
        match self.state {
            State::Quiet => u64::MAX,
            State::Taking { until, .. } | State::Waiting { until } => until,
        }
    }

    pub(super) const fn stop(&mut self) {
        self.state = State::Quiet;
    }
}

/// Takes the three samples of each bit, and compares the rates. `ours` is our bit in ns, `samples`
/// how many there are in a bit, `tolerance` in 1/10000.
fn sample(byte: UartByte, ours: u64, samples: u64, tolerance: u64) -> Frame {
    let theirs = u64::from(byte.bit.max(1));
    let level = |bit: u64| match bit {
        0 => false,
        1..=8 => byte.data >> (bit - 1) & 1 != 0,
        9 => !byte.broken,
        _ => true,
    };
    // In the middle and one before and after it, in halves of a sample.
    let offsets = [samples - 2, samples, samples + 2];
    let vote = |bit: u64| {
        let high = offsets
            .iter()
            .filter(|offset| level(ours * (2 * samples * bit + **offset) / (2 * samples * theirs)))
            .count();
        (high >= 2, !matches!(high, 0 | 3))
    };
    let mut noise = byte.noise;
    let mut data = 0;
    for bit in 1..=8 {
        let (high, differ) = vote(bit);
        data |= u8::from(high) << (bit - 1);
        noise |= differ;
    }
    let off = ours.abs_diff(theirs) * 10_000 > tolerance * ours;
    Frame { data, noise, framing: off || !vote(9).0 }
}

impl Usart {
    /// The receiver begins to listen: what is in the middle of a byte is not heard.
    pub(super) fn listen<B: Board>(&mut self, context: &Context<'_, B>) {
        self.receiver = Receiver { state: State::Quiet, since: context.nanos() };
    }

    /// Everything that has come in by now.
    pub(super) fn receive<B: Board>(&mut self, context: &mut Context<'_, B>) {
        loop {
            match self.receiver.state {
                State::Taking { byte, until } if until <= context.now => {
                    self.taken(byte, until, context);
                }
                State::Taking { .. } => return,
                State::Quiet => {
                    if !self.begin(context) {
                        return;
                    }
                }
                State::Waiting { until } => {
                    let comes = self.begin(context);
                    let begins = match self.receiver.state {
                        State::Taking { byte, .. } if comes => context.clocks.cycle(byte.at),
                        _ => u64::MAX,
                    };
                    if until <= context.now && until <= begins {
                        self.raise(sr::IDLE);
                        if !comes {
                            self.receiver.state = State::Quiet;
                        }
                    }
                    if !comes {
                        return;
                    }
                }
            }
        }
    }

    /// Takes the next byte from the board, if one has begun.
    fn begin<B: Board>(&mut self, context: &mut Context<'_, B>) -> bool {
        while let Some(byte) = context.board.uart_give(self.bus) {
            let hears = self.is_on(cr1::UE | cr1::RE)
                && byte.at >= self.receiver.since
                && self.has_pin(context, place(self.bus).receives);
            if hears {
                let start = context.clocks.cycle(byte.at);
                let until = start + self.bit(context) * 19 / 2;
                self.receiver.state = State::Taking { byte, until };
                return true;
            }
        }
        false
    }

    fn taken<B: Board>(&mut self, byte: UartByte, until: u64, context: &Context<'_, B>) {
        let bit = self.bit(context);
        let clocks = context.clocks;
        let ours = (clocks.nanos(until + 1000 * bit) - clocks.nanos(until) + 500) / 1000;
        let samples = if self.is_on(cr1::OVER8) { 8 } else { 16 };
        let frame = sample(byte, ours, samples, self.tolerance());
        if self.flags & sr::RXNE == 0 {
            self.received = frame.data;
            let one_bit = self.cr3 & cr3::ONEBIT != 0;
            let noise = if frame.noise && !one_bit { sr::NF } else { 0 };
            let framing = if frame.framing { sr::FE } else { 0 };
            self.raise(sr::RXNE | noise | framing);
        } else {
            // "The RDR content will not be lost. The shift register will be overwritten."
            self.raise(sr::ORE);
        }
        // Half a stop bit is left, then a frame of silence.
        self.receiver.state = State::Waiting { until: until + bit / 2 + self.frame() * bit };
    }

    /// How far the sender's rate may be off, in 1/10000 (RM0090, "USART receiver's tolerance when
    /// DIV fraction is 0", and "... is different from 0", for M = 0).
    fn tolerance(&self) -> u64 {
        let whole = self.brr & 0xF == 0;
        match (self.is_on(cr1::OVER8), self.cr3 & cr3::ONEBIT != 0, whole) {
            (false, false, true) => 375,
            (false, true, true) => 437,
            (true, false, true) => 250,
            (true, true, true) => 375,
            (false, false, false) => 333,
            (false, true, false) => 388,
            (true, false, false) => 200,
            (true, true, false) => 300,
        }
    }
}
