//! Pins and their edges: GPIO, SYSCFG and EXTI.

use super::{Chip, at, unmodelled};
use virtual_crazyflie::bus::{Bus, Width};
use virtual_crazyflie::soc::{Level, Pin, ResetCause};

const GPIOA: u32 = 0x4002_0000;
const GPIOB: u32 = 0x4002_0400;
const GPIOC: u32 = 0x4002_0800;
const MODER: u32 = 0x00;
const OTYPER: u32 = 0x04;
const PUPDR: u32 = 0x0C;
const IDR: u32 = 0x10;
const ODR: u32 = 0x14;
const BSRR: u32 = 0x18;
const LCKR: u32 = 0x1C;
const AFRL: u32 = 0x20;

/// A chip with ports A to C on, and SYSCFG.
fn chip() -> Chip {
    let mut chip = Chip::new();
    chip.modify(at::RCC_AHB1ENR, 0, 7);
    chip.modify(at::RCC_APB2ENR, 0, 1 << 14);
    chip
}

fn idr(chip: &mut Chip, port: u32, pin: u32) -> bool {
    chip.load(port + IDR) >> pin & 1 != 0
}

#[test]
fn the_debuggers_pins_are_taken_after_a_reset() {
    let mut chip = chip();
    assert_eq!(chip.load(GPIOA + MODER), 0xA800_0000);
    assert_eq!(chip.load(GPIOA + PUPDR), 0x6400_0000);
    assert_eq!(chip.load(GPIOB + MODER), 0x0000_0280);
    assert_eq!(chip.load(GPIOC + MODER), 0);
}

#[test]
fn a_pin_is_what_is_written_in_modes_types_pulls_and_on_the_board() {
    use Level::{High, Low, Released};
    // Mode, type, pull, ODR; the board; what the chip drives; what it reads.
    let table = [
        // Inputs.
        (0, 0, 0, 0, High, Released, true),
        (0, 0, 0, 0, Low, Released, false),
        (0, 0, 0, 1, Released, Released, false),
        (0, 0, 1, 0, Released, Released, true),
        (0, 0, 2, 0, Released, Released, false),
        (0, 0, 1, 0, Low, Released, false),
        (0, 0, 2, 0, High, Released, true),
        // Outputs, push-pull.
        (1, 0, 0, 0, Released, Low, false),
        (1, 0, 0, 1, Released, High, true),
        // Open drain.
        (1, 1, 1, 0, Released, Low, false),
        (1, 1, 1, 1, Released, Released, true),
        (1, 1, 1, 1, Low, Released, false),
        (1, 1, 0, 1, High, Released, true),
        // A peripheral's, and analog.
        (2, 1, 1, 1, Released, Released, true),
        (2, 1, 1, 1, Low, Released, false),
        (3, 0, 1, 1, High, Released, false),
    ];
    for row in table {
        let (mode, kind, pull, out, board, drives, reads) = row;
        let mut chip = chip();
        let pin = Pin::new('C', 5);
        chip.soc.board_mut().set(pin, board);
        chip.store(GPIOC + PUPDR, pull << 10);
        chip.store(GPIOC + OTYPER, kind << 5);
        chip.store(GPIOC + ODR, out << 5);
        chip.store(GPIOC + MODER, mode << 10);
        let last = chip.soc.board().driven.last().map_or(Released, |(_, level)| *level);
        assert_eq!(last, drives, "{row:?}");
        assert_eq!(idr(&mut chip, GPIOC, 5), reads, "{row:?}");
    }
}

