//! Runs the radio chip's firmware and prints how long it takes for what it does.
//!
//! ```console
//! cargo run --release -p nrf51-chip --example figures -- FILE
//! ```
//!
//! FILE is crazyflie2-nrf-firmware, built with `BLE=0`, as an ELF file or as the image for 0x1B000. All
//! moments are those of an emulated chip: a Cortex-M0 without wait states.

mod rig;

use std::path::Path;

use nrf51_chip::{Cycles, MICROSECOND, PinLevel};
use wire::radio::Datarate;
use wire::radio::timing::flight_us;

use rig::{ALONE, BROADCAST, BYTE, MILLISECOND, Outcome, RATE, Rig, kind};

/// The phases of the main loop and of the millisecond at which each stimulus is repeated.
const PHASES: u64 = 16;
/// From one phase to the next: sixteen of them are a little more than a round.
const PHASE: Cycles = 61;

fn micros(cycles: Cycles) -> f64 {
    cycles as f64 / MICROSECOND as f64
}

/// The least and the largest of some durations, in µs.
fn range(all: &[Cycles]) -> String {
    let least = all.iter().min().copied().map_or(f64::NAN, micros);
    let most = all.iter().max().copied().map_or(f64::NAN, micros);
    format!("{least:.0}..{most:.0}")
}

/// The moments of the phases, from 510 ms on.
fn phases() -> impl Iterator<Item = Cycles> {
    (0..PHASES).map(|phase| 510 * MILLISECOND + phase * PHASE)
}

/// What the pins do until a moment.
fn boot(path: &Path) -> Outcome<()> {
    let mut rig = Rig::start(path)?;
    rig.run(500 * MILLISECOND)?;
    println!("Boot\n\n| ms | pin | level |\n|---|---|---|");
    // The one-wire pin has hundreds of changes.
    for change in rig.pins().iter().filter(|change| change.pin != 8) {
        let ms = micros(change.at) / 1000.0;
        println!("| {ms:.2} | P0.{} | {:?} |", change.pin, change.level);
    }
    assert_eq!(rig.chip.pin(21), PinLevel::Released, "the processor is still held in reset");
    Ok(())
}

/// From the first start bit of a broadcast at one chip to the last stop bit at another.
fn flights(path: &Path) -> Outcome<()> {
    println!("\nA broadcast from chip to chip at 2 Mbit/s, µs\n");
    println!(
        "| data, B | last stop bit to first bit on the air | all | by `flight_us` | off by, mean |"
    );
    println!("|---|---|---|---|---|");
    let (sender, receiver) = (Rig::ready(path)?, Rig::ready(path)?);
    for length in [0u8, 1, 4, 10, 17, 19, 30, 45, 54, 60] {
        let (mut waits, mut flights) = (Vec::new(), Vec::new());
        for at in phases() {
            let (mut from, mut to) = (sender.clone(), receiver.clone());
            let mut data = vec![1];
            data.extend((0..length).map(|byte| byte.wrapping_mul(37)));
            let end = from.say(at, kind::P2P_BROADCAST, &data);
            from.run(at + 5 * MILLISECOND)?;
            let sent = from.transmissions();
            let [packet] = &sent[..] else { return Err(format!("{sent:?}").into()) };
            waits.push(packet.start - end);
            to.hear(packet.start, packet.packet.address, &packet.packet.payload);
            to.run(at + 10 * MILLISECOND)?;
            let frames = to.frames();
            let [frame] = &frames[..] else { return Err(format!("{frames:?}").into()) };
            assert_eq!(frame.data[2..], data[1..]);
            flights.push(frame.end() - at);
        }
        let model = flight_us(Datarate::Mbit2, length.into());
        let mean = flights.iter().map(|it| micros(*it)).sum::<f64>() / flights.len() as f64;
        let off = mean - model as f64;
        let (waits, flights) = (range(&waits), range(&flights));
        println!("| {length} | {waits} | {flights} | {model} | {off:+.0} |");
    }
    Ok(())
}

