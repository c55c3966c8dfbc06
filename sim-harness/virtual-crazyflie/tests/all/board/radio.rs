//! The radio chip, from the flight processor's side and from the air's.

use std::fmt::Write as _;

use super::{Bench, MS, US, frame};
use units::{Dbm, Volts};
use virtual_crazyflie::board::nrf51::{Datarate, OffCause, Power, RAMP_UP, Tuning};
use virtual_crazyflie::board::{Fault, Led};
use virtual_crazyflie::soc::{Board, Level, Nanos, Pin, UartBus};

const READY: u8 = 0x0B;
const AUTOUPDATE: u8 = 0x14;
const WAIT: Pin = Pin::new('A', 4);

/// The frames that came, one a line: µs at which it began, type, data.
fn transcript(bench: &mut Bench) -> String {
    let mut text = String::new();
    for (at, kind, data) in bench.frames() {
        write!(text, "{} {kind:02x}:", at / US).unwrap();
        for byte in data {
            write!(text, " {byte:02x}").unwrap();
        }
        text.push('\n');
    }
    text
}

fn kinds(bench: &mut Bench) -> Vec<u8> {
    bench.frames().into_iter().map(|(_, kind, _)| kind).collect()
}

/// A chip whose radio is on, and that has nothing more to say.
fn ready() -> Bench {
    let mut bench = Bench::new();
    bench.send(READY, &[]);
    bench.wait(MS);
    bench.frames();
    bench
}

#[test]
fn this_is_how_a_flight_processor_and_the_chip_get_to_know_each_other() {
    let mut bench = Bench::new();
    bench.board.set_battery(Volts(3.75), true, true);
    bench.send(0x30, &[]);
    bench.send(0x01, &[60]);
    bench.send(0x02, &[1]);
    bench.send(0x05, &[1, 2, 3, 4, 5]);
    bench.send(READY, &[]);
    bench.send(AUTOUPDATE, &[]);
    bench.run_to(663 * MS);
    bench.board.hear(664_100 * US, 11, &[0xAA, 0xBB], Dbm(-61.4));
    bench.board.hear_alone(665_100 * US, 3, &[0xCC], Dbm(-55.0));
    bench.board.hear_crtp(665_700 * US, &[0xFF], Dbm(-40.0));
    bench.run_to(667 * MS);
    bench.send(0x07, &[0xF4]);
    bench.run_to(674 * MS);
    // Frames behind each other wait for the loop, and the first report for its time.
    let expected = "\
296 30: 32 30 32 35 2e 30 32 20 28 43 46 32 31 29 00
795 01: 3c
1065 02: 01
1367 05: 01 02 03 04 05
1619 0b:
653046 13: 07 f7 db 6f 40 00 00 00 3f
653234 04: 00
663055 13: 07 f7 db 6f 40 00 00 00 3f
663243 04: 00
664157 0a: 0b 3d aa bb
665165 08: 03 37 cc
665763 00: ff
667209 07: f4
673012 13: 07 f7 db 6f 40 00 00 00 3f
673200 04: 28
";
    assert_eq!(transcript(&mut bench), expected);
    let radio = bench.board.radio().model().unwrap();
    let address = [1, 2, 3, 4, 5];
    let tuning = Tuning { channel: 60, datarate: Datarate::M1, address, power: -12 };
    assert_eq!(radio.tuning(), tuning);
    assert_eq!((radio.counters().good, radio.counters().bad_first_sums), (7, 0));
}

#[test]
fn it_says_nothing_before_it_has_received_a_good_frame() {
    let mut bench = Bench::new();
    let mut bad = frame(READY, &[]);
    bad[4] ^= 1;
    bench.send_bytes(&bad);
    bench.run_to(4_000 * MS);
    bench.board.hear(4_000 * MS, 11, &[1], Dbm(-50.0));
    bench.board.press_button();
    bench.run_to(4_100 * MS);
    assert_eq!(transcript(&mut bench), "");
    assert_eq!(bench.board.radio().model().unwrap().counters().bad_first_sums, 1);
    bench.send(0x01, &[80]);
    bench.wait(MS);
    assert_eq!(kinds(&mut bench), [0x01]);
}

