//! Log blocks: nothing is missing, and what cannot be is refused as the vendor's firmware does.

use crate::common::{Line, port};
use units::{Duration, Radians};

/// Ten variables as ten `float`s, which is as much as two blocks hold.
const VARIABLES: [&str; 10] = [
    "stabilizer.roll",
    "stabilizer.pitch",
    "stabilizer.yaw",
    "gyro.x",
    "acc.z",
    "stateEstimate.x",
    "stateEstimate.z",
    "pm.vbat",
    "range.front",
    "uchain.frontRssi",
];

const FLOAT: u8 = 0x77;

/// A line with those variables in blocks 1 and 2, which have been started.
fn logging(period: [u8; 2]) -> Line {
    let mut line = Line::new();
    let ids = VARIABLES.map(|name| line.id_of(port::LOG_TABLE, name));
    for (block, ids) in (1..).zip(ids.chunks(5)) {
        let entries: Vec<u8> = ids.iter().flat_map(|[a, b]| [FLOAT, *a, *b]).collect();
        assert_eq!(line.control(&[&[6, block], &entries[..]].concat()), 0);
    }
    for block in 1..=2 {
        assert_eq!(line.control(&[8, block, period[0], period[1]]), 0);
    }
    line
}

fn stamp(data: &[u8]) -> u32 {
    u32::from_le_bytes([data[1], data[2], data[3], 0])
}

#[test]
fn ten_variables_come_a_hundred_times_a_second_for_half_a_minute_without_a_gap() {
    let mut line = logging([10, 0]);
    // The stamps go round while this runs.
    line.pass(Duration::from_millis((1 << 24) - 16_000));
    for block in 1..=2 {
        line.send(port::LOG_CONTROL, &[8, block, 10, 0]);
    }
    line.all();
    let begin = line.now;
    let mut stamps = [const { Vec::new() }; 2];
    while line.now.since(begin) < Duration::from_secs(30) {
        line.pass(line.server.due().unwrap().since(line.now));
        line.snapshot.position.x = line.now.since(begin).as_secs_f32();
        line.snapshot.attitude.roll = Radians(0.5);
        for (header, data) in line.all() {
            assert_eq!((header, data.len()), (port::LOG_DATA, 4 + 20));
            stamps[usize::from(data[0]) - 1].push(stamp(&data));
            let first = f32::from_le_bytes(data[4..8].try_into().unwrap());
            let right = [28.647_89, line.snapshot.position.x][usize::from(data[0]) - 1];
            assert!((first - right).abs() < 1e-4);
        }
    }
    for stamps in stamps {
        assert_eq!(stamps.len(), 3_000);
        assert!(stamps.windows(2).all(|w| (w[1].wrapping_sub(w[0])) & 0xFF_FFFF == 10));
    }
    assert_eq!(line.server.counters().missed, 0);
}

#[test]
fn a_late_line_keeps_to_the_beat_and_counts_what_it_missed() {
    let mut line = logging([10, 0]);
    line.control(&[4, 2]);
    let begin = line.now;
    line.pass(Duration::from_millis(13));
    assert_eq!(line.all().len(), 1);
    assert_eq!(line.server.due(), Some(begin + Duration::from_millis(20)));
    // 20, 30 and 40 are past; one packet says it all.
    line.pass(Duration::from_millis(32));
    assert_eq!(line.all().len(), 1);
    assert_eq!(line.server.counters().missed, 2);
    assert_eq!(line.server.due(), Some(begin + Duration::from_millis(50)));
}

/// A line that may send one packet in 10 ms, and two blocks that want to be sent in each.
#[test]
fn no_block_starves_another() {
    let mut line = logging([10, 0]);
    let mut sent = [0; 2];
    for _ in 0..1_000 {
        line.pass(Duration::from_millis(10));
        let (_, data) = line.next().unwrap();
        sent[usize::from(data[0]) - 1] += 1;
    }
    assert_eq!(sent, [500, 500]);
}

