//! Ends a run: stops the motors, writes a crash record, resets the chip.
//!
//! The record lies in memory that no start-up code clears (`memory.x`), and the next boot logs it:
//! nothing is logged here, because the fault may have happened in the middle of the logger. A magic
//! number and a checksum distinguish a record from the random contents of a RAM at power-up.
//!
//! Runs end here by panics, by faults ([`crate::safety::fault`]), by interrupts without a handler,
//! and by [`give_up`].

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use heapless::String;

use crate::board;
use crate::board::motors;
use crate::safety::{reset, stack};

/// How the run ended.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
enum Kind {
    /// A panic; `detail` is the line, the column and the exception that was being handled, the
    /// text the file and the message.
    Panic,
    /// A fault; `detail` is PC, LR, CFSR, BFAR (Armv7-M Architecture Reference Manual, B3.2), the
    /// exception that was being handled, and the stack pointer.
    HardFault,
    /// An interrupt without a handler; `detail` is its number.
    Interrupt,
    /// A call of [`give_up`]; the text is its reason.
    GivenUp,
}

impl Kind {
    const fn code(self) -> u32 {
        match self {
            Self::Panic => 1,
            Self::HardFault => 2,
            Self::Interrupt => 3,
            Self::GivenUp => 4,
        }
    }

    const fn from_code(code: u32) -> Option<Self> {
        match code {
            1 => Some(Self::Panic),
            2 => Some(Self::HardFault),
            3 => Some(Self::Interrupt),
            4 => Some(Self::GivenUp),
            _ => None,
        }
    }
}

/// Bytes of text that are kept.
const TEXT: usize = 96;
/// Bytes of a file's path that are kept, from its end.
const FILE: usize = 48;
/// Numbers that are kept.
const DETAIL: usize = 6;

/// Why a run ended, as the boot after it reads it.
pub(crate) struct CrashRecord {
    kind: Kind,
    detail: [u32; DETAIL],
    text: String<TEXT>,
}

impl CrashRecord {
    const fn new(kind: Kind, detail: [u32; DETAIL]) -> Self {
        Self { kind, detail, text: String::new() }
    }

    /// Appends as much of `more` as there is room for.
    fn say(&mut self, more: &str) {
        let room = TEXT.saturating_sub(self.text.len());
        let fits = more.get(..more.floor_char_boundary(room)).unwrap_or_default();
        // It has just been cut to fit.
        let _ = self.text.push_str(fits);
    }

    /// Logs the record.
    pub(crate) fn log(&self) {
        let [a, b, c, d, e, f] = self.detail;
        let text = self.text.as_str();
        match self.kind {
            Kind::Panic => defmt::error!(
                "last run: panic at {=u32}:{=u32} of {=str}, in {=str}",
                a,
                b,
                text,
                place(c)
            ),
            Kind::HardFault => defmt::error!(
                "last run: hard fault{=str}, pc {=u32:#010x} lr {=u32:#010x} cfsr {=u32:#010x} bfar {=u32:#010x} sp {=u32:#010x}, in {=str}",
                if stack::holds_frame(f) { "" } else { " by stack overflow" },
                a,
                b,
                c,
                d,
                f,
                place(e)
            ),
            Kind::Interrupt => defmt::error!("last run: interrupt {=u32} has no handler", a),
            Kind::GivenUp => defmt::error!("last run: {=str}", text),
        }
    }
}

/// The code that was running, by the number of the exception that was being handled.
fn place(exception: u32) -> &'static str {
    /// Exceptions of the core come before the chip's interrupts.
    const CORE: u32 = 16;
    match exception {
        0 => "a task of the thread",
        n if n == CORE + board::CONTROL as u32 => "the control executor",
        _ => "an interrupt handler",
    }
}

/// The magic number of a crash record. With the checksum, one start in 2⁶⁴ from random memory reports
/// a crash that never happened.
const MAGIC: u32 = 0x0BAD_F11E;

/// The memory of the crash record: plain words, so that every content is a valid value.
struct CrashMemory {
    magic: AtomicU32,
    checksum: AtomicU32,
    kind: AtomicU32,
    detail: [AtomicU32; DETAIL],
    length: AtomicU32,
    text: [AtomicU32; TEXT / 4],
}

#[expect(unsafe_code, reason = "naming a section of the linker script is unsafe as such")]
// `used` keeps the compiler from believing that the memory begins with the value written here.
#[used]
// SAFETY: the section is reserved by memory.x, in memory; and as nothing writes this value there,
// the static holds whatever bits it held before the reset, all of which are valid for its type.
#[unsafe(link_section = ".outlives_reset.crash_record")]
static CRASH_MEMORY: CrashMemory = CrashMemory {
    magic: AtomicU32::new(0),
    checksum: AtomicU32::new(0),
    kind: AtomicU32::new(0),
    detail: [const { AtomicU32::new(0) }; DETAIL],
    length: AtomicU32::new(0),
    text: [const { AtomicU32::new(0) }; TEXT / 4],
};

