//! Faults of the board that can be injected, and the moments at which they begin and end.

use std::collections::BTreeMap;

use sensors::models::{Fault as Wrong, Vl53l1xFault};
use sensors::multi_ranger::Beam;

use super::buses::Hold;
use super::noise::Shares;
use super::{Crazyflie, beam_index, fill};
use crate::soc::{I2cBus, Nanos};

/// A device with a serial bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// The BMI088's gyroscope,
    Gyro,
    /// and its accelerometer, a die of its own.
    Accel,
    /// The PMW3901.
    Flow,
    /// The Multi-ranger's expander.
    Expander,
    /// The EEPROM.
    Eeprom,
    /// A VL53L1x.
    Ranger(Beam),
}

/// A fault of the board.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// The device acknowledges nothing, and keeps what it knows. The flow sensor's SPI has no
    /// acknowledgement: it reads as ones.
    Silent(Device),
    /// The device does not acknowledge the last of so many bytes and addresses, over and over. It
    /// has no effect on the flow sensor.
    NackEvery(Device, u32),
    /// The device has no supply: silent, and afterwards as if just switched on.
    Unpowered(Device),
    /// Every byte that is read from the device is this one.
    Reads(Device, u8),
    /// Both dies of the inertial sensor go on sampling what they measured last.
    ImuFrozen,
    /// The gyroscope does not tell of its samples.
    DataReadyMissing,
    /// A ranger does not range as it should.
    Ranging(Beam, Vl53l1xFault),
    /// A device that was interrupted holds SDA. It lets go after so many clocks; without a number,
    /// not before the fault is over.
    SdaHeld {
        /// The bus.
        bus: I2cBus,
        /// The clocks that free it.
        clocks: Option<u32>,
    },
    /// SCL is held, which no clock can mend.
    SclHeld(I2cBus),
    /// The line to the radio chip is disturbed, both ways.
    Noise {
        /// How much.
        shares: Shares,
        /// The seed that decides which bytes are disturbed.
        seed: u64,
    },
    /// The radio chip says that it cannot take any more.
    FlowControlStuck,
    /// The radio chip's core has something else to do for a part of each period, as in Bluetooth
    /// mode around each event of its radio: it reads no bytes from the line, and its "wait" pin goes
    /// high after the second.
    RadioBusy {
        /// The period, ns.
        every: Nanos,
        /// The part of it, ns.
        busy: Nanos,
    },
    /// The radio chip is set to this channel from the air, at the beginning of the time given.
    RadioRetuned(u8),
    /// The radio chip is reset, at the beginning of the time given.
    RadioReset,
    /// The radio chip sends, in place of each packet of its own, the one that it received seven packets
    /// before the last, as it does where the end of a packet falls into a window of 1.25 µs. Before
    /// it has received eight, and where that one was not of a drone, it sends none.
    RadioGhost,
    /// The EEPROM holds other bytes from an address on, from the beginning of the time given.
    EepromBytes {
        /// The first address.
        at: u16,
        /// The bytes; those beyond the end of the memory are left out.
        bytes: Vec<u8>,
    },
}

/// A fault's beginning or end.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Turn {
    Begins(Fault),
    Ends(Fault),
}

/// The faults to come. Of several at one moment, the one that was requested first happens first.
#[derive(Debug, Default)]
pub(super) struct Schedule {
    turns: BTreeMap<(Nanos, u64), Turn>,
    asked: u64,
}

impl Schedule {
    pub(super) fn add(&mut self, fault: Fault, from: Nanos, until: Nanos) {
        self.put(from, Turn::Begins(fault.clone()));
        if until < Nanos::MAX {
            self.put(until.max(from), Turn::Ends(fault));
        }
    }

    pub(super) fn due(&self) -> Nanos {
        self.turns.first_key_value().map_or(Nanos::MAX, |((at, _), _)| *at)
    }

    pub(super) fn next(&mut self, now: Nanos) -> Option<(Nanos, Turn)> {
        if self.due() > now {
            return None;
        }
        self.turns.pop_first().map(|((at, _), turn)| (at, turn))
    }

    fn put(&mut self, at: Nanos, turn: Turn) {
        self.turns.insert((at, self.asked), turn);
        self.asked += 1;
    }
}

impl Crazyflie {
    pub(super) fn apply(&mut self, turn: Turn) {
        match turn {
            Turn::Begins(fault) => self.begin(fault),
            Turn::Ends(fault) => self.end(fault),
        }
        self.plan_ready();
    }

