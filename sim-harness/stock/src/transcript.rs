//! Summarises the traffic on a drone's sensor buses: the configuration that a driver has written to
//! each device, and how often it reads which registers. So the drivers of two firmwares can be
//! compared.

use std::collections::BTreeMap;

use virtual_crazyflie::board::{Peer, Transfer};

/// A device, by its place on the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Device {
    /// The gyroscope of the BMI088.
    Gyroscope,
    /// The accelerometer of the BMI088.
    Accelerometer,
    /// The barometer.
    Barometer,
    /// The flow sensor.
    Flow,
    /// The ranger that looks down.
    Down,
    /// The five rangers of the Multi-ranger deck.
    Sides,
    /// The expander that holds these in reset.
    Expander,
    /// The EEPROM.
    Eeprom,
}

impl Device {
    /// The name of the device.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gyroscope => "gyroscope",
            Self::Accelerometer => "accelerometer",
            Self::Barometer => "barometer",
            Self::Flow => "flow",
            Self::Down => "ranger down",
            Self::Sides => "rangers of the sides and up",
            Self::Expander => "expander",
            Self::Eeprom => "EEPROM",
        }
    }

    /// The device of a transfer, by the addresses that either firmware gives the rangers: the one
    /// that looks down is moved first. At their common address they are none.
    const fn of(peer: Peer) -> Option<Self> {
        Some(match peer {
            Peer::Sensor(0x69) => Self::Gyroscope,
            Peer::Sensor(0x18) => Self::Accelerometer,
            Peer::Sensor(0x77) => Self::Barometer,
            Peer::Flow => Self::Flow,
            Peer::Deck(0x6A) => Self::Down,
            Peer::Deck(0x6B..=0x6F) => Self::Sides,
            Peer::Deck(0x20) => Self::Expander,
            Peer::Deck(0x50) => Self::Eeprom,
            Peer::Sensor(_) | Peer::Deck(_) => return None,
        })
    }

    /// Bytes of a register's address.
    const fn address(self) -> usize {
        match self {
            Self::Down | Self::Sides | Self::Eeprom => 2,
            _ => 1,
        }
    }

    /// Whether a register's number counts on from byte to byte.
    const fn counts_on(self) -> bool {
        !matches!(self, Self::Barometer | Self::Flow | Self::Expander | Self::Eeprom)
    }
}

/// The transfers between the processor and one device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// The registers that were written, with the value that each was given last. The flow sensor's
    /// are counted in `writes` alone: their meaning depends on the bank.
    pub registers: BTreeMap<u16, u8>,
    /// The number of transfers that wrote something.
    pub writes: u32,
    /// The number of transfers that read, by their first register and their length.
    pub reads: BTreeMap<(u16, usize), u32>,
    /// The number of addresses that were not acknowledged.
    pub refused: u32,
    /// The register whose address was written, to be read next.
    begun: Option<u16>,
}

/// The traffic by device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary(BTreeMap<Device, Traffic>);

impl Summary {
    /// Adds transfers, in their order. A read follows the write of its register's address.
    pub fn add(&mut self, transfers: &[Transfer]) {
        for transfer in transfers {
            let Some(device) = Device::of(transfer.peer) else { continue };
            let traffic = self.0.entry(device).or_default();
            if !transfer.acknowledged {
                traffic.refused += 1;
            } else if device == Device::Flow {
                traffic.exchange(transfer);
            } else if transfer.read {
                let at = traffic.begun.take().unwrap_or_default();
                *traffic.reads.entry((at, transfer.answered.len())).or_default() += 1;
            } else {
                traffic.begun = traffic.write(device, &transfer.written);
            }
        }
    }

    /// The traffic of a device.
    #[must_use]
    pub fn of(&self, device: Device) -> Option<&Traffic> {
        self.0.get(&device)
    }

    /// The devices, in order.
    pub fn devices(&self) -> impl Iterator<Item = (Device, &Traffic)> {
        self.0.iter().map(|(device, traffic)| (*device, traffic))
    }
}

impl Traffic {
    /// A write: the register's address, and its values. Where there is no value, the address is
    /// that of the read which follows.
    fn write(&mut self, device: Device, bytes: &[u8]) -> Option<u16> {
        let (address, values) = bytes.split_at_checked(device.address())?;
        let at = address.iter().fold(0, |at, byte| at << 8 | u16::from(*byte));
        if values.is_empty() {
            return Some(at);
        }
        self.writes += 1;
        if device.counts_on() {
            self.registers.extend((at..).zip(values.iter().copied()));
        } else if device == Device::Barometer {
            // Pairs of register and value.
            let pairs = bytes.as_chunks::<2>().0;
            self.registers.extend(pairs.iter().map(|[at, value]| (u16::from(*at), *value)));
        } else if device == Device::Expander {
            self.registers.extend(values.last().map(|value| (at, *value)));
        }
        None
    }

    /// A select of the flow sensor: a write has the highest bit of its register set.
    fn exchange(&mut self, transfer: &Transfer) {
        match transfer.written.first() {
            Some(register) if register & 0x80 != 0 => self.writes += 1,
            Some(register) => {
                let length = transfer.answered.len() - 1;
                *self.reads.entry((u16::from(*register), length)).or_default() += 1;
            }
            None => {}
        }
    }

    /// The number of all reads.
    #[must_use]
    pub fn read_count(&self) -> u32 {
        self.reads.values().sum()
    }

    /// The number of reads of this register, of this length at least.
    #[must_use]
    pub fn reads_of(&self, register: u16, length: usize) -> u32 {
        let wanted = |(at, of): &&(u16, usize)| *at == register && *of >= length;
        let of = |key: &(u16, usize)| self.reads.get(key).copied().unwrap_or_default();
        self.reads.keys().filter(wanted).map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transfer(peer: Peer, written: &[u8], answered: &[u8]) -> Transfer {
        Transfer {
            at: 0,
            peer,
            acknowledged: true,
            read: !answered.is_empty(),
            written: written.to_vec(),
            answered: answered.to_vec(),
        }
    }

    #[test]
    fn a_read_belongs_to_the_register_that_was_written_before() {
        let gyro = Peer::Sensor(0x69);
        let mut summary = Summary::default();
        summary.add(&[
            transfer(gyro, &[0x0F, 0x00, 0x82], &[]),
            transfer(gyro, &[0x02], &[]),
            transfer(gyro, &[], &[1; 6]),
            transfer(Peer::Flow, &[0x16, 0, 0], &[0, 1, 2]),
            transfer(Peer::Flow, &[0xBA, 0x5A], &[0, 0]),
        ]);
        let gyro = summary.of(Device::Gyroscope).unwrap();
        assert_eq!(gyro.registers, BTreeMap::from([(0x0F, 0x00), (0x10, 0x82)]));
        assert_eq!((gyro.reads_of(0x02, 6), gyro.read_count(), gyro.writes), (1, 1, 1));
        let flow = summary.of(Device::Flow).unwrap();
        assert_eq!((flow.reads_of(0x16, 2), flow.writes), (1, 1));
    }
}
