//! The DMA controllers, register by register (RM0090, "DMA controller (DMA)"): what is moved where,
//! in which order, and what stops it. Copies of memory show the data path; USART6, which has a byte
//! for DMA whenever one comes in, and takes one whenever it can, shows requests.

use super::{DMA1, DMA2, RAM, Rig, Stream, cr};
use proptest::prelude::*;
use virtual_crazyflie::bus::{Bus, Width};
use virtual_crazyflie::memory::map;
use virtual_crazyflie::soc::UartByte;

const USART: u32 = 0x4001_1400;
const UART_DR: u32 = USART + 4;

const COPY: Stream = Stream { controller: DMA2, number: 3 };
const TRANSMIT: Stream = Stream { controller: DMA2, number: 6 };
const RECEIVE: Stream = Stream { controller: DMA2, number: 2 };

const FROM: u32 = RAM + 0x1000;
const TO: u32 = RAM + 0x2000;

/// USART6 at 1 Mbaud with both its requests on.
fn rig() -> Rig {
    let mut rig = Rig::new();
    rig.write(USART + 0x08, 16);
    rig.write(USART + 0x14, 3 << 6);
    rig.write(USART + 0x0C, 1 << 13 | 3 << 2);
    rig
}

fn send(rig: &mut Rig, bytes: &[u8]) {
    let start = rig.now * 1000 / 16 + 10_000;
    for (index, data) in (0..).zip(bytes) {
        let at = start + index * 10_000;
        let byte = UartByte { at, bit: 1000, data: *data, noise: false, broken: false };
        rig.board().coming.push_back(byte);
    }
    let now = rig.now;
    rig.soc.touch(now);
}

fn sent(rig: &mut Rig) -> Vec<u8> {
    rig.board().sent.iter().map(|(byte, ..)| *byte).collect()
}

#[test]
fn registers_hold_what_was_written_and_flags_lie_where_the_manual_has_them() {
    let mut rig = rig();
    assert_eq!(rig.read(COPY.register(Stream::FCR)), 0x21);
    rig.write(COPY.register(Stream::PAR), 0x1234_5678);
    rig.write(COPY.register(Stream::M1AR), 0x8765_4321);
    rig.write(COPY.register(Stream::NDTR), 0x1_2345);
    assert_eq!(rig.read(COPY.register(Stream::PAR)), 0x1234_5678);
    assert_eq!(rig.read(COPY.register(Stream::M1AR)), 0x8765_4321);
    assert_eq!(COPY.left(&mut rig), 0x2345);
    let base = cr::COPY | cr::PINC | cr::MINC;
    for number in 0..8 {
        let stream = Stream { controller: DMA2, number };
        stream.start(&mut rig, base, FROM, TO, 2);
        rig.micros(10);
        let status = rig.read(DMA2 + number / 4 * 4);
        let bits = (Stream::TCIF | Stream::HTIF) << [0, 6, 16, 22][number as usize % 4];
        assert_eq!(status, bits, "stream {number}");
        stream.clear(&mut rig, 0x3D);
        assert_eq!(rig.read(DMA2 + number / 4 * 4), 0);
    }
}

