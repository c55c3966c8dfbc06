//! Reads the logs that the vendor's firmware writes to the µSD card deck.
//!
//! A file begins with the byte 0xBC, a version (1 or 2) and the number of event types; each type has
//! a number, a name, and its variables, each as `group.name(X)` with X the letter of Python's
//! `struct`. Then events follow: type, time (32-bit milliseconds in version 1, 64-bit microseconds in
//! version 2), and the values, all little-endian. The last four bytes are the CRC-32 of all before
//! (crazyflie-firmware, `usddeck.c` and `tools/usdlog/cfusdlog.py`).
//!
//! | variable | is |
//! |---|---|
//! | `radio.rssi` | the link `radio`: the last packet of a client, −dBm |
//! | `uchain.frontRaw`, `uchain.backRaw` | the links `front` and `back`: the last packets of both neighbours, dBm, 0 for none |
//! | `uchain.forward` | velocity along the tunnel, towards the head |
//!
//! A logged variable holds the last packet, so it is read once in a round of 0.2 s. What other
//! formats call a line is the number of the event.

pub(crate) mod container;

use std::path::Path;

use input::InputError;
use units::{Instant, MetresPerSecond};

use super::{instant, received};
use crate::recording::{Anomaly, Clock, Recorder, Recording};

pub(super) use container::MAGIC;
use container::{Container, Event};

/// A round of the chain's loop, µs.
const ROUND_US: u64 = 200_000;

/// The link and the sign of a variable that holds a strength.
#[derive(Clone, Copy)]
struct Strength {
    link: &'static str,
    /// The place of the link among those that are read.
    slot: usize,
    sign: f64,
    /// The sign of the own velocity in the rate of separation; zero where the direction to the
    /// other end is not known.
    away: f64,
}

fn strength(name: &str) -> Option<Strength> {
    Some(match name {
        "radio.rssi" => Strength { link: "radio", slot: 0, sign: -1.0, away: 0.0 },
        "uchain.frontRaw" => Strength { link: "front", slot: 1, sign: 1.0, away: -1.0 },
        "uchain.backRaw" => Strength { link: "back", slot: 2, sign: 1.0, away: 1.0 },
        _ => return None,
    })
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut log = Container::open(bytes, file)?;
    if !log.is_whole {
        recorder.note(CUT);
    }
    let kinds: Vec<Links> = log.types.iter().map(|kind| Links::of(&kind.names)).collect();
    if kinds.iter().all(|links| links.strengths.is_empty()) {
        let remedy = "log radio.rssi, or uchain.frontRaw and uchain.backRaw";
        return Err(
            InputError::new("no variable of the log is a signal strength", remedy).in_file(file)
        );
    }
    read_events(&mut log, &kinds, &mut recorder);
    Ok(recorder.finish())
}

/// What is said of a file without its checksum.
pub(crate) const CUT: &str = "its checksum is wrong or missing: it was read as far as it goes";

/// What an event type says about links: the places of its strengths, and of the velocity along the
/// tunnel.
struct Links {
    strengths: Vec<(usize, Strength)>,
    forward: Option<usize>,
}

impl Links {
    fn of(names: &[String]) -> Self {
        let strengths = names.iter().enumerate();
        Self {
            strengths: strengths
                .filter_map(|(place, name)| Some((place, strength(name)?)))
                .collect(),
            forward: names.iter().position(|name| name == "uchain.forward"),
        }
    }
}

fn read_events(log: &mut Container<'_>, kinds: &[Links], recorder: &mut Recorder) {
    let mut clock = Clock::default();
    let mut due = [0; 3];
    let mut line = 0;
    while let Some(event) = log.next() {
        line += 1;
        let Ok(Event { kind, micros, values }) = event else {
            return recorder.anomaly(Anomaly::RowLength, line);
        };
        recorder.row();
        let Some(now) = instant(micros as f64 * 1e-6) else {
            recorder.anomaly(Anomaly::NotANumber, line);
            continue;
        };
        if !recorder.clock_is_sound(&mut clock, now, line) {
            continue;
        }
        let Some(links) = kinds.get(kind) else { continue };
        let forward = links.forward.and_then(|place| values.get(place)).copied();
        for (place, strength) in &links.strengths {
            let Some(due) = due.get_mut(strength.slot) else { continue };
            let Some(value) = values.get(*place) else { continue };
            // The clock may have begun anew.
            if micros >= *due || due.abs_diff(micros) > ROUND_US {
                *due = micros + ROUND_US;
                take(recorder, line, now, *strength, *value, forward);
            }
        }
    }
}

