//! The channels to a debug probe, by SEGGER's RTT: a control block in RAM that the probe reads and
//! writes while the firmware runs.
//!
//! | channel | carries |
//! |---|---|
//! | up 0, `defmt` | the log; the oldest bytes are overwritten when no probe reads them |
//! | up 1, `replay` | the answers of a replay ([`crate::tasks::replay`]) |
//! | down 0, `replay` | the requests of a replay |
//!
//! Nothing here ever waits for a probe. `defmt-rtt` has no down-channel and does not share its control
//! block, and `rtt-target` keeps the oldest bytes of a log instead of the newest, which are the ones
//! that tell of a crash; so the block is the firmware's own. Its layout is that of SEGGER's UM08001,
//! "RTT implementation".

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use critical_section::RestoreState;

/// The identifier by which a probe finds the block.
const IDENTIFIER: [u8; 16] = *b"SEGGER RTT\0\0\0\0\0\0";
/// The flag of a channel whose writer drops what does not fit.
const TRIM: u32 = 1;

/// Bytes of the log's ring.
const LOG: usize = 1024;
/// Bytes of the ring of answers: more than the longest answer, of 0.7 kB.
const ANSWERS: usize = 1024;
/// Bytes of the ring of requests. The host sends a longer one in parts.
pub(crate) const REQUESTS: usize = 512;

/// One channel: a ring that one side writes and the other reads.
#[repr(C)]
struct Channel<const N: usize> {
    name: &'static [u8; 8],
    ring: &'static [AtomicU8; N],
    size: u32,
    write: AtomicU32,
    read: AtomicU32,
    flags: AtomicU32,
}

impl<const N: usize> Channel<N> {
    const fn new(name: &'static [u8; 8], ring: &'static [AtomicU8; N]) -> Self {
        Self {
            name,
            ring,
            size: N as u32,
            write: AtomicU32::new(0),
            read: AtomicU32::new(0),
            flags: AtomicU32::new(TRIM),
        }
    }

    /// A position in the ring; a probe may have written any number.
    fn position(of: &AtomicU32) -> usize {
        of.load(Ordering::Acquire) as usize % N
    }

    /// Writes bytes over the oldest ones.
    fn overwrite(&self, bytes: &[u8]) {
        let mut at = Self::position(&self.write);
        for byte in bytes {
            self.put(at, *byte);
            at = (at + 1) % N;
        }
        self.write.store(at as u32, Ordering::Release);
    }

    /// Writes a byte, or drops it where there is no room.
    fn offer(&self, byte: u8) {
        let at = Self::position(&self.write);
        let next = (at + 1) % N;
        if next != Self::position(&self.read) {
            self.put(at, byte);
            self.write.store(next as u32, Ordering::Release);
        }
    }

    /// Takes the next byte that the probe has written.
    fn take(&self) -> Option<u8> {
        let at = Self::position(&self.read);
        if at == Self::position(&self.write) {
            return None;
        }
        let byte = self.ring.get(at)?.load(Ordering::Relaxed);
        self.read.store(((at + 1) % N) as u32, Ordering::Release);
        Some(byte)
    }

    fn put(&self, at: usize, byte: u8) {
        if let Some(place) = self.ring.get(at) {
            place.store(byte, Ordering::Relaxed);
        }
    }
}

/// The control block.
#[repr(C)]
struct Block {
    identifier: [u8; 16],
    up: u32,
    down: u32,
    log: Channel<LOG>,
    answers: Channel<ANSWERS>,
    requests: Channel<REQUESTS>,
}

static LOG_RING: [AtomicU8; LOG] = [const { AtomicU8::new(0) }; LOG];
static ANSWERS_RING: [AtomicU8; ANSWERS] = [const { AtomicU8::new(0) }; ANSWERS];
static REQUESTS_RING: [AtomicU8; REQUESTS] = [const { AtomicU8::new(0) }; REQUESTS];

/// The control block, under the name by which probes find it in the ELF.
#[expect(unsafe_code, reason = "a name without its module is unsafe as such")]
// SAFETY: nothing else has this name.
#[unsafe(export_name = "_SEGGER_RTT")]
static BLOCK: Block = Block {
    identifier: IDENTIFIER,
    up: 2,
    down: 1,
    log: Channel::new(b"defmt\0\0\0", &LOG_RING),
    answers: Channel::new(b"replay\0\0", &ANSWERS_RING),
    requests: Channel::new(b"replay\0\0", &REQUESTS_RING),
};

/// Takes the next byte of a request.
pub(crate) fn take_request() -> Option<u8> {
    BLOCK.requests.take()
}

/// Sends a byte of an answer; it is lost where the probe has left no room for it.
pub(crate) fn send_answer(byte: u8) {
    BLOCK.answers.offer(byte);
}

/// The log's encoder, and the interrupts' state to restore after a message.
struct Encoder {
    /// How many messages have begun and not ended: more than one only if a message's formatting
    /// logs, which garbles both.
    open: u32,
    restore: RestoreState,
    defmt: defmt::Encoder,
}

struct Exclusive(UnsafeCell<Encoder>);

#[expect(unsafe_code, reason = "the encoder is used between acquire and release only")]
// SAFETY: every access lies between `acquire` and `release`, where interrupts are disabled.
unsafe impl Sync for Exclusive {}

static ENCODER: Exclusive = Exclusive(UnsafeCell::new(Encoder {
    open: 0,
    restore: RestoreState::invalid(),
    defmt: defmt::Encoder::new(),
}));

/// The log, as defmt writes it.
#[defmt::global_logger]
struct Logger;

#[expect(unsafe_code, reason = "defmt asks for a promise")]
// SAFETY: from `acquire` to `release` interrupts are disabled, so no other message is written
// meanwhile; the encoder's bytes go to the ring in their order.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: `release` restores the state, which is kept for the outermost message.
        let restore = unsafe { critical_section::acquire() };
        // SAFETY: interrupts are disabled, and no reference outlives this function.
        let encoder = unsafe { &mut *ENCODER.0.get() };
        if encoder.open == 0 {
            encoder.restore = restore;
        }
        encoder.open += 1;
        encoder.defmt.start_frame(|bytes| BLOCK.log.overwrite(bytes));
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: defmt calls this after `acquire`, so interrupts are disabled.
        let encoder = unsafe { &mut *ENCODER.0.get() };
        encoder.defmt.end_frame(|bytes| BLOCK.log.overwrite(bytes));
        encoder.open = encoder.open.saturating_sub(1);
        if encoder.open == 0 {
            // SAFETY: it is the state that the outermost `acquire` returned.
            unsafe { critical_section::release(encoder.restore) };
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: defmt calls this between `acquire` and `release`.
        let encoder = unsafe { &mut *ENCODER.0.get() };
        encoder.defmt.write(bytes, |bytes| BLOCK.log.overwrite(bytes));
    }
}