#[test]
fn each_stream_has_its_interrupt() {
    let mut rig = rig();
    for (number, line) in (0..).zip([56, 57, 58, 59, 60, 68, 69, 70]) {
        let stream = Stream { controller: DMA2, number };
        stream.start(&mut rig, cr::COPY | cr::TCIE, FROM, TO, 4);
        rig.wait_line(line);
        assert_eq!(rig.soc.lines(), 1 << line);
        stream.clear(&mut rig, Stream::TCIF);
        assert_eq!(rig.soc.lines(), 0);
    }
    for (number, line) in (0..).zip([11, 12, 13, 14, 15, 16, 17, 47]) {
        let stream = Stream { controller: DMA1, number };
        // A copy is refused to DMA1, so a request is abandoned: TCIF.
        let channel = [1, 9, 3, 7, 3, 1, 1, 1][number as usize];
        if channel == 9 {
            continue;
        }
        stream.start(&mut rig, cr::channel(channel) | cr::TCIE, 0x4000_5410, TO, 4);
        rig.modify(stream.register(Stream::CR), 1, 0);
        assert_eq!(rig.soc.lines(), 1 << line);
        stream.clear(&mut rig, Stream::TCIF);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Widths, thresholds and bursts change how bytes are moved, never which.
    #[test]
    fn a_copy_is_a_copy(
        words in 1u32..40,
        psize in 0u32..3,
        msize in 0u32..3,
        threshold in 0u32..4,
        bytes in prop::collection::vec(any::<u8>(), 160),
    ) {
        let mut rig = rig();
        rig.put(FROM, &bytes);
        rig.put(TO, &[0xCC; 200]);
        rig.write(COPY.register(Stream::FCR), threshold);
        let items = (words * 4) >> psize;
        let cr = cr::COPY | cr::PINC | cr::MINC | psize << 11 | msize << 13;
        COPY.start(&mut rig, cr, FROM, TO, items);
        rig.micros(200);
        prop_assert!(!COPY.is_enabled(&mut rig));
        prop_assert_eq!(COPY.left(&mut rig), 0);
        let count = words as usize * 4;
        prop_assert_eq!(&rig.bytes(TO, words * 4)[..], &bytes[..count]);
        prop_assert_eq!(rig.bytes(TO + words * 4, 1), [0xCC]);
    }
}

#[test]
fn an_address_that_does_not_increment_stays() {
    let mut rig = rig();
    rig.put(FROM, &[1, 2, 3, 4]);
    COPY.start(&mut rig, cr::COPY | cr::MINC, FROM, TO, 4);
    rig.micros(20);
    assert_eq!(rig.bytes(TO, 4), [1, 1, 1, 1]);
    COPY.start(&mut rig, cr::COPY | cr::PINC, FROM, TO, 4);
    rig.micros(20);
    assert_eq!(rig.bytes(TO, 1), [4]);
    let spaced = cr::COPY | cr::PINC | 1 << 15 | cr::MINC;
    rig.put(FROM, &[1, 0, 0, 0, 2, 0, 0, 0, 3]);
    COPY.start(&mut rig, spaced, FROM, TO, 3);
    rig.micros(20);
    assert_eq!(rig.bytes(TO, 3), [1, 2, 3], "PINCOS: a word further each time");
}

#[test]
fn an_item_takes_ten_cycles() {
    let mut rig = rig();
    COPY.start(&mut rig, cr::COPY | cr::MINC | cr::TCIE, FROM, TO, 100);
    let began = rig.now;
    while !rig.line(59) {
        rig.pass(1);
    }
    assert_eq!(rig.now - began, 1000);
}

#[test]
fn bytes_are_packed_into_words_for_memory_when_the_fifo_reaches_its_threshold() {
    let mut rig = rig();
    rig.put(TO, &[0; 16]);
    rig.write(RECEIVE.register(Stream::FCR), 1 << 2 | 1);
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC | cr::MSIZE_32, UART_DR, TO, 12);
    send(&mut rig, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    rig.micros(10 + 75);
    assert_eq!(RECEIVE.left(&mut rig), 5);
    assert_eq!(rig.bytes(TO, 8), [0; 8], "seven bytes wait in the FIFO");
    assert_eq!(rig.read(RECEIVE.register(Stream::FCR)) >> 3 & 7, 1, "FS: less than a half");
    rig.micros(10);
    assert_eq!(rig.bytes(TO, 8), [1, 2, 3, 4, 5, 6, 7, 8]);
    rig.micros(40);
    assert_eq!(rig.bytes(TO, 12), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], "the end flushes");
    assert_eq!(RECEIVE.flags(&mut rig), Stream::HTIF | Stream::TCIF);
}

#[test]
fn words_from_memory_are_unpacked_for_the_peripheral() {
    let mut rig = rig();
    rig.put(FROM, b"abcdefgh");
    rig.write(TRANSMIT.register(Stream::FCR), 1 << 2 | 3);
    let cr = cr::channel(5) | cr::TO_PERIPHERAL | cr::MINC | cr::MSIZE_32;
    TRANSMIT.start(&mut rig, cr, UART_DR, FROM, 8);
    rig.micros(150);
    assert_eq!(sent(&mut rig), b"abcdefgh");
    assert_eq!(TRANSMIT.flags(&mut rig), Stream::HTIF | Stream::TCIF);
}