#[test]
fn a_block_is_stopped_started_and_deleted() {
    let mut line = logging([100, 0]);
    assert_eq!(line.control(&[4, 1]), 0);
    assert_eq!(line.control(&[2, 2]), 0);
    assert_eq!(line.server.due(), None);
    // The old request, which cflib sends: in steps of 10 ms.
    assert_eq!(line.control(&[3, 1, 5]), 0);
    assert_eq!(line.server.due(), Some(line.now + Duration::from_millis(50)));
    assert_eq!(line.control(&[3, 2, 5]), 2, "ENOENT: it was deleted");
    // Its variables have made room.
    let [a, b] = line.id_of(port::LOG_TABLE, "sys.canfly");
    for block in 10..15 {
        assert_eq!(line.control(&[&[6, block], &[1, a, b].repeat(9)[..]].concat()), 0);
        assert_eq!(line.control(&[&[7, block], &[1, a, b].repeat(9)[..]].concat()), 0);
        assert_eq!(line.control(&[&[7, block], &[1, a, b].repeat(6)[..]].concat()), 0);
    }
    assert_eq!(line.control(&[5]), 0);
    assert_eq!(line.server.due(), None);
    assert_eq!(line.control(&[4, 1]), 2, "ENOENT: all were deleted");
}

/// The numbers of C's `errno.h` that the vendor's firmware gives (`log.c`).
#[test]
fn bad_requests_get_the_errors_of_the_vendor() {
    const ENOENT: u8 = 2;
    const E2BIG: u8 = 7;
    const ENOEXEC: u8 = 8;
    const ENOMEM: u8 = 12;
    const EEXIST: u8 = 17;
    let mut line = Line::new();
    let [a, b] = line.id_of(port::LOG_TABLE, "pm.vbat");
    let [c, d] = line.id_of(port::LOG_TABLE, "sys.canfly");
    // Blocks that are not there.
    for request in [&[2, 9][..], &[3, 9, 1], &[4, 9], &[7, 9, FLOAT, a, b], &[8, 9, 1, 0]] {
        assert_eq!(line.control(request), ENOENT);
    }
    // Commands that are not there, and the ones of protocols long gone.
    for command in [0, 1, 9, 255] {
        assert_eq!(line.control(&[command, 1]), ENOEXEC);
    }
    // Requests that stop short.
    for request in [&[2][..], &[3], &[3, 1], &[4], &[6], &[7], &[8], &[8, 1], &[8, 1, 5]] {
        assert_eq!(line.control(request), ENOEXEC);
    }
    // Variables and types that are not there, and raw memory.
    assert_eq!(line.control(&[6, 1, FLOAT, 0xFE, 0xFF]), ENOENT);
    assert_eq!(line.control(&[6, 1, FLOAT, a, b]), EEXIST, "a block stays, without the variable");
    assert_eq!(line.control(&[7, 1, 0x70, a, b]), ENOENT);
    assert_eq!(line.control(&[7, 1, 0x79, a, b]), ENOENT);
    assert_eq!(line.control(&[7, 1, FLOAT, 0xFF, 0xFF, 0, 0, 0]), ENOENT);
    // Too much for a packet, at once and in two steps. Up to there it counts.
    assert_eq!(line.control(&[&[6, 2], &[FLOAT, a, b].repeat(7)[..]].concat()), E2BIG);
    assert_eq!(line.control(&[7, 2, FLOAT, a, b]), E2BIG);
    assert_eq!(line.control(&[7, 2, 0x11, c, d, 0x11, c, d]), 0);
    assert_eq!(line.control(&[7, 2, 0x11, c, d]), E2BIG);
    line.send(port::LOG_CONTROL, &[3, 2, 0]);
    assert_eq!(line.all()[1].1.len(), 30);
    // More blocks than there are places.
    for block in 3..=16 {
        assert_eq!(line.control(&[6, block, 0x11, c, d]), 0);
    }
    assert_eq!(line.control(&[6, 17, 0x11, c, d]), ENOMEM);
    // More variables than there are places: 128 in all, of which 8 and 14 are taken.
    let mut free = 128 - 8 - 14;
    for block in 3..=16 {
        for _ in 0..3 {
            let more = free.min(8);
            let entries = [0x11, c, d].repeat(more);
            assert_eq!(line.control(&[&[7, block], &entries[..]].concat()), 0);
            free -= more;
        }
    }
    assert_eq!(free, 0);
    assert_eq!(line.control(&[7, 16, 0x11, c, d]), ENOMEM);
    // Rows that are not there, and questions of protocols long gone.
    assert_eq!(line.ask(port::LOG_TABLE, &[2, 0xFE, 0xFF]), [2]);
    for data in [&[0, 0][..], &[1], &[2, 0], &[9]] {
        assert_eq!(line.send(port::LOG_TABLE, data), None);
        assert_eq!(line.all(), []);
    }
}
