//! USART6, register by register: sending and receiving as the manual has it (RM0090, "USART
//! functional description") and as embassy's driver does it, senders whose rate is off, and every
//! flag's way to be cleared.

use super::{DMA2, GPIOC, MEGAHERTZ, RAM, Rig, Stream, cr};
use proptest::prelude::*;
use virtual_crazyflie::soc::UartByte;

const SR: u32 = 0x4001_1400;
const DR: u32 = SR + 0x04;
const BRR: u32 = SR + 0x08;
const CR1: u32 = SR + 0x0C;
const CR2: u32 = SR + 0x10;
const CR3: u32 = SR + 0x14;

const RE: u32 = 1 << 2;
const TE: u32 = 1 << 3;
const IDLEIE: u32 = 1 << 4;
const RXNEIE: u32 = 1 << 5;
const TCIE: u32 = 1 << 6;
const TXEIE: u32 = 1 << 7;
const UE: u32 = 1 << 13;
const OVER8: u32 = 1 << 15;

const EIE: u32 = 1;
const DMAR: u32 = 1 << 6;
const DMAT: u32 = 1 << 7;
const ONEBIT: u32 = 1 << 11;

const FE: u32 = 1 << 1;
const NF: u32 = 1 << 2;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;

const INTERRUPT: u32 = 71;

/// 1 Mbaud: 16 MHz by 16.
fn rig() -> Rig {
    with_rate(16, 0)
}

fn with_rate(brr: u32, cr1: u32) -> Rig {
    let mut rig = Rig::new();
    rig.write(BRR, brr);
    rig.write(CR1, UE | TE | RE | cr1);
    rig
}

/// Bytes one after the other from `at` µs on, with bits of so many ns.
fn send(rig: &mut Rig, at: u64, bit: u32, bytes: &[u8]) {
    for (index, data) in (0..).zip(bytes) {
        let at = at * 1000 + index * 10 * u64::from(bit);
        let byte = UartByte { at, bit, data: *data, noise: false, broken: false };
        rig.board().coming.push_back(byte);
    }
    let now = rig.now;
    rig.soc.touch(now);
}

fn micros(rig: &Rig) -> u64 {
    rig.now / MEGAHERTZ
}

#[test]
fn a_byte_leaves_in_ten_bits_after_an_idle_frame() {
    let mut rig = rig();
    let began = rig.now;
    assert_eq!(rig.read(SR), TXE | TC, "as after a reset");
    rig.write(DR, 0x55);
    assert_eq!(rig.read(SR) & TXE, 0, "TE sends an idle frame first");
    rig.wait(SR, TXE | TC);
    let (byte, bit, at) = rig.board().sent[0];
    assert_eq!((byte, bit), (0x55, 1000));
    assert_eq!(at.abs_diff((began + 2 * 160) * 1000 / MEGAHERTZ), 0);
}

#[test]
fn the_rate_is_what_brr_says() {
    for (brr, over8, bit) in
        [(16, 0, 1000), (139, 0, 8688), (1667, 0, 104_188), (0x10, OVER8, 500), (0x25, OVER8, 1313)]
    {
        let mut rig = with_rate(brr, over8);
        rig.write(DR, 1);
        rig.wait(SR, TXE);
        rig.write(DR, 2);
        rig.write(SR, !TC);
        rig.wait(SR, TC);
        let sent = rig.board().sent.clone();
        assert_eq!(sent[0].1, bit, "BRR {brr:#x}");
        assert!((sent[1].2 - sent[0].2).abs_diff(10 * u64::from(bit)) <= 10);
    }
}

#[test]
fn two_stop_bits_take_one_bit_longer() {
    let mut rig = Rig::new();
    rig.write(BRR, 16);
    rig.write(CR2, 2 << 12);
    rig.write(CR1, UE | TE);
    rig.write(DR, 1);
    rig.wait(SR, TXE);
    rig.write(DR, 2);
    rig.micros(100);
    let sent = rig.board().sent.clone();
    assert_eq!(sent[1].2 - sent[0].2, 11_000);
}

#[test]
fn tc_is_cleared_by_reading_sr_and_writing_dr_or_by_a_zero() {
    let mut rig = rig();
    rig.write(DR, 1);
    assert_eq!(rig.read(SR) & TC, TC, "SR had not been read");
    rig.micros(40);
    rig.read(SR);
    rig.write(DR, 2);
    assert_eq!(rig.read(SR) & TC, 0);
    rig.wait(SR, TC);
    rig.write(SR, !TC);
    assert_eq!(rig.read(SR) & TC, 0);
    rig.micros(100);
    assert_eq!(rig.read(SR) & TC, 0, "it comes with the end of a byte");
}

