//! Finds the callers of a function by the debug information's call frames, through exceptions.

use std::fmt;

use addr2line::gimli::{
    BaseAddresses, CfaRule, DebugFrame, LittleEndian, RegisterRule, UnwindContext, UnwindSection,
};

use crate::cpu::Cpu;

use super::Image;
use super::lines::{Bytes, SourceFrame};

/// More frames than these are a stack that runs in circles.
const DEPTH: usize = 64;

/// The state of a core with which a back-trace begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// R0 to R15.
    pub registers: [u32; 16],
    /// The stack pointer that is not in use: the process stack's in handler mode, for instance.
    pub other_sp: u32,
}

impl State {
    /// The registers of a core.
    #[must_use]
    pub fn of(cpu: &Cpu) -> Self {
        Self { registers: std::array::from_fn(|n| cpu.register(n)), other_sp: cpu.other_sp }
    }
}

/// A function that has not yet returned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The instruction that is next, in the frame of the last call or after an exception; else the
    /// return address.
    pub address: u32,
    /// The symbol that the address lies in.
    pub symbol: Option<String>,
    /// The functions that the call comes from, the innermost first.
    pub source: Vec<SourceFrame>,
    /// An exception interrupted this function; the frame before it is the handler's.
    pub interrupted: bool,
}

/// The functions that have not yet returned, the innermost first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Backtrace {
    /// The functions.
    pub frames: Vec<Frame>,
    /// Why it ends where it does, if not where the program began.
    pub cut: Option<&'static str>,
}

impl fmt::Display for Backtrace {
    /// One line for each function, inlined ones included, which have the number of the one that
    /// they were inlined into.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, frame) in self.frames.iter().enumerate() {
            if frame.interrupted {
                writeln!(f, "    --- exception ---")?;
            }
            let symbol = frame.symbol.as_deref().unwrap_or("?");
            if frame.source.is_empty() {
                writeln!(f, "#{number} {:#010x} {symbol}", frame.address)?;
            }
            for inlined in &frame.source {
                let function = inlined.function.as_deref().unwrap_or(symbol);
                write!(f, "#{number} {:#010x} {function}", frame.address)?;
                match &inlined.source {
                    Some(source) => writeln!(f, " at {source}")?,
                    None => writeln!(f)?,
                }
            }
        }
        match self.cut {
            Some(why) => writeln!(f, "    ({why})"),
            None => Ok(()),
        }
    }
}

/// The outcome of a step to the caller.
enum Step {
    Caller { exception: bool },
    Start,
    Lost(&'static str),
}

pub(super) fn walk(image: &Image, state: &State, load: &dyn Fn(u32) -> Option<u32>) -> Backtrace {
    let section = image.lines.section(".debug_frame");
    let mut debug_frame = DebugFrame::new(section.slice(), LittleEndian);
    debug_frame.set_address_size(4);
    let mut walk = Walk { image, load, debug_frame, context: UnwindContext::new(), state: *state };
    let mut trace = Backtrace::default();
    let mut places = Vec::new();
    let mut interrupted = false;
    // Of a return address the call is the instruction before it.
    let mut exact = true;
    loop {
        let address = walk.state.registers[15] & !1;
        let place = if exact { address } else { address.wrapping_sub(2) };
        places.push(place);
        trace.frames.push(Frame {
            address,
            symbol: image.symbol_at(place).map(|symbol| symbol.name.to_owned()),
            source: vec![],
            interrupted,
        });
        if trace.frames.len() == DEPTH {
            trace.cut = Some("and so on");
            break;
        }
        match walk.step(place, trace.frames.len() == 1) {
            Step::Caller { exception } => (interrupted, exact) = (exception, exception),
            Step::Start => break,
            Step::Lost(why) => {
                trace.cut = Some(why);
                break;
            }
        }
    }
    for (frame, source) in trace.frames.iter_mut().zip(image.lines.frames(&places)) {
        frame.source = source;
    }
    trace
}

struct Walk<'a> {
    image: &'a Image,
    load: &'a dyn Fn(u32) -> Option<u32>,
    debug_frame: DebugFrame<Bytes<'a>>,
    context: UnwindContext<usize>,
    state: State,
}

