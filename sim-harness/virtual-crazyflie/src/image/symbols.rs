//! Names of addresses, and which addresses hold code.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use crate::memory::map;

/// A function that exists by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// The name as it is written in Rust, without hashes.
    pub name: String,
    /// The address of the first instruction.
    pub address: u32,
    /// The length in bytes, with the constants after its code.
    pub size: u32,
}

impl Function {
    /// The addresses that the function takes.
    #[must_use]
    pub fn range(&self) -> Range<u32> {
        self.address..self.address.saturating_add(self.size)
    }
}

/// The name of an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symbol<'a> {
    /// The function or variable, as it is written in Rust, without hashes.
    pub name: &'a str,
    /// The address at which the function or variable begins.
    pub address: u32,
    /// The offset of the address in it.
    pub offset: u32,
}

/// All symbols of an image.
pub(super) struct Symbols {
    /// The symbols by address, one name each.
    functions: Vec<Function>,
    variables: Vec<Function>,
    /// All names of each function, as they are written in Rust.
    names: BTreeMap<u32, Vec<String>>,
    /// Every name, mangled and as it is written in Rust.
    by_name: HashMap<String, u32>,
    /// Stretches of code, by address.
    code: Vec<Range<u32>>,
    /// Mapping symbols say where there is code.
    mapped: bool,
}

impl Symbols {
    pub(super) fn of(elf: &ElfFile32<'_>) -> Self {
        let mut functions = BTreeMap::new();
        let mut variables = BTreeMap::new();
        let mut names = BTreeMap::<u32, Vec<String>>::new();
        let mut by_name = HashMap::new();
        let mut marks = BTreeMap::new();
        let text: Vec<Range<u32>> = elf
            .sections()
            .filter(|section| section.kind() == SectionKind::Text && section.size() > 0)
            .map(|section| {
                // A damaged header may speak of a section beyond the end of the address space.
                let start = section.address() as u32;
                start..start.saturating_add(section.size() as u32)
            })
            .collect();
        let is_text = |address| text.iter().any(|section| section.contains(&address));
        for symbol in elf.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let address = symbol.address() as u32;
            if let Some(is_code) = mapping(name) {
                marks.insert(address, is_code);
                continue;
            }
            // Those of defmt's table are no addresses but indices.
            if name.is_empty() || symbol.is_undefined() || address < map::FLASH {
                continue;
            }
            let symbol_of =
                |address| Function { name: demangled(name), address, size: symbol.size() as u32 };
            match symbol.kind() {
                SymbolKind::Text if is_text(address & !1) => {
                    keep_better(&mut functions, symbol_of(address & !1));
                    names.entry(address & !1).or_default().push(demangled(name));
                    by_name.entry(name.to_owned()).or_insert(address & !1);
                    continue;
                }
                SymbolKind::Data if symbol.size() > 0 => {
                    keep_better(&mut variables, symbol_of(address));
                }
                _ => {}
            }
            by_name.entry(demangled(name)).or_insert(address);
            by_name.entry(name.to_owned()).or_insert(address);
        }
        let code = if marks.is_empty() { text.clone() } else { stretches(&marks, &text) };
        Self {
            functions: with_sizes(functions, &text),
            variables: variables.into_values().collect(),
            names,
            by_name,
            code,
            mapped: !marks.is_empty(),
        }
    }

    pub(super) fn at(&self, address: u32) -> Option<Symbol<'_>> {
        [&self.functions, &self.variables].into_iter().find_map(|all| {
            let index = all.partition_point(|symbol| symbol.address <= address).checked_sub(1)?;
            let symbol = &all[index];
            symbol.range().contains(&address).then(|| Symbol {
                name: &symbol.name,
                address: symbol.address,
                offset: address - symbol.address,
            })
        })
    }

    pub(super) fn functions(&self) -> &[Function] {
        &self.functions
    }

    pub(super) fn function(&self, name: &str) -> Option<&Function> {
        if let Some(function) = self.functions.iter().find(|function| function.name == name) {
            return Some(function);
        }
        // One of several names of the same code.
        let address = *self.by_name.get(name)?;
        self.functions.iter().find(|function| function.address == address)
    }

    pub(super) fn names_of(&self, function: u32) -> &[String] {
        self.names.get(&function).map_or(&[], Vec::as_slice)
    }

    pub(super) fn variable(&self, name: &str) -> Option<Range<u32>> {
        let address = self.address_of(name)?;
        let variable = self.variables.iter().find(|variable| variable.address == address)?;
        Some(variable.range())
    }

    pub(super) fn address_of(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).copied()
    }

    pub(super) fn is_code(&self, address: u32) -> bool {
        let after = self.code.partition_point(|code| code.start <= address);
        after.checked_sub(1).is_some_and(|index| self.code[index].contains(&address))
    }

    pub(super) const fn are_mapped(&self) -> bool {
        self.mapped
    }

    pub(super) fn code(&self) -> impl Iterator<Item = Range<u32>> {
        self.code.iter().cloned()
    }
}

