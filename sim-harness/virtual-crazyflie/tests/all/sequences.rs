//! What no single instruction shows: IT blocks, exclusives, exceptions, priorities, lazy
//! floating-point state, sleep and faults, as small programs that log what they see.
//!
//! The sources are in `sequences/*.s`, assembled by `sequences/build.sh` into the `.bin` beside
//! them. Each must leave the log that stands in its `.txt`, on this core and, where
//! `qemu-system-arm` is installed, on QEMU's Cortex-M4F (machine mps2-an386). Where QEMU is known
//! not to do what the manual says, [`QEMU_DIFFERS`] says so.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use virtual_crazyflie::bus::{Bus, Refused, Width};
use virtual_crazyflie::cpu::{Cpu, Program, Stop};
use virtual_crazyflie::memory::{Memory, map};

/// A line of a log that QEMU has otherwise: the program, the tag, which of the lines with that tag,
/// QEMU's value, and why the golden log has another.
const QEMU_DIFFERS: &[(&str, &str, usize, u32, &str)] = &[
    (
        "sleep",
        "base",
        0,
        0,
        "WFI is not ended by what BASEPRI masks (DDI 0403, B1.5.19); QEMU's is",
    ),
    ("sleep", "pend", 1, 0, "WFE sleeps until an event (B1.5.18); QEMU's does nothing"),
    ("sleep", "came", 1, 0, "the same: by then the interrupt has come"),
    ("sleep", "slep", 0, 0, "SCR.SLEEPONEXIT (B1.5.19) is not in QEMU"),
    ("floating", "fpsc", 0, 0, KEEPS_FLAGS),
    ("floating", "fpsc", 1, 0, KEEPS_FLAGS),
    ("faults", "pc  ", 31, 2, OWN_ADDRESS),
    ("faults", "pc  ", 32, 2, OWN_ADDRESS),
];

const KEEPS_FLAGS: &str = "a new context takes AHP, DN, FZ and RMode from FPDSCR and keeps the \
    flags (ExecuteFPCheck(), B1.5.7); QEMU clears them, as ARMv8-M does";
const OWN_ADDRESS: &str = "an SVC that escalates is a synchronous HardFault, which returns to the \
    instruction itself (ReturnAddress(), B1.5.6); QEMU's returns behind it";

/// All that are comparable.
const PROGRAMS: &[&str] =
    &["it", "exclusive", "frames", "floating", "priorities", "sleep", "faults", "anywhere"];

/// Where the log is: see `common.s`.
const LOG_END: u32 = 0x2000_0000;
const LOG: u32 = 0x2000_1000;
/// The vector that leads to the end.
const FINISH: usize = 7;
/// More than any of them takes.
const FOREVER: u64 = 10_000_000;

/// A chip of which there is nothing but an interrupt: its line goes high at a cycle, and low when
/// the program stores to it.
struct Alarm {
    at: u64,
    high: bool,
}

impl Alarm {
    const ADDRESS: u32 = 0x4000_4000;

    const fn never() -> Self {
        Self { at: u64::MAX, high: false }
    }
}

impl Bus for Alarm {
    fn load(&mut self, _: &mut Memory, _: u64, _: u32, _: Width) -> Result<u32, Refused> {
        Err(Refused::Fault)
    }

    fn store(
        &mut self,
        _: &mut Memory,
        _: u64,
        address: u32,
        _: Width,
        _: u32,
    ) -> Result<(), Refused> {
        if address != Self::ADDRESS {
            return Err(Refused::Fault);
        }
        self.high = false;
        Ok(())
    }

    fn due(&self) -> u64 {
        self.at
    }

    fn advance(&mut self, _: &mut Memory, now: u64) {
        if self.at <= now {
            *self = Self { at: u64::MAX, high: true };
        }
    }

    fn lines(&self) -> u128 {
        u128::from(self.high)
    }

    fn resets(&self) -> bool {
        false
    }
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sequences").join(name)
}

fn golden(name: &str) -> String {
    std::fs::read_to_string(file(&format!("{name}.txt"))).unwrap()
}

