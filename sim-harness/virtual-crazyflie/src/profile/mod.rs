//! Measures which task has the processor, for how long, and how late it gets it.
//!
//! The firmware is not changed and cannot notice: the emulator stops at a few addresses where a
//! task is polled and returns, where an interrupt begins and ends, and where a task is woken. The
//! time between two such moments is charged to the task or interrupt that had the processor. The
//! profile is as good as the core's count of cycles: see there.
//!
//! | module | what it holds |
//! |---|---|
//! | `sites` | which addresses these are, found in the image |
//! | `account` | which task or interrupt is charged |
//! | `names` | how tasks and interrupts are called |
//! | `quick` | maps that are quick |
//! | `report` | what comes out |

mod account;
mod names;
mod quick;
mod report;
mod sites;

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use crate::bus::Width;
use crate::cpu::Cpu;
use crate::image::Image;
use crate::machine::Observer;
use crate::memory::Memory;

use account::{Account, What};
use quick::QuickMap;
pub use report::{Durations, InterruptLoad, Report, StackUse, TaskLoad, WatchedTime};
use sites::{Site, Sites};

/// The word with which cortex-m-rt paints an unused stack (`paint-stack`).
const PAINT: u32 = 0xCCCC_CCCC;

/// Why a function cannot be watched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoSuchFunction(String);

impl std::fmt::Display for NoSuchFunction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the image has no function {} of its own: it may have been inlined", self.0)
    }
}

impl std::error::Error for NoSuchFunction {}

/// The core's counters at a trap.
#[derive(Clone, Copy, Debug, Default)]
struct Moment {
    registers: [u32; 16],
    exception: u16,
    cycles: u64,
    slept: u64,
}

impl Moment {
    fn of(cpu: &Cpu) -> Self {
        Self {
            registers: std::array::from_fn(|n| cpu.register(n)),
            exception: (cpu.xpsr() & 0x1FF) as u16,
            cycles: cpu.cycles(),
            slept: cpu.slept(),
        }
    }
}

/// A profile in the making.
///
/// The caller marks [`traps`](Self::traps) in the machine, which then calls the profile there.
#[derive(Debug)]
pub struct Profile {
    sites: Sites,
    account: Account,
    watched: Vec<String>,
    /// When each task that waits to be polled was woken, by the address of its header.
    woken: QuickMap<u32, u64>,
    stack: Option<Range<u32>>,
    lowest: u32,
}

impl Profile {
    /// A profile of a machine that runs this image.
    #[must_use]
    pub fn new(image: &Image) -> Self {
        let sites = Sites::find(image);
        let account = Account::new(sites.tasks().len());
        Self {
            sites,
            account,
            watched: vec![],
            woken: QuickMap::default(),
            stack: image.stack(),
            lowest: u32::MAX,
        }
    }

    /// Measures a function too, by its name in Rust: `uchain_firmware::control::step`. To be called
    /// before [`traps`](Self::traps).
    ///
    /// # Errors
    /// If there is no such function that exists by itself.
    pub fn watch(&mut self, image: &Image, name: &str) -> Result<(), NoSuchFunction> {
        let function = image.find(name).ok_or_else(|| NoSuchFunction(name.to_owned()))?;
        self.sites.watch(image, function, self.watched.len());
        self.watched.push(name.to_owned());
        self.account.watch();
        Ok(())
    }

    /// The addresses at which it has to be called.
    pub fn traps(&self) -> impl Iterator<Item = u32> {
        self.sites.addresses()
    }

    /// Forgets all that was measured, and begins anew: behind the start-up, for instance.
    pub fn restart(&mut self, cpu: &Cpu) {
        let now = Moment::of(cpu);
        self.account.restart(&now);
        self.lowest = u32::MAX;
    }

    /// The measurements so far. `core_hz` is the core's clock.
    #[must_use]
    pub fn report(&mut self, cpu: &Cpu, memory: &Memory, core_hz: u32) -> Report {
        self.account.charge(&Moment::of(cpu));
        let stack = self.stack.clone().map(|stack| self.stack_use(memory, stack));
        self.report_with(core_hz, stack)
    }

