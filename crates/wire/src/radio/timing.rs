//! Computes how long a P2P packet takes from the processor of one drone to the processor of another.
//!
//! The processor hands the packet to its radio chip over a serial line, the radio chip sends it, and
//! the radio chip of each receiver hands it on over another such line.
//!
//! The chip's program takes a byte from the line in an interrupt and reads it in its main loop, both
//! on a core of 16 MHz. Together they take longer than the line: when the last byte of a packet has
//! come, the loop still has the rest of the packet to read, the more the longer the packet is. A
//! packet that comes to the loop, from the line or off the air, waits for the loop's next round. The
//! figures are those of the vendor's program (crazyflie2-nrf-firmware, 32b6ecb, without Bluetooth) on
//! an emulated chip, as the page "The virtual Crazyflie" of the book has them.

use super::Datarate;

/// Microseconds of a byte on the serial line to the chip: 1 Mbaud, 8N1 (crazyflie-firmware,
/// `uart_syslink.c`).
pub const LINE_US_PER_BYTE: u64 = 10;
/// Bytes of a syslink frame around a packet's data on the way out: two start bytes, type, length,
/// port and two bytes of checksum (crazyflie2-nrf-firmware, `docs/protocols/syslink.md`).
const LINE_OUT: u64 = 7;
/// Bytes of a syslink frame around a packet's data on the way in: those above, and the signal
/// strength.
const LINE_IN: u64 = 8;

/// Nanoseconds of a round of the chip's main loop that has nothing to do.
pub const ROUND_NS: u64 = 56_600;
/// Nanoseconds of the core that the interrupt takes for a byte from the line.
pub const INTERRUPT_NS: u64 = 6_300;
/// Nanoseconds of the core that the main loop takes to read a byte from the line.
pub const PARSING_NS: u64 = 7_000;
/// Nanoseconds from the last byte of a frame that is read to the command to send, without
/// [`COPYING_NS`].
pub const HANDLING_NS: u64 = 15_600;
/// Nanoseconds for each byte of data that is copied on the way to the radio.
pub const COPYING_NS: u64 = 930;
/// Nanoseconds from the moment at which the loop finds a packet off the air until it begins to send it
/// to the processor.
pub const PASSING_ON_NS: u64 = 51_000;
/// Nanoseconds from one byte that the chip sends to the processor to the next: it waits for each, and
/// fetches the next one only then.
pub const LINE_IN_NS_PER_BYTE: u64 = 12_700;
/// The battery and the signal strength are told every ten milliseconds, one behind the other, which
/// keeps the main loop for so many microseconds.
pub const REPORTS_US: u64 = 267;

/// Microseconds from the end of a packet that the chip acknowledges to the acknowledgement's first bit:
/// 18 of the interrupt, and the ramp-up.
pub const ANSWERS_AFTER_US: u64 = 158;
/// Microseconds from the end of an acknowledgement, or of a packet of its own, until the chip's radio
/// receives again: 6 of the interrupt, and 138 of ramp-up.
pub const LISTENS_AFTER_US: u64 = 144;

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

/// Microseconds that a packet's frame takes on the line from the sender's processor to its radio
/// chip.
#[must_use]
pub const fn line_out_us(data: usize) -> u64 {
    LINE_US_PER_BYTE * (LINE_OUT + data as u64)
}

/// Nanoseconds that a frame with so many bytes takes on the line from the chip to its processor.
#[must_use]
pub const fn frame_in_ns(bytes: u64) -> u64 {
    LINE_IN_NS_PER_BYTE * bytes.saturating_sub(1) + 1_000 * LINE_US_PER_BYTE
}

/// Microseconds that a packet's frame takes on the line from the receiver's radio chip to its
/// processor.
#[must_use]
pub const fn line_in_us(data: usize) -> u64 {
    frame_in_ns(LINE_IN + data as u64).div_ceil(1_000)
}

/// Nanoseconds from the first byte on the line to the command to send, where the main loop looks for
/// the packet's first byte after `round` ns of work on other things.
const fn handed_ns(data: usize, round: u64) -> u64 {
    let (bytes, data) = (LINE_OUT + data as u64, data as u64);
    bytes * (INTERRUPT_NS + PARSING_NS) + round + HANDLING_NS + COPYING_NS * data
}

/// The fewest microseconds from the first byte on the line to the command to send.
#[must_use]
pub const fn handed_soonest_us(data: usize) -> u64 {
    handed_ns(data, 0) / 1_000
}

