//! Answers GDB's requests, one by one.

use std::collections::BTreeMap;

use gdbstub::common::Signal;
use gdbstub::target::ext::base::BaseOps;
use gdbstub::target::ext::base::single_register_access::{
    SingleRegisterAccess, SingleRegisterAccessOps,
};
use gdbstub::target::ext::base::singlethread::{
    SingleThreadBase, SingleThreadResume, SingleThreadResumeOps, SingleThreadSingleStep,
    SingleThreadSingleStepOps,
};
use gdbstub::target::ext::breakpoints::{
    Breakpoints, BreakpointsOps, HwBreakpoint, HwBreakpointOps, HwWatchpoint, HwWatchpointOps,
    SwBreakpoint, SwBreakpointOps, WatchKind,
};
use gdbstub::target::ext::memory_map::{MemoryMap, MemoryMapOps};
use gdbstub::target::ext::monitor_cmd::{ConsoleOutput, MonitorCmd, MonitorCmdOps, outputln};
use gdbstub::target::{Target, TargetError, TargetResult};

use crate::log::{Log, LogLine};

use super::Reason;
use super::arch::{All, CortexM4F, Register, number};
use super::machine::{Debuggee, memory_map};

/// The errno that says that there is nothing at an address.
const EFAULT: u8 = 14;

/// GDB's request to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Resume {
    Continue,
    Step,
}

/// A breakpoint.
#[derive(Clone, Copy, Debug)]
struct Mark {
    hardware: bool,
    /// There was a trap already: it stays when the breakpoint goes.
    was_there: bool,
}

/// A stretch of memory that is watched for changes.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    address: u32,
    bytes: Vec<u8>,
}

/// A machine as GDB sees it.
pub(super) struct Stub<M> {
    pub(super) machine: M,
    pub(super) resume: Resume,
    /// Whether the machine has executed nothing since GDB let it go.
    pub(super) fresh: bool,
    pub(super) watches: Vec<Watch>,
    /// Why it cannot go on.
    pub(super) halt: Option<String>,
    marks: BTreeMap<u32, Mark>,
    log: Option<Log>,
    /// The number of lines that GDB has been shown.
    shown: usize,
}

impl<M: Debuggee> Stub<M> {
    pub(super) fn new(machine: M, log: Option<Log>) -> Self {
        Self {
            machine,
            resume: Resume::Continue,
            fresh: true,
            watches: vec![],
            halt: None,
            marks: BTreeMap::new(),
            log,
            shown: 0,
        }
    }

    /// Why it stops here, if a breakpoint is set here.
    pub(super) fn breakpoint_here(&self) -> Option<Reason> {
        let pc = self.machine.register(Register::R(15)) as u32;
        let mark = self.marks.get(&pc)?;
        Some(if mark.hardware { Reason::HwBreak(()) } else { Reason::SwBreak(()) })
    }

    /// Why it stops, if a watched stretch of memory has changed.
    pub(super) fn changed_watch(&mut self) -> Option<Reason> {
        for watch in &mut self.watches {
            let mut now = watch.bytes.clone();
            self.machine.load(watch.address, &mut now);
            if now != watch.bytes {
                watch.bytes = now;
                return Some(Reason::Watch {
                    tid: (),
                    kind: WatchKind::Write,
                    addr: watch.address,
                });
            }
        }
        None
    }

    pub(super) fn forget_breakpoints(&mut self) {
        for (address, mark) in std::mem::take(&mut self.marks) {
            if !mark.was_there {
                self.machine.untrap(address);
            }
        }
        self.watches.clear();
    }

    pub(super) fn drain_log(&mut self) {
        if let Some(log) = &mut self.log {
            let now = self.machine.now();
            log.drain(self.machine.memory_mut(), now);
        }
    }

    pub(super) fn take_log(&mut self) -> Vec<LogLine> {
        self.shown = 0;
        self.log.as_mut().map(Log::take).unwrap_or_default()
    }

