//! The board of a Crazyflie 2.1: the devices at the chip's pins, and two decks, a Flow deck v2 and a
//! Multi-ranger deck.
//!
//! | bus or pin | what is there |
//! |---|---|
//! | I2C3: PA8, PC9 | BMP388; BMI088, both dies; "data ready" of the gyroscope on PC14 |
//! | I2C1: PB6, PB7 | EEPROM; the Flow deck's ranger; the Multi-ranger's expander and five rangers |
//! | SPI1, select PB4 | the Flow deck's PMW3901 |
//! | USART6, "wait" on PA4 | the radio chip, [`RadioChip`]: the model [`nrf51`], with the decks' one-wire memories, or the vendor's firmware |
//! | PC0 to PC3, PD2 | LEDs |
//!
//! The sensors are the register-level models of `sensors::models`. Each is advanced only when it
//! is accessed, by as much time as has passed. A world sets what they measure, and takes what the
//! radio sends: [`Crazyflie`]'s own methods. What can be wrong is a [`Fault`]. Motors are pins of
//! the chip's timers, which are read there.
//!
//! Pins and buses are those of crazyflie-firmware: `i2c_drv.c`, `sensors_bmi088_i2c.c`,
//! `deck_spi.c`, `uart_syslink.h`, `multiranger.c`, `led.h`.

mod buses;
mod deck_memory;
mod device;
mod faults;
mod inputs;
mod leds;
mod noise;
pub mod nrf51;
mod radio_chip;
mod serial;
mod transcript;

use std::sync::Arc;
use std::sync::atomic::AtomicU8;

use sensors::expander::Lines;
use sensors::models::{
    Bmi088Model, Bmp388Model, EepromModel, ExpanderModel, I2cModel, Pmw3901Model, SpiModel,
    Vl53l1xModel,
};
use sensors::multi_ranger::Beam;
use units::{Acceleration, AngularVelocity};

pub use faults::{Device, Fault};
pub use inputs::{Flow, Sight};
pub use leds::{Blink, Led};
pub use noise::Shares;
pub use nrf51::Nrf51;
pub use radio_chip::{FirmwareChip, RadioChip, RadioFirmware, Unbootable};
pub use transcript::{Peer, Transfer};

use crate::soc::{Board, I2cBus, Level, Nanos, Pin, SpiBus, UartBus, UartByte};
use buses::{Gesture, Line, Wires};
use device::Timed;
use faults::Schedule;
use leds::Leds;
use transcript::{Bus, Transcript};

/// The equipment of the board.
#[derive(Clone, Debug)]
pub struct Config {
    /// A Flow deck v2: optic flow, and the ranger that looks down.
    pub flow_deck: bool,
    /// A Multi-ranger deck: expander, and five rangers.
    pub multi_ranger: bool,
    /// The EEPROM's content, from address zero on; the rest is erased.
    pub eeprom: Vec<u8>,
    /// The lines of the expander that float high after its reset. All is the worse case: rangers
    /// that are not held in reset are all at one address.
    pub floating: u8,
    /// The firmware of the radio chip; where there is none, the chip is the model.
    pub radio: Option<RadioFirmware>,
    /// The version that the model of the radio chip reports for its firmware.
    pub version: String,
    /// Noise of the inertial sensor's samples, beside what a world puts into them.
    pub noise: Option<InertialNoise>,
}

/// Noise on every sample, in steps of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InertialNoise {
    /// The seed of the noise.
    pub seed: u32,
    /// The gyroscope's, at most so many steps either way.
    pub gyro: u8,
    /// The accelerometer's.
    pub accel: u8,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            flow_deck: true,
            multi_ranger: true,
            eeprom: Vec::new(),
            floating: 0xFF,
            radio: None,
            version: String::from("2025.02 (CF21)"),
            noise: None,
        }
    }
}

type SharedLines = Arc<AtomicU8>;

/// The board.
pub struct Crazyflie {
    now: Nanos,
    due: Nanos,
    flow_deck: bool,
    multi_ranger: bool,

    imu: Timed<Bmi088Model>,
    barometer: Timed<Bmp388Model>,
    imu_frozen: bool,
    ready_missing: bool,
    ready_due: Nanos,
    inertia: (AngularVelocity, Acceleration),
    sensor_wires: Wires,