#[test]
fn in_direct_mode_the_size_of_memory_is_the_peripherals() {
    let mut rig = rig();
    let cr = cr::channel(5) | cr::MINC | cr::MSIZE_32;
    RECEIVE.start(&mut rig, cr, UART_DR, TO, 3);
    send(&mut rig, &[1, 2, 3]);
    rig.micros(60);
    assert_eq!(rig.bytes(TO, 3), [1, 2, 3]);
}

#[test]
fn half_and_whole_are_reported_and_a_stream_that_is_done_is_off() {
    let mut rig = rig();
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC, UART_DR, TO, 4);
    send(&mut rig, &[1, 2, 3, 4, 5]);
    rig.micros(10 + 15);
    assert_eq!((RECEIVE.left(&mut rig), RECEIVE.flags(&mut rig)), (3, 0));
    rig.micros(10);
    assert_eq!((RECEIVE.left(&mut rig), RECEIVE.flags(&mut rig)), (2, Stream::HTIF));
    rig.micros(10);
    assert_eq!((RECEIVE.left(&mut rig), RECEIVE.flags(&mut rig)), (1, Stream::HTIF));
    rig.micros(30);
    assert_eq!((RECEIVE.left(&mut rig), RECEIVE.flags(&mut rig)), (0, Stream::HTIF | Stream::TCIF));
    assert!(!RECEIVE.is_enabled(&mut rig));
    assert_eq!(rig.read(UART_DR), 5, "the fifth is not moved");
}

#[test]
fn a_ring_goes_on_until_circ_is_cleared() {
    let mut rig = rig();
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC | cr::CIRC, UART_DR, TO, 3);
    send(&mut rig, &[1, 2, 3, 4, 5, 6, 7, 8]);
    rig.micros(10 + 45);
    assert_eq!(RECEIVE.left(&mut rig), 2);
    assert_eq!(rig.bytes(TO, 3), [4, 2, 3]);
    rig.modify(RECEIVE.register(Stream::CR), cr::CIRC, 0);
    rig.micros(50);
    assert!(!RECEIVE.is_enabled(&mut rig));
    assert_eq!(rig.bytes(TO, 3), [4, 5, 6]);
}

#[test]
fn a_ring_to_a_peripheral_repeats() {
    let mut rig = rig();
    rig.put(FROM, &[1, 2, 3]);
    let cr = cr::channel(5) | cr::TO_PERIPHERAL | cr::MINC | cr::CIRC;
    TRANSMIT.start(&mut rig, cr, UART_DR, FROM, 3);
    rig.micros(10 + 75);
    assert_eq!(sent(&mut rig), [1, 2, 3, 1, 2, 3, 1]);
}

#[test]
fn a_stream_to_a_peripheral_fetches_as_soon_as_it_is_enabled() {
    for (mode, sees) in [(0, [1, 9, 9]), (1 << 2, [1, 2, 3])] {
        let mut rig = rig();
        rig.write(USART + 0x14, 0);
        rig.put(FROM, &[1, 2, 3]);
        rig.write(TRANSMIT.register(Stream::FCR), mode);
        let cr = cr::channel(5) | cr::TO_PERIPHERAL | cr::MINC;
        TRANSMIT.start(&mut rig, cr, UART_DR, FROM, 3);
        rig.put(FROM, &[9, 9, 9]);
        rig.write(USART + 0x14, 1 << 7);
        rig.micros(100);
        assert_eq!(sent(&mut rig), sees, "one item in direct mode, else a FIFO full");
    }
}

