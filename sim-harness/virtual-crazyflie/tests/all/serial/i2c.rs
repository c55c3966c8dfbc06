//! I²C, register by register: as the manual's transfer diagrams have it (RM0090, "I2C master
//! mode"), as embassy's driver for this peripheral does it, and with everything that goes wrong.

use super::{DMA1, GPIOA, GPIOC, MEGAHERTZ, RAM, Rig, Seen, Stream, cr};

const I2C1: u32 = 0x4000_5400;
const I2C3: u32 = 0x4000_5C00;

const CR1: u32 = I2C3;
const CR2: u32 = I2C3 + 0x04;
const OAR1: u32 = I2C3 + 0x08;
const DR: u32 = I2C3 + 0x10;
const SR1: u32 = I2C3 + 0x14;
const SR2: u32 = I2C3 + 0x18;
const CCR: u32 = I2C3 + 0x1C;
const TRISE: u32 = I2C3 + 0x20;

const PE: u32 = 1;
const START: u32 = 1 << 8;
const STOP: u32 = 1 << 9;
const ACK: u32 = 1 << 10;
const POS: u32 = 1 << 11;
const SWRST: u32 = 1 << 15;

const ITERREN: u32 = 1 << 8;
const ITEVTEN: u32 = 1 << 9;
const ITBUFEN: u32 = 1 << 10;
const DMAEN: u32 = 1 << 11;
const LAST: u32 = 1 << 12;

const SB: u32 = 1;
const ADDR: u32 = 1 << 1;
const BTF: u32 = 1 << 2;
const RXNE: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
const BERR: u32 = 1 << 8;
const ARLO: u32 = 1 << 9;
const AF: u32 = 1 << 10;

const MSL: u32 = 1;
const BUSY: u32 = 1 << 1;
const TRA: u32 = 1 << 2;

const EVENT: u32 = 72;
const ERROR: u32 = 73;

const DEVICE: u8 = 0x29;

/// Fast mode at 16 MHz: CCR is 13, a bit 39 cycles.
const BIT: u64 = 39;

fn rig() -> Rig {
    let mut rig = Rig::new();
    set_up(&mut rig);
    rig
}

/// As embassy's driver does it: a software reset, the timing, PE.
fn set_up(rig: &mut Rig) {
    rig.modify(CR1, PE, 0);
    rig.modify(CR1, 0, SWRST);
    rig.modify(CR1, SWRST, 0);
    rig.write(CR2, 16);
    rig.write(CCR, 1 << 15 | 13);
    rig.write(TRISE, 5);
    rig.modify(CR1, 0, PE);
}

/// A start and an address that is acknowledged; ADDR stays up.
#[track_caller]
fn call(rig: &mut Rig, read: bool) {
    rig.modify(CR1, 0, START | if read { ACK } else { 0 });
    rig.wait(SR1, SB);
    assert_eq!(rig.read(CR1) & START, 0);
    assert_eq!(rig.read(SR2) & MSL, MSL);
    rig.write(DR, u32::from(DEVICE) << 1 | u32::from(read));
    rig.wait(SR1, ADDR);
}

#[track_caller]
fn stopped(rig: &mut Rig) {
    for _ in 0..1000 {
        if rig.read(CR1) & STOP == 0 {
            assert_eq!(rig.read(SR2) & (MSL | BUSY), 0);
            return;
        }
    }
    panic!("the stop never comes");
}

fn start(read: bool) -> Seen {
    Seen::Start { address: DEVICE, read }
}

#[test]
fn bytes_are_written_as_the_manual_has_it() {
    let mut rig = rig();
    call(&mut rig, false);
    assert_eq!(rig.read(SR2) & TRA, TRA);
    assert_eq!(rig.read(SR1) & (TXE | BTF | ADDR), TXE, "EV8_1");
    for byte in [0x11, 0x22, 0x33] {
        rig.wait(SR1, TXE);
        rig.write(DR, byte);
    }
    rig.wait(SR1, TXE | BTF);
    rig.modify(CR1, 0, STOP);
    stopped(&mut rig);
    let seen = [start(false), Seen::Write(0x11), Seen::Write(0x22), Seen::Write(0x33), Seen::Stop];
    assert_eq!(rig.board().seen, seen);
    assert_eq!(rig.read(SR1), 0, "a stop takes TXE and BTF with it");
}

