//! The model of the radio chip and the vendor's firmware on an emulated chip, given the same stimuli.
//!
//! A case is what the flight processor says and what comes off the air, with its moments. Both chips do
//! it at sixteen phases of the main loop. The frames that come back on the line, the packets
//! that go on the air and the acknowledgements must be the same; their moments are compared in the order
//! of size over the phases, because where in its round a main loop is at a moment is chance.

mod cases;

use std::collections::BTreeMap;
use std::path::Path;

use nrf51_chip::image::Program;
use virtual_crazyflie::board::nrf51::{ANSWERS_AFTER, RAMP_UP};
use virtual_crazyflie::board::{Config, RadioFirmware};
use virtual_crazyflie::soc::Nanos;

use crate::board::{Bench, US};
use cases::{Case, Stimulus, cases};

/// Phases, and the time between two: sixteen of them pass through a round of the main loop, and through
/// the 12 ms in which the chip measures the battery and the temperature once.
const PHASES: u64 = 16;
const PHASE: Nanos = 753_540;
/// The aim for differences of moments, of which nine and a half in ten are smaller.
const AIM: Nanos = 30 * US;

/// What a chip did, without its moment.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    /// A frame for the flight processor.
    Frame(u8, Vec<u8>),
    /// A packet for all drones: port, and data.
    Broadcast(u8, Vec<u8>),
    /// An acknowledgement.
    Answer(Vec<u8>),
}

/// All that a chip does in a case, each with the moment at which it begins, from the case's first
/// moment on.
fn done(case: &Case, config: &Config, phase: Nanos) -> Vec<(Nanos, What)> {
    let mut bench = Bench::with(config);
    let begins = case.begins + phase;
    for (after, stimulus) in &case.stimuli {
        let at = begins + after;
        match stimulus {
            Stimulus::Say(kind, data) => {
                bench.run_to(at);
                bench.send(*kind, data);
            }
            Stimulus::Line(bytes) => {
                bench.run_to(at);
                bench.send_bytes(bytes);
            }
            Stimulus::Battery(volts) => {
                bench.run_to(at);
                bench.board.set_battery(*volts, false, false);
            }
            // A packet is known a little before its end.
            Stimulus::Hear(port, data, rssi) => {
                bench.run_to(at - 50 * US);
                bench.board.hear(at, *port, data, *rssi);
            }
            Stimulus::HearAlone(port, data, rssi) => {
                bench.run_to(at - 50 * US);
                bench.board.hear_alone(at, *port, data, *rssi);
            }
            Stimulus::HearCrtp(data, rssi) => {
                bench.run_to(at - 50 * US);
                bench.board.hear_crtp(at, data, *rssi);
            }
        }
    }
    let ends = begins + case.lasts;
    bench.run_to(ends);
    // A frame that has begun comes to its end.
    let mut heard = usize::MAX;
    while heard != bench.heard.len() {
        heard = bench.heard.len();
        bench.wait(200 * US);
    }
    let frames = bench.frames().into_iter();
    let mut all: Vec<_> =
        frames.map(|(at, kind, data)| (at, What::Frame(kind, case.masked(kind, data)))).collect();
    let sent = bench.board.take_packets().into_iter();
    all.extend(sent.map(|it| (it.at + RAMP_UP, What::Broadcast(it.port, it.data))));
    let answers = bench.board.take_crtp().into_iter();
    all.extend(answers.map(|it| (it.at + ANSWERS_AFTER, What::Answer(it.data))));
    all.retain(|(at, _)| (begins..ends).contains(at));
    all.sort();
    all.into_iter().map(|(at, what)| (at - begins, what)).collect()
}

/// What differs between the two in a case.
struct Compared {
    /// Frames, packets and acknowledgements of the firmware, over all phases.
    count: usize,
    /// Those that only one of the two has.
    different: Vec<String>,
    /// Differences of moments, over the phases in order, and phase by phase.
    in_order: Vec<Nanos>,
    by_phase: Vec<Nanos>,
}