#[test]
fn sending_has_its_interrupts() {
    let mut rig = rig();
    rig.write(SR, !TC);
    rig.modify(CR1, 0, TCIE);
    assert!(!rig.line(INTERRUPT));
    rig.modify(CR1, 0, TXEIE);
    assert!(rig.line(INTERRUPT));
    rig.write(DR, 1);
    assert!(!rig.line(INTERRUPT));
    rig.wait_line(INTERRUPT);
    rig.modify(CR1, TXEIE, 0);
    assert!(!rig.line(INTERRUPT));
    rig.wait_line(INTERRUPT);
    assert_eq!(rig.board().sent.len(), 1, "TC, when the stop bit is over");
}

#[test]
fn a_byte_is_there_in_the_middle_of_its_stop_bit() {
    let mut rig = rig();
    rig.modify(CR1, 0, RXNEIE);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[0xA7]);
    while !rig.line(INTERRUPT) {
        rig.pass(1);
    }
    assert_eq!(rig.now, at * MEGAHERTZ + 19 * 16 / 2);
    assert_eq!(rig.read(SR), TXE | TC | RXNE);
    assert_eq!(rig.read(DR), 0xA7);
    assert_eq!(rig.read(SR), TXE | TC);
    assert!(!rig.line(INTERRUPT));
}

#[test]
fn idle_comes_once_after_a_frame_of_silence() {
    let mut rig = rig();
    rig.micros(100);
    assert_eq!(rig.read(SR) & IDLE, 0, "nothing has come in yet");
    rig.modify(CR1, 0, IDLEIE);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1, 2, 3]);
    rig.wait_line(INTERRUPT);
    let late = rig.now - (at + 30 + 10) * MEGAHERTZ;
    assert!(late <= 8, "three bytes and a frame: {late} cycles late");
    rig.read(SR);
    assert!(rig.line(INTERRUPT));
    rig.read(DR);
    assert!(!rig.line(INTERRUPT), "SR, then DR");
    rig.micros(1_000);
    assert!(!rig.line(INTERRUPT), "not again before another byte");
}

#[test]
fn a_gap_of_less_than_a_frame_is_no_idle_line() {
    let mut rig = rig();
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1]);
    send(&mut rig, at + 10 + 9, 1000, &[2]);
    rig.micros(10 + 28);
    assert_eq!(rig.read(SR) & IDLE, 0);
    rig.micros(20);
    assert_eq!(rig.read(SR) & IDLE, IDLE);
}

#[test]
fn a_byte_that_was_not_read_stays_and_the_next_is_lost() {
    let mut rig = rig();
    rig.modify(CR1, 0, RXNEIE);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1, 2, 3]);
    rig.micros(60);
    assert_eq!(rig.read(SR) & (ORE | RXNE | FE | NF), ORE | RXNE);
    assert_eq!(rig.read(DR), 1);
    assert_eq!(rig.read(SR) & (ORE | RXNE), 0);
    assert!(!rig.line(INTERRUPT));
}

#[test]
fn an_overrun_interrupts_even_when_the_byte_was_read_without_sr() {
    let mut rig = rig();
    rig.modify(CR1, 0, RXNEIE);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1, 2]);
    rig.micros(60);
    rig.read(DR);
    assert!(rig.line(INTERRUPT), "ORE is still there");
    rig.read(SR);
    rig.read(DR);
    assert!(!rig.line(INTERRUPT));
}

#[test]
fn rxne_falls_by_a_zero_too() {
    let mut rig = rig();
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1]);
    rig.wait(SR, RXNE);
    rig.write(SR, !RXNE);
    assert_eq!(rig.read(SR) & RXNE, 0);
}

#[test]
fn a_broken_stop_bit_is_a_framing_error_and_a_break_is_one_with_nothing_in_it() {
    let mut rig = rig();
    for data in [0x81, 0] {
        let at = (micros(&rig) + 10) * 1000;
        let byte = UartByte { at, bit: 1000, data, noise: false, broken: true };
        rig.board().coming.push_back(byte);
        rig.soc.touch(rig.now);
        rig.micros(30);
        assert_eq!(rig.read(SR) & (FE | RXNE), FE | RXNE);
        assert_eq!(rig.read(DR), u32::from(data));
        assert_eq!(rig.read(SR) & FE, 0);
    }
}

