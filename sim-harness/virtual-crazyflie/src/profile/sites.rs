//! The addresses at which something changes hands, found in an image.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::image::{Function, Image};

use super::names;
use super::quick::QuickMap;

/// What happens at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Site {
    /// The program begins.
    Reset,
    /// An exception's handler begins.
    Handler,
    /// It may end: a return that is one from an exception if it leads to an EXC_RETURN.
    HandlerReturn(Target),
    /// An executor has called a task's poll function.
    Poll(usize),
    /// It has returned.
    PollReturn,
    /// A task is put into its executor's queue, unless it is there already: a register has the
    /// address of the byte that says so, which lies so far into the task's header.
    Wake {
        /// The register.
        register: u8,
        /// How far.
        offset: u32,
    },
    /// A watched function begins.
    Watched(usize),
    /// A watched function may have returned.
    WatchedReturn,
}

/// Where a return takes its target from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// A register.
    Register(u8),
    /// The stack, so far above the stack pointer.
    Stack(u16),
}

/// All of an image.
#[derive(Clone, Debug, Default)]
pub(super) struct Sites {
    by_address: QuickMap<u32, Vec<Site>>,
    tasks: Vec<String>,
}

impl Sites {
    pub(super) fn find(image: &Image) -> Self {
        let mut sites = Self::default();
        sites.add(image.entry(), Site::Reset);
        sites.find_handlers(image);
        sites.find_polls(image);
        sites.find_executor(image);
        sites
    }

    pub(super) fn tasks(&self) -> &[String] {
        &self.tasks
    }

    /// Whether it is known where tasks are woken.
    pub(super) fn knows_wakes(&self) -> bool {
        self.by_address.values().flatten().any(|site| matches!(site, Site::Wake { .. }))
    }

    pub(super) fn at(&self, address: u32) -> &[Site] {
        self.by_address.get(&address).map_or(&[], Vec::as_slice)
    }

    pub(super) fn addresses(&self) -> impl Iterator<Item = u32> {
        self.by_address.keys().copied()
    }

    pub(super) fn add(&mut self, address: u32, site: Site) {
        let here = self.by_address.entry(address).or_default();
        if !here.contains(&site) {
            here.push(site);
        }
    }

    #[cfg(test)]
    pub(super) fn with_tasks(names: &[&str]) -> Self {
        let tasks = names.iter().map(|name| (*name).to_owned()).collect();
        Self { tasks, ..Self::default() }
    }

    /// Where the handlers of the vector table begin and end.
    fn find_handlers(&mut self, image: &Image) {
        let table = image.vector_table();
        // 16 of the system and 82 of the chip (RM0090, "Vector table"); the first two are no
        // handlers but stack pointer and reset. A table may be shorter, and code lie behind it.
        let handlers: BTreeSet<u32> = (2..16 + 82)
            .filter_map(|number| image.word(table + 4 * number))
            .filter(|entry| entry % 2 == 1)
            .map(|entry| entry & !1)
            .filter(|entry| image.function_at(*entry).is_some_and(|at| at.address == *entry))
            .collect();
        for handler in &handlers {
            // One that only loops would be seen to begin for ever.
            if image.instructions_in(*handler..handler + 2).all(|(_, first, _)| first != 0xE7FE) {
                self.add(*handler, Site::Handler);
            }
        }
        // Whatever a handler ends by jumping to ends the handler when it returns.
        let mut open: Vec<u32> = handlers.into_iter().collect();
        let mut seen = BTreeSet::new();
        while let Some(address) = open.pop() {
            let Some(function) = image.function_at(address) else { continue };
            if !seen.insert(function.address) {
                continue;
            }
            for (at, first, second) in image.instructions_in(function.range()) {
                if let Some(target) = return_target(first, second) {
                    self.add(at, Site::HandlerReturn(target));
                }
                match branch(at, first, second) {
                    Some(Branch::Jump(to)) if !function.range().contains(&to) => open.push(to),
                    _ => {}
                }
            }
        }
    }

    /// Where the tasks' poll functions begin.
    fn find_polls(&mut self, image: &Image) {
        for function in image.functions() {
            if let Some(future) = names::future_of(&function.name) {
                self.add(function.address, Site::Poll(self.tasks.len()));
                self.tasks.push(names::task(future));
            }
        }
    }

