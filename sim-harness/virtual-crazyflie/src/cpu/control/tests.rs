//! Registers as software sees them.

use proptest::prelude::*;

use super::*;
use crate::cpu::exceptions::priorities::bit;
use crate::memory::Memory;

fn machine() -> Cpu {
    Cpu::new()
}

fn store(cpu: &mut Cpu, address: u32, value: u32) {
    assert_eq!(cpu.system_store(address, Width::Word, value), Ok(()));
}

fn load(cpu: &mut Cpu, address: u32) -> u32 {
    cpu.system_load(address, Width::Word).expect("it is modelled")
}

fn refused<T>(outcome: Result<T, Refused>) -> &'static str {
    match outcome {
        Err(Refused::Unmodelled { what }) => what,
        Err(Refused::Fault) => "fault",
        Ok(_) => "answered",
    }
}

/// A register after reset, after ones were stored to it, and after zeroes, or why not.
fn line(name: &str, address: u32) -> String {
    let after = |value: Option<u32>| {
        let mut cpu = machine();
        let stored = value.map(|value| cpu.system_store(address, Width::Word, value));
        match (stored, cpu.system_load(address, Width::Word)) {
            (Some(Err(Refused::Unmodelled { what })), _) => format!("({what})"),
            (Some(Err(Refused::Fault)), _) => "(fault)".to_owned(),
            (_, Ok(value)) => format!("{value:08x}"),
            (_, why) => format!("({})", refused(why)),
        }
    };
    let (reset, ones, zeroes) = (after(None), after(Some(!0)), after(Some(0)));
    format!("{name:<10} {address:08x}  {reset}  {ones}  {zeroes}\n")
}

const REGISTERS: &[(&str, u32)] = &[
    ("ITM_STIM0", 0xE000_0000),
    ("DWT_CTRL", 0xE000_1000),
    ("DWT_LSR", 0xE000_1FB4),
    ("FP_CTRL", 0xE000_2000),
    ("ICTR", 0xE000_E004),
    ("ACTLR", 0xE000_E008),
    ("SYST_CSR", 0xE000_E010),
    ("SYST_RVR", 0xE000_E014),
    ("SYST_CVR", 0xE000_E018),
    ("SYST_CALIB", 0xE000_E01C),
    ("ISER0", 0xE000_E100),
    ("ISER2", 0xE000_E108),
    ("ISER3", 0xE000_E10C),
    ("ICER0", 0xE000_E180),
    ("ISPR0", 0xE000_E200),
    ("ISPR2", 0xE000_E208),
    ("ICPR0", 0xE000_E280),
    ("IABR0", 0xE000_E300),
    ("IPR0", 0xE000_E400),
    ("IPR20", 0xE000_E450),
    ("IPR21", 0xE000_E454),
    ("CPUID", 0xE000_ED00),
    ("ICSR", 0xE000_ED04),
    ("VTOR", 0xE000_ED08),
    ("AIRCR", 0xE000_ED0C),
    ("SCR", 0xE000_ED10),
    ("CCR", 0xE000_ED14),
    ("SHPR1", 0xE000_ED18),
    ("SHPR2", 0xE000_ED1C),
    ("SHPR3", 0xE000_ED20),
    ("SHCSR", 0xE000_ED24),
    ("CFSR", 0xE000_ED28),
    ("HFSR", 0xE000_ED2C),
    ("DFSR", 0xE000_ED30),
    ("MMFAR", 0xE000_ED34),
    ("BFAR", 0xE000_ED38),
    ("AFSR", 0xE000_ED3C),
    ("ID_PFR0", 0xE000_ED40),
    ("ID_PFR1", 0xE000_ED44),
    ("ID_DFR0", 0xE000_ED48),
    ("ID_AFR0", 0xE000_ED4C),
    ("ID_MMFR0", 0xE000_ED50),
    ("ID_MMFR1", 0xE000_ED54),
    ("ID_ISAR0", 0xE000_ED60),
    ("ID_ISAR1", 0xE000_ED64),
    ("ID_ISAR2", 0xE000_ED68),
    ("ID_ISAR3", 0xE000_ED6C),
    ("ID_ISAR4", 0xE000_ED70),
    ("CLIDR", 0xE000_ED78),
    ("CTR", 0xE000_ED7C),
    ("CCSIDR", 0xE000_ED80),
    ("CSSELR", 0xE000_ED84),
    ("CPACR", 0xE000_ED88),
    ("MPU_TYPE", 0xE000_ED90),
    ("MPU_CTRL", 0xE000_ED94),
    ("MPU_RNR", 0xE000_ED98),
    ("DHCSR", 0xE000_EDF0),
    ("DCRSR", 0xE000_EDF4),
    ("DEMCR", 0xE000_EDFC),
    ("STIR", 0xE000_EF00),
    ("FPCCR", 0xE000_EF34),
    ("FPCAR", 0xE000_EF38),
    ("FPDSCR", 0xE000_EF3C),
    ("MVFR0", 0xE000_EF40),
    ("MVFR1", 0xE000_EF44),
    ("ICIALLU", 0xE000_EF50),
    ("PID4", 0xE000_EFD0),
    ("TPIU", 0xE004_0000),
    ("ETM", 0xE004_1000),
    ("DBGMCU", 0xE004_2000),
    ("ROM", 0xE00F_F000),
];