#[test]
fn the_board_hears_of_changes_and_of_nothing_else() {
    let mut chip = chip();
    let (two, three) = (Pin::new('C', 2), Pin::new('C', 3));
    chip.store(GPIOC + MODER, 5 << 4);
    chip.store(GPIOC + BSRR, 1 << 2);
    chip.store(GPIOC + BSRR, 1 << 2);
    chip.store(GPIOC + BSRR, 1 << 2 | 1 << 18 | 1 << 19);
    chip.store(GPIOC + BSRR, 1 << 18);
    chip.store(GPIOC + BSRR, 1 << 9);
    chip.store(GPIOC + MODER, 1 << 4);
    assert_eq!(
        chip.soc.board().driven,
        [
            (two, Level::Low),
            (three, Level::Low),
            (two, Level::High),
            (two, Level::Low),
            (three, Level::Released),
        ]
    );
}

#[test]
fn a_reset_lets_every_pin_go() {
    let mut chip = chip();
    chip.store(GPIOC + MODER, 1 << 4);
    chip.store(GPIOC + BSRR, 1 << 2);
    chip.reset(ResetCause::Watchdog);
    assert_eq!(chip.soc.board().driven.last(), Some(&(Pin::new('C', 2), Level::Released)));
    let mut chip = self::chip();
    chip.store(GPIOC + MODER, 1 << 4);
    chip.modify(0x4002_3810, 0, 4);
    assert_eq!(chip.soc.board().driven.last(), Some(&(Pin::new('C', 2), Level::Released)));
}

#[test]
fn halves_and_bytes_of_a_port_are_stored_alone() {
    let mut chip = chip();
    chip.store(GPIOC + MODER, 0x5555_5555);
    chip.try_store(GPIOC + BSRR, Width::Half, 0x0001).expect("sets");
    chip.try_store(GPIOC + ODR + 1, Width::Byte, 0x80).expect("sets");
    assert_eq!(chip.load(GPIOC + ODR), 0x8001);
    chip.try_store(GPIOC + BSRR + 2, Width::Half, 0x0001).expect("clears");
    assert_eq!(chip.load(GPIOC + ODR), 0x8000);
    assert_eq!(chip.try_load(GPIOC + IDR + 1, Width::Byte), Ok(0x80));
}

#[test]
fn a_locked_pin_keeps_its_configuration_and_not_its_level() {
    let mut chip = chip();
    chip.store(GPIOC + MODER, 1 << 4);
    chip.store(GPIOC + LCKR, 1 << 16 | 4);
    chip.store(GPIOC + LCKR, 4);
    chip.store(GPIOC + LCKR, 1 << 16 | 4);
    assert_eq!(chip.load(GPIOC + LCKR), 1 << 16 | 4);
    chip.store(GPIOC + MODER, u32::MAX);
    chip.store(GPIOC + AFRL, u32::MAX);
    assert_eq!(chip.load(GPIOC + MODER), !(2 << 4));
    assert_eq!(chip.load(GPIOC + AFRL), !(15 << 8));
    chip.store(GPIOC + BSRR, 4);
    assert_eq!(chip.load(GPIOC + ODR), 4);
}

#[test]
fn a_sequence_with_a_mistake_locks_nothing() {
    for mistake in
        [[1 << 16 | 4, 4, 1 << 16 | 8], [4, 1 << 16 | 4, 4], [1 << 16 | 4, 5, 1 << 16 | 4]]
    {
        let mut chip = chip();
        for value in mistake {
            chip.store(GPIOC + LCKR, value);
        }
        assert_eq!(chip.load(GPIOC + LCKR) & 1 << 16, 0, "{mistake:?}");
    }
}

/// EXTI line `n` watches port C's pin.
fn watch(chip: &mut Chip, line: u32, rising: bool, falling: bool) {
    chip.modify(at::SYSCFG_EXTICR + line / 4 * 4, 15 << (4 * (line % 4)), 2 << (4 * (line % 4)));
    chip.store(at::EXTI_RTSR, u32::from(rising) << line);
    chip.store(at::EXTI_FTSR, u32::from(falling) << line);
    chip.store(at::EXTI_IMR, 1 << line);
}

