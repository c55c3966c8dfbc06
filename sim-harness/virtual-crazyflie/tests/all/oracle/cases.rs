//! The stimuli.

use units::{Dbm, Volts};
use virtual_crazyflie::soc::Nanos;

use crate::board::{MS, US, frame};

/// Types of frames.
mod kind {
    pub(super) const RAW: u8 = 0x00;
    pub(super) const CHANNEL: u8 = 0x01;
    pub(super) const DATARATE: u8 = 0x02;
    pub(super) const ADDRESS: u8 = 0x05;
    pub(super) const POWER: u8 = 0x07;
    pub(super) const P2P: u8 = 0x0A;
    pub(super) const READY: u8 = 0x0B;
    pub(super) const BATTERY: u8 = 0x13;
    pub(super) const AUTOUPDATE: u8 = 0x14;
    pub(super) const VERSION: u8 = 0x30;
    pub(super) const PROBE: u8 = 0xF0;
}

const NEAR: Dbm = Dbm(-50.0);
/// The radio is ready by then.
const READY: Nanos = 20 * MS;

/// Something that happens to the chip.
#[derive(Clone)]
pub(super) enum Stimulus {
    /// A frame from the flight processor, whose first bit begins then.
    Say(u8, Vec<u8>),
    /// Bytes from the flight processor.
    Line(Vec<u8>),
    Battery(Volts),
    /// A packet to all that has come off the air then.
    Hear(u8, Vec<u8>, Dbm),
    HearAlone(u8, Vec<u8>, Dbm),
    HearCrtp(Vec<u8>, Dbm),
}

/// A list of stimuli.
pub(super) struct Case {
    pub(super) name: String,
    /// From then on what the chip does is compared.
    pub(super) begins: Nanos,
    /// By the time from the beginning on; what is told before is at zero of the chip's time.
    pub(super) stimuli: Vec<(Nanos, Stimulus)>,
    pub(super) lasts: Nanos,
}

impl Case {
    /// A case with a radio that is ready.
    fn new(name: &str, stimuli: Vec<(Nanos, Stimulus)>, lasts: Nanos) -> Self {
        Self { name: name.to_owned(), begins: READY, stimuli, lasts }
    }

    /// The data of a frame, without what the two need not agree in: the firmware's version, and the
    /// battery's last digits, which the flight processor does not use.
    pub(super) fn masked(&self, kind: u8, mut data: Vec<u8>) -> Vec<u8> {
        match kind {
            kind::VERSION => data.clear(),
            kind::BATTERY => {
                // Three steps of the converter are 16 mV.
                let volts = data.get(1..5).and_then(|it| it.first_chunk().copied());
                let hundredths = volts.map_or(0.0, |volts| f32::from_le_bytes(volts) * 50.0);
                data = vec![data.first().copied().unwrap_or_default(), hundredths.round() as u8];
            }
            _ => {}
        }
        data
    }
}

fn bytes(length: usize) -> Vec<u8> {
    (0..length as u8).map(|n| n.wrapping_mul(37) ^ 0x5A).collect()
}

fn p2p(length: usize) -> Stimulus {
    Stimulus::Say(kind::P2P, [vec![11], bytes(length)].concat())
}

fn say(kind: u8, data: &[u8]) -> Stimulus {
    Stimulus::Say(kind, data.to_vec())
}

fn crtp(data: &[u8]) -> Stimulus {
    Stimulus::HearCrtp(data.to_vec(), NEAR)
}

/// All cases.
pub(super) fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    all.extend(broadcasts());
    all.extend(receptions());
    all.extend([settings(), acknowledgements(), safelink(), loader(), reports()]);
    all.extend([full_queue(), mixed(), damaged(), poll_and_broadcast()]);
    all
}