    fn set_breakpoint(&mut self, address: u32, hardware: bool) -> bool {
        if let Some(mark) = self.marks.get_mut(&address) {
            mark.hardware |= hardware;
            return true;
        }
        let was_there = self.machine.is_trapped(address);
        if !self.machine.trap(address) {
            return false;
        }
        self.marks.insert(address, Mark { hardware, was_there });
        true
    }

    fn remove_breakpoint(&mut self, address: u32) -> bool {
        let Some(mark) = self.marks.remove(&address) else { return false };
        if !mark.was_there {
            self.machine.untrap(address);
        }
        true
    }

    fn monitor(&mut self, command: &str, out: &mut dyn FnMut(&str)) {
        match command.trim() {
            "reset" => {
                let now = self.machine.now();
                if let Some(log) = &mut self.log {
                    log.reset(self.machine.memory_mut(), now);
                }
                self.machine.reset();
                self.halt = None;
                out("the chip has been reset; GDB does not know the registers anew until it stops");
            }
            "log" => match &self.log {
                None => out("there is no log"),
                Some(log) => {
                    for line in &log.lines()[self.shown.min(log.lines().len())..] {
                        out(&line.to_string());
                    }
                    self.shown = log.lines().len();
                }
            },
            "time" => {
                let now = self.machine.now();
                out(&format!("{}.{:09} s", now / 1_000_000_000, now % 1_000_000_000));
            }
            "where" => out(self.machine.backtrace().trim_end()),
            "why" => out(self.halt.as_deref().unwrap_or("nothing is wrong")),
            _ => out("monitor reset: press the reset button\n\
                 monitor log: what was logged since the last time\n\
                 monitor time: the simulated time\n\
                 monitor where: the back-trace, inlined functions and exceptions included\n\
                 monitor why: why the machine cannot go on"),
        }
    }
}

impl<M: Debuggee> Target for Stub<M> {
    type Arch = CortexM4F;
    type Error = &'static str;

    fn base_ops(&mut self) -> BaseOps<'_, Self::Arch, Self::Error> {
        BaseOps::SingleThread(self)
    }

    fn support_breakpoints(&mut self) -> Option<BreakpointsOps<'_, Self>> {
        Some(self)
    }

    fn support_monitor_cmd(&mut self) -> Option<MonitorCmdOps<'_, Self>> {
        Some(self)
    }

    fn support_memory_map(&mut self) -> Option<MemoryMapOps<'_, Self>> {
        Some(self)
    }

    /// A machine can do without: its breakpoints are not in its memory.
    fn guard_rail_implicit_sw_breakpoints(&self) -> bool {
        true
    }
}

impl<M: Debuggee> SingleThreadBase for Stub<M> {
    fn read_registers(&mut self, all: &mut All) -> TargetResult<(), Self> {
        all.0 = Register::all().map(|register| self.machine.register(register)).collect();
        Ok(())
    }

    fn write_registers(&mut self, all: &All) -> TargetResult<(), Self> {
        for (register, value) in Register::all().zip(&all.0) {
            // What is as it was may be a view of what was just written: SP and MSP.
            if self.machine.register(register) != *value {
                self.machine.set_register(register, *value);
            }
        }
        Ok(())
    }

    fn support_single_register_access(&mut self) -> Option<SingleRegisterAccessOps<'_, (), Self>> {
        Some(self)
    }

    fn read_addrs(&mut self, start: u32, data: &mut [u8]) -> TargetResult<usize, Self> {
        match self.machine.load(start, data) {
            0 if !data.is_empty() => Err(TargetError::Errno(EFAULT)),
            count => Ok(count),
        }
    }

    fn write_addrs(&mut self, start: u32, data: &[u8]) -> TargetResult<(), Self> {
        if self.machine.store(start, data) { Ok(()) } else { Err(TargetError::Errno(EFAULT)) }
    }

    fn support_resume(&mut self) -> Option<SingleThreadResumeOps<'_, Self>> {
        Some(self)
    }
}