    eeprom: Timed<EepromModel>,
    expander: Timed<ExpanderModel<SharedLines>>,
    rangers: [Timed<Vl53l1xModel<SharedLines>>; 6],
    deck_wires: Wires,

    flow: Pmw3901Model,
    flow_advanced_until: Nanos,
    flow_selected: bool,

    radio: RadioChip,
    leds: Leds,
    schedule: Schedule,
    transcript: Transcript,
}

impl Crazyflie {
    /// A drone that has just been switched on.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let lines = SharedLines::default();
        let expander = ExpanderModel::new(Arc::clone(&lines), config.floating);
        let ranger = |beam| {
            let line = reset_line(beam).map(|line| (Arc::clone(&lines), line));
            Timed::new(Vl53l1xModel::new(line))
        };
        let mut imu = Bmi088Model::new();
        if let Some(noise) = config.noise {
            imu.set_noise(noise.seed, noise.gyro, noise.accel);
        }
        let mut eeprom = EepromModel::new();
        fill(&mut eeprom, 0, &config.eeprom);
        let mut board = Self {
            now: 0,
            due: Nanos::MAX,
            flow_deck: config.flow_deck,
            multi_ranger: config.multi_ranger,
            imu: Timed::new(imu),
            barometer: Timed::new(Bmp388Model::new()),
            imu_frozen: false,
            ready_missing: false,
            ready_due: Nanos::MAX,
            inertia: (AngularVelocity([0.0; 3]), Acceleration([0.0, 0.0, 9.806_65])),
            sensor_wires: Wires::new(),
            eeprom: Timed::new(eeprom),
            expander: Timed::new(expander),
            rangers: Beam::ALL.map(ranger),
            deck_wires: Wires::new(),
            flow: Pmw3901Model::new(),
            flow_advanced_until: 0,
            flow_selected: false,
            radio: RadioChip::new(
                config.radio.as_ref(),
                &config.version,
                deck_memory::memories(config.flow_deck, config.multi_ranger),
            ),
            leds: Leds::new(),
            schedule: Schedule::default(),
            transcript: Transcript::default(),
        };
        board.settle();
        board
    }

    fn has_ranger(&self, beam: Beam) -> bool {
        if beam == Beam::Down { self.flow_deck } else { self.multi_ranger }
    }

    const fn wires(&mut self, bus: I2cBus) -> Option<&mut Wires> {
        match bus {
            I2cBus::I2c1 => Some(&mut self.deck_wires),
            I2cBus::I2c2 => None,
            I2cBus::I2c3 => Some(&mut self.sensor_wires),
        }
    }

    /// Visits the devices on a bus that are among `whom`, each with its bit.
    fn each(&mut self, bus: I2cBus, whom: u8, mut visit: impl FnMut(u8, &mut dyn I2cModel)) {
        let now = self.now;
        match bus {
            I2cBus::I2c1 => {
                if whom & 1 != 0 {
                    visit(1, self.eeprom.at(now));
                }
                for (index, beam) in Beam::ALL.into_iter().enumerate() {
                    let bit = 2 << index;
                    if whom & bit != 0 && self.has_ranger(beam) {
                        visit(bit, self.rangers[index].at(now));
                    }
                }
                if whom & 0x80 != 0 && self.multi_ranger {
                    visit(0x80, self.expander.at(now));
                    self.look_at_reset_lines();
                }
            }
            I2cBus::I2c2 => {}
            I2cBus::I2c3 => {
                if whom & 1 != 0 {
                    visit(1, self.imu.at(now));
                }
                if whom & 2 != 0 {
                    visit(2, self.barometer.at(now));
                }
            }
        }
    }

    /// Lets the rangers see which of them are held in reset.
    fn look_at_reset_lines(&mut self) {
        for ranger in &mut self.rangers {
            ranger.at(self.now);
        }
    }

    fn gesture(&mut self, bus: I2cBus, line: Line, level: Level) {
        let Some(wires) = self.wires(bus) else { return };
        match wires.drive(line, level) {
            Gesture::None => {}
            Gesture::Start => wires.taking_part = 0,
            Gesture::Stop => self.i2c_stop(bus),
        }
    }

    /// The flow sensor's time passes.
    fn flow_now(&mut self) -> &mut Pmw3901Model {
        let nanos = self.now - self.flow_advanced_until;
        self.flow_advanced_until = self.now;
        self.flow.advance(u32::try_from(nanos).unwrap_or(u32::MAX));
        &mut self.flow
    }

    fn select_flow(&mut self, level: Level) {
        let selected = level == Level::Low;
        if selected == self.flow_selected {
            return;
        }
        self.flow_selected = selected;
        if selected {
            self.transcript.start(self.now, Peer::Flow, false, true);
        } else {
            self.transcript.stop(Bus::Flow);
        }
        let chip = self.flow_now();
        if selected { chip.select() } else { chip.deselect() }
    }

    /// When "data ready" next changes by itself.
    fn plan_ready(&mut self) {
        let changes_in = self.imu.as_left().int3_changes_in();
        self.ready_due = match changes_in {
            Some(micros) if !self.ready_missing => self.imu.moment_in(micros),
            _ => Nanos::MAX,
        };
    }

    /// After something has happened: the radio chip's LED, and when something happens next.
    fn settle(&mut self) {
        self.leds.set(self.now, Led::Radio, self.radio.led());
        self.due = self.ready_due.min(self.radio.due()).min(self.schedule.due());
    }

    fn run_to(&mut self, now: Nanos) {
        self.now = self.now.max(now);
        self.radio.advance(self.now);
        if self.ready_due <= self.now {
            self.imu.at(self.now);
            self.plan_ready();
        }
    }
}

