//! The drone's hardware: the faults of it that keep a drone on the ground, and the radio chip's
//! firmware and settings, by the chip's own answers.
//!
//! The chip starts in Bluetooth mode, in which Nordic's SoftDevice owns the radio. The chip's
//! program carries out every setting of the radio by taking the radio's power away, also then
//! (crazyflie2-nrf-firmware, `esb.c`, `esbReset`), and a SoftDevice that finds its radio changed may
//! fault, which switches the drone off (crazyflie2-nrf-firmware #62, crazyflie-firmware #670). The
//! vendor's firmware sets channel, data rate and address once at each boot (crazyflie-firmware,
//! `radiolink.c`, `radiolinkInit`), and so does this one: in Bluetooth mode the chip is told only
//! these three, and again only those that it does not confirm.

use storage::settings::Radio;
use units::{Duration, Instant};
use wire::syslink::{Incoming, Outgoing, Release};

/// A fault of the hardware that keeps the drone on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HardwareFault {
    /// The board is not a Crazyflie 2.1.
    Board,
    /// The radio chip's firmware is older than [`RadioChip::OLDEST`], or does not tell its version.
    RadioFirmware,
    /// The radio chip has not confirmed its settings.
    RadioSettings,
}

impl HardwareFault {
    /// The fault in words, for the operator's console.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Board => "This board is no Crazyflie 2.1: it does not fly.",
            Self::RadioFirmware => "The radio chip needs firmware 2022.01 or newer: no flight.",
            Self::RadioSettings => "The radio chip does not confirm its settings: no flight.",
        }
    }
}

/// The chip reports battery and signal every 5 ms once it was asked to; one that is silent for this
/// long was reset.
const SILENCE: Duration = Duration::from_secs(1);
/// A chip that has heard no packet for this long may listen on another channel: any Crazyradio can
/// set it from the air (crazyflie2-nrf-firmware, `main.c`, `handleRadioCmd`). Drones of a chain
/// report five times a second. In Bluetooth mode no time is too long.
const QUIET: Duration = Duration::from_secs(5);
/// The chip answers within milliseconds; settings that it has not confirmed after this time, or has
/// confirmed wrongly, are told again.
const CONFIRMS_WITHIN: Duration = Duration::from_millis(200);
/// The power is told when the chip has left Bluetooth mode, [`CONFIRMS_WITHIN`] after it was last told
/// its settings at the latest, and has to be confirmed within the same time again.
const CONFIRMS_POWER_WITHIN: Duration = Duration::from_millis(400);

/// The settings that the chip has confirmed since they were told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Confirmed {
    channel: bool,
    datarate: bool,
    address: bool,
    power: bool,
}

/// The version of the chip's firmware, by its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Firmware {
    /// The chip has not told it.
    Unknown,
    /// It is a release of the vendor's.
    Release(Release),
    /// It is no release of the vendor's: its builders know what they run.
    Own,
}

/// The radio chip as its answers show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadioChip {
    /// The settings that it was told, and when; `None` before the first time.
    told: Option<(Radio, Instant)>,
    confirmed: Confirmed,
    firmware: Firmware,
    /// When it was first known to have left Bluetooth mode since it was last silent: it had received
    /// or sent a packet of its own protocol.
    left_bluetooth: Option<Instant>,
    /// When the last frame of any kind came from it, and the last packet off the air.
    spoke: Instant,
    heard: Instant,
    /// Whether it has sent a frame since it was told its settings.
    answers: bool,
}

impl RadioChip {
    /// The oldest release of the chip's firmware with which a drone flies.
    pub const OLDEST: Release = Release { year: 2022, month: 1 };