#[test]
fn each_line_has_its_interrupt() {
    for (line, number) in (0..16).zip([6, 7, 8, 9, 10, 23, 23, 23, 23, 23, 40, 40, 40, 40, 40, 40])
    {
        let mut chip = chip();
        watch(&mut chip, line, true, false);
        chip.soc.board_mut().set(Pin::of(2, line as usize), Level::High);
        chip.soc.touch(chip.now);
        assert_eq!(chip.soc.lines(), 1 << number, "line {line}");
        chip.store(at::EXTI_PR, 1 << line);
        assert_eq!(chip.soc.lines(), 0, "line {line}");
    }
}

#[test]
fn an_edge_counts_in_the_directions_that_are_watched() {
    for (rising, falling, pending) in
        [(true, false, [1, 0]), (false, true, [0, 1]), (true, true, [1, 1])]
    {
        let mut chip = chip();
        watch(&mut chip, 14, rising, falling);
        let edges = [Level::High, Level::Low].map(|level| {
            chip.soc.board_mut().set(Pin::new('C', 14), level);
            chip.soc.touch(chip.now);
            let is_pending = chip.load(at::EXTI_PR) >> 14 & 1;
            chip.store(at::EXTI_PR, 1 << 14);
            is_pending
        });
        assert_eq!(edges, pending, "rising {rising}, falling {falling}");
    }
}

#[test]
fn a_level_that_is_there_already_is_no_edge() {
    let mut chip = chip();
    chip.soc.board_mut().set(Pin::new('C', 14), Level::High);
    watch(&mut chip, 14, true, false);
    chip.soc.touch(chip.now);
    assert_eq!(chip.load(at::EXTI_PR), 0);
}

#[test]
fn an_edge_is_pending_behind_its_mask() {
    let mut chip = chip();
    watch(&mut chip, 14, true, false);
    chip.store(at::EXTI_IMR, 0);
    chip.soc.board_mut().set(Pin::new('C', 14), Level::High);
    chip.soc.touch(chip.now);
    assert_eq!(chip.soc.lines(), 0);
    chip.store(at::EXTI_IMR, 1 << 14);
    assert!(chip.line(40));
}

#[test]
fn a_pulse_is_seen_at_its_moment_even_while_the_core_sleeps() {
    let mut chip = chip();
    chip.start_clocks();
    watch(&mut chip, 14, true, false);
    let at = chip.nanos() + 1_000_000;
    let pin = Pin::new('C', 14);
    chip.soc.board_mut().plan = vec![(at, pin, Level::High), (at + 50, pin, Level::Low)];
    chip.soc.touch(chip.now);
    let due = chip.soc.due();
    assert_eq!(due, chip.soc.cycle(at));
    chip.pass_to(due - 1);
    assert!(!chip.line(40));
    chip.pass(1);
    assert!(chip.line(40));
    // Without an access in between, it would have been seen too.
    let mut late = self::chip();
    watch(&mut late, 14, true, false);
    late.soc.board_mut().plan = vec![(1000, pin, Level::High), (1050, pin, Level::Low)];
    late.now = late.soc.cycle(5000);
    assert_eq!(late.load(at::EXTI_PR), 1 << 14);
}

#[test]
fn software_raises_a_line_that_is_not_masked() {
    let mut chip = chip();
    chip.store(at::EXTI_SWIER, 2);
    assert_eq!(chip.load(at::EXTI_PR), 0);
    chip.store(at::EXTI_PR, 2);
    chip.store(at::EXTI_IMR, 2);
    chip.store(at::EXTI_SWIER, 2);
    assert_eq!(chip.load(at::EXTI_PR), 2);
    assert!(chip.line(7));
    chip.store(at::EXTI_PR, 2);
    assert_eq!(chip.load(at::EXTI_SWIER), 0);
    assert_eq!(chip.soc.lines(), 0);
}

#[test]
fn events_are_refused() {
    let mut chip = chip();
    assert!(unmodelled(chip.try_store(at::EXTI_EMR, Width::Word, 1)).contains("EXTI_EMR"));
}