#[test]
fn two_buffers_take_turns() {
    let mut rig = rig();
    rig.write(RECEIVE.register(Stream::M1AR), TO + 0x100);
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC | cr::DBM, UART_DR, TO, 2);
    send(&mut rig, &[1, 2, 3, 4, 5, 6]);
    rig.micros(10 + 25);
    assert_eq!(rig.read(RECEIVE.register(Stream::CR)) & (cr::CT | cr::CIRC), cr::CT | cr::CIRC);
    rig.write(RECEIVE.register(Stream::M0AR), TO + 0x200);
    rig.micros(60);
    assert_eq!(rig.bytes(TO, 2), [1, 2]);
    assert_eq!(rig.bytes(TO + 0x100, 2), [3, 4]);
    assert_eq!(rig.bytes(TO + 0x200, 2), [5, 6]);
}

#[test]
fn the_buffer_in_use_must_not_be_moved() {
    let mut rig = rig();
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC | cr::DBM | cr::TEIE, UART_DR, TO, 2);
    rig.write(RECEIVE.register(Stream::M0AR), FROM);
    assert_eq!(RECEIVE.flags(&mut rig), Stream::TEIF);
    assert!(!RECEIVE.is_enabled(&mut rig));
    assert!(rig.line(58));
}

#[test]
fn what_is_configured_is_write_protected_while_enabled() {
    let mut rig = rig();
    let cr = cr::channel(5) | cr::MINC;
    RECEIVE.start(&mut rig, cr, UART_DR, TO, 5);
    send(&mut rig, &[7]);
    rig.micros(25);
    rig.write(RECEIVE.register(Stream::PAR), 1);
    rig.write(RECEIVE.register(Stream::M0AR), 1);
    rig.write(RECEIVE.register(Stream::NDTR), 1);
    rig.write(RECEIVE.register(Stream::FCR), 0x87);
    rig.write(RECEIVE.register(Stream::CR), 1 | cr::TCIE | cr::PSIZE_32 | cr::COPY);
    assert_eq!(rig.read(RECEIVE.register(Stream::PAR)), UART_DR);
    assert_eq!(rig.read(RECEIVE.register(Stream::M0AR)), TO);
    assert_eq!(RECEIVE.left(&mut rig), 4);
    assert_eq!(rig.read(RECEIVE.register(Stream::FCR)), 0xA1, "but for FEIE");
    assert_eq!(rig.read(RECEIVE.register(Stream::CR)), cr | 1 | cr::TCIE, "but for interrupts");
}

/// As the vendor's I²C driver leaves a stream after a read that no device has answered.
#[test]
fn an_enabled_stream_that_has_moved_nothing_takes_another_address_and_length() {
    let mut rig = rig();
    let cr = cr::channel(5) | cr::MINC;
    RECEIVE.start(&mut rig, cr, UART_DR, TO, 4);
    rig.write(RECEIVE.register(Stream::NDTR), 1);
    rig.write(RECEIVE.register(Stream::M0AR), TO + 8);
    assert_eq!(RECEIVE.left(&mut rig), 1);
    send(&mut rig, &[7]);
    rig.micros(25);
    assert_eq!(rig.bytes(TO + 8, 1), [7]);
    assert_eq!(RECEIVE.flags(&mut rig) & Stream::TCIF, Stream::TCIF);
    assert!(!RECEIVE.is_enabled(&mut rig));
}

#[test]
fn a_stream_that_is_stopped_tells_how_much_is_left_and_sets_tcif() {
    let mut rig = rig();
    rig.put(TO, &[0; 8]);
    rig.write(RECEIVE.register(Stream::FCR), 1 << 2 | 3);
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC | cr::MSIZE_16, UART_DR, TO, 8);
    send(&mut rig, &[1, 2, 3, 4, 5]);
    rig.micros(10 + 35);
    assert_eq!(rig.bytes(TO, 3), [0, 0, 0]);
    rig.modify(RECEIVE.register(Stream::CR), 1, 0);
    assert!(!RECEIVE.is_enabled(&mut rig));
    assert_eq!(RECEIVE.flags(&mut rig), Stream::TCIF);
    assert_eq!(RECEIVE.left(&mut rig), 5);
    assert_eq!(rig.bytes(TO, 4), [1, 2, 3, 0], "what was in the FIFO");
}

