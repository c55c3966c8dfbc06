//! Carries out commands that reach the radio chip from the flight processor or over the air
//! (crazyflie2-nrf-firmware, `main.c`: `handleSyslinkEvents`, `handleRadioCmd`,
//! `handleBootloaderCmd`).

use super::frame::{MTU, kind};
use super::power::{OffCause, Shutdown};
use super::{Counters, Datarate, MAX_P2P, Nrf51, Sent, TUNING};

impl Nrf51 {
    /// A frame of the flight processor's.
    pub(super) fn handle(&mut self, kind: u8, data: &[u8]) {
        match (kind, data) {
            (kind::RAW, _) if data.len() < MTU => self.leave_for_ground(data.to_vec()),
            (kind::CHANNEL, [channel]) => {
                self.state.radio.set_channel(*channel);
                self.reset_radio(kind, data);
            }
            (kind::DATARATE, [code]) => {
                self.set_datarate(*code);
                self.reset_radio(kind, data);
            }
            (kind::CARRIER, [on]) => {
                self.state.radio.carrier = *on != 0;
                self.reset_radio(kind, data);
            }
            (kind::ADDRESS, &[a, b, c, d, e]) => {
                self.state.radio.tuning.address = [a, b, c, d, e];
                self.reset_radio(kind, data);
            }
            (kind::POWER, [power]) => {
                self.state.radio.set_power(power.cast_signed());
                self.reset_radio(kind, data);
            }
            (kind::P2P_BROADCAST, [port, data @ ..]) if data.len() <= MAX_P2P => {
                self.broadcast(*port, data);
            }
            (kind::READY, _) => {
                self.state.radio.ready = true;
                self.say(kind, &[]);
            }
            (kind::SWITCH_OFF, _) => self.switch_off(OffCause::Agreed),
            (kind::PROCESSOR_OFF, _) => self.switch_processor_off(),
            (kind::AUTOUPDATE, _) => self.state.reports = true,
            (kind::SHUTDOWN_ACK, _) => {
                if let Shutdown::Asked { .. } = self.state.shutdown {
                    self.switch_off(OffCause::Agreed);
                }
            }
            (kind::LED_ON, _) => self.led = true,
            (kind::LED_OFF, _) => self.led = false,
            (kind::VERSION, _) => {
                let mut text = self.version.clone().into_bytes();
                text.truncate(MTU - 1);
                text.push(0);
                self.say(kind, &text);
            }
            (kind::PROBE, _) => self.answer_probe(),
            (kind::MEMORY_SCAN, _) => self.say(kind, &[self.memories.len() as u8]),
            (kind::MEMORY_INFO, &[number, ..]) => self.tell_serial(number),
            (kind::MEMORY_READ, &[number, low, high, ..]) => {
                self.read_memory(number, u16::from_le_bytes([low, high]));
            }
            // A chip that can do Bluetooth does not write them.
            (kind::MEMORY_WRITE, _) => self.say(kind, &[0xFE]),
            _ => {
                self.state.counters.not_understood += 1;
                self.state.counters.last_not_understood = Some(kind);
            }
        }
    }

    /// Resets the radio for a setting, and confirms it. In Bluetooth mode the radio is the
    /// SoftDevice's, and is reset all the same (`esb.c`, `esbReset`). On a real chip that goes well
    /// nearly always, and then switches the drone off (crazyflie2-nrf-firmware #62,
    /// crazyflie-firmware #670 and #857). Here it goes well for the settings that the vendor's
    /// firmware sends at each boot, channel, data rate and address (crazyflie-firmware,
    /// `radiolink.c`, `radiolinkInit`), once more each for an answer that the line has damaged, and
    /// never beyond them: so no test passes by luck.
    fn reset_radio(&mut self, kind: u8, data: &[u8]) {
        let place =
            [kind::CHANNEL, kind::ADDRESS, kind::DATARATE].iter().position(|is| *is == kind);
        let count = place.and_then(|at| self.state.configured.get_mut(at));
        let times = count.map_or(u8::MAX, |count| {
            *count = count.saturating_add(1);
            *count
        });
        if self.state.bluetooth && times > 2 {
            self.switch_off(OffCause::Bluetooth);
        } else {
            self.restart_radio();
            self.say(kind, data);
        }
    }

