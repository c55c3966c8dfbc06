//! Bugs put in on purpose: what our core would leave behind if it had them.
//!
//! Each alters our outcome only where such a bug would show. That a comparison notices says two
//! things: the states reach the place, and nothing hides what happens there.

mod float;
mod integer;
mod memory;

use core_vectors::forms::Form;
use core_vectors::state::CODE;
use core_vectors::{After, State};

/// A core with a bug.
pub(crate) struct Mutant {
    pub(crate) name: &'static str,
    /// Names of forms begin so.
    forms: &'static [&'static str],
    alter: fn(&mut Bug<'_>),
}

impl Mutant {
    pub(crate) fn concerns(&self, form: &Form) -> bool {
        self.forms.iter().any(|stem| {
            form.name.strip_prefix(stem).is_some_and(|rest| {
                // "SMLA" is not to mean SMLAD.
                rest.is_empty() || rest.starts_with([' ', '.'])
            })
        })
    }

    /// The outcome with the bug.
    pub(crate) fn apply(&self, form: &Form, encoding: u32, before: &State, after: &After) -> After {
        let mut bug = Bug { form, encoding, before, after: after.clone() };
        // In a block what fails its condition is not executed.
        if before.it == 0 || self.name.contains("block") {
            (self.alter)(&mut bug);
        }
        bug.after
    }
}

struct Bug<'a> {
    form: &'a Form,
    encoding: u32,
    before: &'a State,
    after: After,
}

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;
const Q: u32 = 1 << 27;
const GE: u32 = 0xF << 16;
const IOC: u32 = 1;
const DZC: u32 = 2;
const OFC: u32 = 4;
const UFC: u32 = 8;
const IXC: u32 = 16;
const IDC: u32 = 128;
const MODES: u32 = 0x07C0_0000;

impl Bug<'_> {
    fn f(&self, letter: u8) -> u32 {
        self.form.field(letter, self.encoding).unwrap_or(16)
    }

    /// The value of the register in a field.
    fn reg(&self, letter: u8) -> u32 {
        self.before.r.get(self.f(letter) as usize).copied().unwrap_or(CODE)
    }

    fn d(&mut self) -> &mut u32 {
        let d = self.f(b'd') as usize;
        &mut self.after.r[d.min(15)]
    }

    fn had(&self, flag: u32) -> bool {
        self.before.apsr & flag != 0
    }

    fn has(&self, flag: u32) -> bool {
        self.after.apsr & flag != 0
    }

    /// The floating-point instruction has raised it.
    fn raised(&self, flag: u32) -> bool {
        self.after.fpscr & !self.before.fpscr & flag != 0
    }

    fn mode(&self) -> u32 {
        self.before.fpscr & MODES
    }

    /// The default mode, and IXC is set already.
    fn takes_the_short_way(&self) -> bool {
        self.before.fpscr & (MODES | IXC) == IXC
    }

    /// Sd, Sn, Sm as in the encoding of data processing.
    fn fd(&self) -> usize {
        (self.encoding >> 11 & 0x1E | self.encoding >> 22 & 1) as usize
    }

    fn s(&self, at: u32, low: u32) -> u32 {
        self.before.s[(self.encoding >> at << 1 & 0x1E | self.encoding >> low & 1) as usize]
    }

    fn sn(&self) -> u32 {
        self.s(16, 7)
    }

    fn sm(&self) -> u32 {
        self.s(0, 5)
    }

    fn result(&mut self) -> &mut u32 {
        let d = self.fd();
        &mut self.after.s[d]
    }

    fn wide_product(&self) -> i64 {
        i64::from(self.reg(b'n') as i32) * i64::from(self.reg(b'm') as i32)
    }
}

/// All of them.
pub(crate) fn all() -> impl Iterator<Item = &'static Mutant> {
    integer::MUTANTS.iter().chain(memory::MUTANTS).chain(float::MUTANTS)
}
