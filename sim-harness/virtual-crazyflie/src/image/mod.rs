//! Reads an ELF: what is flashed, and the names and places in the source of its addresses.

mod backtrace;
mod lines;
mod listing;
mod symbols;

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use object::elf::{FileHeader32, PF_X, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader as _, ProgramHeader as _};
use object::{Endianness, Object, ObjectSection};

use crate::cpu::effect::Instruction;
use crate::cpu::is_wide;
use crate::memory::map;

pub use backtrace::{Backtrace, Frame, State};
use lines::{Lines, shortened};
pub use lines::{Source, SourceFrame, SourceMap};
use symbols::Symbols;
pub use symbols::{Function, Symbol};

/// Why a file cannot be flashed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImageError {
    /// The file is not an ELF file, or a damaged one.
    NotElf(String),
    /// The file is for another machine.
    NotArm,
    /// None of it lies in flash.
    NothingToLoad,
    /// A part of it is to be loaded where there is no flash.
    OutsideFlash {
        /// The address of the part.
        address: u32,
        /// The size of the part in bytes.
        size: u32,
    },
    /// Two parts of it share an address.
    Overlap {
        /// The first one.
        address: u32,
    },
    /// The file has no vector table to start from.
    NoVectorTable,
    /// A vector table that no core could start from.
    BadVectorTable {
        /// The address of the table.
        address: u32,
        /// The initial stack pointer that it gives.
        stack: u32,
        /// The reset handler that it gives.
        reset: u32,
    },
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotElf(why) => write!(f, "not an ELF file: {why}"),
            Self::NotArm => write!(f, "not a little-endian 32-bit ARM executable"),
            Self::NothingToLoad => write!(f, "there is nothing in it to load into flash"),
            Self::OutsideFlash { address, size } => write!(
                f,
                "{size} bytes at {address:#010x} do not lie in flash, which is {:#010x} to {:#010x}",
                map::FLASH,
                map::FLASH + map::FLASH_SIZE - 1
            ),
            Self::Overlap { address } => write!(f, "two segments lie at {address:#010x}"),
            Self::NoVectorTable => write!(f, "it has no vector table"),
            Self::BadVectorTable { address, stack, reset } => write!(
                f,
                "no vector table at {address:#010x}: stack pointer {stack:#010x}, reset handler \
                 {reset:#010x}"
            ),
        }
    }
}

impl std::error::Error for ImageError {}

/// The memory of an image, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Flash: code, constants and the initial values of variables.
    pub flash: u32,
    /// SRAM that is taken for good; the stack is not.
    pub ram: u32,
    /// Core-coupled memory.
    pub ccm: u32,
}

/// A stretch of memory that the program takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// The name in the file: `.text`, `.bss`.
    pub name: String,
    /// The address while the program runs.
    pub address: u32,
    /// The length in bytes.
    pub size: u32,
}

/// A stretch of what is flashed.
#[derive(Clone, Debug)]
struct Segment {
    address: u32,
    /// The offset in the file.
    bytes: Range<usize>,
}

/// An executable for the chip, parsed. It may be shared by any number of machines.
pub struct Image {
    file: Arc<[u8]>,
    segments: Vec<Segment>,
    vector_table: u32,
    entry: u32,
    sections: Vec<Section>,
    symbols: Symbols,
    lines: Lines,
    listing: OnceLock<Vec<Instruction>>,
}

impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Image")
            .field("segments", &self.segments)
            .field("vector_table", &format_args!("{:#010x}", self.vector_table))
            .field("sections", &self.sections)
            .finish_non_exhaustive()
    }
}

/// The path of the firmware's ELF for tests that fly it: the file that the environment variable
/// `UCHAIN_ELF` names, or else the one that `cargo fw` builds beside `target_tmpdir`, which is
/// Cargo's `CARGO_TARGET_TMPDIR`.
#[must_use]
pub fn built_elf(target_tmpdir: &str) -> PathBuf {
    let built = Path::new(target_tmpdir).join("../thumbv7em-none-eabihf/firmware/uchain-firmware");
    std::env::var_os("UCHAIN_ELF").map_or(built, PathBuf::from)
}