    /// The chip before it was told anything.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            told: None,
            confirmed: Confirmed { channel: false, datarate: false, address: false, power: false },
            firmware: Firmware::Unknown,
            left_bluetooth: None,
            spoke: Instant::ZERO,
            heard: Instant::ZERO,
            answers: false,
        }
    }

    /// Notes that the chip was told these settings, and asked for its version. What it has confirmed
    /// before holds on, unless the settings are others or the chip was silent.
    pub fn note_told(&mut self, now: Instant, settings: Radio) {
        let same = self.told.is_some_and(|(told, _)| told == settings);
        if !same || now.since(self.spoke) >= SILENCE {
            *self = Self::new();
        }
        *self = Self { told: Some((settings, now)), spoke: now, heard: now, ..*self };
    }

    /// Takes a packet of the chip. A packet of another kind than those below shows that it is alive.
    pub fn take(&mut self, now: Instant, packet: &Incoming<'_>) {
        self.spoke = now;
        self.answers = self.told.is_some();
        let Some((told, _)) = self.told else { return };
        let confirmed = &mut self.confirmed;
        match packet {
            Incoming::Channel(channel) => confirmed.channel = *channel == told.channel,
            Incoming::Datarate(datarate) => confirmed.datarate = *datarate == told.datarate,
            Incoming::Address(address) => confirmed.address = *address == told.address,
            Incoming::Power(power) => confirmed.power = *power == told.power,
            Incoming::NrfVersion(text) => {
                self.firmware = match Release::parse(text) {
                    _ if text.is_empty() => Firmware::Unknown,
                    Some(release) => Firmware::Release(release),
                    None => Firmware::Own,
                };
            }
            // A packet of a Bluetooth client's comes as one of CRTP, and without a signal.
            Incoming::Raw(_) => self.heard = now,
            Incoming::P2p { .. } | Incoming::P2pBroadcast { .. } => {
                self.heard = now;
                self.note_left_bluetooth(now);
            }
            Incoming::Rssi(Some(_)) => self.note_left_bluetooth(now),
            _ => {}
        }
    }

    /// Notes that the chip was given a packet for other drones, which ends its Bluetooth mode.
    pub const fn note_sent(&mut self, now: Instant) {
        self.note_left_bluetooth(now);
    }

    const fn note_left_bluetooth(&mut self, now: Instant) {
        if self.left_bluetooth.is_none() {
            self.left_bluetooth = Some(now);
        }
    }

    /// Whether the chip is to be told its settings: it never was, it does not confirm them, it was
    /// reset, or it hears nothing although it is not in Bluetooth mode.
    #[must_use]
    pub fn is_to_be_told(&self, now: Instant) -> bool {
        let Some((_, told)) = self.told else { return true };
        let unconfirmed = !self.is_confirmed() || self.firmware == Firmware::Unknown;
        unconfirmed && now.since(told) >= CONFIRMS_WITHIN
            || now.since(self.spoke) >= SILENCE
            || self.left_bluetooth.is_some() && now.since(self.heard) >= QUIET
    }

    /// Whether this frame belongs to what the chip is told: all of them do, but in Bluetooth mode
    /// those settings that it has confirmed, and the power.
    #[must_use]
    pub const fn is_told(&self, frame: &Outgoing<'_>) -> bool {
        self.left_bluetooth.is_some()
            || match frame {
                Outgoing::Channel(_) => !self.confirmed.channel,
                Outgoing::Datarate(_) => !self.confirmed.datarate,
                Outgoing::Address(_) => !self.confirmed.address,
                Outgoing::Power(_) => false,
                _ => true,
            }
    }

    /// Whether the chip has confirmed every setting that it was told.
    const fn is_confirmed(&self) -> bool {
        let Confirmed { channel, datarate, address, power } = self.confirmed;
        channel && datarate && address && (power || self.left_bluetooth.is_none())
    }

    /// Whether the only setting that it has not confirmed is the power, and the time for that is not
    /// over.
    fn owes_power(&self, now: Instant) -> bool {
        let Confirmed { channel, datarate, address, .. } = self.confirmed;
        let is_early = |left| now.since(left) < CONFIRMS_POWER_WITHIN;
        channel && datarate && address && self.left_bluetooth.is_some_and(is_early)
    }

    /// Whether the chip has sent a frame since it was told its settings.
    #[must_use]
    pub const fn answers(&self) -> bool {
        self.answers
    }

    /// The chip's fault, if it has one. A power that the chip was not yet told, or has not had the time
    /// to confirm, is none.
    #[must_use]
    pub fn fault(&self, now: Instant) -> Option<HardwareFault> {
        match self.firmware {
            Firmware::Release(release) if release < Self::OLDEST => {
                Some(HardwareFault::RadioFirmware)
            }
            _ if !self.is_confirmed() && !self.owes_power(now) => {
                Some(HardwareFault::RadioSettings)
            }
            Firmware::Unknown => Some(HardwareFault::RadioFirmware),
            Firmware::Release(_) | Firmware::Own => None,
        }
    }

    /// The release of the chip's firmware; `None` where the chip has not told it, or its firmware is
    /// no release of the vendor's.
    #[must_use]
    pub const fn release(&self) -> Option<Release> {
        match self.firmware {
            Firmware::Release(release) => Some(release),
            Firmware::Unknown | Firmware::Own => None,
        }
    }
}

impl Default for RadioChip {
    fn default() -> Self {
        Self::new()
    }
}
