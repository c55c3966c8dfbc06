//! Describes the registers of a Cortex-M4F to GDB.

use std::num::NonZeroUsize;

use gdbstub::arch::{Arch, RegId, Registers};

/// A register as GDB knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// R0 to R15.
    R(u8),
    /// APSR, IPSR and EPSR in one.
    Xpsr,
    /// D0 to D15: two of S0 to S31 each.
    D(u8),
    /// Floating-point status and control.
    Fpscr,
    /// A special register, by its number in MRS and MSR.
    Special(u8),
}

impl Register {
    /// The registers in the order of `DESCRIPTION`.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        (0..16)
            .map(Self::R)
            .chain([Self::Xpsr])
            .chain((0..16).map(Self::D))
            .chain([Self::Fpscr])
            .chain(SPECIAL.map(Self::Special))
    }

    /// The length in bytes.
    pub(super) const fn size(self) -> usize {
        if let Self::D(_) = self { 8 } else { 4 }
    }
}

/// MSP, PSP, PRIMASK, BASEPRI, FAULTMASK, CONTROL (DDI 0403, B5.1.1).
const SPECIAL: [u8; 6] = [8, 9, 16, 17, 19, 20];
/// The number of XPSR in GDB; R16 to R24 were something else once.
const XPSR: usize = 25;

/// As the manual of GDB has it, "ARM Features".
const DESCRIPTION: &str = r#"<?xml version="1.0"?>
<!DOCTYPE target SYSTEM "gdb-target.dtd">
<target version="1.0"><architecture>armv7e-m</architecture>
<feature name="org.gnu.gdb.arm.m-profile">
<reg name="r0" bitsize="32"/><reg name="r1" bitsize="32"/><reg name="r2" bitsize="32"/>
<reg name="r3" bitsize="32"/><reg name="r4" bitsize="32"/><reg name="r5" bitsize="32"/>
<reg name="r6" bitsize="32"/><reg name="r7" bitsize="32"/><reg name="r8" bitsize="32"/>
<reg name="r9" bitsize="32"/><reg name="r10" bitsize="32"/><reg name="r11" bitsize="32"/>
<reg name="r12" bitsize="32"/><reg name="sp" bitsize="32" type="data_ptr"/>
<reg name="lr" bitsize="32"/><reg name="pc" bitsize="32" type="code_ptr"/>
<reg name="xpsr" bitsize="32" regnum="25"/>
</feature>
<feature name="org.gnu.gdb.arm.vfp">
<reg name="d0" bitsize="64" type="ieee_double"/><reg name="d1" bitsize="64" type="ieee_double"/>
<reg name="d2" bitsize="64" type="ieee_double"/><reg name="d3" bitsize="64" type="ieee_double"/>
<reg name="d4" bitsize="64" type="ieee_double"/><reg name="d5" bitsize="64" type="ieee_double"/>
<reg name="d6" bitsize="64" type="ieee_double"/><reg name="d7" bitsize="64" type="ieee_double"/>
<reg name="d8" bitsize="64" type="ieee_double"/><reg name="d9" bitsize="64" type="ieee_double"/>
<reg name="d10" bitsize="64" type="ieee_double"/><reg name="d11" bitsize="64" type="ieee_double"/>
<reg name="d12" bitsize="64" type="ieee_double"/><reg name="d13" bitsize="64" type="ieee_double"/>
<reg name="d14" bitsize="64" type="ieee_double"/><reg name="d15" bitsize="64" type="ieee_double"/>
<reg name="fpscr" bitsize="32" type="int" group="float"/>
</feature>
<feature name="org.gnu.gdb.arm.m-system">
<reg name="msp" bitsize="32" type="data_ptr"/><reg name="psp" bitsize="32" type="data_ptr"/>
<reg name="primask" bitsize="32"/><reg name="basepri" bitsize="32"/>
<reg name="faultmask" bitsize="32"/><reg name="control" bitsize="32"/>
</feature>
</target>"#;

/// A Cortex-M4F, for GDB.
pub(super) enum CortexM4F {}

impl Arch for CortexM4F {
    type Usize = u32;
    type Registers = All;
    type BreakpointKind = usize;
    type RegId = Register;

    fn target_description_xml() -> Option<&'static str> {
        Some(DESCRIPTION)
    }
}

impl RegId for Register {
    fn from_raw_id(id: usize) -> Option<(Self, Option<NonZeroUsize>)> {
        let index = match id {
            0..16 => id,
            XPSR.. => id - XPSR + 16,
            _ => return None,
        };
        let register = Self::all().nth(index)?;
        Some((register, NonZeroUsize::new(register.size())))
    }
}

/// The values of the registers, in the order of [`Register::all`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct All(pub(super) Vec<u64>);

impl Registers for All {
    type ProgramCounter = u32;

    fn pc(&self) -> u32 {
        self.0.get(15).map_or(0, |pc| *pc as u32)
    }

    fn gdb_serialize(&self, mut write_byte: impl FnMut(Option<u8>)) {
        for (register, value) in Register::all().zip(&self.0) {
            for byte in &value.to_le_bytes()[..register.size()] {
                write_byte(Some(*byte));
            }
        }
    }

    fn gdb_deserialize(&mut self, mut bytes: &[u8]) -> Result<(), ()> {
        self.0.clear();
        for register in Register::all() {
            let (value, rest) = bytes.split_at_checked(register.size()).ok_or(())?;
            self.0.push(number(value));
            bytes = rest;
        }
        Ok(())
    }
}

/// Little-endian, of up to eight bytes.
pub(super) fn number(bytes: &[u8]) -> u64 {
    bytes.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_have_the_numbers_that_the_description_gives_them() {
        let mut number = 0;
        let mut described = Vec::new();
        for register in DESCRIPTION.split("<reg ").skip(1) {
            let field = |name: &str| {
                let value = register.split_once(&format!("{name}=\""))?.1;
                value.split_once('"').map(|(value, _)| value)
            };
            number = field("regnum").map_or(number, |number| number.parse().unwrap());
            let bits: usize = field("bitsize").unwrap().parse().unwrap();
            described.push((number, bits / 8));
            number += 1;
        }
        let sizes: Vec<_> = described.iter().map(|(_, size)| *size).collect();
        assert_eq!(sizes, Register::all().map(Register::size).collect::<Vec<_>>());
        for ((id, size), register) in described.into_iter().zip(Register::all()) {
            assert_eq!(Register::from_raw_id(id), Some((register, NonZeroUsize::new(size))));
        }
        assert_eq!(Register::from_raw_id(16), None);
        assert_eq!(Register::from_raw_id(49), None);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let all = All((0..40).map(|n| n * 0x0101_0101).collect());
        let mut bytes = Vec::new();
        all.gdb_serialize(|byte| bytes.extend(byte));
        let mut back = All::default();
        assert_eq!(back.gdb_deserialize(&bytes), Ok(()));
        assert_eq!(back, all);
        assert_eq!(back.gdb_deserialize(&bytes[1..]), Err(()));
    }
}