#[test]
fn a_byte_takes_nine_bits_of_what_ccr_says() {
    for (ccr, bit) in [(80, 160), (1 << 15 | 13, 39), (3 << 14 | 2, 50)] {
        let mut rig = Rig::new();
        rig.write(CR2, 16);
        rig.write(CCR, ccr);
        rig.write(CR1, PE);
        call(&mut rig, false);
        rig.read(SR2);
        rig.write(DR, 1);
        rig.write(DR, 2);
        rig.wait(SR1, BTF);
        let moments = rig.board().moments.clone();
        let byte = 9 * bit * 1000 / MEGAHERTZ;
        assert!((moments[2] - moments[1]).abs_diff(byte) <= 1, "CCR {ccr:#x}: {moments:?}");
    }
}

#[test]
fn bytes_follow_each_other_without_a_gap_when_dr_is_filled_in_time() {
    let mut rig = rig();
    call(&mut rig, false);
    rig.read(SR2);
    for byte in 0..8 {
        rig.wait(SR1, TXE);
        rig.write(DR, byte);
    }
    rig.wait(SR1, BTF);
    let moments = rig.board().moments.clone();
    assert!((moments[8] - moments[1]).abs_diff(7 * 9 * BIT * 1000 / MEGAHERTZ) <= 1);
}

#[test]
fn the_clock_is_held_while_sb_addr_and_btf_wait() {
    let mut rig = rig();
    rig.modify(CR1, 0, START);
    rig.wait(SR1, SB);
    rig.micros(500);
    assert!(rig.board().seen.is_empty());
    rig.write(DR, u32::from(DEVICE) << 1);
    rig.wait(SR1, ADDR);
    rig.micros(500);
    assert_eq!(rig.read(SR1) & (ADDR | TXE), ADDR);
    rig.read(SR2);
    rig.write(DR, 7);
    rig.wait(SR1, BTF);
    rig.micros(500);
    assert_eq!(rig.board().seen, [start(false), Seen::Write(7)]);
    rig.write(DR, 8);
    assert_eq!(rig.read(SR1) & BTF, 0, "reading SR1 and writing DR has cleared it");
    rig.wait(SR1, BTF);
    assert_eq!(rig.board().seen.len(), 3);
}

#[test]
fn addr_falls_only_by_reading_sr1_and_then_sr2() {
    let mut rig = rig();
    rig.modify(CR1, 0, START);
    rig.wait(SR1, SB);
    rig.write(DR, u32::from(DEVICE) << 1);
    rig.micros(100);
    rig.read(SR2);
    assert_eq!(rig.read(SR1) & ADDR, ADDR, "SR1 had not been read with ADDR in it");
    rig.read(SR2);
    assert_eq!(rig.read(SR1) & ADDR, 0);
}

#[test]
fn an_address_before_sb_was_seen_is_refused_loudly() {
    let mut rig = rig();
    rig.modify(CR1, 0, START);
    rig.micros(100);
    assert!(rig.refusal(DR, 0x52).contains("SB"));
}

#[test]
fn one_byte_is_read_with_ack_cleared_before_addr() {
    let mut rig = rig();
    rig.board().gives.extend([0x42, 0x43]);
    call(&mut rig, true);
    rig.modify(CR1, ACK, 0);
    rig.read(SR2);
    rig.modify(CR1, 0, STOP);
    rig.wait(SR1, RXNE);
    assert_eq!(rig.read(DR), 0x42);
    stopped(&mut rig);
    assert_eq!(rig.board().seen, [start(true), Seen::Read(0x42), Seen::Stop]);
    assert_eq!(rig.read(SR1), 0);
}

