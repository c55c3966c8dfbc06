//! Values that are known before the program runs: constants, and depths below the stack pointer at
//! a function's entry.

use virtual_crazyflie::cpu::effect;

/// More stack than the whole memory holds; a depth beyond it means that a loop takes stack.
pub(super) const ABSURD: u32 = 0x2_0000;

const SP: usize = 13;

/// The known value of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value {
    Unknown,
    Constant(u32),
    /// Bytes below the stack pointer at entry.
    Depth(i64),
}

impl Value {
    fn plus(self, amount: i64) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::Constant(value) => Self::Constant(value.wrapping_add(amount as u32)),
            Self::Depth(depth) => Self::Depth(depth - amount),
        }
    }

    /// The value with the bits outside `mask` cleared. Where that aligns the stack pointer, which
    /// is a multiple of four, the depth grows by as much as it can.
    fn masked(self, mask: u32) -> Self {
        let cleared = !mask;
        let aligns = cleared < ABSURD && cleared & (cleared + 1) == 0;
        match self {
            Self::Constant(value) => Self::Constant(value & mask),
            Self::Depth(depth) if aligns => {
                Self::Depth(depth + (i64::from(cleared) + 1 - 4).max(0))
            }
            Self::Unknown | Self::Depth(_) => Self::Unknown,
        }
    }
}

/// The known values before an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct State {
    registers: [Value; 16],
    /// The top of the stack that is in use, if it is not the one that the function was called on.
    pub(super) stack: Option<u32>,
}

impl State {
    /// The values at a function's entry.
    pub(super) fn at_entry() -> Self {
        let mut registers = [Value::Unknown; 16];
        registers[SP] = Value::Depth(0);
        Self { registers, stack: None }
    }

    /// The values where two paths meet: those on which both agree, and the deeper stack.
    pub(super) fn join(&self, other: &Self) -> Self {
        let value = |i| match (self.registers[i], other.registers[i]) {
            (a, b) if a == b => a,
            (Value::Depth(a), Value::Depth(b)) if i == SP => Value::Depth(a.max(b)),
            _ => Value::Unknown,
        };
        Self {
            registers: std::array::from_fn(value),
            stack: self.stack.filter(|_| self.stack == other.stack),
        }
    }

    /// Bytes that are on the stack.
    pub(super) fn depth(&self) -> u32 {
        match self.registers[SP] {
            Value::Depth(depth) => depth.max(0) as u32,
            Value::Unknown | Value::Constant(_) => 0,
        }
    }

    pub(super) fn register(&self, number: u8) -> Value {
        self.registers[usize::from(number)]
    }

    /// Registers, one bit each, get values that are not known. The stack pointer keeps its depth.
    pub(super) fn forget(&mut self, registers: u16) {
        let written = |i: &usize| registers >> i & 1 == 1 && *i != SP;
        (0..16).filter(written).for_each(|i| self.registers[i] = Value::Unknown);
    }

    /// The stack pointer moves up.
    pub(super) fn move_stack(&mut self, by: i32) {
        self.registers[SP] = self.registers[SP].plus(by.into());
    }

    /// The stack pointer becomes the top of another stack.
    pub(super) fn change_stack(&mut self, to: Value) -> Result<(), String> {
        let Value::Constant(top) = to else {
            return Err("another stack, and its address is not known".into());
        };
        self.stack = Some(top);
        self.registers[SP] = Value::Depth(0);
        Ok(())
    }

    /// A register gets a value.
    pub(super) fn set(&mut self, register: u8, value: effect::Value) -> Result<(), String> {
        let value = self.evaluate(value);
        if usize::from(register) == SP && !matches!(value, Value::Depth(_)) {
            return Err("the stack pointer gets a value that is not known".into());
        }
        self.registers[usize::from(register)] = value;
        Ok(())
    }

    fn evaluate(&self, value: effect::Value) -> Value {
        match value {
            effect::Value::Constant(value) => Value::Constant(value),
            effect::Value::Offset(from, by) => self.register(from).plus(by.cast_signed().into()),
            effect::Value::Sum(a, b) => match (self.register(a), self.register(b)) {
                (value, Value::Constant(by)) | (Value::Constant(by), value) => {
                    value.plus(by.cast_signed().into())
                }
                _ => Value::Unknown,
            },
            effect::Value::Difference(a, b) => match (self.register(a), self.register(b)) {
                (value, Value::Constant(by)) => value.plus(-i64::from(by.cast_signed())),
                _ => Value::Unknown,
            },
            effect::Value::UpperHalf(register, high) => match self.register(register) {
                Value::Constant(low) => Value::Constant(low & 0xFFFF | high),
                Value::Unknown | Value::Depth(_) => Value::Unknown,
            },
            effect::Value::Masked(register, mask) => self.register(register).masked(mask),
        }
    }
}