/// Packets for other drones, at each rate. The rate is set behind a first packet, which ends
/// Bluetooth's phase.
fn broadcasts() -> Vec<Case> {
    let lengths = [1, 4, 10, 17, 19, 30, 36, 45, 54, 60];
    let of_rate = |rate: u8| {
        let mut stimuli = vec![(0, p2p(20)), (5 * MS, say(kind::DATARATE, &[rate]))];
        let at = (20 * MS..).step_by(10 * MS as usize);
        stimuli.extend(lengths.iter().zip(at).map(|(length, at)| (at, p2p(*length))));
        Case::new(&format!("broadcasts, rate {rate}"), ready(stimuli), 140 * MS)
    };
    [0, 1, 2].into_iter().map(of_rate).collect()
}

/// READY in front of all.
fn ready(stimuli: Vec<(Nanos, Stimulus)>) -> Vec<(Nanos, Stimulus)> {
    let ready = (0, say(kind::READY, &[]));
    let later = stimuli.into_iter().map(|(at, stimulus)| (at + 5 * MS, stimulus));
    [ready].into_iter().chain(later).collect()
}

/// Packets of other drones, at each rate.
fn receptions() -> Vec<Case> {
    let lengths = [0, 1, 4, 10, 17, 19, 30, 36, 45, 54, 60];
    let of_rate = |rate: u8| {
        let mut stimuli = vec![(0, p2p(20)), (5 * MS, say(kind::DATARATE, &[rate]))];
        for (length, at) in lengths.iter().zip((20 * MS..).step_by(10 * MS as usize)) {
            stimuli.push((at, Stimulus::Hear(11, bytes(*length), Dbm(-61.0))));
        }
        Case::new(&format!("receptions, rate {rate}"), ready(stimuli), 150 * MS)
    };
    [0, 1, 2].into_iter().map(of_rate).collect()
}

/// Settings and questions, one by one.
fn settings() -> Case {
    let told: [(u8, &[u8]); 14] = [
        (kind::CHANNEL, &[60]),
        (kind::DATARATE, &[1]),
        (kind::ADDRESS, &[1, 2, 3, 4, 5]),
        (kind::POWER, &[0xF4]),
        (kind::POWER, &[2]),
        (kind::VERSION, &[]),
        (kind::READY, &[]),
        (kind::PROBE, &[]),
        (kind::CHANNEL, &[]),
        (kind::ADDRESS, &[1, 2, 3, 4]),
        (0x08, &[1, 2, 3]),
        (0x7F, &[9; 64]),
        (kind::CHANNEL, &[200]),
        (kind::CHANNEL, &[33]),
    ];
    let mut stimuli = vec![(0, p2p(20))];
    let at = (5 * MS..).step_by(5 * MS as usize);
    stimuli.extend(told.iter().zip(at).map(|((kind, data), at)| (at, say(*kind, data))));
    Case::new("settings", ready(stimuli), 100 * MS)
}

/// What the ground asks, and what the flight processor has left for it.
fn acknowledgements() -> Case {
    let stimuli = vec![
        (0, say(kind::RAW, &[0x10, 1, 2, 3])),
        (2 * MS, say(kind::RAW, &bytes(31))),
        (4 * MS, say(kind::RAW, &bytes(63))),
        (10 * MS, crtp(&[0xFF])),
        (15 * MS, crtp(&[0x30, 1])),
        (20 * MS, crtp(&bytes(32))),
        (25 * MS, crtp(&[0xFF])),
        (30 * MS, Stimulus::HearAlone(3, vec![0xCC], NEAR)),
        (35 * MS, crtp(&[0xFF])),
    ];
    Case::new("acknowledgements", ready(stimuli), 60 * MS)
}

fn safelink() -> Case {
    let stimuli = vec![
        (0, crtp(&[0xFF, 0x05, 0x01])),
        (5 * MS, crtp(&[0x33, 9])),
        (8 * MS, say(kind::RAW, &[0x00, 1])),
        (12 * MS, crtp(&[0x3F, 9])),
        (15 * MS, crtp(&[0x3F, 9])),
        (18 * MS, crtp(&[0x37, 10])),
        (22 * MS, crtp(&[0x3B, 11])),
        (26 * MS, crtp(&[0xFF, 0x05, 0x00])),
        (30 * MS, crtp(&[0x33, 9])),
    ];
    Case::new("safelink", ready(stimuli), 50 * MS)
}