/// As RM0090 has it, and as ST's library does it: there ACK falls before ADDR does.
#[test]
fn two_bytes_are_read_with_pos() {
    for ack_falls_first in [false, true] {
        let mut rig = rig();
        rig.board().gives.extend([1, 2, 3]);
        rig.modify(CR1, 0, POS);
        call(&mut rig, true);
        if ack_falls_first {
            rig.modify(CR1, ACK, 0);
            rig.read(SR2);
        } else {
            rig.read(SR2);
            rig.modify(CR1, ACK, 0);
        }
        rig.wait(SR1, BTF | RXNE);
        rig.micros(200);
        assert_eq!(rig.board().seen.len(), 3, "the second was refused: no third");
        rig.modify(CR1, 0, STOP);
        assert_eq!((rig.read(DR), rig.read(DR)), (1, 2));
        stopped(&mut rig);
        assert_eq!(rig.read(SR1), 0);
        assert_eq!(rig.board().seen, [start(true), Seen::Read(1), Seen::Read(2), Seen::Stop]);
    }
}

/// RM0090, "Case of a master receiver, N > 2": the last three with BTF.
#[test]
fn many_bytes_are_read_with_btf_before_the_last_three() {
    let mut rig = rig();
    rig.board().gives.extend(1..=5);
    call(&mut rig, true);
    rig.read(SR2);
    let mut bytes = Vec::new();
    for _ in 0..2 {
        rig.wait(SR1, RXNE);
        bytes.push(rig.read(DR));
    }
    rig.wait(SR1, BTF);
    rig.micros(100);
    assert_eq!(rig.board().seen.len(), 5, "the clock is held with two bytes here");
    rig.modify(CR1, ACK, 0);
    bytes.push(rig.read(DR));
    rig.modify(CR1, 0, STOP);
    bytes.push(rig.read(DR));
    rig.wait(SR1, RXNE);
    bytes.push(rig.read(DR));
    stopped(&mut rig);
    assert_eq!(bytes, [1, 2, 3, 4, 5]);
    assert_eq!(rig.board().seen.len(), 7, "a start, five bytes, a stop: {:?}", rig.board().seen);
}

/// RM0090, method 1: ACK and STOP while the last byte comes in.
#[test]
fn many_bytes_are_read_by_interrupt() {
    let mut rig = rig();
    rig.board().gives.extend(1..=4);
    call(&mut rig, true);
    rig.read(SR2);
    rig.modify(CR2, 0, ITEVTEN | ITBUFEN);
    let mut bytes = Vec::new();
    for count in 1..=4 {
        rig.wait_line(EVENT);
        bytes.push(rig.read(DR));
        assert!(!rig.line(EVENT));
        if count == 3 {
            rig.modify(CR1, ACK, STOP);
        }
    }
    stopped(&mut rig);
    assert_eq!(bytes, [1, 2, 3, 4]);
    assert_eq!(rig.board().seen.last(), Some(&Seen::Stop));
    assert_eq!(rig.board().seen.len(), 6);
}

#[test]
fn ack_cleared_when_the_ninth_bit_has_begun_comes_too_late() {
    let read = |cycles: u64| {
        let mut rig = rig();
        rig.board().gives.extend(1..=4);
        call(&mut rig, true);
        rig.read(SR2);
        rig.pass(cycles);
        rig.modify(CR1, ACK, 0);
        rig.micros(200);
        rig.board().seen.len() - 1
    };
    assert_eq!(read(7 * BIT), 1);
    assert_eq!(read(9 * BIT - 20), 2, "the first was acknowledged already");
}

