//! The board's inputs and outputs: a simulator sets the sensors' readings and takes what is sent.
//!
//! A value that is set counts from the board's moment on, which is that of its last
//! [`advance`](crate::soc::Board::advance): advance it to the moment first.

use sensors::multi_ranger::Beam;
use sensors::vl53l1x::{CountRate, RangeStatus};
use units::{Acceleration, AngularVelocity, Dbm, Metres, Volts};

use super::faults::Fault;
use super::leds::{Blink, Led};
use super::nrf51::{Answer, Power, Sent};
use super::radio_chip::{Heard, RadioChip, What};
use super::transcript::Transfer;
use super::{Crazyflie, beam_index};
use crate::soc::{Board as _, Nanos};

/// The motion that the flow sensor sees from one reading to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flow {
    /// Counts along the chip's own axes, which are not the drone's: as the Flow deck v2 mounts it,
    /// Δx falls as the drone moves to the left,
    pub dx: i16,
    /// and Δy as it moves forward (see [`Motion`](sensors::pmw3901::Motion)). Counts add up until
    /// they are read.
    pub dy: i16,
    /// Surface quality: a quarter of the features seen.
    pub squal: u8,
    /// Exposure, in cycles of the chip's clock.
    pub shutter: u16,
    /// Mean brightness of the image,
    pub raw_sum: u8,
    /// its brightest pixel,
    pub raw_max: u8,
    /// and its darkest.
    pub raw_min: u8,
}

/// The result of a ranger's measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The distance.
    pub distance: Metres,
    /// The standard deviation that the sensor reports.
    pub sigma: Metres,
    /// The status of the measurement.
    pub status: RangeStatus,
    /// The signal rate of the reflected light.
    pub signal: CountRate,
    /// The light that is there anyway.
    pub ambient: CountRate,
}

/// The device's own code (ST's `VL53L1X_GetRangeStatus`, read backwards).
const fn code(status: RangeStatus) -> u8 {
    match status {
        RangeStatus::Valid => 9,
        RangeStatus::Unchecked => 19,
        RangeStatus::SigmaFail => 6,
        RangeStatus::SignalFail => 4,
        RangeStatus::MinRangeClipped => 8,
        RangeStatus::OutOfBounds => 5,
        RangeStatus::WrapTarget => 7,
        RangeStatus::Crosstalk => 12,
        RangeStatus::Synchronisation => 18,
        RangeStatus::MergedPulse => 22,
        RangeStatus::LackOfSignal => 23,
        RangeStatus::MinRangeFail => 13,
        RangeStatus::Hardware(code) | RangeStatus::Other(code) => code,
    }
}

/// The radio chip's way to say how strong a packet was: −dBm, in seven bits.
fn sample(rssi: Dbm) -> u8 {
    // `as` saturates.
    ((-rssi.0 + 0.5) as u8).min(127)
}

impl Crazyflie {
    /// What the inertial sensor measures: about and along the chip's axes, which are the drone's,
    /// x forward, y left, z up; a drone that stands still feels +9.81 m/s² on z. What is beyond a
    /// range is cut off as the chip does. Noise is the world's to add, or
    /// [`Config::noise`](super::Config::noise).
    pub fn set_inertia(&mut self, turning: AngularVelocity, force: Acceleration) {
        self.inertia = (turning, force);
        if !self.imu_frozen {
            self.imu.at(self.now).set(turning, force);
        }
    }

    /// The flow sensor sees the ground move.
    pub fn push_flow(&mut self, flow: Flow) {
        let chip = &mut self.flow;
        chip.push(flow.dx, flow.dy);
        chip.squal = flow.squal;
        chip.shutter = flow.shutter;
        (chip.raw_sum, chip.raw_max, chip.raw_min) = (flow.raw_sum, flow.raw_max, flow.raw_min);
    }

    /// Sets the result of a ranger's measurements from now on.
    pub fn set_range(&mut self, beam: Beam, sight: Sight) {
        let ranger = self.rangers[beam_index(beam)].at(self.now);
        ranger.distance = sight.distance;
        ranger.sigma = sight.sigma;
        ranger.status = Some(code(sight.status));
        (ranger.signal, ranger.ambient) = (sight.signal, sight.ambient);
    }