impl<M: Debuggee> SingleRegisterAccess<()> for Stub<M> {
    fn read_register(
        &mut self,
        (): (),
        register: Register,
        buffer: &mut [u8],
    ) -> TargetResult<usize, Self> {
        let bytes = self.machine.register(register).to_le_bytes();
        let bytes = &bytes[..register.size().min(buffer.len())];
        buffer[..bytes.len()].copy_from_slice(bytes);
        Ok(bytes.len())
    }

    fn write_register(
        &mut self,
        (): (),
        register: Register,
        value: &[u8],
    ) -> TargetResult<(), Self> {
        self.machine.set_register(register, number(value));
        Ok(())
    }
}

impl<M: Debuggee> SingleThreadResume for Stub<M> {
    fn resume(&mut self, _signal: Option<Signal>) -> Result<(), Self::Error> {
        self.resume = Resume::Continue;
        self.fresh = true;
        Ok(())
    }

    fn support_single_step(&mut self) -> Option<SingleThreadSingleStepOps<'_, Self>> {
        Some(self)
    }
}

impl<M: Debuggee> SingleThreadSingleStep for Stub<M> {
    fn step(&mut self, _signal: Option<Signal>) -> Result<(), Self::Error> {
        self.resume = Resume::Step;
        self.fresh = true;
        Ok(())
    }
}

impl<M: Debuggee> Breakpoints for Stub<M> {
    fn support_sw_breakpoint(&mut self) -> Option<SwBreakpointOps<'_, Self>> {
        Some(self)
    }

    fn support_hw_breakpoint(&mut self) -> Option<HwBreakpointOps<'_, Self>> {
        Some(self)
    }

    fn support_hw_watchpoint(&mut self) -> Option<HwWatchpointOps<'_, Self>> {
        Some(self)
    }
}

impl<M: Debuggee> SwBreakpoint for Stub<M> {
    fn add_sw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(self.set_breakpoint(address, false))
    }

    fn remove_sw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(self.remove_breakpoint(address))
    }
}

impl<M: Debuggee> HwBreakpoint for Stub<M> {
    fn add_hw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(self.set_breakpoint(address, true))
    }

    fn remove_hw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(self.remove_breakpoint(address))
    }
}

/// Of writes that change something: the machine goes step by step and compares. Reads leave
/// nothing to compare.
impl<M: Debuggee> HwWatchpoint for Stub<M> {
    fn add_hw_watchpoint(
        &mut self,
        address: u32,
        length: u32,
        kind: WatchKind,
    ) -> TargetResult<bool, Self> {
        let mut bytes = vec![0; length.min(1024) as usize];
        let whole =
            bytes.len() == length as usize && self.machine.load(address, &mut bytes) == bytes.len();
        if kind != WatchKind::Write || !whole {
            return Ok(false);
        }
        self.watches.push(Watch { address, bytes });
        Ok(true)
    }

    fn remove_hw_watchpoint(
        &mut self,
        address: u32,
        length: u32,
        _kind: WatchKind,
    ) -> TargetResult<bool, Self> {
        let is_it =
            |watch: &Watch| watch.address == address && watch.bytes.len() == length as usize;
        let index = self.watches.iter().position(is_it);
        Ok(index.map(|index| self.watches.remove(index)).is_some())
    }
}

impl<M: Debuggee> MonitorCmd for Stub<M> {
    fn handle_monitor_cmd(
        &mut self,
        command: &[u8],
        mut out: ConsoleOutput<'_>,
    ) -> Result<(), Self::Error> {
        let command = String::from_utf8_lossy(command);
        self.monitor(&command, &mut |line| outputln!(out, "{line}"));
        Ok(())
    }
}

impl<M: Debuggee> MemoryMap for Stub<M> {
    fn memory_map_xml(
        &self,
        offset: u64,
        length: usize,
        buffer: &mut [u8],
    ) -> TargetResult<usize, Self> {
        let xml = memory_map();
        let rest = xml.as_bytes().get(offset as usize..).unwrap_or_default();
        let count = rest.len().min(length).min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}
