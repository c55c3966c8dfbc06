//! SPI, register by register: as the manual's procedures have it (RM0090, "Data transmission and
//! reception procedures"), as embassy's driver does it, and with what goes wrong.

use super::{DMA2, GPIOA, RAM, Rig, Stream, cr};
use virtual_crazyflie::bus::Width;

const CR1: u32 = 0x4001_3000;
const CR2: u32 = CR1 + 0x04;
const SR: u32 = CR1 + 0x08;
const DR: u32 = CR1 + 0x0C;

const MSTR: u32 = 1 << 2;
const SPE: u32 = 1 << 6;
const LSBFIRST: u32 = 1 << 7;
const SSI: u32 = 1 << 8;
const SSM: u32 = 1 << 9;
const DFF: u32 = 1 << 11;

const RXNE: u32 = 1;
const TXE: u32 = 1 << 1;
const MODF: u32 = 1 << 5;
const OVR: u32 = 1 << 6;
const BSY: u32 = 1 << 7;

const INTERRUPT: u32 = 35;

/// Master, clocked with a sixteenth of PCLK2: a bit takes 16 cycles.
const MASTER: u32 = MSTR | SSM | SSI | 3 << 3;
const BYTE: u64 = 8 * 16;

fn rig() -> Rig {
    let mut rig = Rig::new();
    rig.write(CR1, MASTER | SPE);
    rig
}

#[test]
fn a_byte_goes_each_way_in_eight_bits() {
    let mut rig = rig();
    assert_eq!(rig.read(SR), TXE);
    rig.board().answers.push_back(0x5A);
    rig.write(DR, 0xC3);
    assert_eq!(rig.read(SR), TXE | BSY, "the buffer is free again at once");
    // An access takes four cycles.
    rig.pass(BYTE - 4 - 4 - 1);
    assert_eq!(rig.read(SR), TXE | BSY, "one cycle is missing");
    assert_eq!(rig.read(SR), TXE | RXNE);
    assert_eq!(rig.read(DR), 0x5A);
    assert_eq!(rig.read(SR), TXE);
    assert_eq!(rig.board().spi, [0xC3]);
}

#[test]
fn the_baud_rate_is_a_power_of_two_of_the_bus() {
    for exponent in 0..8 {
        let mut rig = Rig::new();
        rig.write(CR1, MASTER & !(7 << 3) | exponent << 3 | SPE);
        rig.write(DR, 1);
        let began = rig.now;
        let end = loop {
            rig.pass(1);
            if !rig.board().spi.is_empty() {
                break rig.now;
            }
        };
        assert_eq!(end - began, 8 << (exponent + 1));
    }
}

/// The manual's procedure for full duplex: the next byte is stored while one is on its way.
#[test]
fn bytes_follow_each_other_without_a_gap() {
    let mut rig = rig();
    let began = rig.now;
    rig.write(DR, 0);
    for byte in 1..10 {
        rig.wait(SR, TXE);
        rig.write(DR, byte);
        rig.wait(SR, RXNE);
        assert_eq!(rig.read(DR), !(byte - 1) & 0xFF);
    }
    rig.wait(SR, RXNE);
    assert_eq!(rig.read(DR), !9 & 0xFF);
    let took = rig.now - began;
    assert!((10 * BYTE..10 * BYTE + 40).contains(&took), "{took}");
    assert_eq!(rig.read(SR), TXE);
}

#[test]
fn a_byte_that_was_not_read_stays_and_the_next_is_lost() {
    let mut rig = rig();
    rig.modify(CR2, 0, 1 << 5);
    rig.board().answers.extend([1, 2, 3]);
    rig.write(DR, 0);
    rig.wait(SR, RXNE);
    rig.write(DR, 0);
    rig.wait_line(INTERRUPT);
    assert_eq!(rig.read(SR), TXE | RXNE | OVR);
    assert_eq!(rig.read(SR) & OVR, OVR, "reading SR alone does not clear it");
    assert_eq!(rig.read(DR), 1);
    assert_eq!(rig.read(SR), TXE | OVR, "DR, then SR");
    assert_eq!(rig.read(SR), TXE);
    assert!(!rig.line(INTERRUPT));
    rig.write(DR, 0);
    rig.wait(SR, RXNE);
    assert_eq!(rig.read(DR), 3);
}

#[test]
fn a_master_whose_select_is_low_is_master_no_more() {
    let mut rig = rig();
    rig.modify(CR2, 0, 1 << 5);
    rig.modify(CR1, SSI, 0);
    assert_eq!(rig.read(CR1) & (MSTR | SPE), 0);
    assert!(rig.line(INTERRUPT));
    assert_eq!(rig.read(SR), TXE | MODF);
    assert_eq!(rig.read(SR), TXE | MODF);
    rig.write(CR1, MASTER);
    assert_eq!(rig.read(SR), TXE, "SR, then CR1");
    rig.write(CR1, MASTER | SPE);
    rig.write(DR, 7);
    rig.wait(SR, RXNE);
}

#[test]
fn sixteen_bits_are_two_bytes_the_upper_first() {
    let mut rig = Rig::new();
    rig.write(CR1, MASTER | DFF);
    rig.modify(CR1, 0, SPE);
    rig.board().answers.extend([0xAB, 0xCD]);
    rig.try_store(DR, Width::Half, 0x1234).expect("it is modelled");
    rig.wait(SR, RXNE);
    assert_eq!(rig.read(DR), 0xABCD);
    assert_eq!(rig.board().spi, [0x12, 0x34]);
}