#[test]
fn a_stream_that_is_enabled_again_begins_anew_with_what_was_programmed() {
    let mut rig = rig();
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC, UART_DR, TO, 4);
    send(&mut rig, &[1, 2, 3]);
    rig.micros(10 + 25);
    rig.modify(RECEIVE.register(Stream::CR), 1, 0);
    assert_eq!(RECEIVE.left(&mut rig), 2);
    RECEIVE.clear(&mut rig, Stream::TCIF);
    rig.modify(RECEIVE.register(Stream::CR), 0, 1);
    assert_eq!(RECEIVE.left(&mut rig), 4);
    rig.micros(10);
    assert_eq!(rig.bytes(TO, 2), [3, 2]);
}

#[test]
fn the_higher_priority_goes_first_and_of_equals_the_lower_number() {
    let order = |priorities: [u32; 2]| {
        let mut rig = rig();
        let streams = [0, 1].map(|number| Stream { controller: DMA2, number });
        // Something that keeps the controller busy while both are enabled.
        let first = Stream { controller: DMA2, number: 4 };
        first.start(&mut rig, cr::COPY | cr::priority(3) | cr::MINC, FROM, TO, 40);
        for (stream, priority) in streams.into_iter().zip(priorities) {
            stream.start(&mut rig, cr::COPY | cr::priority(priority) | cr::MINC, FROM, TO, 40);
        }
        rig.pass(10 * 50);
        streams.map(|stream| stream.left(&mut rig))
    };
    assert_eq!(order([1, 1])[1], 40);
    assert_eq!(order([0, 1])[0], 40);
    assert!(order([0, 1])[1] < 40);
}

#[test]
fn where_no_memory_is_a_transfer_fails() {
    let uart = cr::channel(5) | cr::MINC | cr::TEIE;
    // Core-coupled memory is on no bus that DMA is on.
    for target in [map::CCM, 0x3000_0000, RAM + map::RAM_SIZE] {
        let mut rig = rig();
        RECEIVE.start(&mut rig, uart, UART_DR, target, 4);
        send(&mut rig, &[1, 2]);
        rig.wait_line(58);
        assert_eq!(RECEIVE.flags(&mut rig), Stream::TEIF, "{target:#x}");
        assert!(!RECEIVE.is_enabled(&mut rig));
        let mut rig = self::rig();
        TRANSMIT.start(&mut rig, uart | cr::TO_PERIPHERAL, UART_DR, target, 4);
        rig.wait_line(69);
        assert!(sent(&mut rig).is_empty());
    }
}

#[test]
fn the_last_byte_of_ram_can_be_reached() {
    let mut rig = rig();
    RECEIVE.start(&mut rig, cr::channel(5) | cr::MINC, UART_DR, RAM + map::RAM_SIZE - 1, 1);
    send(&mut rig, &[77]);
    rig.micros(40);
    assert_eq!(rig.bytes(RAM + map::RAM_SIZE - 1, 1), [77]);
}

#[test]
fn dma1_reaches_apb1_alone() {
    let mut rig = rig();
    let i2c = 0x4000_5C00;
    rig.write(i2c + 0x04, 16 | 1 << 11);
    rig.write(i2c + 0x1C, 80);
    rig.write(i2c, 1);
    rig.modify(i2c, 0, 1 << 8);
    rig.wait(i2c + 0x14, 1);
    rig.write(i2c + 0x10, 0x29 << 1);
    rig.wait(i2c + 0x14, 2);
    rig.read(i2c + 0x18);
    let stream = Stream { controller: DMA1, number: 4 };
    let cr = cr::channel(3) | cr::TO_PERIPHERAL | cr::MINC | cr::TEIE;
    stream.start(&mut rig, cr, UART_DR, FROM, 4);
    rig.wait_line(15);
    assert_eq!(stream.flags(&mut rig), Stream::TEIF);
    assert!(sent(&mut rig).is_empty());
}