/// A core with a program, from its first instruction on.
struct Bench {
    cpu: Cpu,
    memory: Memory,
    program: Program,
    alarm: Alarm,
}

impl Bench {
    fn new(name: &str) -> Self {
        let image = std::fs::read(file(&format!("{name}.bin"))).unwrap();
        let mut memory = Memory::new();
        assert!(memory.program(map::FLASH, &image));
        let finish = image.as_chunks::<4>().0[FINISH];
        // The programs are where flash is mapped at boot: at zero.
        let mut program = Program::new(0, &image);
        assert!(program.trap(u32::from_le_bytes(finish) & !1));
        let mut cpu = Cpu::new();
        cpu.reset_core(&memory, 0);
        Self { cpu, memory, program, alarm: Alarm::never() }
    }

    fn run(&mut self, until: u64) -> Stop {
        self.cpu.run(&self.program, &mut self.memory, &mut self.alarm, until)
    }

    fn step(&mut self) -> Stop {
        self.cpu.step(&self.program, &mut self.memory, &mut self.alarm, FOREVER)
    }

    fn word(&self, address: u32) -> u32 {
        self.memory.load(address, Width::Word).unwrap()
    }

    fn log(&self) -> String {
        let bytes = self.memory.bytes(LOG, self.word(LOG_END) - LOG).unwrap();
        lines(bytes)
    }

    /// To the end of the program, and what it has logged.
    fn finished(mut self) -> String {
        let stop = self.run(FOREVER);
        assert_eq!(stop, Stop::Trap, "at {:08x} after\n{}", self.cpu.pc(), self.log());
        self.log()
    }
}

fn lines(log: &[u8]) -> String {
    log.as_chunks::<8>().0.iter().fold(String::new(), |mut lines, entry| {
        let (tag, value) = entry.split_at(4);
        let value = u32::from_le_bytes(value.try_into().unwrap());
        writeln!(lines, "{} {value:08x}", String::from_utf8_lossy(tag)).unwrap();
        lines
    })
}

/// Fails with the first line that is not as it should be, and what led there.
fn assert_same(name: &str, found: &str, wanted: &str) {
    let same = found.lines().zip(wanted.lines()).take_while(|(found, wanted)| found == wanted);
    let same = same.count();
    if found != wanted {
        let before: Vec<&str> = wanted.lines().take(same).collect();
        let before = before[before.len().saturating_sub(12)..].join("\n");
        let line = |log: &str| log.lines().nth(same).unwrap_or("(nothing)").to_owned();
        panic!("{name}, line {}:\n{before}\n{} (wanted {})", same + 1, line(found), line(wanted));
    }
}

fn keeps_to_the_manual(name: &str) {
    assert_same(name, &Bench::new(name).finished(), &golden(name));
}

#[test]
fn it_blocks_are_executed_as_they_say_and_survive_exceptions() {
    keeps_to_the_manual("it");
}

#[test]
fn exclusive_stores_fail_where_something_came_between() {
    keeps_to_the_manual("exclusive");
}

#[test]
fn exceptions_leave_and_find_the_frames_that_the_manual_describes() {
    keeps_to_the_manual("frames");
}

#[test]
fn floating_point_state_is_saved_when_it_must_be() {
    keeps_to_the_manual("floating");
}

#[test]
fn exceptions_come_by_priority() {
    keeps_to_the_manual("priorities");
}

#[test]
fn the_core_sleeps_until_what_should_wake_it() {
    keeps_to_the_manual("sleep");
}

#[test]
fn faults_say_what_happened_and_escalate() {
    keeps_to_the_manual("faults");
}

#[test]
fn a_fault_in_the_handler_of_hard_fault_locks_the_core_up() {
    let mut bench = Bench::new("lockup");
    assert_eq!(bench.run(FOREVER), Stop::Lockup);
    assert_same("lockup", &bench.log(), &golden("lockup"));
    assert_eq!(bench.run(FOREVER), Stop::Lockup, "for good");
}