/// Commands from the air that are not for the flight processor. The chip's address is its own.
fn loader() -> Case {
    let stimuli = vec![
        (0, crtp(&[0xFF, 0xFE, 0x05])),
        (5 * MS, crtp(&[0xFF, 0xFE, 0x06])),
        (10 * MS, crtp(&[0xFF, 0x03, 0x01, 90])),
        (15 * MS, crtp(&[0xFF])),
        (20 * MS, crtp(&[0xFF, 0x03, 0x02, 1])),
        (25 * MS, crtp(&[0xFF])),
    ];
    Case::new("commands from the air", ready(stimuli), 40 * MS)
}

/// Battery and signal, with a packet of a drone between them.
fn reports() -> Case {
    let stimuli = vec![
        (0, Stimulus::Battery(Volts(3.75))),
        (5 * MS, say(kind::AUTOUPDATE, &[])),
        // In no phase is it beside a report, of which chance would decide which is first.
        (650_250 * US, Stimulus::Hear(11, bytes(30), Dbm(-61.0))),
    ];
    Case::new("reports", ready(stimuli), 690_400 * US)
}

/// More packets at once than the chip has room for.
fn full_queue() -> Case {
    let heard = (0..12).map(|n| (n * 300 * US, Stimulus::Hear(11, vec![n as u8; 60], NEAR)));
    Case::new("twelve packets in 3.6 ms", ready(heard.collect()), 30 * MS)
}

/// Packets in both directions, as in a chain.
fn mixed() -> Case {
    let stimuli = vec![
        (0, p2p(60)),
        (1_360 * US, p2p(19)),
        (2_000 * US, Stimulus::Hear(11, bytes(40), NEAR)),
        (6_000 * US, Stimulus::Hear(11, bytes(60), NEAR)),
        (6_200 * US, p2p(36)),
        (12_000 * US, Stimulus::Hear(11, bytes(60), NEAR)),
        (12_400 * US, Stimulus::Hear(11, bytes(20), NEAR)),
    ];
    Case::new("a chain's packets", ready(stimuli), 30 * MS)
}

/// Bytes that are no frame, and frames that are damaged.
fn damaged() -> Case {
    let mut wrong = frame(kind::CHANNEL, &[60]);
    wrong[5] ^= 0x10;
    let mut doubled = vec![0xBC];
    doubled.extend(frame(kind::READY, &[]));
    let stimuli = vec![
        (0, p2p(20)),
        (5 * MS, Stimulus::Line(vec![0x55; 20])),
        (10 * MS, Stimulus::Line(wrong)),
        (15 * MS, Stimulus::Line(doubled)),
        (20 * MS, Stimulus::Line(vec![0xBC, 0xCF, 0x01, 65])),
        (25 * MS, say(kind::READY, &[])),
        (30 * MS, say(kind::PROBE, &[])),
    ];
    Case::new("damaged frames", ready(stimuli), 50 * MS)
}

/// Packets that come while the radio answers, or is about to send.
fn poll_and_broadcast() -> Case {
    let stimuli = vec![
        (0, crtp(&[0xFF])),
        (300 * US, Stimulus::Hear(11, bytes(17), NEAR)),
        (10_000 * US, crtp(&[0xFF])),
        (10_500 * US, Stimulus::Hear(11, bytes(17), NEAR)),
        (20_000 * US, p2p(17)),
        (20_700 * US, Stimulus::Hear(11, bytes(17), NEAR)),
        (21_100 * US, Stimulus::Hear(11, bytes(17), NEAR)),
    ];
    Case::new("beside an answer", ready(stimuli), 40 * MS)
}