#[test]
fn a_repeated_start_changes_the_direction_without_a_stop() {
    let mut rig = rig();
    rig.board().gives.push_back(9);
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 0x0F);
    rig.wait(SR1, BTF);
    call(&mut rig, true);
    rig.modify(CR1, ACK, 0);
    assert_eq!(rig.read(SR2) & (MSL | TRA), MSL);
    rig.modify(CR1, 0, STOP);
    rig.wait(SR1, RXNE);
    assert_eq!(rig.read(DR), 9);
    stopped(&mut rig);
    let seen = [start(false), Seen::Write(0x0F), start(true), Seen::Read(9), Seen::Stop];
    assert_eq!(rig.board().seen, seen);
}

#[test]
fn a_start_asked_for_with_the_stop_follows_it() {
    let mut rig = rig();
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 1);
    rig.wait(SR1, BTF);
    rig.modify(CR1, 0, START | STOP);
    rig.wait(SR1, SB);
    assert_eq!(rig.read(CR1) & (START | STOP), 0);
    assert_eq!(rig.board().seen, [start(false), Seen::Write(1), Seen::Stop]);
}

#[test]
fn a_stop_during_a_byte_waits_for_its_end() {
    let mut rig = rig();
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 1);
    rig.write(DR, 2);
    rig.modify(CR1, 0, STOP);
    stopped(&mut rig);
    assert_eq!(rig.board().seen, [start(false), Seen::Write(1), Seen::Stop], "and 2 is lost");
}

#[test]
fn an_address_without_an_answer_raises_af_and_holds_the_clock_until_the_stop() {
    let mut rig = rig();
    rig.modify(CR2, 0, ITERREN | ITEVTEN);
    rig.modify(CR1, 0, START);
    rig.wait(SR1, SB);
    assert!(rig.line(EVENT));
    rig.write(DR, 0x55 << 1);
    assert!(!rig.line(EVENT));
    rig.wait_line(ERROR);
    assert_eq!(rig.read(SR1), AF);
    assert_eq!(rig.read(SR2) & (MSL | BUSY | TRA), MSL | BUSY);
    rig.micros(300);
    assert_eq!(rig.read(SR2) & BUSY, BUSY);
    rig.write(SR1, !AF);
    assert!(!rig.line(ERROR));
    rig.modify(CR1, 0, STOP);
    stopped(&mut rig);
    let seen = [Seen::Start { address: 0x55, read: false }, Seen::Stop];
    assert_eq!(rig.board().seen, seen);
}

#[test]
fn a_byte_that_is_refused_raises_af_and_no_btf() {
    let mut rig = rig();
    rig.board().takes = 1;
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 1);
    rig.wait(SR1, TXE);
    rig.write(DR, 2);
    let status = rig.wait(SR1, AF);
    assert_eq!(status & BTF, 0);
    rig.modify(CR1, 0, STOP);
    stopped(&mut rig);
    let seen = [start(false), Seen::Write(1), Seen::Write(2), Seen::Stop];
    assert_eq!(rig.board().seen, seen);
    assert_eq!(rig.read(SR1), AF, "until it is written zero");
}

#[test]
fn errors_are_cleared_by_zeros_alone() {
    let mut rig = rig();
    rig.modify(CR1, 0, START);
    rig.wait(SR1, SB);
    rig.write(DR, 0x55 << 1);
    rig.wait(SR1, AF);
    rig.write(SR1, 0xFFFF);
    assert_eq!(rig.read(SR1), AF);
    rig.write(SR1, 0);
    assert_eq!(rig.read(SR1), 0);
}

#[test]
fn no_start_while_a_device_holds_the_data_line() {
    let mut rig = rig();
    rig.board().data_held = 2_000_000;
    assert_eq!(rig.read(SR2), BUSY);
    rig.modify(CR1, 0, START);
    rig.micros(1_000);
    assert_eq!((rig.read(SR1), rig.read(CR1) & START), (0, START));
    assert_eq!(rig.read(SR2), BUSY, "nor is it master");
    rig.micros(1_100);
    assert_eq!(rig.read(SR1), SB);
}

