//! The bounds of the stack, and how deep it has been.
//!
//! The stack lies at the lower end of the RAM (`memory.x`), so that an overflow leaves the memory and
//! faults ([`crate::safety::fault`]). All tasks and interrupts share it.
#![expect(unsafe_code, reason = "reads memory that belongs to no variable")]

unsafe extern "C" {
    // Symbols of `memory.x`, of which only the addresses are used.
    static _stack_start: u32;
    static _stack_end: u32;
}

/// The stack's lowest address, and the one above its highest.
fn bounds() -> (usize, usize) {
    ((&raw const _stack_end).addr(), (&raw const _stack_start).addr())
}

/// The size of the stack in bytes.
pub(crate) fn size() -> u32 {
    let (end, start) = bounds();
    start.saturating_sub(end) as u32
}

/// Bytes that have been used at some time since boot. The stack is painted at boot (`paint-stack`
/// of cortex-m-rt); from its end up to where the paint is gone it has never been used.
pub(crate) fn used() -> u32 {
    let (end, start) = bounds();
    let words = start.saturating_sub(end) / size_of::<u32>();
    let painted = (0..words)
        .take_while(|word| {
            let place = (&raw const _stack_end).wrapping_add(*word);
            // SAFETY: between the two symbols there is memory, aligned to 8 bytes; every bit
            // pattern is a number; and the read is volatile because interrupts write there.
            let content = unsafe { place.read_volatile() };
            content == cortex_m_rt::STACK_PAINT_VALUE
        })
        .count();
    ((words - painted) * size_of::<u32>()) as u32
}

/// Whether the eight words that the processor pushes for an exception lie within the stack, when
/// they begin at `address`.
pub(crate) fn holds_frame(address: u32) -> bool {
    const FRAME: u32 = 32;
    let (end, start) = bounds();
    let (end, start) = (end as u32, start as u32);
    address.is_multiple_of(4) && address >= end && address <= start.saturating_sub(FRAME)
}
