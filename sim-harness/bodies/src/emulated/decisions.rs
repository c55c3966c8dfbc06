//! Records the inputs and outputs of a firmware's agent, round by round, so that a test can give
//! the same inputs to the agent on the host.

use onboard::probe::Round;

use super::Firmware;
use virtual_crazyflie::memory::Memory;

/// The rounds of one drone, in order.
#[derive(Debug, Default)]
pub(super) struct Decisions {
    rounds: Vec<Round>,
    /// The probe's count of rounds at the last look.
    count: u32,
    /// Rounds that came and went between two looks.
    missed: u32,
}

impl Decisions {
    /// Takes a new round, if there is one. To be called more often than there are rounds.
    pub(super) fn look(&mut self, firmware: &Firmware, memory: &Memory) {
        if firmware.rounds(memory) == self.count {
            return;
        }
        // A round that is being written is whole at the next look.
        let Some((count, round)) = firmware.round(memory) else { return };
        // The count grows by two each time.
        let new = count.wrapping_sub(self.count) / 2;
        self.missed += new.saturating_sub(1);
        self.count = count;
        self.rounds.push(round);
    }

    /// All rounds so far; `None` where one was missed.
    pub(super) fn rounds(&self) -> Option<&[Round]> {
        (self.missed == 0).then_some(&self.rounds)
    }
}