#[test]
fn a_device_stretches_a_byte_for_as_long_as_it_holds_the_clock() {
    let mut rig = rig();
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 5);
    let now = rig.now * 1000 / MEGAHERTZ;
    rig.board().clock_held = now + 3_000_000;
    rig.micros(2_900);
    assert_eq!(rig.board().seen.len(), 1);
    rig.micros(200);
    assert_eq!(rig.board().seen, [start(false), Seen::Write(5)]);
    assert_eq!(rig.read(SR1), TXE | BTF, "and no timeout, which is SMBus's");
}

#[test]
fn arbitration_is_lost_where_a_one_stays_low() {
    let mut rig = rig();
    rig.modify(CR2, 0, ITERREN);
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 0xA0);
    let now = rig.now * 1000 / MEGAHERTZ;
    rig.board().data_held = now + 1_000_000;
    rig.wait_line(ERROR);
    assert_eq!(rig.read(SR1), ARLO);
    assert_eq!(rig.read(SR2), BUSY, "a slave again, and the line is low");
    rig.write(SR1, !ARLO);
    rig.micros(1_100);
    assert_eq!(rig.read(SR2), 0);
}

#[test]
fn a_stop_cannot_be_made_while_the_data_line_is_held() {
    let mut rig = rig();
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 1);
    rig.wait(SR1, BTF);
    let now = rig.now * 1000 / MEGAHERTZ;
    rig.board().data_held = now + 1_000_000;
    rig.modify(CR1, 0, STOP);
    rig.micros(900);
    assert_eq!(rig.read(CR1) & STOP, STOP);
    assert_eq!(rig.read(SR2) & BUSY, BUSY);
    rig.micros(200);
    stopped(&mut rig);
}

#[test]
fn a_software_reset_frees_a_peripheral_that_hangs() {
    let mut rig = rig();
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 1);
    rig.board().clock_held = u64::MAX;
    rig.micros(1_000);
    assert_eq!(rig.read(SR2) & (MSL | BUSY), MSL | BUSY);
    rig.modify(CR1, PE, 0);
    assert_eq!(rig.read(SR2) & MSL, MSL, "PE alone waits for the end of the transfer");
    rig.modify(CR1, 0, SWRST);
    rig.write(CCR, 1);
    rig.modify(CR1, SWRST, 0);
    for register in [CR1, CR2, OAR1, SR1, CCR] {
        assert_eq!(rig.read(register), 0, "{register:#x}");
    }
    assert_eq!(rig.read(TRISE), 2);
    assert_eq!(rig.read(SR2), BUSY, "the line is low still");
    rig.board().clock_held = 0;
    assert_eq!(rig.read(SR2), 0);
    set_up(&mut rig);
    call(&mut rig, false);
}

#[test]
fn pe_takes_start_stop_ack_and_pos_with_it() {
    let mut rig = rig();
    rig.board().data_held = u64::MAX;
    rig.modify(CR1, 0, START | ACK | POS);
    rig.modify(CR1, PE, 0);
    assert_eq!(rig.read(CR1), 0);
    rig.board().data_held = 0;
    rig.micros(100);
    assert_eq!((rig.read(SR1), rig.read(SR2)), (0, 0));
}

/// As the firmware mends a bus: the pins as outputs, and back.
#[test]
fn pins_that_are_taken_away_leave_the_lines_high() {
    let mut rig = rig();
    rig.board().data_held = u64::MAX;
    assert_eq!(rig.read(SR2), BUSY);
    rig.mode(GPIOC, 9, 1);
    assert_eq!(rig.read(SR2), 0);
    rig.mode(GPIOA, 8, 1);
    rig.modify(CR1, 0, START);
    rig.wait(SR1, SB);
    rig.write(DR, u32::from(DEVICE) << 1);
    rig.wait(SR1, AF);
    assert!(rig.board().seen.is_empty(), "no device was addressed");
    rig.modify(CR1, 0, STOP);
    stopped(&mut rig);
    assert!(rig.board().seen.is_empty());
}

