//! What the ELF file says of itself: sections, functions, memory contents, the vector table.

use std::collections::BTreeMap;

use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use crate::Result;

/// A stretch of memory that the firmware takes.
pub(crate) struct Section {
    pub(crate) name: String,
    pub(crate) address: u32,
    pub(crate) size: u32,
}

/// A symbol with a size: a function or a static.
#[derive(Clone, Debug)]
pub(crate) struct Symbol {
    pub(crate) name: String,
    pub(crate) address: u32,
    pub(crate) size: u32,
}

/// What of the ELF file matters here.
pub(crate) struct Elf {
    pub(crate) sections: Vec<Section>,
    /// By address, one name each.
    pub(crate) functions: Vec<Symbol>,
    pub(crate) statics: Vec<Symbol>,
    /// All names of each function.
    names: BTreeMap<u32, Vec<String>>,
    memory: BTreeMap<u32, Vec<u8>>,
}

impl Elf {
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self> {
        let file: ElfFile32<'_> =
            ElfFile32::parse(bytes).map_err(|why| format!("no ELF: {why}"))?;
        let mut sections = Vec::new();
        let mut memory = BTreeMap::new();
        for section in file.sections() {
            // What is not in memory, as debug information, has no address.
            if section.address() == 0 || section.size() == 0 {
                continue;
            }
            let name = section.name().unwrap_or_default().to_owned();
            let (address, size) = (section.address() as u32, section.size() as u32);
            if section.kind() != SectionKind::UninitializedData {
                let data = section.data().map_err(|why| format!("{name}: {why}"))?;
                memory.insert(address, data.to_vec());
            }
            sections.push(Section { name, address, size });
        }
        let symbols: Vec<_> = file
            .symbols()
            .filter(|symbol| symbol.is_definition())
            .map(|symbol| (symbol.kind(), named(&symbol)))
            .collect();
        let text = file.section_by_name(".text").ok_or("it has no .text section")?;
        let text = text.address() as u32..(text.address() + text.size()) as u32;
        let functions = one_name_each(
            symbols.iter().filter(|(kind, symbol)| {
                *kind == SymbolKind::Text && text.contains(&(symbol.address & !1))
            }),
            text.end,
        );
        let mut names = BTreeMap::<u32, Vec<String>>::new();
        for (_, symbol) in symbols.iter().filter(|(kind, _)| *kind == SymbolKind::Text) {
            names.entry(symbol.address & !1).or_default().push(symbol.name.clone());
        }
        let statics = symbols
            .into_iter()
            .filter(|(kind, symbol)| *kind == SymbolKind::Data && symbol.size > 0)
            .map(|(_, symbol)| symbol)
            .collect();
        Ok(Self { sections, functions, statics, names, memory })
    }

    /// A vector table at the beginning of the flash, functions by their distance from it, and
    /// sections without contents.
    #[cfg(test)]
    pub(crate) fn synthetic(
        vectors: &[u32],
        functions: &[(&str, u32, u32)],
        sections: &[(&str, u32, u32)],
    ) -> Self {
        let flash = 0x0800_4000;
        let table: Vec<u8> = vectors.iter().flat_map(|word| word.to_le_bytes()).collect();
        let vectors = (".vector_table", flash, table.len() as u32);
        let section = |(name, address, size): (&str, u32, u32)| Section {
            name: name.to_owned(),
            address,
            size,
        };
        let symbol = |(name, offset, size): &(&str, u32, u32)| Symbol {
            name: (*name).to_owned(),
            address: flash + offset,
            size: *size,
        };
        Self {
            sections: std::iter::once(vectors)
                .chain(sections.iter().copied())
                .map(section)
                .collect(),
            functions: functions.iter().map(symbol).collect(),
            statics: vec![],
            names: functions
                .iter()
                .map(|(name, offset, _)| (flash + offset, vec![(*name).to_owned()]))
                .collect(),
            memory: BTreeMap::from([(flash, table)]),
        }
    }

    /// The bytes from `address` to `end`, if the file holds them all.
    pub(crate) fn bytes(&self, address: u32, end: u32) -> Option<&[u8]> {
        let (start, data) = self.memory.range(..=address).next_back()?;
        data.get((address - start) as usize..(end.checked_sub(*start)?) as usize)
    }

    /// The word at `address`, if the file holds it.
    pub(crate) fn word(&self, address: u32) -> Option<u32> {
        let bytes = self.bytes(address, address.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    }

    /// Initial stack pointer, and the handlers with their numbers: 1 is reset, 16 and up are the
    /// chip's interrupts.
    pub(crate) fn vectors(&self) -> Result<(u32, Vec<(u32, u32)>)> {
        let table = self
            .sections
            .iter()
            .find(|section| section.name == ".vector_table")
            .ok_or("it has no .vector_table section")?;
        let word = |number: u32| self.word(table.address + 4 * number).unwrap_or(0);
        let handlers = (1..table.size / 4)
            .map(|number| (number, word(number) & !1))
            .filter(|(_, handler)| *handler != 0)
            .collect();
        Ok((word(0), handlers))
    }

    /// All names of the function at an address.
    pub(crate) fn names_at(&self, address: u32) -> Vec<String> {
        self.names.get(&address).cloned().unwrap_or_default()
    }

    /// The static of this name, whatever its kind of mangling.
    pub(crate) fn static_named(&self, name: &str) -> Option<&Symbol> {
        self.statics.iter().find(|symbol| symbol.name == name)
    }
}

fn named<'a>(symbol: &impl ObjectSymbol<'a>) -> Symbol {
    Symbol {
        name: demangled(symbol.name().unwrap_or_default()),
        address: symbol.address() as u32,
        size: symbol.size() as u32,
    }
}

/// A symbol's name as it is written in Rust, without the hash.
pub(crate) fn demangled(name: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(name))
}

/// Functions often have several names, and those written in assembly sometimes no size: takes the
/// name that has one, and lets the others end where the next begins.
fn one_name_each<'a>(
    symbols: impl Iterator<Item = &'a (SymbolKind, Symbol)>,
    end: u32,
) -> Vec<Symbol> {
    let mut by_address = BTreeMap::<u32, Symbol>::new();
    for (_, symbol) in symbols {
        let symbol = Symbol { address: symbol.address & !1, ..symbol.clone() };
        let known = by_address.entry(symbol.address).or_insert_with(|| symbol.clone());
        if (symbol.size, &known.name) > (known.size, &symbol.name) {
            *known = symbol;
        }
    }
    let mut functions: Vec<_> = by_address.into_values().collect();
    for i in 0..functions.len() {
        let next = functions.get(i + 1).map_or(end, |next| next.address);
        let function = &mut functions[i];
        if function.size == 0 {
            function.size = next - function.address;
        }
    }
    functions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_names_the_one_with_a_size_is_taken() {
        let symbol = |name: &str, address, size| {
            (SymbolKind::Text, Symbol { name: name.into(), address, size })
        };
        let symbols = [
            symbol("WWDG", 0x101, 0),
            symbol("DefaultHandler", 0x101, 24),
            symbol("by_hand", 0x121, 0),
            symbol("last", 0x131, 4),
        ];
        let functions = one_name_each(symbols.iter(), 0x140);
        let is: Vec<_> = functions.iter().map(|f| (f.name.as_str(), f.address, f.size)).collect();
        assert_eq!(is, [("DefaultHandler", 0x100, 24), ("by_hand", 0x120, 16), ("last", 0x130, 4)]);
    }
}