/// Pairs what both did: the first of a content with the first of it, and so on.
fn compare(case: &Case, firmware: &RadioFirmware) -> Compared {
    let model = Config { flow_deck: false, multi_ranger: false, ..Config::default() };
    let chip = Config { radio: Some(firmware.clone()), ..model.clone() };
    let mut compared =
        Compared { count: 0, different: Vec::new(), in_order: Vec::new(), by_phase: Vec::new() };
    let mut moments: BTreeMap<(What, usize), [Vec<Nanos>; 2]> = BTreeMap::new();
    for phase in (0..PHASES).map(|phase| phase * PHASE) {
        let of_chip = done(case, &chip, phase);
        let mut of_model = done(case, &model, phase);
        compared.count += of_chip.len();
        let mut seen: BTreeMap<What, usize> = BTreeMap::new();
        for (at, what) in of_chip {
            let Some(place) = of_model.iter().position(|(_, other)| *other == what) else {
                compared.different.push(format!("chip alone, {} µs: {what:x?}", at / US));
                continue;
            };
            let (by_model, _) = of_model.remove(place);
            compared.by_phase.push(at.abs_diff(by_model));
            let count = seen.entry(what.clone()).or_default();
            let [chip, model] = moments.entry((what, *count)).or_default();
            *count += 1;
            chip.push(at);
            model.push(by_model);
        }
        let alone = of_model.into_iter();
        compared
            .different
            .extend(alone.map(|(at, what)| format!("model alone, {} µs: {what:x?}", at / US)));
    }
    for [mut chip, mut model] in moments.into_values() {
        chip.sort_unstable();
        model.sort_unstable();
        compared.in_order.extend(chip.iter().zip(&model).map(|(a, b)| a.abs_diff(*b)));
    }
    compared
}

/// The value below which `percent` of all lie, in µs.
fn percentile(all: &mut [Nanos], percent: usize) -> f64 {
    all.sort_unstable();
    let at = (all.len() * percent).div_ceil(100).saturating_sub(1);
    all.get(at).map_or(0.0, |nanos| *nanos as f64 * 1e-3)
}

/// The firmware in the file that `UCHAIN_RADIO_ELF` names.
fn firmware() -> RadioFirmware {
    let path = std::env::var_os("UCHAIN_RADIO_ELF").expect("UCHAIN_RADIO_ELF names the file");
    let program = Program::open(Path::new(&path)).unwrap_or_else(|why| panic!("{why}"));
    RadioFirmware::start(program).unwrap_or_else(|why| panic!("{why}"))
}

#[test]
#[ignore = "needs the radio chip's own firmware; UCHAIN_RADIO_ELF names the file"]
fn the_model_does_what_the_radio_chips_own_firmware_does() {
    let firmware = firmware();
    println!("| case | events | different | in order p95, µs | by phase p95, µs | largest |");
    println!("|---|---|---|---|---|---|");
    let (mut all, mut by_phase, mut different, mut count) = (Vec::new(), Vec::new(), 0, 0);
    for case in cases() {
        let mut compared = compare(&case, &firmware);
        let (in_order, phases) = (&mut compared.in_order, &mut compared.by_phase);
        let [p95, largest] = [95, 100].map(|percent| percentile(in_order, percent));
        let of_phases = percentile(phases, 95);
        let (events, wrong) = (compared.count, compared.different.len());
        println!(
            "| {} | {events} | {wrong} | {p95:.1} | {of_phases:.1} | {largest:.1} |",
            case.name
        );
        for line in compared.different.iter().take(4) {
            eprintln!("{}: {line}", case.name);
        }
        different += wrong;
        count += events;
        all.append(&mut compared.in_order);
        by_phase.append(&mut compared.by_phase);
    }
    let p95 = percentile(&mut all, 95);
    let of_phases = percentile(&mut by_phase, 95);
    println!("| all | {count} | {different} | {p95:.1} | {of_phases:.1} | |");
    assert_eq!(different, 0, "frames, packets and acknowledgements");
    assert!(p95 <= AIM as f64 * 1e-3, "{p95} µs");
}
