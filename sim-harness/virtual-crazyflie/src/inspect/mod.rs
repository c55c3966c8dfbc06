//! Reads the firmware's variables by its own debug information.
//!
//! The emulated memory is bytes; what they mean, the ELF's DWARF says: where a static lies, how its
//! type is laid out on the chip, and where a function's arguments are when it begins. So a host can
//! read a Rust value of the firmware as the same type of its own, whatever the two compilers made
//! of its layout: [`Place::get`] goes through serde.
//!
//! - [`Inspector`]: the types and statics of an ELF
//! - [`Place`]: a value in memory, of which a part can be looked at
//!
//! ```no_run
//! # use virtual_crazyflie::{inspect::Inspector, memory::Memory};
//! # fn look(elf: &[u8], memory: &Memory) -> Option<u32> {
//! let inspector = Inspector::parse(elf).ok()?;
//! let tally = inspector.variable("uchain_firmware::radio::HEARD")?;
//! tally.part("0")?.part("v")?.part("value")?.get(memory).ok()
//! # }
//! ```

mod dwarf;
mod read;
mod shape;

use std::collections::HashMap;
use std::sync::Arc;

use crate::cpu::Cpu;
use crate::memory::Memory;

pub use read::ReadError;
use shape::{Kind, Shape};

/// The types, statics and functions of an ELF.
#[derive(Default)]
pub struct Inspector {
    variables: HashMap<String, Place>,
    functions: HashMap<String, Arguments>,
    /// Keeps what pointers point to.
    shapes: Vec<Arc<Shape>>,
}

impl Inspector {
    /// Reads the debug information of these statics and functions, or of all for empty lists.
    /// Names are paths, such as `uchain_firmware::tasks::mission::COMMAND`.
    ///
    /// # Errors
    /// When the ELF has no debug information, or none that can be read.
    pub fn of(elf: &[u8], variables: &[&str], functions: &[&str]) -> Result<Self, String> {
        dwarf::read(elf, variables, functions)
    }

    /// All statics and functions.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn parse(elf: &[u8]) -> Result<Self, String> {
        Self::of(elf, &[], &[])
    }

    /// A static, by its path.
    #[must_use]
    pub fn variable(&self, path: &str) -> Option<&Place> {
        self.variables.get(path)
    }

    /// A function, by its path.
    #[must_use]
    pub fn function(&self, path: &str) -> Option<&Arguments> {
        self.functions.get(path)
    }
}

/// A value of some type, somewhere in memory.
#[derive(Clone)]
pub struct Place {
    shape: Arc<Shape>,
    address: u32,
}

impl Place {
    /// Where it lies.
    #[must_use]
    pub const fn address(&self) -> u32 {
        self.address
    }

    /// What its type is called.
    #[must_use]
    pub fn type_name(&self) -> &str {
        &self.shape.name
    }

    /// A field of a structure. Tuples have fields "0", "1" and so on.
    #[must_use]
    pub fn part(&self, field: &str) -> Option<Self> {
        let Kind::Structure { members } = &self.shape.kind else { return None };
        let member = members.iter().find(|member| member.is_called(field))?;
        Some(Self {
            shape: Arc::clone(&member.shape),
            address: self.address.wrapping_add(member.offset),
        })
    }

    /// What is within wrappers that have nothing else in them: cells, mutexes, newtypes. It stops
    /// at the first type that has more than one part with any bytes, and at anything that is no
    /// structure.
    #[must_use]
    pub fn inner(&self) -> Self {
        let mut place = self.clone();
        while let Kind::Structure { members } = &place.shape.kind {
            let mut sized = members.iter().filter(|member| member.shape.size > 0);
            let (Some(only), None) = (sized.next(), sized.next()) else { break };
            let address = place.address.wrapping_add(only.offset);
            place = Self { shape: Arc::clone(&only.shape), address };
        }
        place
    }

    /// The same type somewhere else.
    #[must_use]
    pub fn at(&self, address: u32) -> Self {
        Self { shape: Arc::clone(&self.shape), address }
    }

    /// The value, as a type whose fields and variants have the same names.
    ///
    /// # Errors
    /// Where memory does not reach, and where the types do not fit each other.
    pub fn get<'m, T: serde::Deserialize<'m>>(&self, memory: &'m Memory) -> Result<T, ReadError> {
        T::deserialize(read::Reader { shape: &self.shape, address: self.address, memory })
    }
}

/// Where a function's arguments are.
#[derive(Clone)]
pub struct Arguments {
    /// Its first instruction.
    pub entry: u32,
    /// The first instruction at which every argument is where it is said to be: behind the
    /// prologue.
    pub ready: u32,
    parameters: Vec<Parameter>,
    returns: Option<Arc<Shape>>,
}

#[derive(Clone)]
struct Parameter {
    name: String,
    shape: Arc<Shape>,
    location: Location,
}

/// Where an argument is while [`Arguments::ready`] is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Location {
    /// In a register.
    Register(u8),
    /// In memory, this far from what a register holds.
    Based(u8, i32),
}

impl Arguments {
    /// What a reference of this name refers to, or where a value of this name lies, when the core
    /// is about to execute [`ready`](Self::ready). `None` for what is in registers and is no
    /// reference.
    #[must_use]
    pub fn place(&self, name: &str, cpu: &Cpu, memory: &Memory) -> Option<Place> {
        let parameter = self.parameters.iter().find(|parameter| parameter.name == name)?;
        let target = match &parameter.shape.kind {
            Kind::Pointer { target } => Some(target.get()?),
            _ => None,
        };
        match (parameter.location, target) {
            (Location::Register(n), Some(shape)) => {
                Some(Place { shape, address: cpu.register(n.into()) })
            }
            (Location::Register(_), None) => None,
            (Location::Based(n, offset), target) => {
                let address = cpu.register(n.into()).wrapping_add_signed(offset);
                match target {
                    None => Some(Place { shape: Arc::clone(&parameter.shape), address }),
                    Some(shape) => {
                        let address = memory.load(address, crate::bus::Width::Word)?;
                        Some(Place { shape, address })
                    }
                }
            }
        }
    }

    /// What it returns, when that is returned in memory at `address`: what R0 held at
    /// [`entry`](Self::entry).
    #[must_use]
    pub fn result_at(&self, address: u32) -> Option<Place> {
        Some(Place { shape: Arc::clone(self.returns.as_ref()?), address })
    }
}