#[test]
fn a_byte_follows_another_after_12_7_microseconds() {
    let mut bench = ready();
    bench.board.hear(bench.now + 1_234, 1, &[7; 60], Dbm(-50.0));
    let landed = bench.now + 1_234;
    bench.wait(2 * MS);
    let moments: Vec<Nanos> = bench.heard.iter().map(|byte| byte.at).collect();
    let begin = moments[0];
    assert!((51 * US..108 * US).contains(&(begin - landed)), "{}", begin - landed);
    let expected: Vec<Nanos> = (0..68).map(|n| begin + n * 12_700).collect();
    assert_eq!(moments, expected);
    assert!(bench.heard.iter().all(|byte| byte.bit == 1_000 && !byte.noise && !byte.broken));
}

#[test]
fn it_is_deaf_until_it_is_told_that_its_radio_is_set() {
    let mut bench = Bench::new();
    bench.send(0x01, &[80]);
    bench.board.hear(5 * MS, 11, &[1], Dbm(-50.0));
    bench.board.hear_crtp(5 * MS, &[0xFF], Dbm(-50.0));
    bench.run_to(10 * MS);
    assert_eq!(kinds(&mut bench), [0x01]);
    assert_eq!(bench.board.radio().model().unwrap().counters().deaf, 2);
    assert!(bench.board.take_crtp().is_empty());
    bench.tell(READY, &[]);
    assert!(bench.board.radio().model().unwrap().listens());
    bench.board.hear(15 * MS, 11, &[1], Dbm(-50.0));
    bench.run_to(20 * MS);
    assert_eq!(kinds(&mut bench), [READY, 0x0A]);
}

#[test]
fn three_seconds_after_its_start_it_listens_whatever_it_was_told() {
    let mut bench = Bench::new();
    bench.send(0x30, &[]);
    // The flight processor starts 357.4 ms behind the chip, whose first round is at 120.8 ms.
    let opens = 3_120_800 * US - 357_400 * US;
    bench.run_to(opens - 1);
    assert!(!bench.board.radio().model().unwrap().listens());
    bench.run_to(opens);
    assert!(bench.board.radio().model().unwrap().listens());
}

#[test]
fn a_packet_is_on_its_way_when_the_chip_has_read_it() {
    let mut bench = ready();
    assert!(bench.board.radio().model().unwrap().is_in_bluetooth());
    bench.send(0x0A, &[11, 1, 2, 3]);
    let last = bench.now;
    assert!(bench.board.take_packets().is_empty());
    bench.wait(MS);
    let sent = bench.board.take_packets();
    assert_eq!(sent.len(), 1);
    assert!((last + 30 * US..last + 110 * US).contains(&sent[0].at), "{}", sent[0].at - last);
    assert_eq!((sent[0].port, &sent[0].data[..]), (11, &[1, 2, 3][..]));
    assert_eq!(sent[0].tuning, Tuning::DEFAULT);
    assert!(bench.board.take_packets().is_empty());
    assert!(!bench.board.radio().model().unwrap().is_in_bluetooth());
    assert_eq!(transcript(&mut bench), "", "a broadcast is not acknowledged");
}

/// The range of what is measured in sixteen phases of the loop's round.
fn over_phases(mut measure: impl FnMut(&mut Bench) -> Nanos) -> (Nanos, Nanos) {
    let all: Vec<Nanos> = (0..16)
        .map(|phase| {
            let mut bench = ready();
            bench.wait(phase * 3_800);
            measure(&mut bench)
        })
        .collect();
    (all.iter().min().unwrap() / US, all.iter().max().unwrap() / US)
}

/// The figures of the vendor's program on an emulated chip, in the same phases.
#[test]
fn a_packet_takes_the_time_that_the_vendors_program_takes() {
    for (length, least, most) in [(0, 179, 235), (60, 433, 489)] {
        let (from, to) = over_phases(|bench| {
            bench.send(0x0A, &[&[11][..], &vec![7; length]].concat());
            let last = bench.now;
            bench.wait(MS);
            bench.board.take_packets()[0].at + RAMP_UP - last
        });
        let all = (from, to);
        assert!(from.abs_diff(least) <= 20 && to.abs_diff(most) <= 20, "{length} B: {all:?} µs");
    }
    // From the end on the air to the last stop bit at the processor.
    for (length, on_air) in [(17, 112), (60, 285)] {
        let (from, to) = over_phases(|bench| {
            let begin = bench.now;
            bench.send(0x0A, &[&[11][..], &vec![7; length]].concat());
            bench.wait(MS);
            let off_air = bench.board.take_packets()[0].at + RAMP_UP + on_air * US;
            let mut other = ready();
            other.wait(off_air - other.now);
            other.board.hear(off_air, 11, &vec![7; length], Dbm(-50.0));
            other.wait(2 * MS);
            other.heard.last().unwrap().at + 10 * US - begin
        });
        let (least, most) = if length == 17 { (1_008, 1_064) } else { (2_323, 2_381) };
        // The phases of the two loops are the same in one measurement, and not in the other.
        assert!(from + 57 >= least && to <= most + 57, "{length} B: {from} to {to} µs");
    }
}

