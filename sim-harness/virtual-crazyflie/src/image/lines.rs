//! Finds the place in the source that an address comes from, by the debug information.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use addr2line::Context;
use addr2line::gimli::{self, Dwarf, EndianSlice, LittleEndian};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection};

use super::symbols::demangled;

/// A section of the file.
pub(super) type Bytes<'a> = EndianSlice<'a, LittleEndian>;

/// A place in the source.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Source {
    /// The file, from the root of its package on: `src/control.rs`,
    /// `embassy-executor-0.10.0/src/raw/mod.rs`, `library/core/src/fmt/mod.rs`.
    pub file: String,
    /// The line; 0 where the compiler names none.
    pub line: u32,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// One of the functions that an address belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFrame {
    /// The function's name as it is written in Rust, without hashes.
    pub function: Option<String>,
    /// The source line: the instruction's own in the innermost function, the call's in the others.
    pub source: Option<Source>,
}

/// The lines and inlined functions of an image, opened for many questions.
pub struct SourceMap<'a>(Option<Context<Bytes<'a>>>);

impl SourceMap<'_> {
    /// The functions that an address belongs to, as [`Image::source_frames`] has them.
    ///
    /// [`Image::source_frames`]: super::Image::source_frames
    #[must_use]
    pub fn frames(&self, address: u32) -> Vec<SourceFrame> {
        let found = self.0.as_ref().map(|context| frames(context, address));
        found.and_then(Result::ok).unwrap_or_default()
    }

    /// Whether there is debug information at all.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_none()
    }
}

/// The debug information. Reading it takes some milliseconds; what was asked once is kept.
pub(super) struct Lines {
    file: Arc<[u8]>,
    sections: HashMap<String, Range<usize>>,
    known: Mutex<HashMap<u32, Vec<SourceFrame>>>,
}

impl Lines {
    pub(super) fn of(elf: &ElfFile32<'_>, file: &Arc<[u8]>) -> Self {
        let sections = elf.sections().filter_map(|section| {
            let name = section.name().ok()?;
            let (start, size) = section.file_range()?;
            let range = start as usize..start.checked_add(size)? as usize;
            // A compressed section keeps its name, but not what one expects in it.
            let plain =
                section.compressed_file_range().ok()?.format == object::CompressionFormat::None;
            let good = name.starts_with(".debug_") && plain && range.end <= file.len();
            good.then(|| (name.to_owned(), range))
        });
        Self { sections: sections.collect(), file: file.clone(), known: Mutex::default() }
    }

    /// A section's contents; nothing if there is no such section.
    pub(super) fn section(&self, name: &str) -> Bytes<'_> {
        let range = self.sections.get(name).cloned().unwrap_or(0..0);
        Bytes::new(&self.file[range], LittleEndian)
    }

    /// For each address the functions that it belongs to, the innermost first.
    pub(super) fn frames(&self, addresses: &[u32]) -> Vec<Vec<SourceFrame>> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if addresses.iter().any(|address| !known.contains_key(address)) {
            let map = self.source_map();
            for address in addresses {
                known.entry(*address).or_insert_with(|| map.frames(*address));
            }
        }
        addresses.iter().map(|address| known[address].clone()).collect()
    }

    /// The directories of the compiler's runs, one for each unit that has one.
    pub(super) fn directories(&self) -> Vec<String> {
        let directories = self.dwarf().map(|dwarf| directories(&dwarf));
        directories.and_then(Result::ok).unwrap_or_default()
    }

    /// The offset of a member in a structure. Rust orders members freely.
    pub(super) fn member_offset(&self, structure: &str, member: &str) -> Option<u32> {
        member_offset(&self.dwarf()?, structure, member).ok()?
    }

    pub(super) fn source_map(&self) -> SourceMap<'_> {
        SourceMap(self.dwarf().and_then(|dwarf| Context::from_dwarf(dwarf).ok()))
    }

    fn dwarf(&self) -> Option<Dwarf<Bytes<'_>>> {
        if !self.sections.contains_key(".debug_info") {
            return None;
        }
        Dwarf::load(|id| Ok::<_, gimli::Error>(self.section(id.name()))).ok()
    }
}