#[test]
fn noise_is_reported_unless_one_sample_is_enough() {
    for (cr3, noise) in [(0, NF), (ONEBIT, 0)] {
        let mut rig = rig();
        rig.write(CR3, cr3);
        let at = (micros(&rig) + 10) * 1000;
        let byte = UartByte { at, bit: 1000, data: 9, noise: true, broken: false };
        rig.board().coming.push_back(byte);
        rig.soc.touch(rig.now);
        rig.wait(SR, RXNE);
        assert_eq!(rig.read(SR) & NF, noise);
        assert_eq!(rig.read(DR), 9);
    }
}

/// EIE stands for errors where DMA receives (USART_CR3, EIE).
#[test]
fn errors_interrupt_where_dma_receives() {
    let mut rig = rig();
    rig.write(CR3, EIE);
    let at = (micros(&rig) + 10) * 1000;
    let byte = UartByte { at, bit: 1000, data: 9, noise: false, broken: true };
    rig.board().coming.push_back(byte);
    rig.soc.touch(rig.now);
    rig.wait(SR, FE);
    assert!(!rig.line(INTERRUPT));
    rig.write(CR3, EIE | DMAR);
    assert!(rig.line(INTERRUPT));
}

fn comes_through(brr: u32, cr1: u32, bit: u32, data: u8) -> (u32, u8) {
    let mut rig = with_rate(brr, cr1);
    let at = micros(&rig) + 10;
    send(&mut rig, at, bit, &[data]);
    let status = rig.wait(SR, RXNE);
    #[expect(clippy::cast_possible_truncation, reason = "eight bits")]
    let received = rig.read(DR) as u8;
    (status & (FE | NF), received)
}

#[test]
fn the_tolerance_is_the_manuals() {
    // Whole divisors tolerate 3.75 %, by eight 2.5 %; others 3.33 and 2 %.
    for (brr, cr1, ours, good, bad) in [
        (16, 0, 1000, 1037, 1038),
        (16, 0, 1000, 963, 962),
        (0x10, OVER8, 500, 512, 513),
        (24, 0, 1500, 1549, 1550),
        (0x14, OVER8, 750, 765, 766),
    ] {
        assert_eq!(comes_through(brr, cr1, ours, 0x5A), (0, 0x5A));
        assert_eq!(comes_through(brr, cr1, good, 0x5A), (0, 0x5A), "{brr:#x}, {good} ns");
        assert_eq!(comes_through(brr, cr1, bad, 0x5A).0 & FE, FE, "{brr:#x}, {bad} ns");
    }
}

#[test]
fn a_sender_at_half_or_twice_the_rate_is_read_wrong() {
    let (slow, fast) = (comes_through(16, 0, 2000, 0x35), comes_through(16, 0, 500, 0x35));
    assert_eq!(slow.0 & FE, FE);
    assert_eq!(fast.0 & FE, FE);
    // Each of the sender's bits fills two of ours: start, 1, 0, 1, and half of the next 0.
    assert_eq!(slow.1, 0b0110_0110);
    assert_ne!(fast.1, 0x35);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn within_the_tolerance_every_byte_is_read_right(data: u8, bit in 963u32..=1037) {
        prop_assert_eq!(comes_through(16, 0, bit, data), (0, data));
    }

    #[test]
    fn beyond_the_tolerance_no_byte_goes_unmarked(
        data: u8,
        bit in prop_oneof![300u32..=962, 1038u32..3000],
    ) {
        prop_assert_eq!(comes_through(16, 0, bit, data).0 & FE, FE);
    }

    #[test]
    fn whatever_is_sent_in_a_row_is_received_in_order(bytes in prop::collection::vec(any::<u8>(), 1..40)) {
        let mut rig = rig();
        let at = micros(&rig) + 10;
        send(&mut rig, at, 1000, &bytes);
        for byte in bytes {
            rig.wait(SR, RXNE);
            prop_assert_eq!(rig.read(DR), u32::from(byte));
        }
        prop_assert_eq!(rig.read(SR) & (ORE | FE | NF), 0);
    }
}