#[test]
fn wfe_is_deaf_to_what_primask_masks() {
    let mut bench = Bench::new("deaf");
    assert_eq!(bench.run(FOREVER), Stop::Until);
    assert_same("deaf", &bench.log(), &golden("deaf"));
    assert!(bench.cpu.is_asleep());
    assert!(bench.cpu.slept() > FOREVER - 10_000);
}

#[test]
fn an_interrupt_changes_nothing_wherever_it_comes() {
    let mut quiet = Bench::new("anywhere");
    assert_eq!(quiet.run(FOREVER), Stop::Trap);
    let wanted = golden("anywhere");
    assert_same("anywhere", &quiet.log(), &wanted);
    // An instruction and an entry before the end it might not come any more.
    let end = quiet.cpu.cycles() - 40;
    for at in 0..end {
        let mut bench = Bench::new("anywhere");
        bench.memory.store(TAKEN, Width::Word, 0);
        bench.alarm.at = at;
        assert_eq!(bench.run(FOREVER), Stop::Trap, "at cycle {at}");
        assert_same(&format!("anywhere, cycle {at}"), &bench.log(), &wanted);
        assert_eq!(bench.word(TAKEN), 1, "at cycle {at}");
    }
}

/// Where `anywhere.s` counts its interrupts.
const TAKEN: u32 = 0x2000_0010;

#[test]
fn one_step_at_a_time_comes_to_the_same() {
    for name in PROGRAMS {
        let (mut run, mut stepped) = (Bench::new(name), Bench::new(name));
        assert_eq!(run.run(FOREVER), Stop::Trap);
        while stepped.cpu.pc() != run.cpu.pc() {
            assert_eq!(stepped.step(), Stop::Until, "{name}");
        }
        assert_same(name, &stepped.log(), &run.log());
        assert_eq!(stepped.cpu.cycles(), run.cpu.cycles(), "{name}");
        assert_eq!(stepped.cpu.slept(), run.cpu.slept(), "{name}");
        assert_eq!(stepped.cpu.instructions(), run.cpu.instructions(), "{name}");
    }
}

#[test]
fn stopping_and_going_on_comes_to_the_same() {
    for name in PROGRAMS {
        let (mut run, mut halting) = (Bench::new(name), Bench::new(name));
        assert_eq!(run.run(FOREVER), Stop::Trap);
        let stop = (0..FOREVER).step_by(7).map(|until| halting.run(until));
        assert_eq!(stop.into_iter().find(|stop| *stop != Stop::Until), Some(Stop::Trap), "{name}");
        assert_same(name, &halting.log(), &run.log());
        assert_eq!(halting.cpu.cycles(), run.cpu.cycles(), "{name}");
        assert_eq!(halting.cpu.slept(), run.cpu.slept(), "{name}");
    }
}

/// What QEMU must log: the golden text, but for what it is known to do otherwise.
fn golden_of_qemu(name: &str) -> String {
    let golden = golden(name);
    let mut lines: Vec<String> = golden.lines().map(str::to_owned).collect();
    for (_, tag, nth, value, why) in QEMU_DIFFERS.iter().filter(|entry| entry.0 == name) {
        let mut with_tag = lines.iter_mut().filter(|line| line.starts_with(tag));
        let line = with_tag.nth(*nth).expect("the table names lines that are there");
        let theirs = format!("{tag} {value:08x}");
        assert_ne!(*line, theirs, "no difference: {why}");
        *line = theirs;
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// The log that QEMU leaves, or `None` where there is no QEMU.
fn log_of_qemu(name: &str) -> Option<String> {
    let mut command = Command::new("qemu-system-arm");
    command.args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"]);
    // Time by instructions, so that it too does the same each time.
    command.args(["-serial", "none", "-icount", "shift=0,sleep=off"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]);
    command.arg(file(&format!("{name}.bin"))).stdin(Stdio::null());
    Some(lines(&command.output().ok()?.stdout))
}

#[test]
fn qemu_logs_the_same_where_it_is_installed() {
    for name in PROGRAMS {
        let Some(log) = log_of_qemu(name) else {
            eprintln!("skipped: there is no qemu-system-arm here");
            return;
        };
        assert_same(&format!("{name} on QEMU"), &log, &golden_of_qemu(name));
    }
}
