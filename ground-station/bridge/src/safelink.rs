//! The safelink of the Crazyflie's radio chip: one bit in each direction by which either end knows
//! a repeated packet (crazyflie2-nrf-firmware, `src/esb.c`; cflib 0.1.34, `radiodriver.py`).
//!
//! An acknowledgement that is lost makes the sender repeat a packet that has arrived. Bit 3 of the
//! header counts the packets to the drone and bit 2 those from it, so the receiver drops the
//! second copy. A CRTP header means nothing by these bits.

/// The packet that asks the drone's radio chip for a safelink; it answers with the same.
const ASK: [u8; 3] = [0xFF, 0x05, 0x01];
/// How often it is asked before it counts as one that has none, as cflib does it.
const TRIES: u8 = 10;
/// Bit 3 of a header.
const UP: u8 = 1 << 3;
/// Bit 2 of a header.
const DOWN: u8 = 1 << 2;

/// The state of a safelink with one drone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Safelink {
    /// The drone is asked for it, so many times more.
    Asking { left: u8 },
    /// Packets are counted: the bits that the next packet to the drone has.
    On { up: u8, down: u8 },
    /// The drone has none.
    Off,
}

/// What an acknowledgement says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer<'a> {
    /// The packet that was sent has arrived, and the acknowledgement carries this packet, which is
    /// empty where there is none or where it has come before.
    Packet(&'a [u8]),
    /// The question for the safelink was answered; there was no packet in the exchange.
    Question,
}

impl Safelink {
    pub(super) const NEW: Self = Self::Asking { left: TRIES };

    /// The question that must be sent before any packet, if there is one.
    pub(super) const fn question(self) -> Option<[u8; 3]> {
        match self {
            Self::Asking { .. } => Some(ASK),
            Self::On { .. } | Self::Off => None,
        }
    }

    /// The packet as it goes on the air.
    pub(super) fn numbered(self, packet: &[u8]) -> Vec<u8> {
        let mut packet = packet.to_vec();
        if let (Self::On { up, down }, Some(header)) = (self, packet.first_mut()) {
            *header = *header & !(UP | DOWN) | up | down;
        }
        packet
    }

    /// Takes the acknowledgement of a packet, and `None` when none came.
    pub(super) fn acknowledged<'a>(&mut self, answer: Option<&'a [u8]>) -> Option<Answer<'a>> {
        match *self {
            Self::Asking { left } => {
                *self = match (answer, left.saturating_sub(1)) {
                    (Some(answer), _) if answer == ASK => Self::On { up: 0, down: 0 },
                    // A drone that is not there may well have one.
                    (None, _) => Self::NEW,
                    (Some(_), 0) => Self::Off,
                    (Some(_), left) => Self::Asking { left },
                };
                answer.map(|_| Answer::Question)
            }
            Self::On { up, down } => answer.map(|answer| {
                let is_new = answer.first().is_some_and(|header| header & DOWN == down);
                *self = Self::On { up: up ^ UP, down: if is_new { down ^ DOWN } else { down } };
                Answer::Packet(if is_new { answer } else { &[] })
            }),
            Self::Off => answer.map(Answer::Packet),
        }
    }
}