#[test]
fn pins_that_go_in_the_middle_of_a_byte_are_a_bus_error() {
    let mut rig = rig();
    rig.modify(CR2, 0, ITERREN);
    call(&mut rig, false);
    rig.read(SR2);
    rig.write(DR, 1);
    rig.mode(GPIOA, 8, 1);
    rig.wait_line(ERROR);
    assert_eq!(rig.read(SR1) & (BERR | AF), BERR | AF);
    rig.write(SR1, !(BERR | AF));
    assert_eq!(rig.read(SR1) & (BERR | AF), 0);
}

const TRANSMIT: Stream = Stream { controller: DMA1, number: 4 };
const RECEIVE: Stream = Stream { controller: DMA1, number: 2 };
const TRANSMIT_INTERRUPT: u32 = 15;
const RECEIVE_INTERRUPT: u32 = 13;
const BOTH: u32 = 3 << 25 | cr::MINC | cr::TCIE | cr::TEIE | 3 << 16;

/// embassy's `write_frame`.
#[track_caller]
fn write_by_dma(rig: &mut Rig, bytes: &[u8], stop: bool) {
    rig.put(RAM, bytes);
    rig.modify(CR2, ITBUFEN | LAST, DMAEN);
    rig.modify(CR2, 0, ITEVTEN | ITERREN);
    rig.modify(CR1, 0, START);
    rig.wait_line(EVENT);
    assert_eq!(rig.read(SR1), SB);
    rig.write(DR, u32::from(DEVICE) << 1);
    rig.wait_line(EVENT);
    assert_eq!(rig.read(SR1), ADDR);
    rig.read(SR2);
    let count = u32::try_from(bytes.len()).expect("a short one");
    TRANSMIT.start(rig, BOTH | cr::TO_PERIPHERAL, DR, RAM, count);
    rig.wait_line(TRANSMIT_INTERRUPT);
    assert_eq!(rig.read(SR1) & BTF, 0, "the last byte is on its way");
    TRANSMIT.clear(rig, Stream::TCIF);
    rig.modify(CR2, DMAEN, 0);
    rig.wait_line(EVENT);
    assert_eq!(rig.read(SR1), BTF | TXE);
    if stop {
        rig.modify(CR1, 0, STOP);
    }
    rig.modify(CR2, ITEVTEN | ITERREN, 0);
}

/// embassy's `read_frame`.
#[track_caller]
fn read_by_dma(rig: &mut Rig, count: u32) -> Vec<u8> {
    let single = count == 1;
    rig.modify(CR2, ITBUFEN | LAST, DMAEN | if single { 0 } else { LAST });
    rig.modify(CR1, 0, START | ACK);
    rig.wait(SR1, SB);
    rig.read(SR2);
    rig.write(DR, u32::from(DEVICE) << 1 | 1);
    rig.wait(SR1, ADDR);
    if single {
        rig.modify(CR1, ACK, 0);
    }
    rig.read(SR2);
    if single {
        rig.modify(CR1, 0, STOP);
    }
    RECEIVE.start(rig, BOTH, DR, RAM + 0x100, count);
    rig.wait_line(RECEIVE_INTERRUPT);
    RECEIVE.clear(rig, Stream::TCIF);
    rig.modify(CR2, DMAEN, 0);
    if !single {
        rig.modify(CR1, 0, STOP);
    }
    stopped(rig);
    rig.bytes(RAM + 0x100, count)
}

#[test]
fn dma_writes_and_reads_as_embassy_has_it() {
    for count in [1, 2, 3, 6, 64] {
        let mut rig = rig();
        let sent: Vec<u8> = (0..count).collect();
        write_by_dma(&mut rig, &sent, false);
        let given: Vec<u8> = (100..100 + count).collect();
        rig.board().gives.extend(&given);
        assert_eq!(read_by_dma(&mut rig, count.into()), given);
        let mut seen = vec![start(false)];
        seen.extend(sent.iter().map(|byte| Seen::Write(*byte)));
        seen.push(start(true));
        seen.extend(given.iter().map(|byte| Seen::Read(*byte)));
        seen.push(Seen::Stop);
        assert_eq!(rig.board().seen, seen, "{count} bytes: none more, the last refused");
        assert_eq!(rig.read(SR1), 0);
    }
}