    /// Where an executor calls poll functions, and where tasks are put into queues. Both are
    /// inlined: the debug information knows where from.
    fn find_executor(&mut self, image: &Image) {
        let mut calls = Vec::new();
        let mut stores = Vec::new();
        for (at, first, second) in image.instructions() {
            // BLX of a register; STREXB.
            if first & 0xFF87 == 0x4780 {
                calls.push(at);
            } else if first & 0xFFF0 == 0xE8C0 && second & 0x0FF0 == 0x0F40 {
                stores.push((at, (first & 15) as u8));
            }
        }
        for (at, frames) in calls.iter().zip(image.source_frames_of(&calls)) {
            let innermost = frames.first().and_then(|frame| frame.function.as_deref());
            if innermost
                .is_some_and(|name| name.starts_with("<embassy_executor::raw::SyncExecutor>::poll"))
            {
                self.add(at + 2, Site::PollReturn);
            }
        }
        // The header begins with its state where the compiler has left it there; in the state the
        // byte `run_queued` is the second (embassy-executor 0.10, `state_atomics_arm.rs`).
        let Some(state) = image.member_offset("TaskHeader", "state") else { return };
        let offset = state + 1;
        let addresses: Vec<u32> = stores.iter().map(|(at, _)| *at).collect();
        for ((at, register), frames) in stores.into_iter().zip(image.source_frames_of(&addresses)) {
            let enqueues = frames
                .iter()
                .filter_map(|frame| frame.function.as_deref())
                .any(|name| name.starts_with("<embassy_executor::raw::state::State>::run_enqueue"));
            if enqueues {
                self.add(at, Site::Wake { register, offset });
            }
        }
    }

    /// Where a function begins, and where it returns to.
    pub(super) fn watch(&mut self, image: &Image, function: &Function, index: usize) {
        self.add(function.address, Site::Watched(index));
        // A function that ends by jumping to it lets it return to its own caller.
        let mut targets = BTreeSet::from([function.address]);
        let mut before = 0;
        while before != targets.len() {
            before = targets.len();
            for (at, first, second) in image.instructions() {
                match branch(at, first, second) {
                    Some(Branch::Jump(to)) if targets.contains(&to) => {
                        let from = image.function_at(at).map(|from| from.range());
                        targets
                            .extend(from.filter(|from| !from.contains(&to)).map(|from| from.start));
                    }
                    Some(Branch::Call(to)) if targets.contains(&to) => {
                        self.add(at + 4, Site::WatchedReturn);
                    }
                    _ => {}
                }
            }
        }
    }
}

impl Image {
    fn function_at(&self, address: u32) -> Option<&Function> {
        let index = self.functions().partition_point(|function| function.address <= address);
        let function = self.functions().get(index.checked_sub(1)?)?;
        function.range().contains(&address).then_some(function)
    }

    fn instructions_in(&self, range: Range<u32>) -> impl Iterator<Item = (u32, u16, u16)> {
        self.instructions_from(range.start).take_while(move |(at, _, _)| *at < range.end)
    }
}

/// Where a return leads to, if the instruction is one: BX, POP or LDR to PC.
fn return_target(first: u16, second: u16) -> Option<Target> {
    match (first, second) {
        // BX.
        _ if first & 0xFF87 == 0x4700 => Some(Target::Register((first >> 3 & 15) as u8)),
        // POP with PC, T1: the registers below it come first.
        _ if first & 0xFF00 == 0xBD00 => {
            Some(Target::Stack(4 * (first & 0xFF).count_ones() as u16))
        }
        // POP with PC, T2.
        (0xE8BD, _) if second & 0x8000 != 0 => {
            Some(Target::Stack(4 * (second & 0x7FFF).count_ones() as u16))
        }
        // POP of PC alone, T3: LDR PC, [SP], #4.
        (0xF85D, 0xFB04) => Some(Target::Stack(0)),
        _ => None,
    }
}

/// A branch to an address that stands in the instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Branch {
    Jump(u32),
    Call(u32),
}

