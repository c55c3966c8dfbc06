//! The addresses at which something changes hands, found in an image.

use std::collections::BTreeSet;

use crate::cpu::effect::Effect;
use crate::image::{Function, Image};

use super::names;
use super::quick::QuickMap;

/// The event at an address.
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
    /// A task's poll function has returned.
    PollReturn,
    /// A task is put into its executor's queue, unless it is there already: a register has the
    /// address of the byte that says so, which lies so far into the task's header.
    Wake {
        /// The register.
        register: u8,
        /// The distance.
        offset: u32,
    },
    /// A watched function begins.
    Watched(usize),
    /// A watched function may have returned.
    WatchedReturn,
}

/// The source of a return's target.
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

    /// Whether the addresses at which tasks are woken were found.
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

    /// The beginnings and ends of the handlers in the vector table.
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
            let mut first = image.listing_in(*handler..handler + 2).iter();
            if first.all(|first| first.effect != Effect::Jump(*handler)) {
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
            for instruction in image.listing_in(function.range()) {
                if let Some(target) = return_target(&instruction.effect) {
                    self.add(instruction.address, Site::HandlerReturn(target));
                }
                match instruction.effect {
                    Effect::Jump(to) if !function.range().contains(&to) => open.push(to),
                    _ => {}
                }
            }
        }
    }

    /// The beginnings of the tasks' poll functions.
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
        for instruction in image.listing() {
            match instruction.effect {
                Effect::CallRegister(_) => calls.push(instruction.address),
                Effect::StoreExclusive { base, byte: true, .. } => {
                    stores.push((instruction.address, base));
                }
                _ => {}
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

    /// The beginning of a function, and its returns.
    pub(super) fn watch(&mut self, image: &Image, function: &Function, index: usize) {
        self.add(function.address, Site::Watched(index));
        // A function that ends by jumping to it lets it return to its own caller.
        let mut targets = BTreeSet::from([function.address]);
        let mut before = 0;
        while before != targets.len() {
            before = targets.len();
            for instruction in image.listing() {
                match instruction.effect {
                    Effect::Jump(to) if targets.contains(&to) => {
                        let from = image.function_at(instruction.address).map(Function::range);
                        targets
                            .extend(from.filter(|from| !from.contains(&to)).map(|from| from.start));
                    }
                    Effect::Call(to) if targets.contains(&to) => {
                        self.add(instruction.address + instruction.size, Site::WatchedReturn);
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
}

/// The source of a return's target, if the instruction is a return.
fn return_target(effect: &Effect) -> Option<Target> {
    match *effect {
        Effect::JumpRegister(register) => Some(Target::Register(register)),
        // The registers below PC come first.
        Effect::Stack { loaded, .. } if loaded & 1 << 15 != 0 => {
            Some(Target::Stack(4 * (loaded & 0x7FFF).count_ones() as u16))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_are_told_with_where_they_lead() {
        let pop = |loaded| Effect::Stack { by: 0, loaded };
        for (effect, is) in [
            (Effect::JumpRegister(14), Some(Target::Register(14))),
            (Effect::JumpRegister(1), Some(Target::Register(1))),
            (pop(0x8080), Some(Target::Stack(4))),
            (pop(0x8FF0), Some(Target::Stack(32))),
            (pop(0x8000), Some(Target::Stack(0))),
            (pop(0x0FF0), None),
            (Effect::CallRegister(1), None),
        ] {
            assert_eq!(return_target(&effect), is, "{effect:?}");
        }
    }
}