/// With two bytes here already the last one was acknowledged: the manual's EOT_1 comes too late,
/// and the device gives one more. A driver has to be in time.
#[test]
fn dma_that_is_late_reads_one_byte_too_many() {
    let mut rig = rig();
    rig.board().gives.extend([1, 2, 3]);
    rig.modify(CR2, 0, DMAEN | LAST);
    call(&mut rig, true);
    rig.read(SR2);
    rig.micros(200);
    RECEIVE.start(&mut rig, BOTH, DR, RAM, 2);
    rig.wait_line(RECEIVE_INTERRUPT);
    rig.micros(100);
    assert_eq!(rig.bytes(RAM, 2), [1, 2]);
    assert_eq!(rig.read(SR1) & RXNE, RXNE);
    assert_eq!(rig.board().seen.len(), 4);
}

#[test]
fn a_refused_byte_stops_the_requests_to_dma() {
    let mut rig = rig();
    rig.board().takes = 2;
    rig.put(RAM, &[1, 2, 3, 4, 5, 6]);
    rig.modify(CR2, 0, DMAEN | ITERREN);
    call(&mut rig, false);
    rig.read(SR2);
    TRANSMIT.start(&mut rig, BOTH | cr::TO_PERIPHERAL, DR, RAM, 6);
    rig.wait_line(ERROR);
    rig.micros(500);
    assert!(TRANSMIT.left(&mut rig) > 0);
    assert_eq!(rig.board().seen.len(), 4, "three bytes went out, of which the third was refused");
}

#[test]
fn what_a_lone_master_never_needs_is_refused_loudly() {
    let mut rig = rig();
    for bit in [1, 3, 4, 5, 6, 12, 13] {
        assert!(rig.refusal(CR1, PE | 1 << bit).contains("I2C_CR1"), "bit {bit}");
    }
    assert!(rig.refusal(OAR1, 1 << 15).contains("OAR1"));
    assert!(rig.refusal(OAR1 + 4, 1).contains("OAR2"));
    // An address of its own, to which no device speaks: bit 14 "should always be kept at 1".
    rig.write(OAR1, 1 << 14 | 0x30 << 1);
    assert!(rig.refusal(I2C3 + 0x24, 0).contains("STM32F405"));
    rig.modify(CR1, 0, START);
    rig.wait(SR1, SB);
    assert!(rig.refusal(DR, 0xF0).contains("ten-bit"));
}

#[test]
fn a_wrong_timing_is_refused_loudly() {
    let mut rig = rig();
    assert!(rig.refusal(CCR, 20).contains("PE"));
    rig.write(CCR, 1 << 15 | 13);
    rig.modify(CR1, PE, 0);
    rig.write(CR2, 42);
    assert!(rig.refusal(CR1, PE).contains("FREQ"), "42 MHz are not what APB1 has");
    rig.write(CR2, 16);
    rig.write(CCR, 0);
    assert!(rig.refusal(CR1, PE).contains("CCR"));
}

#[test]
fn each_of_them_has_its_own_interrupts() {
    let mut rig = Rig::new();
    rig.write(I2C1 + 4, 16 | ITEVTEN | ITERREN);
    rig.write(I2C1 + 0x1C, 80);
    rig.write(I2C1, PE);
    rig.modify(I2C1, 0, START);
    rig.wait_line(31);
    rig.read(I2C1 + 0x14);
    rig.write(I2C1 + 0x10, 0x20);
    rig.wait_line(32);
    assert!(!rig.line(31) && !rig.line(EVENT) && !rig.line(ERROR));
}
