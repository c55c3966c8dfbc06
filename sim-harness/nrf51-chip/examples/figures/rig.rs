//! A chip with a serial line to its other processor, and with an antenna.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use nrf51_chip::air::{Incoming, OVERHEAD, OnAir, Rate, Transmission};
use nrf51_chip::image::Program;
use nrf51_chip::{Chip, Config, Cycles, MICROSECOND, PinChange};
use object::{Object as _, ObjectSymbol as _};
use units::Volts;

pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;

/// The duration of a byte at 1 Mbaud.
pub(crate) const BYTE: Cycles = 10 * MICROSECOND;
pub(crate) const MILLISECOND: Cycles = 1000 * MICROSECOND;

/// The types of frames (crazyflie2-nrf-firmware, `syslink.h`).
pub(crate) mod kind {
    pub(crate) const P2P_BROADCAST: u8 = 0x0A;
    pub(crate) const READY: u8 = 0x0B;
    pub(crate) const BATTERY: u8 = 0x13;
    pub(crate) const AUTOUPDATE: u8 = 0x14;
    pub(crate) const PROBE: u8 = 0xF0;
}

/// The address of broadcasts, and the one that a chip has before it is told another.
pub(crate) const BROADCAST: [u8; 5] = [0xFF, 0xE7, 0xE7, 0xE7, 0xE7];
pub(crate) const ALONE: [u8; 5] = [0xE7; 5];

/// A frame that the chip has sent.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// When each of its bytes begins.
    pub(crate) at: Vec<Cycles>,
    pub(crate) kind: u8,
    pub(crate) data: Vec<u8>,
}

impl Frame {
    /// When its last stop bit is over.
    pub(crate) fn end(&self) -> Cycles {
        self.at.last().map_or(0, |at| at + BYTE)
    }
}

/// The chip and what it has said.
#[derive(Clone)]
pub(crate) struct Rig {
    pub(crate) chip: Chip,
    bytes: Vec<(Cycles, u8)>,
}

/// The bytes of a frame (the same, `syslink.c`).
pub(crate) fn frame(kind: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xBC, 0xCF, kind, data.len() as u8];
    bytes.extend_from_slice(data);
    let sums = bytes[2..].iter().fold((0u8, 0u8), |(a, b), byte| {
        let a = a.wrapping_add(*byte);
        (a, b.wrapping_add(a))
    });
    bytes.extend([sums.0, sums.1]);
    bytes
}

/// The firmware in a file, and the address of one of its functions.
pub(crate) fn function(path: &Path, name: &str) -> Outcome<Option<u32>> {
    let file = std::fs::read(path)?;
    let Ok(elf) = object::File::parse(&*file) else { return Ok(None) };
    let symbol = elf.symbol_by_name(name);
    Ok(symbol.map(|symbol| symbol.address() as u32 & !1))
}

impl Rig {
    /// A chip that has just started, on a battery of 4 V.
    pub(crate) fn start(path: &Path) -> Outcome<Self> {
        let mut chip = Chip::new(Arc::new(Program::open(path)?), Config::default())?;
        // The board divides the battery's voltage by three (`platform.c`).
        chip.set_analog(2, Volts(4.0 / 3.0));
        Ok(Self { chip, bytes: Vec::new() })
    }

    /// A chip whose radio is open, half a second after its start.
    pub(crate) fn ready(path: &Path) -> Outcome<Self> {
        let mut rig = Self::start(path)?;
        rig.say(400 * MILLISECOND, kind::READY, &[]);
        rig.run(500 * MILLISECOND)?;
        rig.bytes.clear();
        Ok(rig)
    }

    pub(crate) fn run(&mut self, until: Cycles) -> Outcome<()> {
        self.chip.run_until(until)?;
        let sent = self.chip.sent_bytes().drain(..);
        self.bytes.extend(sent.map(|byte| (byte.at, byte.byte)));
        Ok(())
    }

    /// Sends a frame whose first start bit begins at a moment. Returns the end of its last stop bit.
    pub(crate) fn say(&mut self, at: Cycles, kind: u8, data: &[u8]) -> Cycles {
        let bytes = frame(kind, data);
        for (byte, end) in bytes.iter().zip((at + BYTE..).step_by(BYTE as usize)) {
            self.chip.receive(end, Some(*byte));
        }
        at + bytes.len() as Cycles * BYTE
    }

    /// Lets a packet be on the air from a moment on. Returns its end.
    pub(crate) fn hear(&mut self, start: Cycles, address: [u8; 5], payload: &[u8]) -> Cycles {
        let radio = self.chip.radio();
        let packet = OnAir {
            channel: radio.channel,
            rate: radio.rate,
            address,
            power: 0,
            s1: 0,
            payload: payload.to_vec(),
            overhead: OVERHEAD,
        };
        let end = start + packet.duration();
        self.chip.hear(Incoming { start, end, packet, rssi: 50, is_intact: true });
        end
    }

    /// The whole frames that it has sent.
    pub(crate) fn frames(&self) -> Vec<Frame> {
        let mut frames = Vec::new();
        let mut rest = &self.bytes[..];
        while rest.len() >= 6 {
            let length = usize::from(rest[3].1) + 6;
            let Some((bytes, behind)) = rest.split_at_checked(length) else { break };
            let data = bytes[4..length - 2].iter().map(|(_, byte)| *byte).collect();
            let at = bytes.iter().map(|(at, _)| *at).collect();
            frames.push(Frame { at, kind: bytes[2].1, data });
            rest = behind;
        }
        frames
    }

    pub(crate) fn transmissions(&mut self) -> Vec<Transmission> {
        self.chip.take_transmissions()
    }

    pub(crate) fn pins(&mut self) -> Vec<PinChange> {
        self.chip.take_pin_changes()
    }
}

/// The rate that the firmware begins with.
pub(crate) const RATE: Rate = Rate::M2;