    /// Powers the radio off and on.
    fn restart_radio(&mut self) {
        self.state.radio.restart(self.clock);
        self.state.main_loop.work(TUNING);
    }

    /// Answers with the serial number of a deck's memory; minus one stands for none.
    fn tell_serial(&mut self, number: u8) {
        let mut answer = vec![number];
        match self.memories.get(usize::from(number)) {
            Some(memory) => answer.extend_from_slice(&memory.serial),
            None => answer = vec![0xFF],
        }
        self.say(kind::MEMORY_INFO, &answer);
    }

    /// Answers with 29 bytes of a deck's memory, which the chip has read when it started.
    fn read_memory(&mut self, number: u8, address: u16) {
        const LENGTH: usize = 29;
        let mut answer = vec![number];
        answer.extend_from_slice(&address.to_le_bytes());
        match self.memories.get(usize::from(number)) {
            Some(memory) => {
                let bytes = memory.bytes.iter().skip(address.into()).chain(&[0xFF; LENGTH]);
                answer.extend(bytes.take(LENGTH));
            }
            None => answer = vec![0xFF],
        }
        self.say(kind::MEMORY_READ, &answer);
    }

    /// Answers the request by which a test of the board probes the radio.
    fn answer_probe(&mut self) {
        let [channel, address, rate] = self.state.configured;
        let Counters { bad_first_sums, bad_second_sums, dropped_bytes, broken_bytes, .. } =
            self.counters();
        // The framing error is the only one that there is here (nRF51 reference manual, ERRORSRC).
        let error = if broken_bytes == 0 { 0 } else { 4 };
        let data = [
            u8::from(address > 0),
            u8::from(channel > 0),
            u8::from(rate > 0),
            dropped_bytes as u8,
            error,
            broken_bytes as u8,
            bad_first_sums as u8,
            bad_second_sums as u8,
        ];
        self.say(kind::PROBE, &data);
    }

    /// A code that is none stands for 1 Mbit/s (`esbSetDatarate`).
    const fn set_datarate(&mut self, code: u8) {
        self.state.radio.tuning.datarate = match code {
            0 => Datarate::K250,
            2 => Datarate::M2,
            _ => Datarate::M1,
        };
    }

    fn leave_for_ground(&mut self, data: Vec<u8>) {
        if !self.state.radio.queue(data) {
            self.state.counters.refused += 1;
        }
    }

    /// Sends a packet without a queue, in any state of the radio (`esbSendP2PPacket`).
    fn broadcast(&mut self, port: u8, data: &[u8]) {
        self.state.bluetooth = false;
        let (at, tuning) = (self.clock, self.state.radio.tuning);
        self.state.radio.send(at, data.len());
        let (port, data) = if self.ghosts {
            let Some((port, data)) = self.state.radio.oldest_p2p() else { return };
            (port, data.to_vec())
        } else {
            (port & 0x0F, data.to_vec())
        };
        self.sent.push(Sent { at, port, data, tuning });
    }

    /// Carries out a command that came over the air.
    pub(super) fn obey(&mut self, data: &[u8]) {
        match *data {
            [_, 0x03, 1, channel, ..] => {
                self.state.radio.set_channel(channel);
                self.restart_radio();
            }
            [_, 0x03, 2, code, ..] => {
                self.set_datarate(code);
                self.restart_radio();
            }
            [_, 0xFE, 0x01, ..] => self.switch_off(OffCause::Ordered),
            [_, 0xFE, 0x04, ..] => {
                let mut answer = vec![0xFF, 0xFE, 0x04];
                answer.extend_from_slice(&self.battery.volts(self.clock).to_le_bytes());
                self.leave_for_ground(answer);
            }
            // The chip's own address, which no two chips share; here it is the same for all.
            [_, 0xFE, 0xFF, ..] => {
                self.leave_for_ground(vec![0xFF, 0xFE, 0xFF, 1, 2, 3, 4, 5, 6]);
            }
            [_, 0xFE, 0x05, ..] => self.led = true,
            [_, 0xFE, 0x06, ..] => self.led = false,
            _ => self.state.counters.commands += 1,
        }
    }
}
