//! Drives a board by hand in the tests: a controller on its I²C buses, and a flight processor
//! at the radio chip's line.

mod faults;
mod radio;
mod sensors;

use virtual_crazyflie::board::{Config, Crazyflie};
use virtual_crazyflie::soc::{Board, I2cBus, Level, Nanos, Pin, UartBus, UartByte};

pub(crate) const US: Nanos = 1_000;
pub(crate) const MS: Nanos = 1_000_000;
/// A byte and its acknowledgement at 400 kHz.
const I2C_BYTE: Nanos = 22_500;

pub(crate) const SENSORS: I2cBus = I2cBus::I2c3;
pub(crate) const DECKS: I2cBus = I2cBus::I2c1;

/// A board, and the time.
pub(crate) struct Bench {
    pub(crate) board: Crazyflie,
    pub(crate) now: Nanos,
    /// Bytes that came from the radio chip.
    pub(crate) heard: Vec<UartByte>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::with(&Config::default())
    }

    pub(crate) fn with(config: &Config) -> Self {
        Self { board: Crazyflie::new(config), now: 0, heard: Vec::new() }
    }

    /// Runs to a moment as the chip does: from one thing that happens to the next.
    pub(crate) fn run_to(&mut self, until: Nanos) {
        while self.board.due() <= until {
            let due = self.board.due().max(self.now);
            self.board.advance(due);
            self.now = due;
            self.listen();
            assert!(self.board.due() > due, "something is due for ever");
        }
        self.now = self.now.max(until);
        self.board.advance(self.now);
    }

    pub(crate) fn wait(&mut self, time: Nanos) {
        self.run_to(self.now + time);
    }

    fn listen(&mut self) {
        while let Some(byte) = self.board.uart_give(UartBus::Usart6) {
            self.heard.push(byte);
        }
    }

    /// Writes; whether everything was acknowledged.
    pub(crate) fn write(&mut self, bus: I2cBus, address: u8, bytes: &[u8]) -> bool {
        let mut good = self.board.i2c_start(bus, address, false);
        self.wait(I2C_BYTE);
        for byte in bytes {
            if good {
                good = self.board.i2c_write(bus, *byte);
                self.wait(I2C_BYTE);
            }
        }
        self.board.i2c_stop(bus);
        good
    }

    /// Writes and then reads; `None` where something was not acknowledged.
    pub(crate) fn read(
        &mut self,
        bus: I2cBus,
        address: u8,
        register: &[u8],
        count: usize,
    ) -> Option<Vec<u8>> {
        let mut good = self.board.i2c_start(bus, address, false);
        self.wait(I2C_BYTE);
        for byte in register {
            good = good && self.board.i2c_write(bus, *byte);
            self.wait(I2C_BYTE);
        }
        good = good && self.board.i2c_start(bus, address, true);
        self.wait(I2C_BYTE);
        let bytes = good.then(|| {
            (0..count)
                .map(|_| {
                    let byte = self.board.i2c_read(bus);
                    self.wait(I2C_BYTE);
                    byte
                })
                .collect()
        });
        self.board.i2c_stop(bus);
        bytes
    }

    pub(crate) fn answers(&mut self, bus: I2cBus, address: u8) -> bool {
        self.write(bus, address, &[])
    }

    /// What answers on a bus.
    pub(crate) fn addresses(&mut self, bus: I2cBus) -> Vec<u8> {
        (0x08..0x78).filter(|address| self.answers(bus, *address)).collect()
    }

    pub(crate) fn is_high(&self, port: char, number: u8) -> bool {
        self.board.level(Pin::new(port, number)) == Level::High
    }

    pub(crate) fn drive(&mut self, port: char, number: u8, level: Level) {
        self.board.drive(Pin::new(port, number), level);
    }

    /// Brings the inertial sensor up as the firmware does: 1000 samples a second, signalled on INT3.
    pub(crate) fn start_imu(&mut self) {
        for (register, value) in
            [(0x11, 0x00), (0x0F, 0x00), (0x10, 0x02), (0x16, 0x0D), (0x18, 0x01), (0x15, 0x80)]
        {
            assert!(self.write(SENSORS, 0x69, &[register, value]));
        }
        for (register, value) in [(0x7C, 0x00), (0x7D, 0x04), (0x40, 0x8C), (0x41, 0x03)] {
            assert!(self.write(SENSORS, 0x18, &[register, value]));
        }
    }

    pub(crate) fn axes(&mut self, address: u8, register: u8) -> Option<[i16; 3]> {
        let bytes = self.read(SENSORS, address, &[register], 6)?;
        let axis = |at| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        Some([axis(0), axis(2), axis(4)])
    }

    /// Lets a ranger range: 20 ms and a little, over and over.
    pub(crate) fn start_ranger(&mut self, address: u8) {
        for (register, bytes) in [
            (0x005E_u16, &[0x00, 0x1E, 0x0F, 0x00, 0x22, 0x0D][..]),
            (0x006C, &[0, 0, 0, 0]),
            (0x0086, &[0x01]),
            (0x0087, &[0x40]),
        ] {
            let mut all = register.to_be_bytes().to_vec();
            all.extend_from_slice(bytes);
            assert!(self.write(DECKS, address, &all));
        }
    }

    /// The 17 bytes of a ranger's result.
    pub(crate) fn result(&mut self, address: u8) -> Vec<u8> {
        self.read(DECKS, address, &[0x00, 0x89], 17).unwrap()
    }

    /// Sends a frame to the radio chip at 1 Mbaud.
    pub(crate) fn send(&mut self, kind: u8, data: &[u8]) {
        self.send_bytes(&frame(kind, data));
    }

    /// Sends a frame to the radio chip and gives it the time to read it.
    pub(crate) fn tell(&mut self, kind: u8, data: &[u8]) {
        self.send(kind, data);
        self.wait(MS);
    }

    pub(crate) fn send_bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.wait(10 * US);
            self.board.uart_take(UartBus::Usart6, *byte, 1_000);
            self.listen();
        }
    }

    /// The frames that came in since the last look, with the moment at which each began.
    pub(crate) fn frames(&mut self) -> Vec<(Nanos, u8, Vec<u8>)> {
        let bytes = std::mem::take(&mut self.heard);
        let mut rest = &bytes[..];
        let mut frames = Vec::new();
        while let [start, _, kind, length, ..] = rest {
            let length = usize::from(length.data);
            let (whole, behind) = rest.split_at(6 + length);
            let data: Vec<u8> = whole[4..4 + length].iter().map(|byte| byte.data).collect();
            let line: Vec<u8> = whole.iter().map(|byte| byte.data).collect();
            assert_eq!(line, frame(kind.data, &data));
            frames.push((start.at, kind.data, data));
            rest = behind;
        }
        assert!(rest.is_empty(), "{rest:?}");
        frames
    }
}

/// A frame, by the letter of the vendor's document.
pub(crate) fn frame(kind: u8, data: &[u8]) -> Vec<u8> {
    let mut sealed = vec![kind, data.len() as u8];
    sealed.extend_from_slice(data);
    let (a, b) = sealed.iter().fold((0_u8, 0_u8), |(a, b), byte| {
        let a = a.wrapping_add(*byte);
        (a, b.wrapping_add(a))
    });
    [&[0xBC, 0xCF][..], &sealed, &[a, b]].concat()
}