/// B and BL (DDI 0403, A7.7.12 and A7.7.18).
fn branch(at: u32, first: u16, second: u16) -> Option<Branch> {
    let (wide_first, wide_second) = (u32::from(first), u32::from(second));
    let to = |offset: u32, bits: u32| {
        let signed = (offset << (32 - bits)).cast_signed() >> (32 - bits);
        at.wrapping_add(4).wrapping_add_signed(signed)
    };
    // T1; condition 14 is undefined, and 15 is SVC.
    if first & 0xF000 == 0xD000 && first & 0x0E00 != 0x0E00 {
        return Some(Branch::Jump(to((wide_first & 0xFF) << 1, 9)));
    }
    // T2.
    if first & 0xF800 == 0xE000 {
        return Some(Branch::Jump(to((wide_first & 0x7FF) << 1, 12)));
    }
    if first & 0xF800 != 0xF000 || second & 0x8000 == 0 {
        return None;
    }
    let s = wide_first >> 10 & 1;
    let (j1, j2) = (wide_second >> 13 & 1, wide_second >> 11 & 1);
    let low = (wide_second & 0x7FF) << 1;
    match second & 0x5000 {
        // T3; conditions 14 and 15 are other instructions.
        0x0000 if first & 0x0380 != 0x0380 => {
            let offset = s << 20 | j2 << 19 | j1 << 18 | (wide_first & 0x3F) << 12 | low;
            Some(Branch::Jump(to(offset, 21)))
        }
        // T4, and BL.
        kind @ (0x1000 | 0x5000) => {
            let (i1, i2) = (j1 ^ s ^ 1, j2 ^ s ^ 1);
            let offset = s << 24 | i1 << 23 | i2 << 22 | (wide_first & 0x3FF) << 12 | low;
            let target = to(offset, 25);
            Some(if kind == 0x1000 { Branch::Jump(target) } else { Branch::Call(target) })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_read_as_a_disassembler_reads_them() {
        // From llvm-objdump, of a firmware.
        let jump = |to| Some(Branch::Jump(to));
        let call = |to| Some(Branch::Call(to));
        for (at, first, second, is) in [
            (0x0800_41BE, 0xE7FA, 0, jump(0x0800_41B6)),
            (0x0800_5FF2, 0xE008, 0, jump(0x0800_6006)),
            (0x0800_433A, 0xD1F1, 0, jump(0x0800_4320)),
            (0x0800_6138, 0xD106, 0, jump(0x0800_6148)),
            (0x0800_53A6, 0xF000, 0x815B, jump(0x0800_5660)),
            (0x0800_5888, 0xF040, 0x80A1, jump(0x0800_59CE)),
            (0x0800_E1A2, 0xF200, 0x8113, jump(0x0800_E3CC)),
            (0x0800_4272, 0xF020, 0xBD42, jump(0x0802_4CFA)),
            (0x0800_B25C, 0xF7FF, 0xBA48, jump(0x0800_A6F0)),
            (0x0800_42DE, 0xF018, 0xFFF2, call(0x0801_D2C6)),
            (0x0800_40AA, 0xF7FF, 0xFFEF, call(0x0800_408C)),
            // UDF, SVC, MRS, DSB.
            (0x0800_4000, 0xDE00, 0, None),
            (0x0800_4000, 0xDF00, 0, None),
            (0x0800_4000, 0xF3EF, 0x8005, None),
            (0x0800_4000, 0xF3BF, 0x8F4F, None),
        ] {
            assert_eq!(branch(at, first, second), is, "{first:04x} {second:04x}");
        }
    }

    #[test]
    fn returns_are_told_with_where_they_lead() {
        for (first, second, is) in [
            (0x4770, 0, Some(Target::Register(14))),
            (0x4708, 0, Some(Target::Register(1))),
            (0xBD80, 0, Some(Target::Stack(4))),
            (0xBDF0, 0, Some(Target::Stack(16))),
            (0xBC80, 0, None),
            (0xE8BD, 0x8FF0, Some(Target::Stack(32))),
            (0xE8BD, 0x0FF0, None),
            (0xF85D, 0xFB04, Some(Target::Stack(0))),
            (0x4780, 0, None),
        ] {
            assert_eq!(return_target(first, second), is, "{first:04x} {second:04x}");
        }
    }
}