/// How often the second packet of a burst cuts off the first.
fn bursts(path: &Path) -> Outcome<()> {
    println!("\nThe second packet, 855 µs behind the first, cuts the first off\n");
    println!("| first, B | second, B | cut, of {PHASES} |\n|---|---|---|");
    let ready = Rig::ready(path)?;
    for (first, second) in [(60, 19), (54, 19), (60, 21), (54, 21), (60, 36), (45, 19)] {
        let mut cut = 0;
        for at in phases() {
            let mut rig = ready.clone();
            rig.say(at, kind::P2P_BROADCAST, &vec![1; first + 1]);
            rig.say(at + 855 * MICROSECOND, kind::P2P_BROADCAST, &vec![1; second + 1]);
            rig.run(at + 10 * MILLISECOND)?;
            let sent = rig.transmissions();
            cut += u64::from(sent.len() < 2 || sent.iter().any(|packet| packet.is_cut));
        }
        println!("| {first} | {second} | {cut} |");
    }
    Ok(())
}

/// The duration of a round of the main loop: the time between two calls of `shutdownProcess`.
fn rounds(path: &Path) -> Outcome<()> {
    let Some(function) = rig::function(path, "shutdownProcess")? else {
        println!("\nNo symbols: the main loop's round is left out.");
        return Ok(());
    };
    let mut rig = Rig::ready(path)?;
    let mut calls = Vec::new();
    while rig.chip.now() < 600 * MILLISECOND {
        // An interrupt in front of its first instruction returns to it.
        let is_new = calls.last().is_none_or(|last| rig.chip.now() - last > 20 * MICROSECOND);
        if rig.chip.pc() == function && rig.chip.exception() == 0 && is_new {
            calls.push(rig.chip.now());
        }
        rig.chip.run_until(rig.chip.now() + 1)?;
    }
    let mut rounds: Vec<_> = calls.windows(2).map(|pair| pair[1] - pair[0]).collect();
    rounds.sort_unstable();
    let [median, most] = [rounds.len() / 2, rounds.len() - 1].map(|at| micros(rounds[at]));
    println!(
        "\nA round of the idle main loop: {} µs, median {median:.1}, most {most:.1}",
        range(&rounds)
    );
    Ok(())
}

/// The time of a byte that the chip sends, and its first reports.
fn sending(path: &Path) -> Outcome<()> {
    let mut rig = Rig::ready(path)?;
    let mut payload = vec![0xFF, 0x81];
    payload.extend([0x55; 60]);
    rig.hear(510 * MILLISECOND, BROADCAST, &payload);
    rig.say(520 * MILLISECOND, kind::AUTOUPDATE, &[]);
    rig.run(1100 * MILLISECOND)?;
    let frames = rig.frames();
    let gaps = frames.iter().flat_map(|frame| frame.at.windows(2).map(|pair| pair[1] - pair[0]));
    let mut gaps: Vec<_> = gaps.collect();
    gaps.sort_unstable();
    let [least, middle, late] = [0, gaps.len() / 2, gaps.len() * 9 / 10].map(|at| micros(gaps[at]));
    println!(
        "\nA byte that it sends: {least:.1} µs at least, median {middle:.1}, nine of ten below {late:.1}"
    );
    for frame in frames.iter().take(3) {
        let (kind, length) = (frame.kind, frame.data.len());
        let span = micros(frame.end() - frame.at[0]);
        println!("Type {kind:#04x} with {length} bytes: {span:.0} µs");
    }
    let first = frames.iter().find(|frame| frame.kind == kind::BATTERY);
    if let Some(first) = first {
        println!("The first report of the battery: {:.3} ms", micros(first.at[0]) / 1000.0);
    }
    let reports: Vec<_> = frames.iter().filter(|frame| frame.kind == kind::BATTERY).collect();
    let periods: Vec<_> = reports.windows(2).map(|pair| pair[1].at[0] - pair[0].at[0]).collect();
    println!("Reports of the battery every {} µs", range(&periods));
    if let [.., last] = &reports[..] {
        let volts = f32::from_le_bytes(last.data[1..5].try_into()?);
        println!("The battery's voltage in the last report: {volts:.4} V");
    }
    Ok(())
}