#[test]
fn while_it_sends_to_the_processor_it_sends_nothing_to_the_air() {
    let mut bench = ready();
    let begin = bench.now + 5 * US;
    bench.board.hear(begin, 1, &[7; 60], Dbm(-50.0));
    bench.send(0x0A, &[11, 9]);
    assert!(bench.board.take_packets().is_empty());
    bench.wait(2 * MS);
    let sent = bench.board.take_packets();
    let passed_on = bench.heard.last().unwrap().at + 10 * US;
    // Then the loop reads the frame's eight bytes.
    assert!((60 * US..100 * US).contains(&(sent[0].at - passed_on)), "{}", sent[0].at - passed_on);
}

/// What the project's own drones never send: the queue takes two whole frames, but not four, and the
/// "wait" pin does not tell.
#[test]
fn of_long_frames_back_to_back_bytes_are_lost() {
    for (frames, least, most) in [(2, 0, 0), (4, 4, 25), (8, 100, 190)] {
        let mut bench = ready();
        for _ in 0..frames {
            bench.send(0x0A, &[&[11][..], &[1; 60]].concat());
            assert_eq!(bench.board.level(WAIT), Level::Low);
        }
        bench.wait(10 * MS);
        let lost = bench.board.radio().model().unwrap().counters().dropped_bytes;
        assert!((least..=most).contains(&lost), "{frames} frames: {lost}");
    }
}

/// Packets for the flight processor to send: what cuts what off, as the chip has one buffer. By
/// `airlink`'s spacing none is; at the one that it had before, a short one cut off a long one.
#[test]
fn a_short_packet_close_behind_a_long_one_cuts_it_off() {
    let cuts = |apart: Nanos, first: usize, second: usize| {
        let (_, overlaps) = over_phases(|bench| {
            let begin = bench.now;
            bench.send(0x0A, &[&[11][..], &vec![1; first]].concat());
            bench.run_to(begin + apart);
            bench.send(0x0A, &[&[11][..], &vec![2; second]].concat());
            bench.wait(3 * MS);
            let sent = bench.board.take_packets();
            let off_air = sent[0].at + RAMP_UP + (89 + 8 * first as u64) * 500;
            off_air.saturating_sub(sent[1].at)
        });
        overlaps > 0
    };
    assert!(cuts(855 * US, 60, 19) && cuts(855 * US, 54, 19));
    assert!(!cuts(855 * US, 60, 40) && !cuts(855 * US, 45, 19));
    for (first, second) in [(60, 17), (60, 19), (54, 19), (60, 60)] {
        assert!(!cuts(1_362 * US, first, second), "{first} B, then {second} B");
    }
}

/// Where the end of a packet falls into a window of 1.25 µs, the chip sends a packet that it received.
#[test]
fn a_ghost_is_the_packet_that_came_seven_before_the_last() {
    let mut bench = ready();
    for n in 0..9 {
        bench.board.hear(bench.now + US, 11, &[n, 0xAA], Dbm(-50.0));
        bench.wait(2 * MS);
    }
    bench.board.inject(Fault::RadioGhost, bench.now, bench.now + 5 * MS);
    bench.tell(0x0A, &[11, 42]);
    let sent = bench.board.take_packets();
    assert_eq!((sent[0].port, &sent[0].data[..]), (11, &[1, 0xAA][..]));
    bench.wait(10 * MS);
    bench.tell(0x0A, &[11, 42]);
    assert_eq!(bench.board.take_packets()[0].data, [42]);
}

#[test]
fn a_packet_that_is_sent_opens_the_receiver() {
    let mut bench = Bench::new();
    assert!(!bench.board.radio().model().unwrap().listens());
    bench.tell(0x0A, &[11, 1]);
    assert!(bench.board.radio().model().unwrap().listens());
}

