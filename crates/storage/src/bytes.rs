//! Reading and writing the fields of a record, one after the other.

use units::Role;

use crate::Error;

/// The fields of a record that have not been read yet.
pub(crate) struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// A reader of a record whose first four bytes must be `magic`.
    pub(crate) fn after_magic(bytes: &'a [u8], magic: [u8; 4]) -> Result<Self, Error> {
        let mut reader = Self(bytes);
        match reader.array()? {
            found if found == magic => Ok(reader),
            _ if is_blank(bytes) => Err(Error::Blank),
            _ => Err(Error::Magic),
        }
    }

    /// A reader of a record of `length` bytes with this magic number, whose CRC-32 is right and whose
    /// version must be `version`; what follows the version is left to read.
    #[inline(never)]
    pub(crate) fn of_record(
        bytes: &'a [u8],
        length: usize,
        magic: [u8; 4],
        version: u8,
    ) -> Result<Self, Error> {
        let record = bytes.get(..length).ok_or(Error::Short)?;
        let mut fields = Self::after_magic(record, magic)?;
        check_crc(record, length)?;
        match fields.u8()? {
            found if found == version => Ok(fields),
            found => Err(Error::Version(found)),
        }
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (field, rest) = self.0.split_first_chunk().ok_or(Error::Short)?;
        self.0 = rest;
        Ok(*field)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Error> {
        self.array().map(|[byte]| byte)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Error> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn f32(&mut self) -> Result<f32, Error> {
        self.array().map(f32::from_le_bytes)
    }

    /// A number whose four zero bytes mean that there is none.
    pub(crate) fn optional_f32(&mut self) -> Result<Option<f32>, Error> {
        let bytes = self.array()?;
        Ok((bytes != [0; 4]).then_some(f32::from_le_bytes(bytes)))
    }
}

/// Whether the memory was never written, as far as it was read.
fn is_blank(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| *byte == 0xFF)
}

/// The `N` bytes of a record: `fields` in their order, and the CRC-32 of everything before it.
pub(crate) fn sealed<const N: usize>(fields: &[&[u8]]) -> [u8; N] {
    let mut record = [0; N];
    fill(&mut record, fields);
    record
}

/// One function for the records of all lengths.
#[inline(never)]
fn fill(record: &mut [u8], fields: &[&[u8]]) {
    if let Some((body, crc)) = record.split_last_chunk_mut::<4>() {
        let bytes = fields.iter().copied().flatten();
        for (place, byte) in body.iter_mut().zip(bytes) {
            *place = *byte;
        }
        *crc = crc32(body.iter().copied()).to_le_bytes();
    }
}

/// Checks that the first `length` bytes end in the CRC-32 of the others.
#[inline(never)]
pub(crate) fn check_crc(bytes: &[u8], length: usize) -> Result<(), Error> {
    let record = bytes.get(..length).ok_or(Error::Short)?;
    let (body, crc) = record.split_last_chunk().ok_or(Error::Short)?;
    if u32::from_le_bytes(*crc) == crc32(body.iter().copied()) {
        Ok(())
    } else {
        Err(Error::Checksum)
    }
}

/// CRC-32 as in Ethernet and zip (polynomial 0x04C11DB7, reflected). It is calculated bit by bit: a
/// table would take a kilobyte of flash, and records are seldom written.
#[inline(never)]
pub fn crc32(bytes: impl Iterator<Item = u8>) -> u32 {
    !bytes.fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

/// The byte that stands for a role in every record.
pub(crate) const fn role_code(role: Role) -> u8 {
    match role {
        Role::Head => 0,
        Role::Relay => 1,
        Role::Base => 2,
    }
}

/// The role that a byte of a record stands for.
pub(crate) const fn role_of_code(code: u8) -> Result<Role, Error> {
    match code {
        0 => Ok(Role::Head),
        1 => Ok(Role::Relay),
        2 => Ok(Role::Base),
        _ => Err(Error::Value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crc_is_that_of_the_check_string() {
        assert_eq!(crc32(b"123456789".iter().copied()), 0xCBF4_3926);
    }
}