fn directories(dwarf: &Dwarf<Bytes<'_>>) -> Result<Vec<String>, gimli::Error> {
    let mut directories = Vec::new();
    let mut units = dwarf.units();
    while let Some(header) = units.next()? {
        let directory = dwarf.unit(header)?.comp_dir;
        directories.extend(directory.map(|name| name.to_string_lossy().into_owned()));
    }
    directories.sort_unstable();
    directories.dedup();
    Ok(directories)
}

fn member_offset(
    dwarf: &Dwarf<Bytes<'_>>,
    structure: &str,
    member: &str,
) -> Result<Option<u32>, gimli::Error> {
    let mut units = dwarf.units();
    while let Some(header) = units.next()? {
        let unit = dwarf.unit(header)?;
        let is_named = |name: Option<gimli::AttributeValue<Bytes<'_>>>, is: &str| {
            let name = name.and_then(|name| dwarf.attr_string(&unit, name).ok());
            name.is_some_and(|name| name.slice() == is.as_bytes())
        };
        let mut entries = unit.entries();
        // How deep the structure lies that is being read.
        let mut within = None;
        while let Some(entry) = entries.next_dfs()? {
            if within.is_some_and(|depth| entry.depth() <= depth) {
                within = None;
            }
            let name = entry.attr_value(gimli::DW_AT_name);
            if entry.tag() == gimli::DW_TAG_structure_type && is_named(name, structure) {
                within = Some(entry.depth());
            } else if within == Some(entry.depth() - 1)
                && entry.tag() == gimli::DW_TAG_member
                && is_named(name, member)
            {
                let place = entry.attr_value(gimli::DW_AT_data_member_location);
                return Ok(place.and_then(|place| u32::try_from(place.udata_value()?).ok()));
            }
        }
    }
    Ok(None)
}

fn frames(context: &Context<Bytes<'_>>, address: u32) -> Result<Vec<SourceFrame>, gimli::Error> {
    let probe = u64::from(address);
    let unit = context.find_dwarf_and_unit(probe).skip_all_loads();
    let directory = unit.and_then(|unit| {
        let directory = unit.comp_dir.as_ref()?;
        Some(directory.to_string_lossy().into_owned())
    });
    let mut found = context.find_frames(probe).skip_all_loads()?;
    let mut frames = Vec::new();
    while let Some(frame) = found.next()? {
        let function = frame.function.and_then(|name| Some(demangled(&name.raw_name().ok()?)));
        let source = frame.location.and_then(|location| {
            let file = shortened(location.file?, directory.as_deref());
            Some(Source { file, line: location.line.unwrap_or(0) })
        });
        frames.push(SourceFrame { function, source });
    }
    Ok(frames)
}

/// A path from the root of its package on: the same on every machine that compiles it.
pub(super) fn shortened(path: &str, directory: Option<&str>) -> String {
    if let Some((_, rest)) = path.split_once("/registry/src/") {
        // Then comes the registry's name.
        return rest.split_once('/').map_or(rest, |(_, rest)| rest).to_owned();
    }
    if let Some(rest) = path.strip_prefix("/rustc/") {
        return rest.split_once('/').map_or(rest, |(_, rest)| rest).to_owned();
    }
    if let Some((_, rest)) = path.split_once("/lib/rustlib/src/rust/") {
        return rest.to_owned();
    }
    let inside = directory.and_then(|directory| path.strip_prefix(directory));
    inside.map_or(path, |inside| inside.trim_start_matches('/')).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_begins_at_its_package() {
        let home = "/home/u/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f";
        for (path, directory, is) in [
            (&*format!("{home}/defmt-1.2.0/src/lib.rs"), None, "defmt-1.2.0/src/lib.rs"),
            ("/rustc/0123abcd/library/core/src/cell.rs", None, "library/core/src/cell.rs"),
            ("/x/house/src/control.rs", Some("/x/house"), "src/control.rs"),
            ("/y/src/control.rs", Some("/x/house"), "/y/src/control.rs"),
        ] {
            assert_eq!(shortened(path, directory), is);
        }
    }
}