#[test]
fn each_register_has_the_value_and_the_bits_of_the_manual() {
    let text: String = REGISTERS.iter().map(|(name, address)| line(name, *address)).collect();
    assert_eq!(text, include_str!("tests/registers.txt"));
}

#[test]
fn no_address_of_the_bus_is_answered_by_a_panic() {
    for address in (0xE000_0000..=0xE00F_FFFC).step_by(4) {
        for value in [None, Some(0), Some(1), Some(!0)] {
            let mut cpu = machine();
            let _ = match value {
                None => cpu.system_load(address, Width::Word).map(|_| ()),
                Some(value) => cpu.system_store(address, Width::Word, value),
            };
            // The rest of the bus is reserved, and one page of it like the other.
            if address > 0xE004_3000 && address < 0xE00F_F000 {
                break;
            }
        }
    }
}

#[test]
fn thread_mode_without_privileges_gets_a_bus_fault() {
    let mut cpu = machine();
    cpu.msr(20, 0, 1);
    assert_eq!(cpu.system_load(0xE000_ED00, Width::Word), Err(Refused::Fault));
    assert_eq!(cpu.system_store(0xE000_ED08, Width::Word, 0), Err(Refused::Fault));
    assert_eq!(cpu.system_store(0xE000_EF00, Width::Word, 3), Err(Refused::Fault));
    cpu.special.unprivileged = false;
    store(&mut cpu, 0xE000_ED14, 0x202);
    cpu.special.unprivileged = true;
    assert_eq!(cpu.system_store(0xE000_EF00, Width::Word, 3), Ok(()));
    assert_eq!(cpu.exceptions.priorities.pending(), bit(19));
}

#[test]
fn priorities_and_the_fault_status_are_also_bytes_and_halfwords() {
    let mut cpu = machine();
    assert_eq!(cpu.system_store(0xE000_E405, Width::Byte, 0xAB), Ok(()));
    assert_eq!(load(&mut cpu, 0xE000_E404), 0xA000);
    assert_eq!(cpu.system_load(0xE000_E405, Width::Byte), Ok(0xA0));
    assert_eq!(cpu.exceptions.priorities.priority(16 + 5), 0xA0);
    assert_eq!(cpu.system_store(0xE000_ED23, Width::Byte, 0xFF), Ok(()));
    assert_eq!(load(&mut cpu, 0xE000_ED20), 0xF000_0000);
    assert_eq!(cpu.exceptions.priorities.priority(15), 0xF0);
    cpu.control.faults.cfsr = 0x0201_8282;
    assert_eq!(cpu.system_load(0xE000_ED2A, Width::Half), Ok(0x0201));
    assert_eq!(cpu.system_store(0xE000_ED29, Width::Byte, 0x80), Ok(()));
    assert_eq!(load(&mut cpu, 0xE000_ED28), 0x0201_0282);
    assert_eq!(cpu.system_store(0xE000_ED2A, Width::Half, 0x0200), Ok(()));
    assert_eq!(load(&mut cpu, 0xE000_ED28), 0x0001_0282);
    assert!(refused(cpu.system_load(0xE000_ED08, Width::Byte)).contains("a part"));
    assert!(refused(cpu.system_load(0xE000_E402, Width::Word)).contains("unaligned"));
}

#[test]
fn a_reset_needs_the_key() {
    let mut cpu = machine();
    store(&mut cpu, 0xE000_ED0C, 0x1234_0704);
    assert!(!cpu.wants_reset());
    assert_eq!(load(&mut cpu, 0xE000_ED0C), 0xFA05_0000);
    store(&mut cpu, 0xE000_ED0C, 0x05FA_0304);
    assert!(cpu.wants_reset());
    assert_eq!(load(&mut cpu, 0xE000_ED0C), 0xFA05_0300);
}