#[test]
fn behind_an_acknowledgement_a_broadcast_is_not_heard() {
    let mut bench = ready();
    bench.board.hear_alone(bench.now + MS, 3, &[0xCC], Dbm(-55.0));
    bench.board.hear(bench.now + MS + 300 * US, 11, &[1], Dbm(-50.0));
    bench.board.hear(bench.now + MS + 500 * US, 11, &[2], Dbm(-50.0));
    bench.wait(4 * MS);
    assert_eq!(kinds(&mut bench), [0x08, 0x0A]);
    assert_eq!(bench.board.radio().model().unwrap().counters().deaf, 1);
    assert!(bench.board.take_crtp()[0].data.is_empty(), "it is acknowledged with nothing");
}

#[test]
fn packets_longer_than_the_air_allows_are_not_sent() {
    let mut bench = ready();
    bench.tell(0x0A, &[&[11][..], &[1; 60]].concat());
    bench.tell(0x0A, &[&[11][..], &[1; 61]].concat());
    bench.tell(0x0A, &[]);
    assert_eq!(bench.board.take_packets().len(), 1);
    let counters = bench.board.radio().model().unwrap().counters();
    assert_eq!((counters.not_understood, counters.last_not_understood), (2, Some(0x0A)));
}

#[test]
fn each_packet_from_the_ground_is_answered_once() {
    let mut bench = ready();
    bench.board.hear_crtp(bench.now, &[0xFF], Dbm(-50.0));
    bench.tell(0x00, &[0xF3, 1]);
    bench.tell(0x00, &[0xF3, 2]);
    let _ = bench.board.take_crtp();
    for n in 0..3 {
        bench.board.hear_crtp(bench.now + n * MS, &[0x30, 5], Dbm(-50.0));
    }
    let begin = bench.now;
    bench.wait(5 * MS);
    let answers = bench.board.take_crtp();
    let moments: Vec<Nanos> = answers.iter().map(|answer| answer.at - begin).collect();
    assert_eq!(moments, [0, MS, 2 * MS]);
    assert_eq!(answers[0].data, [0xF3, 1]);
    assert_eq!(answers[1].data, [0xF3, 2]);
    assert_eq!(answers[2].data.len(), 1, "nothing is left but the acknowledgement");
    assert_eq!(kinds(&mut bench), [0x00; 4]);
}

#[test]
fn what_waits_for_the_processor_is_seven_packets_at_most() {
    let mut bench = ready();
    for _ in 0..20 {
        bench.board.hear(bench.now + US, 1, &[1; 60], Dbm(-50.0));
    }
    bench.wait(20 * MS);
    assert_eq!(kinds(&mut bench).len(), 7);
    assert_eq!(bench.board.radio().model().unwrap().counters().overruns, 13);
}

#[test]
fn what_is_no_frame_is_counted_and_costs_no_other() {
    let mut bench = ready();
    let mut line = vec![0x00, 0xCF, 0xBC];
    let mut second = frame(0x30, &[]);
    second[5] ^= 1;
    line.extend(&second);
    line.extend([0xBC, 0xCF, 0x30, 65]);
    bench.send_bytes(&line);
    bench.send(0x01, &[80]);
    for byte in frame(0x01, &[80]) {
        bench.wait(87 * US);
        bench.board.uart_take(UartBus::Usart6, byte, 8_681);
    }
    bench.wait(MS);
    assert_eq!(kinds(&mut bench), [0x01]);
    let counters = bench.board.radio().model().unwrap().counters();
    assert_eq!((counters.too_long, counters.broken_bytes), (1, 7));
}

#[test]
fn battery_and_signal_come_a_hundred_times_a_second_from_653_ms_on() {
    let mut bench = ready();
    bench.send(AUTOUPDATE, &[]);
    bench.run_to(700 * MS + 5 * MS);
    let first = bench.frames()[0].0;
    // 1,010.4 ms after the chip's start, and the round in which it finds that out.
    assert!((653 * MS..653_060 * US).contains(&first), "{first}");
    bench.board.set_battery(Volts(3.1), false, false);
    bench.wait(12 * MS);
    bench.frames();
    bench.wait(1_000 * MS);
    let frames = bench.frames();
    let batteries: Vec<_> = frames.iter().filter(|(_, kind, _)| *kind == 0x13).collect();
    assert_eq!((batteries.len(), frames.len()), (100, 200));
    let late = |pair: &[&(Nanos, u8, Vec<u8>)]| (pair[1].0 - pair[0].0).abs_diff(10 * MS);
    assert!(batteries.windows(2).all(|pair| late(pair) < 60 * US));
    let volts = f32::from_le_bytes(batteries[0].2[1..5].try_into().unwrap());
    assert!((3.094..=3.1).contains(&volts), "{volts}");
    // Both reports together keep the loop for as long as the link reckons with.
    let [battery, signal] = [&frames[0], &frames[1]];
    assert_eq!((battery.1, signal.1), (0x13, 0x04));
    assert!((180 * US..190 * US).contains(&(signal.0 - battery.0)));
}