fn take(
    recorder: &mut Recorder,
    line: usize,
    now: Instant,
    strength: Strength,
    value: f64,
    forward: Option<f64>,
) {
    // Zero stands for a neighbour that was never heard.
    if value == 0.0 {
        return;
    }
    let Some(rssi) = received(strength.sign * value) else {
        return recorder.anomaly(Anomaly::ImpossibleRssi, line);
    };
    let link = recorder.link(strength.link);
    let separating = forward.filter(|v| v.is_finite() && strength.away != 0.0);
    let separating = separating.map(|v| MetresPerSecond((v * strength.away) as f32));
    recorder.sample(line, now, link, rssi, separating, None);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A log of one event type with these variables, and one event a tenth of a second.
    fn log(version: u16, variables: &[&str], events: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = vec![MAGIC];
        bytes.extend(version.to_le_bytes());
        bytes.extend(1_u16.to_le_bytes());
        bytes.extend(7_u16.to_le_bytes());
        bytes.extend(b"fixedFrequency\0");
        bytes.extend((variables.len() as u16).to_le_bytes());
        for variable in variables {
            bytes.extend(variable.as_bytes());
            bytes.push(0);
        }
        for (n, event) in events.iter().enumerate() {
            bytes.extend(7_u16.to_le_bytes());
            let ms = n as u32 * 100;
            match version {
                1 => bytes.extend(ms.to_le_bytes()),
                _ => bytes.extend((u64::from(ms) * 1000).to_le_bytes()),
            }
            bytes.extend(event);
        }
        let checksum = crc32fast::hash(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    fn parsed(bytes: &[u8]) -> Recording {
        parse(bytes, Path::new("log00")).unwrap()
    }

    #[test]
    fn the_clients_packets_are_read_once_a_round() {
        for version in [1, 2] {
            let events: Vec<Vec<u8>> = (0..10).map(|n| vec![1, 2, 50 + n]).collect();
            let bytes = log(version, &["pm.vbatMV(H)", "radio.rssi(B)"], &events);
            let recording = parsed(&bytes);
            assert_eq!(recording.links, ["radio"]);
            let heard: Vec<f32> = recording.samples.iter().map(|sample| sample.rssi.0).collect();
            assert_eq!(heard, [-50.0, -52.0, -54.0, -56.0, -58.0]);
            assert_eq!(recording.note, None);
        }
    }

    #[test]
    fn a_relays_log_has_both_links_and_its_own_motion() {
        let values = [-61.0_f32, 0.0, 0.25];
        let event: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let names = ["uchain.frontRaw(f)", "uchain.backRaw(f)", "uchain.forward(f)"];
        let recording = parsed(&log(2, &names, &[event]));
        assert_eq!(recording.links, ["front"], "0 dBm is a neighbour that was never heard");
        let sample = recording.samples[0];
        assert_eq!((sample.rssi.0, sample.separating), (-61.0, Some(MetresPerSecond(-0.25))));
    }

    #[test]
    fn a_log_that_was_cut_is_read_as_far_as_it_goes() {
        let events: Vec<Vec<u8>> = (0..10).map(|_| vec![60]).collect();
        let whole = log(2, &["radio.rssi(B)"], &events);
        let recording = parsed(&whole[..whole.len() - 4 - 6]);
        assert_eq!(recording.samples.len(), 5);
        assert!(recording.note.unwrap().starts_with("its checksum"));
        assert_eq!(recording.anomalies.of(Anomaly::RowLength), [10]);
    }

    /// The largest time that eight bytes can hold.
    #[test]
    fn an_impossible_time_is_an_anomaly() {
        let mut bytes = log(2, &["radio.rssi(B)"], &[vec![60], vec![61]]);
        let last_event = bytes.len() - 4 - 11;
        bytes[last_event + 2..last_event + 10].fill(0xFF);
        let recording = parsed(&bytes);
        assert_eq!(recording.samples.len(), 1);
        assert_eq!(recording.anomalies.of(Anomaly::NotANumber), [2]);
    }

    #[test]
    fn a_log_without_a_strength_says_what_to_log() {
        let bytes = log(2, &["gyro.x(f)"], &[]);
        let error = parse(&bytes, Path::new("log00")).unwrap_err().to_string();
        assert!(error.contains("log radio.rssi"), "{error}");
    }

    proptest! {
        /// Any bytes are a log or an error.
        #[test]
        fn any_bytes_end(
            mut bytes in prop::collection::vec(any::<u8>(), 0..400),
            at in 0..70_usize,
            damaged in 1..12_usize,
        ) {
            let _ = parse(&bytes, Path::new("log00"));
            let mut good = log(2, &["radio.rssi(B)"], &[vec![60], vec![61]]);
            for (n, byte) in bytes.drain(..).enumerate().take(damaged) {
                if let Some(place) = good.get_mut(at + n) {
                    *place = byte;
                }
            }
            let _ = parse(&good, Path::new("log00"));
        }
    }
}