impl Image {
    /// Reads and parses an ELF file.
    ///
    /// # Errors
    /// One line with the path, if the file cannot be read or the chip could not be started with it.
    pub fn open(path: &Path) -> Result<Self, String> {
        let named = |why: &dyn fmt::Display| format!("{}: {why}", path.display());
        let bytes = std::fs::read(path).map_err(|why| named(&why))?;
        Self::parse(bytes).map_err(|why| named(&why))
    }

    /// Parses an ELF file's contents.
    ///
    /// # Errors
    /// If the chip could not be started with the file.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, ImageError> {
        let file: Arc<[u8]> = bytes.into();
        let broken = |why: object::Error| ImageError::NotElf(why.to_string());
        let header = FileHeader32::<Endianness>::parse(&*file).map_err(|why| {
            // A good ELF of 64 bits is no damaged one.
            if file.starts_with(b"\x7fELF\x02") { ImageError::NotArm } else { broken(why) }
        })?;
        let endian = header.endian().map_err(broken)?;
        if endian != Endianness::Little
            || header.e_machine(endian) != object::elf::EM_ARM
            || header.e_type(endian) != object::elf::ET_EXEC
        {
            return Err(ImageError::NotArm);
        }
        let segments = segments(&file, header, endian)?;
        let elf: ElfFile32<'_> = ElfFile32::parse(&*file).map_err(broken)?;
        let symbols = Symbols::of(&elf);
        let mut image = Self {
            segments,
            vector_table: 0,
            entry: header.e_entry(endian),
            sections: sections(&elf),
            symbols,
            lines: Lines::of(&elf, &file),
            listing: OnceLock::new(),
            file: file.clone(),
        };
        image.vector_table = image.find_vector_table(&elf)?;
        Ok(image)
    }

    /// The pieces that are written to flash, in order: address and bytes.
    pub fn segments(&self) -> impl Iterator<Item = (u32, &[u8])> {
        self.segments.iter().map(|segment| (segment.address, &self.file[segment.bytes.clone()]))
    }

    /// The bytes of the flash from the first to the last of the image, with the address of the
    /// first; gaps are as erased.
    #[must_use]
    pub fn flat(&self) -> (u32, Vec<u8>) {
        let start = self.segments.first().map_or(map::FLASH, |segment| segment.address);
        let mut flat = Vec::new();
        for (address, bytes) in self.segments() {
            flat.resize((address - start) as usize, 0xFF);
            flat.extend_from_slice(bytes);
        }
        (start, flat)
    }

    /// The address of the vector table.
    #[must_use]
    pub fn vector_table(&self) -> u32 {
        self.vector_table
    }

    /// The entry point, by the file's header.
    #[must_use]
    pub fn entry(&self) -> u32 {
        self.entry & !1
    }

    /// The memory that the image takes.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        let mut sizes = Sizes::default();
        for Section { name, address, size } in &self.sections {
            match address {
                0x0800_0000..=0x0FFF_FFFF => sizes.flash = sizes.flash.saturating_add(*size),
                0x1000_0000..=0x1FFF_FFFF => sizes.ccm = sizes.ccm.saturating_add(*size),
                0x2000_0000..=0x2FFF_FFFF => sizes.ram = sizes.ram.saturating_add(*size),
                _ => {}
            }
            // Initial values lie in flash too.
            if name == ".data" {
                sizes.flash = sizes.flash.saturating_add(*size);
            }
        }
        sizes
    }

    /// The sections that lie in memory; debug information does not.
    #[must_use]
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// The file itself.
    #[must_use]
    pub fn file(&self) -> &[u8] {
        &self.file
    }

    /// The word that is flashed at an address.
    #[must_use]
    pub fn word(&self, address: u32) -> Option<u32> {
        self.flashed(address).map(u32::from_le_bytes)
    }

    /// The halfword that is flashed at an address.
    fn half(&self, address: u32) -> Option<u16> {
        self.flashed(address).map(u16::from_le_bytes)
    }

    fn flashed<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        let (start, bytes) = self.segments().take_while(|(start, _)| *start <= address).last()?;
        bytes.get((address - start) as usize..)?.first_chunk().copied()
    }

    /// The name of the function or variable that an address lies in.
    #[must_use]
    pub fn symbol_at(&self, address: u32) -> Option<Symbol<'_>> {
        self.symbols.at(address)
    }

    /// An address in words: `control::step+0x1c`, or the bare number.
    #[must_use]
    pub fn name_of(&self, address: u32) -> String {
        match self.symbol_at(address) {
            None => format!("{address:#010x}"),
            Some(Symbol { name, offset: 0, .. }) => name.to_owned(),
            Some(Symbol { name, offset, .. }) => format!("{name}+{offset:#x}"),
        }
    }

    /// All functions that exist by themselves, by address. What was inlined everywhere does not.
    #[must_use]
    pub fn functions(&self) -> &[Function] {
        self.symbols.functions()
    }

    /// The function of this name, as it is written in Rust: `uchain_firmware::control::step`.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<&Function> {
        self.symbols.function(name)
    }

    /// All names of the function that begins at an address: the linker makes one of functions that
    /// do the same.
    #[must_use]
    pub fn names_of(&self, function: u32) -> &[String] {
        self.symbols.names_of(function)
    }

    /// The address of a variable.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<Range<u32>> {
        self.symbols.variable(name)
    }

    /// The address of a variable, or of a label that a linker script has made.
    #[must_use]
    pub fn address_of(&self, name: &str) -> Option<u32> {
        self.symbols.address_of(name)
    }

    /// The memory that is meant for the stack, if the linker script says so (`_stack_end` and
    /// `_stack_start`, as in cortex-m-rt).
    #[must_use]
    pub fn stack(&self) -> Option<Range<u32>> {
        let stack = self.address_of("_stack_end")?..self.address_of("_stack_start")?;
        (stack.start < stack.end).then_some(stack)
    }

    /// Whether an address in flash holds an instruction and not data among the code (AAELF32,
    /// "Mapping symbols").
    #[must_use]
    pub fn is_code(&self, address: u32) -> bool {
        self.symbols.is_code(address)
    }

    /// Whether mapping symbols tell code from constants; without them [`Self::is_code`] holds for
    /// every address of a section of code.
    #[must_use]
    pub fn has_mapping_symbols(&self) -> bool {
        self.symbols.are_mapped()
    }

    /// Every instruction in flash: its address, and its one or two halfwords, of which the second
    /// is 0 where there is none.
    pub fn instructions(&self) -> impl Iterator<Item = (u32, u16, u16)> {
        self.symbols.code().flat_map(|code| Instructions { image: self, code })
    }

    /// The source line of an address: that of the innermost of the functions that were inlined
    /// there.
    #[must_use]
    pub fn source(&self, address: u32) -> Option<Source> {
        self.source_frames(address).into_iter().find_map(|frame| frame.source)
    }

    /// The functions that an address belongs to, the innermost first; the last is the one that
    /// was compiled, the others were inlined into it. Empty without debug information.
    #[must_use]
    pub fn source_frames(&self, address: u32) -> Vec<SourceFrame> {
        self.source_frames_of(&[address & !1]).pop().unwrap_or_default()
    }

    /// The lines and inlined functions, opened once for many questions.
    #[must_use]
    pub fn source_map(&self) -> SourceMap<'_> {
        self.lines.source_map()
    }

    /// The functions of each of many addresses, as [`source_frames`](Self::source_frames) has them.
    pub(crate) fn source_frames_of(&self, addresses: &[u32]) -> Vec<Vec<SourceFrame>> {
        self.lines.frames(addresses)
    }

    /// A path of the source as in [`Source`], as a whole path is written in the image.
    pub(crate) fn shortened_paths(&self) -> impl Fn(&str) -> String + use<> {
        let directories = self.lines.directories();
        move |path| {
            let inside = directories.iter().filter(|directory| path.starts_with(*directory));
            shortened(path, inside.max_by_key(|directory| directory.len()).map(String::as_str))
        }
    }

    /// The offset of a member in a structure, by the debug information.
    pub(crate) fn member_offset(&self, structure: &str, member: &str) -> Option<u32> {
        self.lines.member_offset(structure, member)
    }

    /// The functions that have not yet returned, from registers and the stack.
    #[must_use]
    pub fn backtrace(&self, state: &State, load: &dyn Fn(u32) -> Option<u32>) -> Backtrace {
        backtrace::walk(self, state, load)
    }

    fn find_vector_table(&self, elf: &ElfFile32<'_>) -> Result<u32, ImageError> {
        let by_section = elf.section_by_name(".vector_table").map(|table| table.address() as u32);
        let by_symbol = || self.address_of("__RESET_VECTOR").map(|reset| reset.wrapping_sub(4));
        // Without either name: the bootloader takes the table from where the image begins.
        let by_place = || self.segments.first().map(|segment| segment.address);
        let address =
            by_section.or_else(by_symbol).or_else(by_place).ok_or(ImageError::NoVectorTable)?;
        let (Some(stack), Some(reset)) =
            (self.word(address), address.checked_add(4).and_then(|reset| self.word(reset)))
        else {
            return Err(ImageError::NoVectorTable);
        };
        // The core clears the two lowest bits of the initial stack pointer (DDI 0403, B1.5.5); a
        // stack grows down from its end. Code is Thumb.
        let top = stack & !3;
        let inside = |base, size| top > base && top <= base + size;
        let stack_is_good = inside(map::RAM, map::RAM_SIZE) || inside(map::CCM, map::CCM_SIZE);
        if stack_is_good && reset % 2 == 1 && self.word(reset & !3).is_some() {
            Ok(address)
        } else {
            Err(ImageError::BadVectorTable { address, stack, reset })
        }
    }
}