#[test]
fn icsr_shows_what_is_active_and_what_waits() {
    let (mut cpu, mut memory) = (machine(), Memory::new());
    assert!(memory.program(crate::memory::map::FLASH, &[1; 0x200]));
    cpu.r[13] = crate::memory::map::RAM + 0x100;
    store(&mut cpu, 0xE000_ED04, 1 << 28);
    cpu.take_exception(&mut memory);
    assert_eq!(load(&mut cpu, 0xE000_ED04), 1 << 11 | 14);
    store(&mut cpu, 0xE000_ED04, 1 << 28 | 1 << 26);
    assert_eq!(load(&mut cpu, 0xE000_ED04), 1 << 28 | 1 << 26 | 14 << 12 | 1 << 11 | 14);
    store(&mut cpu, 0xE000_ED04, 1 << 27 | 1 << 25);
    assert_eq!(load(&mut cpu, 0xE000_ED04), 1 << 11 | 14);
    store(&mut cpu, 0xE000_ED04, 1 << 31);
    cpu.take_exception(&mut memory);
    assert_eq!(load(&mut cpu, 0xE000_ED04), 2, "PendSV is active below it");
    store(&mut cpu, 0xE000_E200, 8);
    assert_eq!(load(&mut cpu, 0xE000_ED04), 1 << 22 | 2, "it is not enabled");
    store(&mut cpu, 0xE000_E100, 8);
    assert_eq!(load(&mut cpu, 0xE000_ED04), 1 << 22 | 19 << 12 | 2);
}

#[test]
fn cyccnt_counts_cycles_awake_and_only_while_it_is_enabled() {
    let mut cpu = machine();
    assert!(refused(cpu.system_load(0xE000_1004, Width::Word)).contains("TRCENA"));
    store(&mut cpu, 0xE000_EDFC, 1 << 24);
    cpu.cycles = 1000;
    assert_eq!(load(&mut cpu, 0xE000_1004), 0);
    store(&mut cpu, 0xE000_1000, 1);
    cpu.cycles = 1100;
    assert_eq!(load(&mut cpu, 0xE000_1004), 100);
    (cpu.cycles, cpu.slept) = (2000, 850);
    assert_eq!(load(&mut cpu, 0xE000_1004), 150);
    cpu.set_counts_in_sleep(true);
    (cpu.cycles, cpu.slept) = (2010, 860);
    assert_eq!(load(&mut cpu, 0xE000_1004), 160);
    cpu.set_counts_in_sleep(false);
    (cpu.cycles, cpu.slept) = (2020, 870);
    assert_eq!(load(&mut cpu, 0xE000_1004), 160);
    store(&mut cpu, 0xE000_1004, u32::MAX);
    cpu.cycles += 2;
    assert_eq!(load(&mut cpu, 0xE000_1004), 1);
    store(&mut cpu, 0xE000_1000, 0x4000_0000);
    cpu.cycles += 50;
    assert_eq!(load(&mut cpu, 0xE000_1004), 1);
    assert!(refused(cpu.system_store(0xE000_1000, Width::Word, 1 << 12)).contains("CYCCNTENA"));
    assert!(refused(cpu.system_store(0xE000_1028, Width::Word, 4)).contains("comparator"));
}

/// SysTick, tick by tick (B3.3.1).
#[derive(Clone, Copy, Debug, Default)]
struct Ticking {
    control: u32,
    reload: u32,
    current: u32,
    counted: bool,
    pending: bool,
}

impl Ticking {
    fn tick(&mut self) {
        if self.control & 1 == 0 {
            return;
        }
        if self.current == 0 {
            self.current = self.reload;
        } else {
            self.current -= 1;
            if self.current == 0 {
                self.counted = true;
                self.pending |= self.control & 2 != 0;
            }
        }
    }

    fn cycle(&mut self, now: u64) {
        if self.control & 4 != 0 || now.is_multiple_of(8) {
            self.tick();
        }
    }
}

proptest! {
    #[test]
    fn systick_computed_equals_systick_counted(
        steps in prop::collection::vec((0_u64..40, 0_u8..6, 0_u32..12), 1..40),
    ) {
        let mut cpu = machine();
        let mut ticking = Ticking::default();
        for (cycles, what, value) in steps {
            for _ in 0..cycles {
                let due = cpu.system_due();
                cpu.cycles += 1;
                ticking.cycle(cpu.cycles);
                if due <= cpu.cycles {
                    cpu.system_advance();
                }
                let pending = cpu.exceptions.priorities.pending() == bit(15);
                prop_assert_eq!(pending, ticking.pending, "to the cycle");
            }
            match what {
                0 => {
                    store(&mut cpu, 0xE000_E010, value);
                    ticking.control = value & 7;
                }
                1 => {
                    store(&mut cpu, 0xE000_E014, value);
                    ticking.reload = value;
                }
                2 => {
                    store(&mut cpu, 0xE000_E018, value);
                    (ticking.current, ticking.counted) = (0, false);
                }
                3 => prop_assert_eq!(load(&mut cpu, 0xE000_E018), ticking.current),
                4 => {
                    let flag = u32::from(std::mem::take(&mut ticking.counted)) << 16;
                    prop_assert_eq!(load(&mut cpu, 0xE000_E010), ticking.control | flag);
                }
                _ => {
                    store(&mut cpu, 0xE000_ED04, 1 << 25);
                    ticking.pending = false;
                }
            }
        }
    }
}