    fn begin(&mut self, fault: Fault) {
        match fault {
            Fault::Silent(Device::Flow) => self.flow.fault = Wrong::Absent,
            Fault::Silent(device) => self.set_wrong(device, Wrong::NackAfter(0)),
            Fault::NackEvery(device, every) => {
                self.set_wrong(device, Wrong::NackEvery { every, done: 0 });
            }
            Fault::Unpowered(device) => self.set_wrong(device, Wrong::Absent),
            Fault::Reads(device, byte) => self.set_wrong(device, Wrong::Stuck(byte)),
            Fault::ImuFrozen => self.imu_frozen = true,
            Fault::DataReadyMissing => self.ready_missing = true,
            Fault::Ranging(beam, fault) => self.set_ranging(beam, fault),
            Fault::SdaHeld { bus, clocks } => self.hold(bus, Hold::Data { clocks }),
            Fault::SclHeld(bus) => self.hold(bus, Hold::Clock),
            Fault::Noise { shares, seed } => self.radio.disturb(shares, seed),
            Fault::FlowControlStuck => self.radio.set_stuck_full(true),
            Fault::RadioBusy { every, busy } => self.radio.keep_busy(self.now, every, busy),
            Fault::RadioRetuned(channel) => self.radio.retune(self.now, channel),
            Fault::RadioReset => self.radio.reset(self.now),
            Fault::RadioGhost => self.radio.set_ghosts(true),
            Fault::EepromBytes { at, bytes } => fill(self.eeprom.at(self.now), at, &bytes),
        }
    }

    fn end(&mut self, fault: Fault) {
        match fault {
            Fault::Unpowered(device) => {
                self.set_wrong(device, Wrong::None);
                self.power_up(device);
            }
            Fault::Silent(device) | Fault::NackEvery(device, _) | Fault::Reads(device, _) => {
                self.set_wrong(device, Wrong::None);
            }
            Fault::ImuFrozen => {
                self.imu_frozen = false;
                let (turning, force) = self.inertia;
                self.set_inertia(turning, force);
            }
            Fault::DataReadyMissing => self.ready_missing = false,
            Fault::Ranging(beam, _) => self.set_ranging(beam, Vl53l1xFault::None),
            Fault::SdaHeld { bus, .. } | Fault::SclHeld(bus) => self.hold(bus, Hold::None),
            Fault::Noise { .. } => self.radio.disturb(Shares::default(), 0),
            Fault::FlowControlStuck => self.radio.set_stuck_full(false),
            Fault::RadioBusy { .. } => self.radio.keep_busy(self.now, 1, 0),
            Fault::RadioGhost => self.radio.set_ghosts(false),
            Fault::RadioRetuned(_) | Fault::RadioReset | Fault::EepromBytes { .. } => {}
        }
    }

    fn set_wrong(&mut self, device: Device, wrong: Wrong) {
        let now = self.now;
        match device {
            Device::Gyro => self.imu.at(now).gyro_fault = wrong,
            Device::Accel => self.imu.at(now).accel_fault = wrong,
            Device::Flow => self.flow.fault = wrong,
            Device::Expander => self.expander.at(now).fault = wrong,
            Device::Eeprom => self.eeprom.at(now).fault = wrong,
            Device::Ranger(beam) => self.rangers[beam_index(beam)].at(now).fault = wrong,
        }
        self.look_at_reset_lines();
    }

    fn set_ranging(&mut self, beam: Beam, fault: Vl53l1xFault) {
        self.rangers[beam_index(beam)].at(self.now).ranging_fault = fault;
    }

    /// The device begins anew. A ranger sees to that itself, and an EEPROM forgets nothing.
    fn power_up(&mut self, device: Device) {
        let now = self.now;
        match device {
            Device::Gyro => self.imu.at(now).reset_gyro(),
            Device::Accel => self.imu.at(now).reset_accel(),
            Device::Flow => self.flow.reset(),
            Device::Expander => self.expander.at(now).reset(),
            Device::Eeprom | Device::Ranger(_) => {}
        }
        self.look_at_reset_lines();
    }

    fn hold(&mut self, bus: I2cBus, hold: Hold) {
        if let Some(wires) = self.wires(bus) {
            wires.hold(hold);
        }
    }
}
