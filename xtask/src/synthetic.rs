//! Programs made up for tests.

use std::collections::BTreeMap;

use virtual_crazyflie::cpu::effect::{Effect, Instruction, Value};
use virtual_crazyflie::image::{Function, Section};

use crate::elf::{Elf, Vectors};

/// The beginning of the flash.
pub(crate) const FLASH: u32 = 0x0800_4000;
pub(crate) const SP: u8 = 13;
pub(crate) const LR: u8 = 14;
pub(crate) const PC: u8 = 15;

/// Instructions of two bytes each, the first at `start`.
pub(crate) fn listing(
    start: u32,
    effects: impl IntoIterator<Item = Line>,
) -> BTreeMap<u32, Instruction> {
    (start..)
        .step_by(2)
        .zip(effects)
        .map(|(address, Line { conditional, effect })| {
            (address, Instruction { address, size: 2, conditional, effect })
        })
        .collect()
}

/// One instruction of a listing.
pub(crate) struct Line {
    conditional: bool,
    effect: Effect,
}

/// An instruction that is always executed.
pub(crate) const fn always(effect: Effect) -> Line {
    Line { conditional: false, effect }
}

/// An instruction that is executed on a condition.
pub(crate) const fn perhaps(effect: Effect) -> Line {
    Line { conditional: true, effect }
}

/// `push` of some bytes.
pub(crate) const fn push(bytes: i32) -> Line {
    always(Effect::Stack { by: -bytes, loaded: 0 })
}

/// `pop` of some bytes, PC not among them.
pub(crate) const fn pop(bytes: i32) -> Line {
    always(Effect::Stack { by: bytes, loaded: 0b1_0000 })
}

/// `pop` of some bytes into PC: a return.
pub(crate) const fn pop_pc(bytes: i32) -> Line {
    always(Effect::Stack { by: bytes, loaded: 1 << PC })
}

/// `mov` or `add` of a register and a number to a register.
pub(crate) const fn offset(to: u8, from: u8, by: i32) -> Line {
    set(to, Value::Offset(from, by.cast_unsigned()))
}

/// `sub sp, #bytes`, and for a negative number `add`.
pub(crate) const fn take(bytes: i32) -> Line {
    offset(SP, SP, -bytes)
}

pub(crate) const fn set(register: u8, value: Value) -> Line {
    always(Effect::Set { register, value })
}

pub(crate) const fn jump(to: u32) -> Line {
    always(Effect::Jump(to))
}

pub(crate) const fn branch(to: u32) -> Line {
    perhaps(Effect::Jump(to))
}

pub(crate) const fn call(to: u32) -> Line {
    always(Effect::Call(to))
}

/// `blx` of a register.
pub(crate) const fn call_register(register: u8) -> Line {
    always(Effect::CallRegister(register))
}

/// `bx lr`.
pub(crate) const fn ret() -> Line {
    always(Effect::JumpRegister(LR))
}

/// A program of these functions, named with their distance from the flash's beginning and their
/// instructions, and sections without contents.
pub(crate) fn elf(
    vectors: Vectors,
    functions: Vec<(&str, u32, Vec<Line>)>,
    sections: &[(&str, u32, u32)],
) -> Elf {
    let section = |(name, address, size): &(&str, u32, u32)| Section {
        name: (*name).to_owned(),
        address: *address,
        size: *size,
    };
    let mut elf = Elf {
        sections: sections.iter().map(section).collect(),
        functions: vec![],
        names: BTreeMap::new(),
        instructions: BTreeMap::new(),
        vectors,
    };
    for (name, distance, lines) in functions {
        let (address, size) = (FLASH + distance, 2 * lines.len() as u32);
        elf.functions.push(Function { name: name.to_owned(), address, size });
        elf.names.insert(address, vec![name.to_owned()]);
        elf.instructions.extend(listing(address, lines));
    }
    elf
}
