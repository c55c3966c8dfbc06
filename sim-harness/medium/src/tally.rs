//! Counts the packets by what became of them.

/// Why a packet did not reach a station that might have received it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The packet was too weak there, so that some of its bits were wrong, or the receiver is
    /// silenced.
    Weak,
    /// The packet was lost by chance, at the rate of [`radio_model::Reception::loss_rate`], or in a
    /// fade.
    Chance,
    /// Another station was on the air, and not weaker by enough, or the receiver had found the address
    /// of its packet before.
    Collision,
    /// The receiver was sending itself, its radio was busy with the operator's, or its chip had no
    /// room for the packet.
    Deaf,
    /// Its own sender took the radio for the next packet before this one was out.
    Cut,
}

/// Counts since the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Packets that went on the air.
    pub sent: u64,
    /// Bytes of data in them.
    pub bytes: u64,
    /// Microseconds that they were on the air, all together.
    pub air_us: u64,
    /// Times that a packet was heard.
    pub heard: u64,
    /// Times that a packet was too weak.
    pub weak: u64,
    /// Times that a packet was lost by chance.
    pub chance: u64,
    /// Times that a packet was lost to another.
    pub collisions: u64,
    /// Times that a packet met a radio that was not listening.
    pub deaf: u64,
    /// Times that a packet was cut off.
    pub cut: u64,
}

impl Tally {
    /// No packet.
    pub const NONE: Self = Self {
        sent: 0,
        bytes: 0,
        air_us: 0,
        heard: 0,
        weak: 0,
        chance: 0,
        collisions: 0,
        deaf: 0,
        cut: 0,
    };

    /// Counts a packet that was lost.
    pub fn lose(&mut self, loss: Loss) {
        let count = match loss {
            Loss::Weak => &mut self.weak,
            Loss::Chance => &mut self.chance,
            Loss::Collision => &mut self.collisions,
            Loss::Deaf => &mut self.deaf,
            Loss::Cut => &mut self.cut,
        };
        *count += 1;
    }

    /// The part of the time that the air was in use, after so many microseconds.
    #[must_use]
    pub fn air_time(&self, elapsed_us: u64) -> f64 {
        if elapsed_us == 0 { 0.0 } else { self.air_us as f64 / elapsed_us as f64 }
    }
}
