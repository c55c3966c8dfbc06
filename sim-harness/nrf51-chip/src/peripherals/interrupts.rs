//! Events that raise a peripheral's interrupt: each event is a register that the peripheral sets to 1 and the program to 0, at 0x100 and on; INTEN has one
//! bit for each.

/// The first event register.
pub(super) const EVENTS: u32 = 0x100;
/// INTEN, INTENSET and INTENCLR.
const INTEN: u32 = 0x300;
const INTENSET: u32 = 0x304;
const INTENCLR: u32 = 0x308;

/// The events of a peripheral; event `n` is the register at 0x100 + 4 n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Events {
    /// Which events the peripheral has.
    known: u32,
    happened: u32,
    enabled: u32,
}

impl Events {
    /// The events of a peripheral, one bit for each that it has.
    pub(super) const fn new(known: u32) -> Self {
        Self { known, happened: 0, enabled: 0 }
    }

    /// An event happens.
    pub(super) const fn raise(&mut self, event: u32) {
        self.happened |= 1 << event;
    }

    /// Whether the interrupt line is high.
    pub(super) const fn line(&self) -> bool {
        self.happened & self.enabled != 0
    }

    const fn event(&self, offset: u32) -> Option<u32> {
        if offset < EVENTS || offset >= EVENTS + 0x80 {
            return None;
        }
        let bit = 1 << ((offset - EVENTS) / 4);
        if self.known & bit == 0 { None } else { Some(bit) }
    }

    /// The value of an event or of INTEN, if the offset is one's.
    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        if let Some(bit) = self.event(offset) {
            return Some(u32::from(self.happened & bit != 0));
        }
        matches!(offset, INTEN | INTENSET | INTENCLR).then_some(self.enabled)
    }

    /// Writes an event or INTEN, if the offset is one's.
    pub(super) fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        if let Some(bit) = self.event(offset) {
            self.happened = if value & 1 == 0 { self.happened & !bit } else { self.happened | bit };
            return Some(());
        }
        match offset {
            INTEN => self.enabled = value,
            INTENSET => self.enabled |= value,
            INTENCLR => self.enabled &= !value,
            _ => return None,
        }
        Some(())
    }
}