/// A name as it is written in Rust, without the hash.
pub(super) fn demangled(name: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(name))
}

/// Whether a mapping symbol marks Thumb code, `Some(true)`, or anything else, `Some(false)`
/// (AAELF32, "Mapping symbols"; they may have a suffix after a dot).
fn mapping(name: &str) -> Option<bool> {
    match name.split('.').next() {
        Some("$t") => Some(true),
        Some("$d" | "$a") => Some(false),
        _ => None,
    }
}

/// Functions often have several names, and those written in assembly sometimes no size: prefers
/// the name that has one, and of equals the first in the alphabet.
fn keep_better(all: &mut BTreeMap<u32, Function>, new: Function) {
    match all.get(&new.address) {
        Some(known) if (known.size, &new.name) >= (new.size, &known.name) => {}
        _ => {
            all.insert(new.address, new);
        }
    }
}

/// Lets those without a size end where the next begins.
fn with_sizes(functions: BTreeMap<u32, Function>, text: &[Range<u32>]) -> Vec<Function> {
    let mut functions: Vec<Function> = functions.into_values().collect();
    for i in 0..functions.len() {
        let next = functions.get(i + 1).map_or(u32::MAX, |next| next.address);
        let function = &mut functions[i];
        if function.size == 0 {
            let section = text.iter().find(|section| section.contains(&function.address));
            let end = section.map_or(function.address, |section| section.end.min(next));
            function.size = end - function.address;
        }
    }
    functions
}

fn stretches(marks: &BTreeMap<u32, bool>, text: &[Range<u32>]) -> Vec<Range<u32>> {
    let mut code: Vec<Range<u32>> = Vec::new();
    for section in text {
        let mut marks = marks.range(section.clone()).peekable();
        while let Some((start, is_code)) = marks.next() {
            let end = marks.peek().map_or(section.end, |(next, _)| **next);
            match code.last_mut() {
                _ if !is_code => {}
                Some(last) if last.end == *start => last.end = end,
                _ => code.push(*start..end),
            }
        }
    }
    code.sort_by_key(|stretch| stretch.start);
    code
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(name: &str, address: u32, size: u32) -> Function {
        Function { name: name.into(), address, size }
    }

    #[test]
    fn of_several_names_the_one_with_a_size_is_taken() {
        let mut all = BTreeMap::new();
        for name in ["WWDG", "TIM2"] {
            keep_better(&mut all, function(name, 0x100, 0));
        }
        keep_better(&mut all, function("DefaultHandler", 0x100, 24));
        keep_better(&mut all, function("ADC", 0x100, 0));
        keep_better(&mut all, function("by_hand", 0x120, 0));
        keep_better(&mut all, function("last", 0x130, 0));
        let text = 0x100..0x134;
        let functions = with_sizes(all, std::slice::from_ref(&text));
        let is = [
            function("DefaultHandler", 0x100, 24),
            function("by_hand", 0x120, 0x10),
            function("last", 0x130, 4),
        ];
        assert_eq!(functions, is);
    }

    #[test]
    fn what_lies_between_d_and_t_is_not_code() {
        let marks = [(0x100, true), (0x110, true), (0x120, false), (0x128, true), (0x140, false)];
        let marks = BTreeMap::from(marks);
        let text = 0x100..0x150;
        let code = stretches(&marks, std::slice::from_ref(&text));
        assert_eq!(code, [0x100..0x120, 0x128..0x140]);
        assert_eq!(mapping("$t.7"), Some(true));
        assert_eq!(mapping("$d"), Some(false));
        assert_eq!(mapping("$x"), None);
        assert_eq!(mapping("main"), None);
    }
}