/// The program headers that have something to load, by physical address, which for the initial
/// values of variables is not where they are used.
fn segments(
    file: &[u8],
    header: &FileHeader32<Endianness>,
    endian: Endianness,
) -> Result<Vec<Segment>, ImageError> {
    let headers =
        header.program_headers(endian, file).map_err(|why| ImageError::NotElf(why.to_string()))?;
    let mut segments = Vec::new();
    for header in headers {
        let size = header.p_filesz(endian);
        if header.p_type(endian) != PT_LOAD || size == 0 {
            continue;
        }
        let address = header.p_paddr(endian);
        let start = header.p_offset(endian) as usize;
        let bytes = start..start + size as usize;
        if file.get(bytes.clone()).is_none() {
            return Err(ImageError::NotElf("a segment lies outside the file".into()));
        }
        // A flash tool writes flash only. Variables that a reset must not clear stand in the file
        // with RAM as the address to load them at, and keep what the RAM holds.
        if !header.p_flags(endian).contains(PF_X) && is_ram(address, size) {
            continue;
        }
        let offset = address.wrapping_sub(map::FLASH);
        if offset.checked_add(size).is_none_or(|end| end > map::FLASH_SIZE) {
            return Err(ImageError::OutsideFlash { address, size });
        }
        segments.push(Segment { address, bytes });
    }
    segments.sort_by_key(|segment| segment.address);
    if segments.is_empty() {
        return Err(ImageError::NothingToLoad);
    }
    for pair in segments.windows(2) {
        if pair[0].address as usize + pair[0].bytes.len() > pair[1].address as usize {
            return Err(ImageError::Overlap { address: pair[1].address });
        }
    }
    Ok(segments)
}

