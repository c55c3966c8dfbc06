//! Computes how long a P2P packet takes from the processor of one drone to the processor of another.
//!
//! The processor hands the packet to its radio chip over a serial line, the radio chip sends it, and
//! the radio chip of each receiver hands it on over another such line.

use super::Datarate;

/// Microseconds of a byte on the serial line: 1 Mbaud, 8N1 (crazyflie-firmware, `uart_syslink.c`).
pub const LINE_US_PER_BYTE: u64 = 10;
/// Bytes of a syslink frame around a packet's data on the way out: two start bytes, type, length,
/// port and two bytes of checksum (crazyflie2-nrf-firmware, `docs/protocols/syslink.md`).
const LINE_OUT: u64 = 7;
/// Bytes of a syslink frame around a packet's data on the way in: those above, and the signal
/// strength.
const LINE_IN: u64 = 8;

/// Microseconds from the command to send to the first bit on the air: 140 µs for the nRF51. To
/// receive takes 138 µs, for which this constant stands as well (zephyr, `radio_nrf51.h`:
/// `HAL_RADIO_NRF51_TXEN_TXIDLE_TX_US` and `HAL_RADIO_NRF51_RXEN_RXIDLE_RX_US`).
pub const RAMP_UP_US: u64 = 140;

/// Bits of a packet until a receiver has found its address: a byte of preamble and five of address
/// (crazyflie2-nrf-firmware, `esb.c`).
const ADDRESS_BITS: u64 = 8 * (1 + 5);
/// Bits of a packet on the air around its payload: preamble and address, the nine bits of the packet
/// control field, and two bytes of checksum (nRF24L01+ product specification, 7.3: Enhanced
/// ShockBurst).
const AROUND_BITS: u64 = ADDRESS_BITS + 9 + 8 * 2;
/// Bytes of a P2P packet's payload before its data: its kind and its port (`esb.c`).
const P2P_HEAD: u64 = 2;

/// Bits of a P2P packet with so many bytes of data, from the preamble to the checksum.
#[must_use]
pub const fn air_bits(data: usize) -> u64 {
    AROUND_BITS + 8 * (P2P_HEAD + data as u64)
}

/// Microseconds that so many bits take.
const fn bits_us(datarate: Datarate, bits: u64) -> u64 {
    (bits * datarate.two_bits_us() as u64).div_ceil(2)
}

/// Microseconds that a P2P packet with so many bytes of data is on the air.
#[must_use]
pub const fn air_us(datarate: Datarate, data: usize) -> u64 {
    bits_us(datarate, air_bits(data))
}

/// Microseconds that a packet of any kind with so many bytes of payload is on the air.
#[must_use]
pub const fn payload_air_us(datarate: Datarate, payload: usize) -> u64 {
    bits_us(datarate, AROUND_BITS + 8 * payload as u64)
}

/// Microseconds from the first bit of a packet until a receiver has found its address.
#[must_use]
pub const fn address_us(datarate: Datarate) -> u64 {
    bits_us(datarate, ADDRESS_BITS)
}

/// Microseconds from the sender's processor to its radio chip.
#[must_use]
pub const fn line_out_us(data: usize) -> u64 {
    LINE_US_PER_BYTE * (LINE_OUT + data as u64)
}

/// Microseconds from the receiver's radio chip to its processor.
#[must_use]
pub const fn line_in_us(data: usize) -> u64 {
    LINE_US_PER_BYTE * (LINE_IN + data as u64)
}

/// Microseconds from the first byte on the sender's serial line to the end of the packet on the air.
#[must_use]
pub const fn sending_us(datarate: Datarate, data: usize) -> u64 {
    line_out_us(data) + RAMP_UP_US + air_us(datarate, data)
}

/// Microseconds from one processor to the other.
#[must_use]
pub const fn flight_us(datarate: Datarate, data: usize) -> u64 {
    sending_us(datarate, data) + line_in_us(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 67 bytes out, 140 µs, 62 + 8 bytes and 9 bits at 2 Mbit/s, 68 bytes in.
    #[test]
    fn the_longest_packet_takes_one_and_three_quarter_milliseconds() {
        assert_eq!(air_us(Datarate::Mbit2, 60), 285);
        assert_eq!(flight_us(Datarate::Mbit2, 60), 670 + 140 + 285 + 680);
        assert_eq!(air_us(Datarate::Kbit250, 60), 2_276);
        assert_eq!(address_us(Datarate::Mbit1), 48);
    }
}
