//! The forms of instructions: which bits are fixed, which are registers, what is UNPREDICTABLE.
//!
//! A pattern is 16 or 32 characters: `0` and `1` are fixed bits, a letter is a field of all the bits
//! that carry it. `d n m t u a l h` are core registers: never PC, and never SP unless the letter is a
//! capital. Other letters are free. What an earlier pattern takes, a later one does not see.

mod control;
mod float;
mod integer;
mod memory;
mod narrow;

use std::sync::OnceLock;

use crate::random::Random;

/// The source of an instruction's data, so that a state can put it within the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// It has none, or it lies by PC or SP.
    Nothing,
    /// Field `n` is the base.
    Base,
    /// Field `n` is the base, field `m` an index.
    Indexed,
    /// Field `m` is where to go.
    Target,
}

type Rule = fn(&Form, u32) -> bool;

/// A form of an instruction: all encodings that differ in operands only.
#[derive(Clone)]
pub struct Form {
    /// Mnemonic and variant. No two forms have the same.
    pub name: String,
    pattern: Vec<u8>,
    mask: u32,
    value: u32,
    rule: Option<Rule>,
    pub(super) aim: Aim,
}

impl Form {
    fn new(name: &str, pattern: &str) -> Self {
        let pattern: Vec<u8> = pattern.bytes().filter(|b| *b != b' ').collect();
        assert!(matches!(pattern.len(), 16 | 32), "{name}: {} bits", pattern.len());
        let fixed = |wanted: &[u8]| {
            pattern.iter().fold(0, |bits, c| bits << 1 | u32::from(wanted.contains(c)))
        };
        let (mask, value) = (fixed(b"01"), fixed(b"1"));
        Self { name: name.to_owned(), mask, value, rule: None, aim: Aim::Nothing, pattern }
    }

    fn aim(mut self, aim: Aim) -> Self {
        self.aim = aim;
        self
    }

    fn rule(mut self, rule: Rule) -> Self {
        self.rule = Some(rule);
        self
    }

    /// Two halfwords, not one.
    #[must_use]
    pub fn is_wide(&self) -> bool {
        self.pattern.len() == 32
    }

    /// The fixed bits are these.
    #[must_use]
    pub fn matches(&self, encoding: u32) -> bool {
        is_wide(encoding) == self.is_wide() && encoding & self.mask == self.value
    }

    /// The value of a field; `None` if the form has no such letter.
    #[must_use]
    pub fn field(&self, letter: u8, encoding: u32) -> Option<u32> {
        let mut value = None;
        for (place, c) in self.pattern.iter().rev().enumerate().rev() {
            if c.eq_ignore_ascii_case(&letter) {
                value = Some(value.unwrap_or(0) << 1 | encoding >> place & 1);
            }
        }
        value
    }

    fn f(&self, letter: u8, encoding: u32) -> u32 {
        self.field(letter, encoding).unwrap_or_else(|| panic!("{}: no such field", self.name))
    }

    /// Whether the manual defines the instruction: its registers are allowed, and none overlap that
    /// must not.
    #[must_use]
    pub fn is_predictable(&self, encoding: u32) -> bool {
        let registers = b"dnmtualhDNMTUALH".iter().all(|letter| {
            let width = self.pattern.iter().filter(|c| *c == letter).count();
            let value = self.field(*letter, encoding);
            match value {
                Some(15) if width == 4 => false,
                Some(13) if width == 4 => letter.is_ascii_uppercase(),
                _ => true,
            }
        });
        registers && self.rule.is_none_or(|rule| rule(self, encoding))
    }

    /// The fixed bits with others between them. What is no register is often all zeros or all ones:
    /// there the meaning of an immediate may turn.
    fn fill(&self, random: &mut Random) -> u32 {
        let mut free = random.word() & if self.is_wide() { !0 } else { 0xFFFF };
        for letter in b"efgijkqrswxz" {
            let field = self
                .pattern
                .iter()
                .fold(0, |bits, c| bits << 1 | u32::from(c.eq_ignore_ascii_case(letter)));
            match random.below(5) {
                0 => free &= !field,
                1 => free |= field,
                _ => {}
            }
        }
        free & !self.mask | self.value
    }

    /// It is many instructions by condition or by special register, and wants more members than
    /// others to show them all.
    #[must_use]
    pub fn is_family(&self) -> bool {
        self.name.starts_with("B cond") || matches!(self.name.as_str(), "MRS" | "MSR")
    }

    /// Whether it loads or stores at an address that one register holds.
    #[must_use]
    pub fn aim_is_base(&self) -> bool {
        self.aim == Aim::Base
    }

    /// One that is predictable.
    #[must_use]
    pub fn sample(&self, random: &mut Random) -> u32 {
        for _ in 0..100_000 {
            let encoding = self.fill(random);
            if self.is_predictable(encoding) && of(encoding).is_some_and(|f| f.name == self.name) {
                return encoding;
            }
        }
        panic!("{}: no member was found", self.name)
    }
}

/// The first halfword says that a second follows (DDI 0403, A5.1).
#[must_use]
pub const fn is_wide(encoding: u32) -> bool {
    encoding > 0xFFFF
}

/// All forms of ARMv7E-M with FPv4-SP.
#[must_use]
pub fn all() -> &'static [Form] {
    static ALL: OnceLock<Vec<Form>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut forms = Vec::new();
        narrow::narrow(&mut forms);
        memory::multiple(&mut forms);
        memory::exclusive_and_table(&mut forms);
        integer::shifted_register(&mut forms);
        integer::immediates(&mut forms);
        control::control(&mut forms);
        memory::single(&mut forms);
        integer::register(&mut forms);
        integer::multiply(&mut forms);
        float::float(&mut forms);
        forms
    })
}

/// The form of an encoding; `None` if it has none.
#[must_use]
pub fn of(encoding: u32) -> Option<&'static Form> {
    all().iter().find(|form| form.matches(encoding))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_has_members_and_a_name_of_its_own() {
        let mut random = Random::new(1);
        let mut names = std::collections::BTreeSet::new();
        for form in all() {
            assert!(names.insert(form.name.clone()), "{} twice", form.name);
            for _ in 0..20 {
                let encoding = form.sample(&mut random);
                assert!(form.matches(encoding) && form.is_predictable(encoding));
            }
        }
        assert!(names.len() > 300, "{}", names.len());
    }
}