impl Board for Crazyflie {
    fn advance(&mut self, now: Nanos) {
        if now < self.due {
            self.now = self.now.max(now);
            self.radio.advance(self.now);
            return;
        }
        while let Some((at, turn)) = self.schedule.next(now) {
            self.run_to(at);
            self.apply(turn);
        }
        self.run_to(now);
        self.settle();
    }

    fn due(&self) -> Nanos {
        self.due
    }

    fn i2c_start(&mut self, bus: I2cBus, address: u8, read: bool) -> bool {
        let Some(wires) = self.wires(bus) else { return false };
        wires.taking_part = 0;
        if wires.is_held() {
            return false;
        }
        let mut taking_part = 0;
        self.each(bus, 0xFF, |bit, device| {
            if device.start(address, read) {
                taking_part |= bit;
            }
        });
        if let Some(wires) = self.wires(bus) {
            wires.taking_part = taking_part;
        }
        if let Some(peer) = Peer::i2c(bus, address) {
            self.transcript.start(self.now, peer, read, taking_part != 0);
        }
        taking_part != 0
    }

    /// A data line that is held low reads as an acknowledgement.
    fn i2c_write(&mut self, bus: I2cBus, byte: u8) -> bool {
        let Some(wires) = self.wires(bus) else { return false };
        if wires.is_held() {
            return wires.level(Line::Data) == Level::Low;
        }
        let whom = wires.taking_part;
        let mut acknowledged = false;
        self.each(bus, whom, |_, device| acknowledged |= device.write(byte));
        if let Some(bus) = Bus::i2c(bus) {
            self.transcript.add(bus, Some(byte), None);
        }
        if bus == I2cBus::I2c3 {
            self.plan_ready();
            self.settle();
        }
        acknowledged
    }

    fn i2c_read(&mut self, bus: I2cBus) -> u8 {
        let Some(wires) = self.wires(bus) else { return 0xFF };
        if wires.level(Line::Data) == Level::Low {
            return 0x00;
        }
        let whom = wires.taking_part;
        let mut byte = 0xFF;
        self.each(bus, whom, |_, device| byte &= device.read());
        if let Some(bus) = Bus::i2c(bus) {
            self.transcript.add(bus, None, Some(byte));
        }
        byte
    }

    fn i2c_stop(&mut self, bus: I2cBus) {
        let Some(wires) = self.wires(bus) else { return };
        wires.taking_part = 0;
        self.each(bus, 0xFF, |_, device| device.stop());
        if let Some(bus) = Bus::i2c(bus) {
            self.transcript.stop(bus);
        }
    }

