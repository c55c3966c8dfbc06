//! The frames of the serial line: 0xBC 0xCF, type, length, data, and two sums over all from the type
//! on (crazyflie2-nrf-firmware, `syslink.c`). Written apart from the flight processor's own end of
//! the line, so that the two check each other.

/// The most data of a frame (`SYSLINK_MTU`).
pub(super) const MTU: usize = 64;

const START: [u8; 2] = [0xBC, 0xCF];

/// Types (crazyflie2-nrf-firmware, `syslink.h`).
pub(super) mod kind {
    pub(in super::super) const RAW: u8 = 0x00;
    pub(in super::super) const CHANNEL: u8 = 0x01;
    pub(in super::super) const DATARATE: u8 = 0x02;
    pub(in super::super) const CARRIER: u8 = 0x03;
    pub(in super::super) const RSSI: u8 = 0x04;
    pub(in super::super) const ADDRESS: u8 = 0x05;
    pub(in super::super) const RAW_BROADCAST: u8 = 0x06;
    pub(in super::super) const POWER: u8 = 0x07;
    pub(in super::super) const P2P: u8 = 0x08;
    pub(in super::super) const P2P_BROADCAST: u8 = 0x0A;
    pub(in super::super) const READY: u8 = 0x0B;
    pub(in super::super) const SWITCH_OFF: u8 = 0x11;
    pub(in super::super) const BATTERY: u8 = 0x13;
    pub(in super::super) const AUTOUPDATE: u8 = 0x14;
    pub(in super::super) const SHUTDOWN_REQUEST: u8 = 0x15;
    pub(in super::super) const SHUTDOWN_ACK: u8 = 0x16;
    pub(in super::super) const LED_ON: u8 = 0x17;
    pub(in super::super) const LED_OFF: u8 = 0x18;
    pub(in super::super) const PROCESSOR_OFF: u8 = 0x1A;
    pub(in super::super) const MEMORY_SCAN: u8 = 0x20;
    pub(in super::super) const MEMORY_INFO: u8 = 0x21;
    pub(in super::super) const MEMORY_READ: u8 = 0x22;
    pub(in super::super) const MEMORY_WRITE: u8 = 0x23;
    pub(in super::super) const VERSION: u8 = 0x30;
    pub(in super::super) const PROBE: u8 = 0xF0;
}

/// The two sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sums(u8, u8);

impl Sums {
    const fn with(self, byte: u8) -> Self {
        let first = self.0.wrapping_add(byte);
        Self(first, self.1.wrapping_add(first))
    }
}

/// A whole frame, as it is on the line.
pub(super) fn frame(kind: u8, data: &[u8]) -> Vec<u8> {
    let length = u8::try_from(data.len()).expect("the chip never says more than a frame holds");
    let mut bytes = vec![START[0], START[1], kind, length];
    bytes.extend_from_slice(data);
    let sums = bytes[2..].iter().fold(Sums::default(), |sums, byte| sums.with(*byte));
    bytes.extend_from_slice(&[sums.0, sums.1]);
    bytes
}

/// The outcome of a byte: whether it completed a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// A frame whose sums are right.
    Frame { kind: u8, data: Vec<u8> },
    /// A frame whose first sum is wrong.
    BadFirstSum,
    /// or its second.
    BadSecondSum,
    /// A frame whose length is larger than any frame's.
    TooLong,
}

/// The part of a frame that has been received.
#[derive(Clone, Debug, PartialEq, Eq)]
enum State {
    FirstStart,
    SecondStart,
    Kind,
    Length { kind: u8 },
    Data { kind: u8, length: usize, data: Vec<u8> },
    FirstSum { kind: u8, data: Vec<u8> },
    SecondSum { kind: u8, data: Vec<u8> },
}

/// Finds frames as the vendor's parser does: a byte that is not what was expected is thrown away,
/// even where it could begin a frame.
#[derive(Clone, Debug)]
pub(super) struct Parser {
    state: State,
    sums: Sums,
}