#[test]
fn with_lsbfirst_the_board_sees_the_bits_turned_round() {
    let mut rig = Rig::new();
    rig.write(CR1, MASTER | LSBFIRST | SPE);
    rig.board().answers.push_back(0b0000_0001);
    rig.try_store(DR, Width::Byte, 0b0000_1011).expect("it is modelled");
    rig.wait(SR, RXNE);
    assert_eq!(rig.read(DR), 0b1000_0000);
    assert_eq!(rig.board().spi, [0b1101_0000]);
}

#[test]
fn a_byte_stored_before_spe_waits_for_it() {
    let mut rig = Rig::new();
    rig.write(CR1, MASTER);
    rig.write(DR, 5);
    assert_eq!(rig.read(SR), 0);
    rig.pass(10_000);
    assert!(rig.board().spi.is_empty());
    rig.modify(CR1, 0, SPE);
    rig.wait(SR, RXNE);
    assert_eq!(rig.board().spi, [5]);
}

#[test]
fn each_flag_has_its_interrupt() {
    let mut rig = rig();
    assert!(!rig.line(INTERRUPT));
    rig.write(CR2, 1 << 7);
    assert!(rig.line(INTERRUPT), "TXE");
    rig.write(CR2, 1 << 6);
    assert!(!rig.line(INTERRUPT));
    rig.write(DR, 1);
    rig.wait_line(INTERRUPT);
    rig.read(DR);
    assert!(!rig.line(INTERRUPT), "RXNE");
}

#[test]
fn a_line_without_a_pin_is_high() {
    let mut rig = rig();
    rig.board().answers.extend([1, 2]);
    rig.mode(GPIOA, 6, 0);
    rig.write(DR, 0x11);
    rig.wait(SR, RXNE);
    assert_eq!(rig.read(DR), 0xFF, "MISO");
    rig.mode(GPIOA, 7, 0);
    rig.write(DR, 0x22);
    rig.wait(SR, RXNE);
    rig.read(DR);
    rig.mode(GPIOA, 5, 0);
    rig.write(DR, 0x33);
    rig.wait(SR, RXNE);
    assert_eq!(rig.board().spi, [0x11, 0xFF], "MOSI, and without SCK nothing");
}

const RECEIVE: Stream = Stream { controller: DMA2, number: 0 };
const TRANSMIT: Stream = Stream { controller: DMA2, number: 5 };

/// embassy's `transfer_inner`.
#[test]
fn dma_exchanges_as_embassy_has_it() {
    let mut rig = rig();
    let sent: Vec<u8> = (0..50).map(|byte| byte * 5).collect();
    rig.put(RAM, &sent);
    for _ in 0..2 {
        rig.board().spi.clear();
        rig.modify(CR1, SPE, 0);
        while rig.read(SR) & RXNE != 0 {
            rig.read(DR);
        }
        let common = cr::channel(3) | cr::MINC | cr::TCIE | cr::TEIE | cr::priority(3);
        rig.modify(CR2, 0, 1);
        RECEIVE.start(&mut rig, common, DR, RAM + 0x100, 50);
        TRANSMIT.start(&mut rig, common | cr::TO_PERIPHERAL, DR, RAM, 50);
        rig.modify(CR2, 0, 2);
        rig.modify(CR1, 0, SPE);
        rig.wait_line(68);
        TRANSMIT.clear(&mut rig, Stream::TCIF);
        rig.wait_line(56);
        RECEIVE.clear(&mut rig, Stream::TCIF);
        while rig.read(SR) & BSY != 0 {}
        rig.modify(CR1, SPE, 0);
        rig.modify(CR2, 3, 0);
        assert_eq!(rig.board().spi, sent);
        let received: Vec<u8> = sent.iter().map(|byte| !byte).collect();
        assert_eq!(rig.bytes(RAM + 0x100, 50), received);
        assert_eq!(rig.read(SR), TXE, "no overrun");
    }
}

#[test]
fn what_a_full_duplex_master_never_needs_is_refused_loudly() {
    let mut rig = Rig::new();
    assert!(rig.refusal(CR1, SSM | SPE).contains("slave"));
    assert!(rig.refusal(CR1, MSTR | SPE).contains("NSS"));
    for bit in [10, 15] {
        assert!(rig.refusal(CR1, MASTER | 1 << bit).contains("one way"));
    }
    for bit in [12, 13] {
        assert!(rig.refusal(CR1, MASTER | 1 << bit).contains("CRC"));
    }
    assert!(rig.refusal(CR2, 1 << 4).contains("TI"));
    assert!(rig.refusal(CR1 + 0x1C, 1 << 11).contains("I2S"));
    rig.write(CR1 + 0x1C, 0);
}

#[test]
fn a_change_in_the_middle_of_a_byte_is_refused_loudly() {
    let mut rig = rig();
    rig.write(DR, 1);
    assert!(rig.refusal(CR1, MASTER).contains("middle"));
    assert!(rig.refusal(CR1, MASTER ^ 1 << 3 | SPE).contains("middle"));
    rig.write(CR1, MASTER | SPE);
}