    /// Whether a ranger ends a measurement within so many ns, so that what it finds must be known.
    #[must_use]
    pub fn wants_range(&mut self, beam: Beam, within: Nanos) -> bool {
        if !self.has_ranger(beam) {
            return false;
        }
        let ranger = &mut self.rangers[beam_index(beam)];
        match ranger.at(self.now).until_result() {
            Some(micros) => ranger.moment_in(micros) <= self.now.saturating_add(within),
            None => false,
        }
    }

    /// The battery, as the radio chip measures it.
    pub fn set_battery(&mut self, voltage: Volts, charging: bool, usb: bool) {
        self.radio.set_battery(self.now, voltage.0, charging, usb);
    }

    /// The power button is pressed for a moment.
    pub fn press_button(&mut self) {
        self.radio.press(self.now);
        self.settle();
    }

    /// Whether the processor has power. Once it has not, nothing here happens any more.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.radio.power()
    }

    /// The radio chip, to look at.
    #[must_use]
    pub const fn radio(&self) -> &RadioChip {
        &self.radio
    }

    /// The packets for other drones that were sent since this was last called.
    #[must_use]
    pub fn take_packets(&mut self) -> Vec<Sent> {
        self.radio.take_sent()
    }

    /// The packets with which the chip has acknowledged those of the ground since the last call:
    /// one for each that it received.
    #[must_use]
    pub fn take_crtp(&mut self) -> Vec<Answer> {
        self.radio.take_answers()
    }

    /// Another drone's packet has come off the air at that moment, to all. Of more than 60 bytes
    /// the rest is left out. A moment that is past is now.
    pub fn hear(&mut self, at: Nanos, port: u8, data: &[u8], rssi: Dbm) {
        self.hear_what(at, What::P2p { port, data, broadcast: true }, rssi);
    }

    /// Receives a packet that was sent to this drone alone, as a ground station can send it.
    pub fn hear_alone(&mut self, at: Nanos, port: u8, data: &[u8], rssi: Dbm) {
        self.hear_what(at, What::P2p { port, data, broadcast: false }, rssi);
    }

    /// A packet of the ground's, header first, has come off the air at that moment.
    pub fn hear_crtp(&mut self, at: Nanos, data: &[u8], rssi: Dbm) {
        self.hear_what(at, What::Crtp(data), rssi);
    }

    fn hear_what(&mut self, at: Nanos, what: What<'_>, rssi: Dbm) {
        self.radio.hear(self.now, &Heard { at, rssi: sample(rssi), what });
        self.settle();
    }

    /// Lets something be wrong for a time; `until` may be `u64::MAX`. Of two faults of one device
    /// that overlap, the later replaces the earlier, and the end of either ends both.
    pub fn inject(&mut self, fault: Fault, from: Nanos, until: Nanos) {
        self.schedule.add(fault, from, until);
        self.settle();
        self.advance(self.now);
    }

    /// Records the traffic on the sensor buses from now on.
    pub fn record_transfers(&mut self) {
        self.transcript.begin();
    }

    /// The traffic on the sensor buses since the last call, if it is recorded.
    #[must_use]
    pub fn take_transfers(&mut self) -> Vec<Transfer> {
        self.transcript.take()
    }

    /// Whether an LED is lit.
    #[must_use]
    pub fn is_lit(&self, led: Led) -> bool {
        self.leds.is_lit(led)
    }

    /// The changes of the LEDs since the last call, the latest 4096 of them.
    #[must_use]
    pub fn take_blinks(&mut self) -> Vec<Blink> {
        self.leds.take_log()
    }

    /// The EEPROM's content.
    #[must_use]
    pub const fn eeprom(&self) -> &[u8; sensors::eeprom::SIZE as usize] {
        self.eeprom.as_left().bytes()
    }

    /// How often the flow sensor was given less time between two bytes than it needs.
    #[must_use]
    pub const fn flow_violations(&self) -> u32 {
        self.flow.violations()
    }
}
