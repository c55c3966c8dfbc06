//! The parts of an image that the stack and the panics are judged by.

use std::collections::BTreeMap;

use virtual_crazyflie::cpu::effect::Instruction;
use virtual_crazyflie::image::{Function, Image, Section};

use crate::Result;

/// Sections, functions, instructions and vector table of the firmware.
pub(crate) struct Elf {
    pub(crate) sections: Vec<Section>,
    /// The functions by address, one name each.
    pub(crate) functions: Vec<Function>,
    /// All names of each function.
    pub(crate) names: BTreeMap<u32, Vec<String>>,
    pub(crate) instructions: BTreeMap<u32, Instruction>,
    pub(crate) vectors: Vectors,
}

/// The vector table.
pub(crate) struct Vectors {
    /// The initial address of the main stack.
    pub(crate) stack: u32,
    /// Handlers with their numbers: 1 is reset, 16 and up are the chip's interrupts.
    pub(crate) handlers: Vec<(u32, u32)>,
}

impl Elf {
    pub(crate) fn of(image: &Image) -> Result<Self> {
        let sections = image.sections().to_vec();
        let table = sections
            .iter()
            .find(|section| section.name == ".vector_table")
            .ok_or("it has no .vector_table section")?;
        let word = |number: u32| image.word(table.address + 4 * number).unwrap_or(0);
        let handlers = (1..table.size / 4)
            .map(|number| (number, word(number) & !1))
            .filter(|(_, handler)| *handler != 0)
            .collect();
        let vectors = Vectors { stack: word(0), handlers };
        let functions = image.functions().to_vec();
        let names = |function: &Function| image.names_of(function.address).to_vec();
        Ok(Self {
            names: functions.iter().map(|function| (function.address, names(function))).collect(),
            instructions: image.listing().iter().map(|i| (i.address, i.clone())).collect(),
            sections,
            functions,
            vectors,
        })
    }
}
