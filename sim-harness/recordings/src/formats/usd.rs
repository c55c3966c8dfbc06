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

use std::path::Path;

use input::InputError;
use units::{Instant, MetresPerSecond};

use super::{instant, received};
use crate::recording::{Anomaly, Clock, Recorder, Recording};

/// The first byte of a file.
pub(super) const MAGIC: u8 = 0xBC;
/// A round of the chain's loop, µs.
const ROUND_US: u64 = 200_000;
/// The most variables of one event type, against damaged files: ours.
const MOST: usize = 256;

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

/// The types of a variable.
#[derive(Clone, Copy)]
enum Type {
    Unsigned(usize),
    Signed(usize),
    Single,
    Double,
    /// A value that is passed over.
    Other(usize),
}

impl Type {
    fn of(letter: u8) -> Option<Self> {
        Some(match letter {
            b'B' | b'?' => Self::Unsigned(1),
            b'H' => Self::Unsigned(2),
            b'I' | b'L' => Self::Unsigned(4),
            b'Q' => Self::Unsigned(8),
            b'b' => Self::Signed(1),
            b'h' => Self::Signed(2),
            b'i' | b'l' => Self::Signed(4),
            b'q' => Self::Signed(8),
            b'f' => Self::Single,
            b'd' => Self::Double,
            b'e' => Self::Other(2),
            b'c' | b'x' => Self::Other(1),
            _ => return None,
        })
    }

    fn read(self, bytes: &mut Bytes<'_>) -> Option<f64> {
        let length = match self {
            Self::Unsigned(length) | Self::Signed(length) | Self::Other(length) => length,
            Self::Single => 4,
            Self::Double => 8,
        };
        let field = bytes.take(length)?;
        let mut wide = [0; 8];
        wide.get_mut(..length)?.copy_from_slice(field);
        let unsigned = u64::from_le_bytes(wide);
        Some(match self {
            Self::Unsigned(_) => unsigned as f64,
            Self::Signed(length) => {
                let unused = 64 - 8 * length as u32;
                ((unsigned << unused) as i64 >> unused) as f64
            }
            Self::Single => f64::from(f32::from_bits(unsigned as u32)),
            Self::Double => f64::from_bits(unsigned),
            Self::Other(_) => f64::NAN,
        })
    }
}

/// The bytes of a file that are left to read.
struct Bytes<'a> {
    whole: usize,
    left: &'a [u8],
}

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (field, left) = self.left.split_at_checked(length)?;
        self.left = left;
        Some(field)
    }

    fn number<const N: usize>(&mut self) -> Option<u64> {
        let mut wide = [0; 8];
        wide.get_mut(..N)?.copy_from_slice(self.take(N)?);
        Some(u64::from_le_bytes(wide))
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.left.iter().position(|byte| *byte == 0)?;
        let text = self.take(length + 1)?;
        std::str::from_utf8(text.get(..length)?).ok()
    }

    const fn place(&self) -> usize {
        self.whole - self.left.len()
    }
}

/// One event type.
struct Event {
    id: u64,
    variables: Vec<(Type, Option<Strength>)>,
    /// Which variable is the velocity along the tunnel.
    forward: Option<usize>,
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let body = body(bytes, &mut recorder);
    let mut rest = Bytes { whole: body.len(), left: body };
    let broken = |rest: &Bytes<'_>, wrong: &str| {
        let wrong = format!("{wrong}, at byte {}", rest.place());
        InputError::new(wrong, "copy the file from the card again").in_file(file)
    };
    let head = rest.take(1).and_then(|_| Some((rest.number::<2>()?, rest.number::<2>()?)));
    let Some((version @ 1..=2, types)) = head else {
        return Err(broken(&rest, "this is no µSD log of version 1 or 2"));
    };
    let mut events = Vec::new();
    for _ in 0..types {
        match event(&mut rest) {
            Some(event) => events.push(event),
            None => return Err(broken(&rest, "an event type cannot be read")),
        }
    }
    if !events.iter().flat_map(|event| &event.variables).any(|(_, strength)| strength.is_some()) {
        let remedy = "log radio.rssi, or uchain.frontRaw and uchain.backRaw";
        return Err(
            InputError::new("no variable of the log is a signal strength", remedy).in_file(file)
        );
    }
    read_events(&mut rest, version, &events, &mut recorder);
    Ok(recorder.finish())
}

/// The file without its checksum. One that was cut short has none, and is read as far as it goes.
fn body<'a>(bytes: &'a [u8], recorder: &mut Recorder) -> &'a [u8] {
    if let Some((body, checksum)) = bytes.split_last_chunk::<4>()
        && crc32fast::hash(body).to_le_bytes() == *checksum
    {
        return body;
    }
    recorder.note("its checksum is wrong or missing: it was read as far as it goes");
    bytes
}

fn event(rest: &mut Bytes<'_>) -> Option<Event> {
    let id = rest.number::<2>()?;
    rest.text()?;
    let count = usize::try_from(rest.number::<2>()?).ok().filter(|count| *count <= MOST)?;
    let mut event = Event { id, variables: Vec::with_capacity(count), forward: None };
    for place in 0..count {
        let (name, letter) = rest.text()?.strip_suffix(')')?.rsplit_once('(')?;
        let [letter] = *letter.as_bytes() else { return None };
        if name == "uchain.forward" {
            event.forward = Some(place);
        }
        event.variables.push((Type::of(letter)?, strength(name)));
    }
    Some(event)
}

fn read_events(rest: &mut Bytes<'_>, version: u64, events: &[Event], recorder: &mut Recorder) {
    let mut clock = Clock::default();
    let mut due = [0; 3];
    let mut line = 0;
    while !rest.left.is_empty() {
        line += 1;
        let Some((event, micros)) = head(rest, version, events) else {
            return recorder.anomaly(Anomaly::RowLength, line);
        };
        let values: Option<Vec<f64>> =
            event.variables.iter().map(|(kind, _)| kind.read(rest)).collect();
        let Some(values) = values else {
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
        let forward = event.forward.and_then(|place| values.get(place)).copied();
        for ((_, strength), value) in event.variables.iter().zip(values) {
            let Some(strength) = strength else { continue };
            let Some(due) = due.get_mut(strength.slot) else { continue };
            // The clock may have begun anew.
            if micros >= *due || due.abs_diff(micros) > ROUND_US {
                *due = micros + ROUND_US;
                take(recorder, line, now, *strength, value, forward);
            }
        }
    }
}

/// The type and the time of the next event.
fn head<'e>(rest: &mut Bytes<'_>, version: u64, events: &'e [Event]) -> Option<(&'e Event, u64)> {
    let id = rest.number::<2>()?;
    let micros = match version {
        1 => rest.number::<4>()? * 1000,
        _ => rest.number::<8>()?,
    };
    Some((events.iter().find(|event| event.id == id)?, micros))
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