#[test]
fn what_comes_before_the_receiver_listens_is_lost() {
    let mut rig = rig();
    rig.modify(CR1, RE, 0);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1, 2, 3]);
    rig.micros(10 + 15);
    rig.modify(CR1, 0, RE);
    rig.wait(SR, RXNE);
    assert_eq!(rig.read(DR), 3, "the second had begun");
}

#[test]
fn without_pins_nothing_is_sent_or_received() {
    let mut rig = rig();
    rig.mode(GPIOC, 6, 0);
    rig.mode(GPIOC, 7, 0);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1]);
    rig.write(DR, 5);
    rig.micros(100);
    assert_eq!(rig.read(SR), TXE | TC);
    assert!(rig.board().sent.is_empty());
}

const TRANSMIT: Stream = Stream { controller: DMA2, number: 7 };
const RECEIVE: Stream = Stream { controller: DMA2, number: 1 };
const COMMON: u32 = 5 << 25 | cr::MINC | cr::TCIE | cr::TEIE | 3 << 16;

#[test]
fn dma_sends_as_embassy_has_it() {
    let mut rig = rig();
    let bytes: Vec<u8> = (0..32).collect();
    rig.put(RAM, &bytes);
    rig.modify(CR3, 0, DMAT);
    rig.write(SR, !TC);
    TRANSMIT.start(&mut rig, COMMON | cr::TO_PERIPHERAL, DR, RAM, 32);
    rig.wait_line(70);
    assert!(!TRANSMIT.is_enabled(&mut rig));
    TRANSMIT.clear(&mut rig, Stream::TCIF);
    rig.wait(SR, TC);
    let sent = rig.board().sent.clone();
    assert!(sent.iter().map(|(byte, ..)| *byte).eq(bytes));
    let gaps = sent.windows(2).map(|pair| pair[1].2 - pair[0].2);
    assert!(gaps.into_iter().all(|gap| gap == 10_000), "without a gap");
}

/// embassy's ring buffer: circular, both interrupts, and IDLE for what is less than half a buffer.
#[test]
fn dma_receives_into_a_ring_as_embassy_has_it() {
    let mut rig = rig();
    RECEIVE.start(&mut rig, COMMON | cr::CIRC | cr::HTIE, DR, RAM, 8);
    rig.modify(CR1, 0, IDLEIE);
    rig.modify(CR3, 0, EIE | DMAR);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[1, 2, 3]);
    rig.wait_line(INTERRUPT);
    assert_eq!(rig.read(SR) & (IDLE | RXNE), IDLE, "DMA has taken it");
    rig.read(DR);
    assert_eq!(RECEIVE.left(&mut rig), 5);
    assert_eq!(rig.bytes(RAM, 3), [1, 2, 3]);
    let at = micros(&rig) + 10;
    send(&mut rig, at, 1000, &[4, 5, 6, 7, 8, 9]);
    rig.wait_line(57);
    assert_eq!(RECEIVE.flags(&mut rig), Stream::HTIF);
    RECEIVE.clear(&mut rig, Stream::HTIF);
    rig.wait_line(57);
    assert_eq!(RECEIVE.flags(&mut rig), Stream::TCIF);
    RECEIVE.clear(&mut rig, Stream::TCIF);
    assert_eq!(RECEIVE.left(&mut rig), 8);
    rig.micros(50);
    assert_eq!(RECEIVE.left(&mut rig), 7);
    assert_eq!(rig.bytes(RAM, 8), [9, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(rig.read(SR) & ORE, 0);
}

#[test]
fn what_eight_bits_without_parity_never_need_is_refused_loudly() {
    let mut rig = Rig::new();
    rig.write(BRR, 16);
    for (bit, what) in [(0, "break"), (1, "mute"), (10, "parity"), (12, "nine")] {
        assert!(rig.refusal(CR1, UE | 1 << bit).contains(what));
    }
    for bit in [6, 8, 9, 10, 11, 14] {
        assert!(rig.refusal(CR2, 1 << bit).contains("USART_CR2"), "bit {bit}");
    }
    assert!(rig.refusal(CR2, 1 << 12).contains("half"));
    for bit in [1, 2, 3, 4, 5, 8, 9, 10] {
        assert!(rig.refusal(CR3, 1 << bit).contains("USART_CR3"), "bit {bit}");
    }
    rig.write(BRR, 15);
    assert!(rig.refusal(CR1, UE | TE).contains("BRR"));
    rig.write(BRR, 16);
    rig.write(CR1, UE | TE);
    assert!(rig.refusal(BRR, 17).contains("UE"));
}