    fn report_with(&self, core_hz: u32, stack: Option<StackUse>) -> Report {
        let (sites, account) = (&self.sites, &self.account);
        Report::new(account, sites.tasks(), &self.watched, sites.knows_wakes(), core_hz, stack)
    }

    fn stack_use(&self, memory: &Memory, stack: Range<u32>) -> StackUse {
        let size = stack.end - stack.start;
        let unpainted = memory.bytes(stack.start, size).map(|bytes| {
            let words = bytes.as_chunks::<4>().0.iter();
            let painted = words.take_while(|word| u32::from_le_bytes(**word) == PAINT).count();
            size - 4 * painted as u32
        });
        StackUse {
            size,
            // One that reaches to the very end was hardly painted.
            by_paint: unpainted.filter(|used| *used < size),
            seen: stack.contains(&self.lowest).then(|| stack.end - self.lowest),
        }
    }

    fn at(&mut self, now: &Moment, load: &dyn Fn(u32, Width) -> Option<u32>) {
        let pc = now.registers[15];
        self.account.charge(now);
        let sp = now.registers[13];
        if self.stack.as_ref().is_some_and(|stack| stack.contains(&sp)) {
            self.lowest = self.lowest.min(sp);
        }
        let Self { sites, account, woken, .. } = self;
        for site in sites.at(pc) {
            reach(account, woken, *site, now, load);
        }
    }

    #[cfg(test)]
    fn of_sites(sites: Sites) -> Self {
        let account = Account::new(sites.tasks().len());
        Self {
            sites,
            account,
            watched: vec![],
            woken: QuickMap::default(),
            stack: None,
            lowest: u32::MAX,
        }
    }
}

/// The core is at a site.
fn reach(
    account: &mut Account,
    woken: &mut QuickMap<u32, u64>,
    site: Site,
    now: &Moment,
    load: &dyn Fn(u32, Width) -> Option<u32>,
) {
    match site {
        Site::Reset => {
            account.reset();
            woken.clear();
        }
        Site::Handler => account.enter(now),
        Site::HandlerReturn(place) => {
            let target = match place {
                sites::Target::Register(n) => Some(now.registers[usize::from(n & 15)]),
                sites::Target::Stack(offset) => {
                    load(now.registers[13].wrapping_add(offset.into()), Width::Word)
                }
            };
            if now.exception != 0 && target.is_some_and(|target| target >= 0xFFFF_FF00) {
                account.leave(now);
            }
        }
        // Seen a second time, when an exception came in before the first instruction.
        Site::Poll(task) if account.has_begun(now, What::Poll(task)) => {}
        Site::Watched(index) if account.has_begun(now, What::Watched(index)) => {}
        Site::Poll(task) => {
            let since = woken.remove(&now.registers[0]);
            account.polled(now, task, since);
        }
        Site::PollReturn => account.poll_returned(now),
        Site::Wake { register, offset } => {
            let queued = now.registers[usize::from(register & 15)];
            if load(queued, Width::Byte) == Some(0) {
                woken.entry(queued.wrapping_sub(offset)).or_insert(now.cycles);
            }
        }
        Site::Watched(index) => account.begin(now, What::Watched(index)),
        Site::WatchedReturn => account.returned(now),
    }
}

impl Observer for Profile {
    fn trap(&mut self, cpu: &Cpu, memory: &Memory) {
        self.at(&Moment::of(cpu), &|address, width| memory.load(address, width));
    }
}

/// Shares a profile between the machine that fills it and a caller that reads it.
impl Observer for Arc<Mutex<Profile>> {
    fn trap(&mut self, cpu: &Cpu, memory: &Memory) {
        self.lock().unwrap_or_else(PoisonError::into_inner).trap(cpu, memory);
    }
}

#[cfg(test)]
mod tests;