#[test]
fn flash_is_read_and_not_written() {
    let mut rig = rig();
    assert!(rig.memory.program(map::FLASH + 0x8000, b"flash"));
    let cr = cr::channel(5) | cr::TO_PERIPHERAL | cr::MINC;
    TRANSMIT.start(&mut rig, cr, UART_DR, map::FLASH + 0x8000, 5);
    rig.micros(100);
    assert_eq!(sent(&mut rig), b"flash");
    COPY.start(&mut rig, cr::COPY | cr::MINC, FROM, map::FLASH + 0x8000, 4);
    rig.micros(10);
    assert!(rig.soc.trouble().is_some());
}

#[test]
fn a_burst_that_the_threshold_does_not_serve_is_a_fifo_error() {
    let mut rig = rig();
    rig.write(COPY.register(Stream::FCR), 0);
    // Four words at a quarter of the FIFO.
    COPY.start(&mut rig, cr::COPY | cr::MINC | cr::MSIZE_32 | 1 << 23, FROM, TO, 16);
    assert_eq!(COPY.flags(&mut rig), Stream::FEIF);
    assert!(!COPY.is_enabled(&mut rig));
    COPY.clear(&mut rig, Stream::FEIF);
    rig.write(COPY.register(Stream::FCR), 3);
    COPY.start(&mut rig, cr::COPY | cr::MINC | cr::MSIZE_32 | 1 << 23, FROM, TO, 16);
    rig.micros(20);
    assert_eq!(COPY.flags(&mut rig), Stream::HTIF | Stream::TCIF);
}

#[test]
fn what_is_not_modelled_is_refused_loudly() {
    let mut rig = rig();
    let refusal = |rig: &mut Rig, stream: Stream, cr: u32| {
        rig.write(stream.register(Stream::PAR), UART_DR);
        rig.write(stream.register(Stream::M0AR), TO);
        rig.write(stream.register(Stream::NDTR), 4);
        rig.refusal(stream.register(Stream::CR), cr | 1)
    };
    let dma1 = Stream { controller: DMA1, number: 0 };
    assert!(refusal(&mut rig, dma1, cr::channel(0)).contains("channel"), "SPI3");
    assert!(refusal(&mut rig, RECEIVE, cr::channel(4)).contains("channel"), "USART1");
    assert!(refusal(&mut rig, RECEIVE, cr::channel(5) | cr::PFCTRL).contains("flow"));
    assert!(refusal(&mut rig, RECEIVE, cr::channel(5) | 1 << 21).contains("burst"));
    assert!(refusal(&mut rig, RECEIVE, cr::channel(5) | 3 << 6).contains("direction"));
    assert!(refusal(&mut rig, RECEIVE, cr::channel(5) | 3 << 11).contains("size"));
    assert!(refusal(&mut rig, COPY, cr::COPY | cr::CIRC).contains("copy"));
    assert!(refusal(&mut rig, dma1, cr::COPY).contains("copy"));
    rig.write(RECEIVE.register(Stream::M0AR), TO + 1);
    let packs = cr::channel(5) | cr::PSIZE_16 | 1;
    assert!(rig.refusal(RECEIVE.register(Stream::CR), packs).contains("aligned"));
    rig.write(RECEIVE.register(Stream::M0AR), TO);
    rig.write(RECEIVE.register(Stream::NDTR), 3);
    rig.write(RECEIVE.register(Stream::FCR), 1 << 2);
    let odd = cr::channel(5) | cr::MSIZE_16 | 1;
    assert!(rig.refusal(RECEIVE.register(Stream::CR), odd).contains("whole number"));
    assert!(rig.try_load(DMA1 + 0xD0, Width::Word).is_err());
}

#[test]
fn a_stream_whose_last_transfer_was_not_acknowledged_is_refused_loudly() {
    let mut rig = rig();
    COPY.start(&mut rig, cr::COPY, FROM, TO, 1);
    rig.micros(10);
    assert!(rig.refusal(COPY.register(Stream::CR), cr::COPY | 1).contains("flags"));
}

#[test]
fn with_nothing_to_move_nothing_is_moved() {
    let mut rig = rig();
    COPY.start(&mut rig, cr::COPY, FROM, TO, 0);
    rig.micros(100);
    assert!(COPY.is_enabled(&mut rig));
    assert_eq!(COPY.flags(&mut rig), 0);
}
