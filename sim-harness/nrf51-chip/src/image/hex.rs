//! Reads Intel hex files: lines of a colon, a length, an address, a type, data and a sum.

use super::ImageError;

/// The types of lines that matter here; the others say where execution begins.
mod kind {
    pub(super) const DATA: u8 = 0;
    pub(super) const END: u8 = 1;
    pub(super) const SEGMENT: u8 = 2;
    pub(super) const UPPER: u8 = 4;
}

/// The chip's configuration, which is no flash of the program's (nRF51 Series Reference Manual, UICR).
const CONFIGURATION: std::ops::Range<u64> = 0x1000_1000..0x1000_2000;

/// Copies the data of a file to their place in the flash.
pub(super) fn load(file: &[u8], flash: &mut [u8]) -> Result<(), ImageError> {
    let mut base = 0;
    for (number, line) in file.split(|byte| *byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        let bad = ImageError::BadHex { line: number + 1 };
        let Some(bytes) = bytes(line) else { return Err(bad) };
        let [_, high, low, kind, ref data @ .., _] = bytes[..] else { return Err(bad) };
        match (kind, data) {
            (kind::DATA, _) => {
                let address = base + u64::from(u16::from_be_bytes([high, low]));
                if !CONFIGURATION.contains(&address) {
                    super::load(data, address, flash)?;
                }
            }
            (kind::END, _) => return Ok(()),
            (kind::SEGMENT, [high, low]) => {
                base = u64::from(u16::from_be_bytes([*high, *low])) << 4
            }
            (kind::UPPER, [high, low]) => base = u64::from(u16::from_be_bytes([*high, *low])) << 16,
            _ => {}
        }
    }
    Ok(())
}

/// The bytes of a line, whose length and sum are right.
fn bytes(line: &[u8]) -> Option<Vec<u8>> {
    let digits = std::str::from_utf8(line.strip_prefix(b":")?).ok()?;
    let pairs = digits.as_bytes().chunks(2).map(|pair| {
        let pair = std::str::from_utf8(pair).ok().filter(|pair| pair.len() == 2)?;
        u8::from_str_radix(pair, 16).ok()
    });
    let bytes: Vec<u8> = pairs.collect::<Option<_>>()?;
    let sum = bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    (sum == 0 && bytes.len() == usize::from(*bytes.first()?) + 5).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_go_where_the_lines_say() {
        // Upper address 0x0001; four bytes at 0xB000; the end.
        let file = b":020000040001F9\r\n:04B00000DEADBEEF14\r\n:00000001FF\r\n";
        let mut flash = vec![0xFF; 0x2_0000];
        load(file, &mut flash).unwrap();
        assert_eq!(flash[0x1_B000..0x1_B005], [0xDE, 0xAD, 0xBE, 0xEF, 0xFF]);
    }

    #[test]
    fn a_damaged_line_is_named() {
        for line in [":04B00000DEADBEEF15", ":04B00000DEADBE", ":xx", ":", "04", ":é"] {
            let file = format!(":020000040001F9\n{line}\n");
            let result = load(file.as_bytes(), &mut [0; 16]);
            assert_eq!(result, Err(ImageError::BadHex { line: 2 }), "{line}");
        }
    }
}
