//! Computes how long a packet takes from the processor of one drone to the processor of another.
//!
//! The processor hands a packet to the radio chip over a serial line; the radio chip sends it; the
//! radio chip of each receiver hands it on over another such line.

use wire::radio::Datarate;

/// Microseconds of a byte on the serial line: 1 Mbaud, 8N1 (crazyflie-firmware, `uart_syslink.c`).
const LINE_US_PER_BYTE: u64 = 10;
/// Bytes of a syslink frame around the packet's data: two start bytes, type, length, port and two
/// bytes of checksum (crazyflie2-nrf-firmware, `docs/protocols/syslink.md`),
const FRAME_OUT: u64 = 7;
/// and one more, the strength, on the way in.
const FRAME_IN: u64 = 8;
/// Bytes of a packet on the air before its data: its kind and its port.
const AIR_HEAD: u64 = 2;
/// Bits of a packet on the air: a byte of preamble, five of address, nine bits of control, the
/// payload, two bytes of checksum (nRF24L01+ product specification, 7.3: Enhanced ShockBurst).
const AIR_BITS: u64 = 8 * (1 + 5 + 2) + 9;
/// The radio turns round between receiving and sending in this time: nRF51822 product
/// specification, 8.5 (130 µs to transmit, 130 µs to receive).
pub(crate) const TURN_US: u64 = 130;

/// Bits per millisecond.
const fn rate(datarate: Datarate) -> u64 {
    match datarate {
        Datarate::Kbit250 => 250,
        Datarate::Mbit1 => 1_000,
        Datarate::Mbit2 => 2_000,
    }
}

/// Microseconds from the sender's processor to its radio.
pub(super) const fn line_out_us(data: usize) -> u64 {
    LINE_US_PER_BYTE * (FRAME_OUT + data as u64)
}

/// Microseconds from the receiver's radio to its processor.
pub(crate) const fn line_in_us(data: usize) -> u64 {
    LINE_US_PER_BYTE * (FRAME_IN + data as u64)
}

/// Microseconds that so many bytes of a P2P packet's data are on the air.
#[must_use]
pub const fn air_us(datarate: Datarate, data: usize) -> u64 {
    raw_air_us(datarate, AIR_HEAD + data as u64)
}

/// The same of any packet's payload.
pub(super) const fn raw_air_us(datarate: Datarate, payload: u64) -> u64 {
    ((AIR_BITS + 8 * payload) * 1_000).div_ceil(rate(datarate))
}

/// Microseconds from one processor to the other.
#[must_use]
pub const fn flight_us(datarate: Datarate, data: usize) -> u64 {
    line_out_us(data) + TURN_US + air_us(datarate, data) + line_in_us(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 67 bytes out, 130 µs, 62 + 8 bytes and 9 bits at 2 Mbit/s, 68 bytes in.
    #[test]
    fn the_longest_packet_takes_one_and_three_quarter_milliseconds() {
        assert_eq!(air_us(Datarate::Mbit2, 60), 285);
        assert_eq!(flight_us(Datarate::Mbit2, 60), 670 + 130 + 285 + 680);
        assert_eq!(air_us(Datarate::Kbit250, 60), 2_276);
    }
}
