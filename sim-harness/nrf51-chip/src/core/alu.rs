//! Arithmetic, logic and shifts, with their flags (ARMv6-M Architecture Reference Manual, A2.2.1).

use super::op::{Alu, Change, Register, Shift};
use super::{Core, Flags};

/// The sum of two words and a carry, with the flags that it sets.
pub(super) const fn add(a: u32, b: u32, carry: bool) -> (u32, Flags) {
    let (part, first) = a.overflowing_add(b);
    let (sum, second) = part.overflowing_add(carry as u32);
    let v = ((a ^ sum) & (b ^ sum)) >> 31 != 0;
    (sum, Flags { n: sum >> 31 != 0, z: sum == 0, c: first || second, v })
}

/// A value shifted by a number of bits, with the carry.
const fn shift(shift: Shift, value: u32, by: u32, carry: bool) -> (u32, bool) {
    match (shift, by) {
        (_, 0) => (value, carry),
        (Shift::Lsl, 1..=31) => (value << by, value >> (32 - by) & 1 != 0),
        (Shift::Lsl, 32) => (0, value & 1 != 0),
        (Shift::Lsr, 1..=31) => (value >> by, value >> (by - 1) & 1 != 0),
        (Shift::Lsr, 32) => (0, value >> 31 != 0),
        (Shift::Lsl | Shift::Lsr, _) => (0, false),
        (Shift::Asr, 1..=31) => {
            ((value.cast_signed() >> by).cast_unsigned(), value >> (by - 1) & 1 != 0)
        }
        (Shift::Asr, _) => ((value.cast_signed() >> 31).cast_unsigned(), value >> 31 != 0),
    }
}

/// The result of an extension or a change of the byte order.
pub(super) fn change(change: Change, value: u32) -> u32 {
    let [a, b, c, d] = value.to_le_bytes();
    match change {
        Change::Sxth => i32::from(i16::from_le_bytes([a, b])).cast_unsigned(),
        Change::Sxtb => i32::from(a.cast_signed()).cast_unsigned(),
        Change::Uxth => value & 0xFFFF,
        Change::Uxtb => value & 0xFF,
        Change::Rev => value.swap_bytes(),
        Change::Rev16 => u32::from_le_bytes([b, a, d, c]),
        Change::Revsh => i32::from(i16::from_le_bytes([b, a])).cast_unsigned(),
    }
}

impl Core {
    /// Sets a low register, and N and Z by its value.
    pub(super) fn set(&mut self, d: Register, value: u32) {
        self.registers[usize::from(d)] = value;
        self.flags.n = value >> 31 != 0;
        self.flags.z = value == 0;
    }

    /// Sets a low register to a sum, and all flags.
    pub(super) fn sum(&mut self, d: Register, a: u32, b: u32, carry: bool) {
        let (sum, flags) = add(a, b, carry);
        self.registers[usize::from(d)] = sum;
        self.flags = flags;
    }

    /// Sets all flags by a difference.
    pub(super) const fn compare(&mut self, a: u32, b: u32) {
        self.flags = add(a, !b, true).1;
    }

    pub(super) fn shift(&mut self, kind: Shift, d: Register, value: u32, by: u32) {
        let (result, carry) = shift(kind, value, by, self.flags.c);
        self.set(d, result);
        self.flags.c = carry;
    }

    fn rotate(&mut self, d: Register, value: u32, by: u32) {
        let result = value.rotate_right(by);
        self.set(d, result);
        if by != 0 {
            self.flags.c = result >> 31 != 0;
        }
    }

    pub(super) fn alu(&mut self, alu: Alu, d: Register, m: Register) {
        let (a, b) = (self.registers[usize::from(d)], self.registers[usize::from(m)]);
        let carry = self.flags.c;
        // A shift takes the lowest byte of its register.
        let by = b & 0xFF;
        match alu {
            Alu::And => self.set(d, a & b),
            Alu::Eor => self.set(d, a ^ b),
            Alu::Lsl => self.shift(Shift::Lsl, d, a, by),
            Alu::Lsr => self.shift(Shift::Lsr, d, a, by),
            Alu::Asr => self.shift(Shift::Asr, d, a, by),
            Alu::Adc => self.sum(d, a, b, carry),
            Alu::Sbc => self.sum(d, a, !b, carry),
            Alu::Ror => self.rotate(d, a, by),
            Alu::Tst => {
                self.flags.n = (a & b) >> 31 != 0;
                self.flags.z = a & b == 0;
            }
            Alu::Rsb => self.sum(d, 0, !b, true),
            Alu::Cmp => self.compare(a, b),
            Alu::Cmn => self.flags = add(a, b, false).1,
            Alu::Orr => self.set(d, a | b),
            Alu::Mul => self.set(d, a.wrapping_mul(b)),
            Alu::Bic => self.set(d, a & !b),
            Alu::Mvn => self.set(d, !b),
        }
    }
}