#[test]
fn power_goes_when_the_processor_lets_it_and_else_after_a_second() {
    let mut bench = ready();
    bench.board.press_button();
    bench.wait(MS);
    assert_eq!(kinds(&mut bench), [0x15]);
    bench.board.press_button();
    bench.wait(100 * MS);
    assert!(kinds(&mut bench).is_empty(), "it asks once");
    assert_eq!(bench.board.power(), Power::On);
    bench.tell(0x16, &[]);
    assert!(matches!(bench.board.power(), Power::Off { cause: OffCause::Agreed, .. }));

    let mut bench = ready();
    let pressed = bench.now;
    bench.board.press_button();
    bench.wait(1_000 * MS);
    assert_eq!(bench.board.power(), Power::On);
    bench.wait(2 * MS);
    let Power::Off { since, cause: OffCause::Unanswered } = bench.board.power() else {
        panic!("it is on")
    };
    assert!((1_000 * MS..=1_001 * MS + 60 * US).contains(&(since - pressed)));
    // Nothing moves any more.
    bench.frames();
    bench.send(0x30, &[]);
    bench.board.hear(bench.now + MS, 1, &[1], Dbm(-40.0));
    bench.wait(10 * MS);
    assert_eq!(transcript(&mut bench), "");
}

#[test]
fn an_answer_to_a_question_that_was_not_asked_switches_nothing_off() {
    let mut bench = ready();
    bench.send(0x16, &[]);
    bench.wait(10 * MS);
    assert_eq!(bench.board.power(), Power::On);
    bench.tell(0x11, &[]);
    assert!(matches!(bench.board.power(), Power::Off { cause: OffCause::Agreed, .. }));
    assert!(!bench.board.radio().model().unwrap().listens());
}

#[test]
fn a_chip_that_switches_the_processor_off_alone_goes_on_acknowledging() {
    let mut bench = ready();
    bench.tell(0x1A, &[]);
    assert!(matches!(bench.board.power(), Power::Off { cause: OffCause::Agreed, .. }));
    assert!(bench.board.radio().model().unwrap().listens());
    for n in 1..20 {
        bench.board.hear_crtp(bench.now + n * MS, &[0xFF], Dbm(-40.0));
    }
    bench.wait(30 * MS);
    assert_eq!(bench.board.take_crtp().len(), 19);
    assert_eq!(transcript(&mut bench), "");
}

#[test]
fn its_led_is_the_processors() {
    let mut bench = ready();
    bench.tell(0x18, &[]);
    assert!(!bench.board.is_lit(Led::Radio));
    bench.tell(0x17, &[]);
    assert!(bench.board.is_lit(Led::Radio));
    assert_eq!(bench.board.take_blinks().len(), 2);
}

#[test]
fn a_full_program_drops_what_comes_and_its_wait_pin_does_not_tell() {
    let mut bench = ready();
    for _ in 0..7 {
        bench.board.hear(bench.now, 1, &[1; 60], Dbm(-50.0));
    }
    // One small frame is taken for each large one that is passed on.
    let small = frame(0x17, &[]).repeat(30);
    bench.send_bytes(&small);
    assert_eq!(bench.board.level(WAIT), Level::Low);
    let dropped = bench.board.radio().model().unwrap().counters().dropped_bytes;
    assert!(dropped > 0);
    bench.wait(100 * MS);
    let counters = bench.board.radio().model().unwrap().counters();
    assert_eq!(counters.dropped_bytes, dropped);
    assert!((20..30).contains(&counters.good), "{counters:?}");
}