    fn i2c_lines(&self, bus: I2cBus) -> (bool, bool) {
        match bus {
            I2cBus::I2c1 => self.deck_wires.released(),
            I2cBus::I2c2 => (true, true),
            I2cBus::I2c3 => self.sensor_wires.released(),
        }
    }

    /// A line that no device drives reads as ones, as with a pull-up.
    fn spi_exchange(&mut self, bus: SpiBus, byte: u8) -> u8 {
        match bus {
            SpiBus::Spi1 if self.flow_deck && self.flow_selected => {
                let answer = self.flow_now().transfer(byte);
                self.transcript.add(Bus::Flow, Some(byte), Some(answer));
                answer
            }
            SpiBus::Spi1 => 0xFF,
        }
    }

    fn uart_take(&mut self, bus: UartBus, byte: u8, bit: u32) {
        match bus {
            UartBus::Usart6 => self.radio.take(self.now, byte, bit),
        }
        self.settle();
    }

    fn uart_give(&mut self, bus: UartBus) -> Option<UartByte> {
        let byte = match bus {
            UartBus::Usart6 => self.radio.give(self.now),
        };
        self.settle();
        byte
    }

    fn drive(&mut self, pin: Pin, level: Level) {
        match wire(pin) {
            Some(Wire::I2c(bus, line)) => self.gesture(bus, line, level),
            Some(Wire::FlowSelect) => self.select_flow(level),
            Some(Wire::DataReady | Wire::Wait) => {}
            None => self.leds.drive(self.now, pin, level),
        }
    }

    fn level(&self, pin: Pin) -> Level {
        match wire(pin) {
            Some(Wire::I2c(I2cBus::I2c1, line)) => self.deck_wires.level(line),
            Some(Wire::I2c(_, line)) => self.sensor_wires.level(line),
            Some(Wire::DataReady) if self.ready_missing => Level::Low,
            Some(Wire::DataReady) => match self.imu.as_left().int3() {
                Some(true) => Level::High,
                Some(false) => Level::Low,
                None => Level::Released,
            },
            Some(Wire::Wait) => self.radio.wait(),
            Some(Wire::FlowSelect) | None => Level::Released,
        }
    }
}

/// The target of a pin, LEDs left out.
#[derive(Clone, Copy)]
enum Wire {
    I2c(I2cBus, Line),
    FlowSelect,
    DataReady,
    Wait,
}

fn wire(pin: Pin) -> Option<Wire> {
    const A: usize = 0;
    const B: usize = 1;
    const C: usize = 2;
    match (pin.port(), pin.number()) {
        (A, 8) => Some(Wire::I2c(I2cBus::I2c3, Line::Clock)),
        (C, 9) => Some(Wire::I2c(I2cBus::I2c3, Line::Data)),
        (B, 6) => Some(Wire::I2c(I2cBus::I2c1, Line::Clock)),
        (B, 7) => Some(Wire::I2c(I2cBus::I2c1, Line::Data)),
        (B, 4) => Some(Wire::FlowSelect),
        (C, 14) => Some(Wire::DataReady),
        (A, 4) => Some(Wire::Wait),
        _ => None,
    }
}

/// The expander's line that holds a ranger in reset.
const fn reset_line(beam: Beam) -> Option<Lines> {
    match beam {
        Beam::Down => None,
        Beam::Front => Some(Lines::FRONT),
        Beam::Back => Some(Lines::BACK),
        Beam::Up => Some(Lines::UP),
        Beam::Left => Some(Lines::LEFT),
        Beam::Right => Some(Lines::RIGHT),
    }
}

/// In the order of [`Beam::ALL`].
const fn beam_index(beam: Beam) -> usize {
    match beam {
        Beam::Down => 0,
        Beam::Front => 1,
        Beam::Back => 2,
        Beam::Up => 3,
        Beam::Left => 4,
        Beam::Right => 5,
    }
}

fn fill(eeprom: &mut EepromModel, at: u16, bytes: &[u8]) {
    for (slot, byte) in eeprom.bytes_mut().iter_mut().skip(at.into()).zip(bytes) {
        *slot = *byte;
    }
}