/// Whether a stretch lies in RAM or in core-coupled memory.
fn is_ram(address: u32, size: u32) -> bool {
    [(map::RAM, map::RAM_SIZE), (map::CCM, map::CCM_SIZE)].into_iter().any(|(base, capacity)| {
        let end = address.wrapping_sub(base).checked_add(size);
        end.is_some_and(|end| end <= capacity)
    })
}

fn sections(elf: &ElfFile32<'_>) -> Vec<Section> {
    elf.sections()
        .filter(|section| section.address() != 0 && section.size() != 0)
        .map(|section| Section {
            name: section.name().unwrap_or_default().to_owned(),
            address: section.address() as u32,
            size: section.size() as u32,
        })
        .collect()
}

/// Iterates over the instructions of a stretch of code.
struct Instructions<'a> {
    image: &'a Image,
    code: Range<u32>,
}

impl Iterator for Instructions<'_> {
    type Item = (u32, u16, u16);

    fn next(&mut self) -> Option<Self::Item> {
        let at = self.code.start;
        if at >= self.code.end {
            return None;
        }
        let first = self.image.half(at)?;
        let wide = is_wide(first);
        let second = if wide { self.image.half(at + 2)? } else { 0 };
        self.code.start = at + if wide { 4 } else { 2 };
        Some((at, first, second))
    }
}