#[test]
fn a_busy_chip_says_wait_in_the_middle_of_a_frame_and_takes_four_bytes_more() {
    let mut bench = ready();
    let good = bench.board.radio().model().unwrap().counters().good;
    let fault = Fault::RadioBusy { every: MS, busy: 300 * US };
    bench.board.inject(fault, bench.now, bench.now + 3 * MS);
    let bytes = frame(0x01, &[80]);
    bench.send_bytes(&bytes[..1]);
    assert_eq!(bench.board.level(WAIT), Level::Low);
    bench.send_bytes(&bytes[1..2]);
    assert_eq!(bench.board.level(WAIT), Level::High);
    bench.send_bytes(&bytes[2..6]);
    assert_eq!(bench.board.radio().model().unwrap().counters().dropped_bytes, 0);
    // The pin falls by itself, and at a moment that was announced.
    let begin = bench.now;
    while bench.board.level(WAIT) == Level::High {
        let due = bench.board.due();
        bench.run_to(due);
    }
    assert_eq!(bench.now - begin, 240 * US);
    bench.send_bytes(&bytes[6..]);
    bench.wait(MS);
    let counters = bench.board.radio().model().unwrap().counters();
    assert_eq!((counters.good - good, counters.dropped_bytes), (1, 0));
    assert_eq!(kinds(&mut bench), [0x01]);
}

#[test]
fn bytes_that_come_though_a_busy_chip_says_wait_are_lost() {
    let mut bench = ready();
    let fault = Fault::RadioBusy { every: MS, busy: 300 * US };
    bench.board.inject(fault, bench.now, bench.now + MS);
    bench.send(0x01, &[80]);
    bench.wait(2 * MS);
    let counters = bench.board.radio().model().unwrap().counters();
    assert_eq!((counters.good, counters.dropped_bytes), (1, 1), "one of seven, beyond six");
    assert!(kinds(&mut bench).is_empty());
}

#[test]
fn a_radio_that_is_set_from_the_air_does_not_tell() {
    let mut bench = ready();
    bench.board.inject(Fault::RadioRetuned(33), bench.now, bench.now);
    bench.wait(MS);
    assert_eq!(bench.board.radio().model().unwrap().tuning().channel, 33);
    assert_eq!(transcript(&mut bench), "");
}

#[test]
fn orders_from_the_air_are_obeyed() {
    let mut bench = ready();
    let orders: [&[u8]; 4] = [
        &[0xFF, 0x03, 0x01, 33],
        &[0xFF, 0xFE, 0x06],
        &[0xFF, 0xFE, 0xF0, 0x01],
        &[0xFF, 0xFE, 0xFF],
    ];
    for order in orders {
        bench.board.hear_crtp(bench.now, order, Dbm(-50.0));
        bench.wait(MS);
    }
    assert_eq!(bench.board.radio().model().unwrap().tuning().channel, 33);
    assert!(!bench.board.is_lit(Led::Radio));
    assert_eq!(bench.board.radio().model().unwrap().counters().commands, 1);
    assert_eq!(transcript(&mut bench), "", "they are not the processor's");
    let _ = bench.board.take_crtp();
    bench.board.hear_crtp(bench.now, &[0xFF], Dbm(-50.0));
    assert_eq!(bench.board.take_crtp()[0].data.len(), 9, "the loader's answer");
    bench.wait(MS);
    bench.board.hear_crtp(bench.now, &[0xFF, 0xFE, 0x01], Dbm(-50.0));
    bench.wait(MS);
    assert!(matches!(bench.board.power(), Power::Off { cause: OffCause::Ordered, .. }));
}

/// A board's test reads whether address, channel and data rate were set, in this order.
#[test]
fn a_probe_tells_the_address_before_the_channel() {
    let mut bench = ready();
    bench.tell(0x01, &[60]);
    bench.frames();
    bench.tell(0xF0, &[]);
    assert_eq!(bench.frames()[0].2[..3], [0, 1, 0]);
}

#[test]
fn in_bluetooth_mode_it_stands_the_vendors_settings_twice_and_faults_at_any_other() {
    let vendors: [(u8, &[u8]); 3] = [(0x01, &[80]), (0x02, &[2]), (0x05, &[0xE7; 5])];
    let others: [(u8, &[u8]); 2] = [(0x03, &[0]), (0x07, &[4])];
    for (kind, data) in vendors.into_iter().chain(others) {
        let mut bench = ready();
        for _ in 0..2 {
            vendors.iter().for_each(|(kind, data)| bench.tell(*kind, data));
        }
        bench.wait(MS);
        assert_eq!(bench.board.power(), Power::On);
        bench.tell(kind, data);
        let power = bench.board.power();
        let is_off = matches!(power, Power::Off { cause: OffCause::Bluetooth, .. });
        assert!(is_off, "{kind:#04x}: {power:?}");

        let mut bench = ready();
        bench.tell(0x0A, &[11, 1]);
        (0..9).for_each(|_| bench.tell(kind, data));
        assert_eq!(bench.board.power(), Power::On, "{kind:#04x}: the radio is the chip's own");
    }
}