impl CrashMemory {
    fn write(&self, record: &CrashRecord) {
        self.magic.store(0, Ordering::SeqCst);
        self.kind.store(record.kind.code(), Ordering::SeqCst);
        for (cell, value) in self.detail.iter().zip(record.detail) {
            cell.store(value, Ordering::SeqCst);
        }
        self.length.store(record.text.len() as u32, Ordering::SeqCst);
        let mut bytes = record.text.bytes();
        for cell in &self.text {
            let mut next = || bytes.next().unwrap_or(0);
            cell.store(u32::from_le_bytes([next(), next(), next(), next()]), Ordering::SeqCst);
        }
        self.checksum.store(self.sum(), Ordering::SeqCst);
        self.magic.store(MAGIC, Ordering::SeqCst);
    }

    /// Takes the record: a second boot does not report it again.
    fn take(&self) -> Option<CrashRecord> {
        let magic = self.magic.swap(0, Ordering::SeqCst);
        if magic != MAGIC || self.checksum.load(Ordering::SeqCst) != self.sum() {
            return None;
        }
        let kind = Kind::from_code(self.kind.load(Ordering::SeqCst))?;
        let mut record = CrashRecord::new(kind, [0; DETAIL]);
        for (value, cell) in record.detail.iter_mut().zip(&self.detail) {
            *value = cell.load(Ordering::SeqCst);
        }
        let bytes = self.text.iter().flat_map(|cell| cell.load(Ordering::SeqCst).to_le_bytes());
        let mut text = heapless::Vec::<u8, TEXT>::new();
        text.extend(bytes.take(self.length.load(Ordering::SeqCst) as usize));
        record.say(core::str::from_utf8(&text).unwrap_or_default());
        Some(record)
    }

    /// FNV-1a, by words instead of bytes.
    fn sum(&self) -> u32 {
        let cells = [&self.kind, &self.length];
        cells.into_iter().chain(&self.detail).chain(&self.text).fold(0x811C_9DC5, |hash, cell| {
            (hash ^ cell.load(Ordering::SeqCst)).wrapping_mul(0x0100_0193)
        })
    }
}

/// Takes the crash record of the last run, if it ended in this module.
pub(crate) fn take_crash_record() -> Option<CrashRecord> {
    CRASH_MEMORY.take()
}

/// Stops the motors, writes the record and resets, in this order, since each step may fail again.
fn end(record: &CrashRecord) -> ! {
    cortex_m::interrupt::disable();
    motors::stop();
    CRASH_MEMORY.write(record);
    reset::wait_for_quiet_line();
    SCB::sys_reset()
}

/// Ends a run in a hard fault: `detail` as [`Kind::HardFault`] has it.
pub(crate) fn end_by_fault(detail: [u32; DETAIL]) -> ! {
    end(&CrashRecord::new(Kind::HardFault, detail))
}

/// Ends a run that cannot go on, for a reason that is not a panic.
pub(crate) fn give_up(why: &str) -> ! {
    let mut record = CrashRecord::new(Kind::GivenUp, [0; DETAIL]);
    record.say(why);
    end(&record)
}

#[panic_handler]
fn panicked(info: &PanicInfo<'_>) -> ! {
    // Before anything else: the rest is code that may panic in turn.
    cortex_m::interrupt::disable();
    motors::stop();
    let mut record = CrashRecord::new(Kind::Panic, [0; DETAIL]);
    if let Some(location) = info.location() {
        record.detail = [location.line(), location.column(), exception_now(), 0, 0, 0];
        let file = location.file();
        let tail = file.ceil_char_boundary(file.len().saturating_sub(FILE));
        record.say(file.get(tail..).unwrap_or_default());
    }
    // A message with values in it would have to be formatted, which costs kilobytes of flash.
    if let Some(message) = info.message().as_str() {
        record.say(": ");
        record.say(message);
    }
    end(&record)
}

/// The number of the exception that is being handled, 0 for none.
fn exception_now() -> u32 {
    #[expect(unsafe_code, reason = "a register of the core")]
    // SAFETY: reading it has no side effect.
    let icsr = unsafe { (*SCB::PTR).icsr.read() };
    icsr & 0x1FF
}

#[exception]
#[allow(unsafe_code, reason = "cortex-m-rt asks for `unsafe fn`")]
unsafe fn DefaultHandler(number: i16) -> ! {
    end(&CrashRecord::new(Kind::Interrupt, [number as u32, 0, 0, 0, 0, 0]))
}