impl Parser {
    pub(super) const fn new() -> Self {
        Self { state: State::FirstStart, sums: Sums(0, 0) }
    }

    pub(super) fn take(&mut self, byte: u8) -> Option<Found> {
        let (state, found) = match std::mem::replace(&mut self.state, State::FirstStart) {
            State::FirstStart if byte == START[0] => (State::SecondStart, None),
            State::SecondStart if byte == START[1] => (State::Kind, None),
            State::FirstStart | State::SecondStart => (State::FirstStart, None),
            State::Kind => {
                self.sums = Sums::default().with(byte);
                (State::Length { kind: byte }, None)
            }
            State::Length { kind } => {
                self.sums = self.sums.with(byte);
                match usize::from(byte) {
                    0 => (State::FirstSum { kind, data: Vec::new() }, None),
                    length @ 1..=MTU => (State::Data { kind, length, data: Vec::new() }, None),
                    _ => (State::FirstStart, Some(Found::TooLong)),
                }
            }
            State::Data { kind, length, mut data } => {
                self.sums = self.sums.with(byte);
                data.push(byte);
                if data.len() < length {
                    (State::Data { kind, length, data }, None)
                } else {
                    (State::FirstSum { kind, data }, None)
                }
            }
            State::FirstSum { kind, data } if byte == self.sums.0 => {
                (State::SecondSum { kind, data }, None)
            }
            State::FirstSum { .. } => (State::FirstStart, Some(Found::BadFirstSum)),
            State::SecondSum { kind, data } if byte == self.sums.1 => {
                (State::FirstStart, Some(Found::Frame { kind, data }))
            }
            State::SecondSum { .. } => (State::FirstStart, Some(Found::BadSecondSum)),
        };
        self.state = state;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Vec<Found> {
        let mut parser = Parser::new();
        bytes.iter().filter_map(|byte| parser.take(*byte)).collect()
    }

    #[test]
    fn known_frames_have_the_known_bytes() {
        // From published notes on this chip's protocol.
        assert_eq!(frame(0x0B, &[]), [0xBC, 0xCF, 0x0B, 0x00, 0x0B, 0x16]);
        assert_eq!(frame(0x14, &[]), [0xBC, 0xCF, 0x14, 0x00, 0x14, 0x28]);
        assert_eq!(frame(0x01, &[80]), [0xBC, 0xCF, 0x01, 0x01, 0x50, 0x52, 0x55]);
    }

    #[test]
    fn what_is_framed_is_found_again_at_every_length() {
        for length in 0..=MTU {
            let data: Vec<u8> = (0..length as u8).map(|n| n.wrapping_mul(73)).collect();
            let mut line = vec![0x00, 0xBC, 0x17, 0xCF];
            line.extend(frame(0x0A, &data));
            assert_eq!(all(&line), [Found::Frame { kind: 0x0A, data }]);
        }
    }

    #[test]
    fn one_wrong_byte_loses_one_frame_and_not_the_next() {
        let good = frame(0x08, &[1, 2, 3]);
        for at in 0..good.len() {
            let mut line = good.clone();
            line[at] ^= 0x40;
            // A length that is wrong swallows what follows, up to as much as it says.
            line.extend([0; MTU + 2]);
            line.extend(&good);
            let found = all(&line);
            let frames = found.iter().filter(|found| matches!(found, Found::Frame { .. }));
            assert_eq!(frames.count(), 1, "byte {at}: {found:?}");
            assert!(matches!(found.last(), Some(Found::Frame { kind: 8, .. })));
        }
    }

    #[test]
    fn a_doubled_first_byte_loses_the_frame_as_it_does_with_the_vendors_parser() {
        let mut line = vec![0xBC];
        line.extend(frame(0x0B, &[]));
        assert!(all(&line).is_empty());
    }
}
