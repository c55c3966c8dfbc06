//! What is logged, by a firmware and by a hand that writes into its ring.

use std::sync::Arc;

use crate::image_tiny::{machine, tiny};
use proptest::prelude::*;
use virtual_crazyflie::bus::Width;
use virtual_crazyflie::log::{Level, Log, LogLine, Messages, Probe};
use virtual_crazyflie::memory::Memory;
use virtual_crazyflie::soc::{Nanos, ResetCause};

/// "counted to 42", with its end.
const MESSAGE: [u8; 4] = [1, 42, 0x7A, 0];
const RING: u32 = 0x2000_0434;
const SIZE: u32 = 16;

/// A ring as a firmware writes it.
struct Writer {
    memory: Memory,
    block: u32,
    log: Log,
}

impl Writer {
    fn new(probe: Probe) -> Self {
        let image = tiny();
        let block = image.address_of("_SEGGER_RTT").unwrap();
        let log = Log::new(Arc::new(Messages::of(&image).unwrap()), probe);
        Self { memory: Memory::new(), block, log }
    }

    fn word(&self, offset: u32) -> u32 {
        self.memory.load(self.block + offset, Width::Word).unwrap()
    }

    fn set(&mut self, offset: u32, value: u32) {
        self.memory.store(self.block + offset, Width::Word, value);
    }

    /// As the start-up does.
    fn start(&mut self) {
        for (at, byte) in (self.block..).zip(*b"SEGGER RTT\0\0\0\0\0\0") {
            self.memory.store(at, Width::Byte, byte.into());
        }
        for (offset, value) in [(16, 1), (20, 0), (28, RING), (32, SIZE), (36, 0), (40, 0), (44, 0)]
        {
            self.set(offset, value);
        }
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let write = self.word(36);
            self.memory.store(RING + write, Width::Byte, (*byte).into());
            self.set(36, (write + 1) % SIZE);
        }
    }

    fn drain(&mut self, now: Nanos) -> Vec<LogLine> {
        self.log.drain(&mut self.memory, now);
        self.log.take()
    }
}

fn texts(lines: &[LogLine]) -> Vec<&str> {
    lines.iter().map(|line| line.text.as_str()).collect()
}

#[test]
fn a_firmware_s_message_has_a_text_a_level_and_a_time() {
    let mut machine = machine();
    let messages = Arc::new(Messages::of(machine.image()).unwrap());
    let mut log = Log::new(messages, Probe::Absent);
    log.drain(machine.memory_mut(), 0);
    assert!(log.lines().is_empty());
    machine.run_until(1_000_000).unwrap();
    log.drain(machine.memory_mut(), 1_000_000);
    let [line] = log.lines() else { panic!("{:?}", log.lines()) };
    assert_eq!(
        (line.text.as_str(), line.level, line.at),
        ("counted to 42", Level::Info, 1_000_000)
    );
    assert_eq!(line.to_string(), "     0.001000 INFO  counted to 42");
}

#[test]
fn after_a_reset_what_is_written_anew_is_read_anew() {
    let mut machine = machine();
    let messages = Arc::new(Messages::of(machine.image()).unwrap());
    let mut log = Log::new(messages, Probe::Absent);
    for round in 1..=3 {
        machine.run_until(round * 1_000_000).unwrap();
        log.drain(machine.memory_mut(), round);
        assert_eq!(texts(&log.take()), ["counted to 42"]);
        // What lies there is old until the start-up has written it anew.
        log.reset(machine.memory_mut(), round);
        machine.reset(ResetCause::Software);
        log.drain(machine.memory_mut(), round);
        assert!(log.take().is_empty());
    }
}

#[test]
fn an_eye_touches_nothing_and_a_probe_moves_on_and_makes_the_firmware_wait() {
    for (probe, read, flags) in [(Probe::Absent, 0, 0), (Probe::Attached, 4, 2)] {
        let mut writer = Writer::new(probe);
        writer.start();
        writer.write(&MESSAGE);
        assert_eq!(texts(&writer.drain(5)), ["counted to 42"]);
        assert_eq!((writer.word(40), writer.word(44)), (read, flags));
    }
}

#[test]
fn a_message_in_two_parts_is_one_message() {
    let mut writer = Writer::new(Probe::Attached);
    writer.start();
    writer.write(&MESSAGE[..2]);
    assert!(writer.drain(1).is_empty());
    writer.write(&MESSAGE[2..]);
    let lines = writer.drain(2);
    assert_eq!((texts(&lines), lines[0].at), (vec!["counted to 42"], 2));
}

#[test]
fn what_cannot_be_decoded_is_a_line_and_what_follows_is_read() {
    let mut writer = Writer::new(Probe::Attached);
    writer.start();
    writer.write(&[0x99, 0x7F, 3, 0]);
    writer.write(&MESSAGE);
    let lines = writer.drain(1);
    assert_eq!(texts(&lines), ["3 bytes that are no message", "counted to 42"]);
    assert_eq!(lines[0].level, Level::Garbled);
}

#[test]
fn a_reset_in_the_middle_of_a_message_is_told() {
    let mut writer = Writer::new(Probe::Attached);
    writer.start();
    writer.write(&MESSAGE);
    writer.write(&MESSAGE[..3]);
    writer.log.reset(&mut writer.memory, 9);
    assert_eq!(
        texts(&writer.log.take()),
        ["counted to 42", "3 bytes of a message that a reset cut off"]
    );
    writer.start();
    writer.write(&MESSAGE);
    assert_eq!(texts(&writer.drain(10)), ["counted to 42"]);
}

#[test]
fn a_control_block_of_nonsense_is_no_ring() {
    for (offset, value) in [(0, 0), (28, 0x4000_0000), (32, u32::MAX), (32, 0), (36, 99)] {
        let mut writer = Writer::new(Probe::Attached);
        writer.start();
        writer.write(&MESSAGE);
        writer.set(offset, value);
        assert_eq!(writer.drain(1), [], "{offset}: {value:#x}");
    }
}

proptest! {
    #[test]
    fn however_the_ring_is_filled_and_drained_all_messages_come_out_in_order(
        values in proptest::collection::vec(1_u8.., 1..60),
        parts in proptest::collection::vec(1_usize..15, 1..200),
    ) {
        let mut writer = Writer::new(Probe::Attached);
        writer.start();
        let bytes: Vec<u8> = values.iter().flat_map(|value| [1, *value, 0x7A, 0]).collect();
        let mut rest = bytes.as_slice();
        let mut seen = Vec::new();
        for part in parts.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (now, later) = rest.split_at((*part).min(rest.len()));
            writer.write(now);
            seen.extend(writer.drain(1));
            rest = later;
        }
        let expected: Vec<String> =
            values.iter().map(|value| format!("counted to {value}")).collect();
        prop_assert_eq!(texts(&seen), expected);
    }

    #[test]
    fn whatever_bytes_come_each_message_is_one_line(
        bytes in proptest::collection::vec(any::<u8>(), 0..500),
    ) {
        let mut writer = Writer::new(Probe::Attached);
        writer.start();
        let mut lines = Vec::new();
        for part in bytes.chunks(15) {
            writer.write(part);
            lines.extend(writer.drain(1));
        }
        let ended = bytes.iter().rposition(|byte| *byte == 0).map_or(0, |last| last + 1);
        let messages = bytes[..ended].split(|byte| *byte == 0).filter(|part| !part.is_empty());
        prop_assert_eq!(lines.len(), messages.count());
    }
}