impl Walk<'_> {
    /// Goes to the caller of the function that `place` lies in.
    fn step(&mut self, place: u32, first: bool) -> Step {
        if self.start_of(place) == self.image.entry() {
            return Step::Start;
        }
        let before = self.state.registers;
        let back = match self.by_frame_information(place) {
            Some(registers) => {
                self.state.registers = registers;
                registers[15]
            }
            // A leaf written in assembly has no frame, or its first instructions have none yet.
            None if first => before[14],
            None => return Step::Lost("no call frame information"),
        };
        if back == u32::MAX || back == 0 {
            // What a core that comes out of reset has in LR (DDI 0403, B1.5.5).
            return Step::Start;
        }
        if back >= 0xFFFF_FF00 {
            return self.exception(back);
        }
        if back % 2 == 0 || !self.image.is_code(back & !1) {
            return Step::Lost("a return address into no code");
        }
        self.state.registers[15] = back & !1;
        if self.state.registers == before {
            return Step::Lost("a function that seems to have called itself");
        }
        Step::Caller { exception: false }
    }

    fn start_of(&self, place: u32) -> u32 {
        self.image.symbol_at(place).map_or(0, |symbol| symbol.address)
    }

    /// The caller's registers; in R15 what the function will return to.
    fn by_frame_information(&mut self, place: u32) -> Option<[u32; 16]> {
        let bases = BaseAddresses::default();
        let row = self
            .debug_frame
            .unwind_info_for_address(
                &bases,
                &mut self.context,
                u64::from(place),
                DebugFrame::cie_from_offset,
            )
            .ok()?;
        let now = &self.state.registers;
        let CfaRule::RegisterAndOffset { register, offset } = *row.cfa() else { return None };
        let cfa = now.get(usize::from(register.0))?.wrapping_add(offset as u32);
        let mut then = *now;
        // The return address column of AADWARF32 is LR.
        for (register, rule) in row.registers() {
            let Some(value) = then.get_mut(usize::from(register.0)) else { continue };
            *value = match *rule {
                RegisterRule::Offset(offset) => (self.load)(cfa.wrapping_add(offset as u32))?,
                RegisterRule::ValOffset(offset) => cfa.wrapping_add(offset as u32),
                RegisterRule::Register(other) => *now.get(usize::from(other.0))?,
                RegisterRule::SameValue | RegisterRule::Undefined => continue,
                _ => return None,
            };
        }
        then[15] = then[14];
        then[13] = cfa;
        Some(then)
    }

    /// Out of an exception's handler, to what it broke in upon (DDI 0403, B1.5.6 and B1.5.8).
    fn exception(&mut self, exc_return: u32) -> Step {
        let on_process_stack = exc_return & 0b1111 == 0b1101;
        let extended = exc_return & 0b1_0000 == 0;
        let frame = if on_process_stack { self.state.other_sp } else { self.state.registers[13] };
        let mut words = [0; 8];
        for (word, at) in words.iter_mut().zip((0..).step_by(4)) {
            match (self.load)(frame.wrapping_add(at)) {
                Some(value) => *word = value,
                None => return Step::Lost("an exception frame that cannot be read"),
            }
        }
        let [r0, r1, r2, r3, r12, lr, pc, psr] = words;
        let size = if extended { 0x68 } else { 0x20 };
        // Bit 9 of the PSR on the stack: a word was left out for alignment.
        let after = frame.wrapping_add(size).wrapping_add(if psr & 1 << 9 == 0 { 0 } else { 4 });
        if on_process_stack {
            self.state.other_sp = self.state.registers[13];
        }
        let registers = &mut self.state.registers;
        registers[..4].copy_from_slice(&[r0, r1, r2, r3]);
        registers[12..].copy_from_slice(&[r12, after, lr, pc & !1]);
        if self.image.is_code(pc & !1) {
            Step::Caller { exception: true }
        } else {
            Step::Lost("an exception that broke in upon no code")
        }
    }
}