/// The most microseconds from the first byte on the line to the command to send, unless the chip has
/// something else to do than the round in which the packet comes.
#[must_use]
pub const fn handed_latest_us(data: usize) -> u64 {
    handed_ns(data, ROUND_NS).div_ceil(1_000)
}

/// The fewest microseconds from the end of a packet on the air to its last byte at the receiver's
/// processor.
#[must_use]
pub const fn received_us(data: usize) -> u64 {
    (PASSING_ON_NS + frame_in_ns(LINE_IN + data as u64)).div_ceil(1_000)
}

/// The most microseconds from the first byte on the sender's serial line to the end of the packet on
/// the air, unless the chip has something else to do.
#[must_use]
pub const fn sending_us(datarate: Datarate, data: usize) -> u64 {
    handed_latest_us(data) + RAMP_UP_US + air_us(datarate, data)
}

/// The fewest microseconds from one processor to the other.
#[must_use]
pub const fn soonest_us(datarate: Datarate, data: usize) -> u64 {
    handed_soonest_us(data) + RAMP_UP_US + air_us(datarate, data) + received_us(data)
}

/// Microseconds from one processor to the other, as they are in the mean: the packet waits for half a
/// round of each of the two main loops.
#[must_use]
pub const fn flight_us(datarate: Datarate, data: usize) -> u64 {
    soonest_us(datarate, data) + ROUND_NS / 1_000
}

/// Microseconds from one packet to the next on the serial line so that the second does not cut the
/// first off: the chip has one buffer, and sends at once what comes last, whatever it is sending
/// (crazyflie2-nrf-firmware, `esb.c`: `esbSendP2PPacket`). The second begins when the first has been
/// read, because its bytes would delay the reading.
#[must_use]
pub const fn apart_us(datarate: Datarate, first: usize, second: usize) -> u64 {
    let off_air_us = sending_us(datarate, first).saturating_sub(handed_soonest_us(second));
    let read_us = handed_latest_us(first);
    if off_air_us > read_us { off_air_us } else { read_us }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 62 + 8 bytes and 9 bits.
    #[test]
    fn the_longest_packet_is_a_quarter_of_a_millisecond_on_the_air() {
        assert_eq!(air_us(Datarate::Mbit2, 60), 285);
        assert_eq!(air_us(Datarate::Kbit250, 60), 2_276);
        assert_eq!(address_us(Datarate::Mbit1), 48);
    }

    /// The vendor's program on an emulated chip, at 2 Mbit/s, over sixteen phases of a round.
    #[test]
    fn a_flight_takes_what_the_vendors_program_takes() {
        for (data, measured) in [(17, 1_008..=1_064), (60, 2_323..=2_381)] {
            let flight_us = flight_us(Datarate::Mbit2, data);
            assert!(measured.contains(&flight_us), "{data} bytes: {flight_us} of {measured:?}");
        }
    }

    /// The same, from the last stop bit of the frame to the packet's first bit.
    #[test]
    fn a_packet_is_on_the_air_when_the_vendors_program_has_it_there() {
        for (data, measured) in [(0, 179..=235), (60, 433..=489)] {
            let since = |handed_us| handed_us + RAMP_UP_US - line_out_us(data);
            let model = [since(handed_soonest_us(data)), since(handed_latest_us(data))];
            for (model, measured) in model.into_iter().zip([*measured.start(), *measured.end()]) {
                assert!(model.abs_diff(measured) <= 3, "{data} bytes: {model} for {measured}");
            }
        }
    }

    /// The same of what the chip sends to its processor: packets of 60 bytes, battery, strength.
    #[test]
    fn what_the_chip_tells_its_processor_takes_what_it_was_measured_to_take() {
        for (bytes, measured_us) in [(LINE_IN + 60, 858), (15, 184), (7, 83)] {
            let model_us = frame_in_ns(bytes) / 1_000;
            assert!(model_us.abs_diff(measured_us) <= 4, "{bytes} bytes: {model_us}");
        }
    }

    /// Measured with packets 855 µs apart: one of 19 bytes cut off one of 60 or of 54 bytes, and none
    /// of 45.
    #[test]
    fn a_short_packet_cuts_off_a_long_one_in_front_of_it() {
        let is_safe = |first, second| apart_us(Datarate::Mbit2, first, second) <= 855;
        assert!(!is_safe(60, 19) && !is_safe(60, 21) && !is_safe(54, 19));
        assert!(is_safe(45, 19));
    }
}
