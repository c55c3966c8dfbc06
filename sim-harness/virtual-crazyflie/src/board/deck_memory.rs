//! The one-wire memories of the decks, by which the vendor's firmware knows them
//! (crazyflie-firmware, `deck_memory_format.md`).

/// The size of a DS28E05.
pub(super) const SIZE: usize = 112;

/// The content of a deck's memory, and the serial number of its chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DeckMemory {
    pub(super) serial: [u8; 8],
    pub(super) bytes: [u8; SIZE],
}

/// Bitcraze.
const VENDOR: u8 = 0xBC;
const FLOW_V2: u8 = 0x0F;
const MULTI_RANGER: u8 = 0x0C;

/// The memories of the decks that are there.
pub(super) fn memories(flow_deck: bool, multi_ranger: bool) -> Vec<DeckMemory> {
    let flow = flow_deck.then(|| memory(FLOW_V2, "bcFlow2", 1));
    let ranger = multi_ranger.then(|| memory(MULTI_RANGER, "bcMultiranger", 2));
    flow.into_iter().chain(ranger).collect()
}

/// A header and a list of elements, each with a sum behind it; the rest is erased.
fn memory(product: u8, name: &str, number: u8) -> DeckMemory {
    const MAGIC: u8 = 0xEB;
    const VERSION: u8 = 0;
    const NAME: u8 = 1;
    const REVISION: u8 = 2;
    let mut content = vec![MAGIC, 0, 0, 0, 0, VENDOR, product];
    content.push(sum(&content));
    let mut elements = Vec::new();
    for (element, text) in [(NAME, name), (REVISION, "A")] {
        elements.extend([element, text.len() as u8]);
        elements.extend_from_slice(text.as_bytes());
    }
    let mut list = vec![VERSION, elements.len() as u8];
    list.extend(elements);
    list.push(sum(&list));
    content.extend(list);
    let mut bytes = [0xFF; SIZE];
    bytes[..content.len()].copy_from_slice(&content);
    // A DS28E05's family code; its own sum is not looked at.
    DeckMemory { serial: [0x0D, number, 0, 0, 0, 0, 0, 0], bytes }
}

/// The lowest byte of the CRC-32 of IEEE 802.3.
fn sum(bytes: &[u8]) -> u8 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 0 { crc >> 1 } else { crc >> 1 ^ 0xEDB8_8320 };
        }
    }
    !crc as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_the_lowest_byte_of_a_crc_32() {
        // The check value of CRC-32 is 0xCBF43926.
        assert_eq!(sum(b"123456789"), 0x26);
    }

    #[test]
    fn a_memory_says_who_made_which_deck() {
        let [flow] = memories(true, false).try_into().unwrap();
        assert_eq!(flow.bytes[..7], [0xEB, 0, 0, 0, 0, 0xBC, 0x0F]);
        assert_eq!(flow.bytes[8..10], [0, 12]);
        assert_eq!(&flow.bytes[10..19], b"\x01\x07bcFlow2");
        assert_eq!(flow.bytes[23..], [0xFF; SIZE - 23]);
        assert_eq!(memories(true, true).len(), 2);
    }
}