/// The spans in which the radio does not listen, from a moment on, from that moment.
fn deafness(rig: &mut Rig, since: Cycles) -> Outcome<Option<(Cycles, Cycles)>> {
    rig.chip.run_until(since)?;
    let mut deaf_from = None;
    while rig.chip.now() < since + 2 * MILLISECOND {
        match (rig.chip.radio().listens, deaf_from) {
            (false, None) => deaf_from = Some(rig.chip.now() - since),
            (true, Some(from)) => return Ok(Some((from, rig.chip.now() - since))),
            _ => {}
        }
        rig.chip.run_until(rig.chip.now() + 1)?;
    }
    Ok(None)
}

/// How long the radio is deaf after a packet that it acknowledges and for one of its own.
fn deaf(path: &Path) -> Outcome<()> {
    let ready = Rig::ready(path)?;
    let (mut ends, mut starts, mut own) = (Vec::new(), Vec::new(), Vec::new());
    for at in phases() {
        let mut rig = ready.clone();
        let end = rig.hear(at, ALONE, &[0x30, 1]);
        if let Some((_, until)) = deafness(&mut rig, end)? {
            ends.push(until);
        }
        starts.extend(rig.transmissions().first().map(|packet| packet.start - end));
        let mut rig = ready.clone();
        let end = rig.say(at, kind::P2P_BROADCAST, &[1, 2, 3, 4, 5]);
        own.extend(deafness(&mut rig, end)?);
    }
    let (from, until): (Vec<_>, Vec<_>) = own.into_iter().unzip();
    println!(
        "\nFrom the end of a packet to its acknowledgement's first bit: {} µs",
        range(&starts)
    );
    println!("Deaf after a packet that it acknowledges: until {} µs", range(&ends));
    println!("Deaf for a packet of 4 bytes: from {} to {} µs", range(&from), range(&until));
    Ok(())
}

/// How many bytes are lost of frames without a gap between them.
fn losses(path: &Path) -> Outcome<()> {
    let ready = Rig::ready(path)?;
    println!("\n| frames of 60 B back to back | bytes lost |\n|---|---|");
    for frames in [2, 4, 8] {
        let mut rig = ready.clone();
        let mut at = 510 * MILLISECOND;
        for _ in 0..frames {
            at = rig.say(at, kind::P2P_BROADCAST, &[1; 61]);
        }
        // A frame of an unknown type brings the parser to the beginning of one.
        rig.say(at + 10 * MILLISECOND, 0x7F, &[0; 64]);
        rig.say(at + 20 * MILLISECOND, kind::PROBE, &[]);
        rig.run(at + 40 * MILLISECOND)?;
        let frames_sent = rig.frames();
        let probe = frames_sent.iter().find(|frame| frame.kind == kind::PROBE);
        let lost = probe.map_or("no answer".to_owned(), |probe| probe.data[3].to_string());
        println!("| {frames} | {lost} |");
    }
    Ok(())
}

fn main() -> Outcome<()> {
    let path = std::env::args_os().nth(1).ok_or("give the file of the radio chip's firmware")?;
    let path = Path::new(&path);
    boot(path)?;
    flights(path)?;
    bursts(path)?;
    rounds(path)?;
    sending(path)?;
    deaf(path)?;
    losses(path)?;
    let mut rig = Rig::ready(path)?;
    let (instructions, started) = (rig.chip.instructions(), std::time::Instant::now());
    rig.run(2500 * MILLISECOND)?;
    let speed = (rig.chip.instructions() - instructions) as f64 / started.elapsed().as_secs_f64();
    println!(
        "\nRate {RATE:?}, a byte {BYTE} cycles; {:.0} million instructions a second",
        speed / 1e6
    );
    for unknown in rig.chip.unknown() {
        println!("Not modelled: {:#010x}, written: {}", unknown.address, unknown.is_write);
    }
    Ok(())
}
