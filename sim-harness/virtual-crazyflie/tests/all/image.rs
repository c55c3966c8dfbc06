//! What an ELF says of itself, and what is made of ELFs that say nonsense.

use crate::image_tiny::{TINY, machine, tiny};
use proptest::prelude::*;
use virtual_crazyflie::bus::Width;
use virtual_crazyflie::image::{Image, ImageError, Sizes, State};
use virtual_crazyflie::machine::Pause;

#[test]
fn initial_values_are_loaded_where_they_are_stored_not_where_they_are_used() {
    let image = tiny();
    let count = image.address_of("tiny::COUNT").unwrap();
    assert_eq!(count, 0x2000_0400);
    let stored = image.address_of("__sidata").unwrap();
    assert_eq!(image.word(stored), Some(7));
    let (start, flat) = image.flat();
    assert_eq!(start, 0x0800_4000);
    for (address, bytes) in image.segments() {
        let offset = (address - start) as usize;
        assert_eq!(&flat[offset..offset + bytes.len()], bytes);
    }
    assert_eq!(start as usize + flat.len(), stored as usize + 0x34);
}

#[test]
fn it_knows_its_vector_table_its_stack_and_its_size() {
    let image = tiny();
    assert_eq!(image.vector_table(), 0x0800_4000);
    assert_eq!(image.word(image.vector_table() + 4), Some(image.entry() | 1));
    assert_eq!(image.stack(), Some(0x2000_0000..0x2000_0400));
    assert_eq!(image.sizes(), Sizes { flash: 0x40 + 0x116 + 1 + 0x34, ram: 0x44, ccm: 0 });
}

#[test]
fn addresses_have_names() {
    let image = tiny();
    let inner = image.find("tiny::inner").unwrap().clone();
    assert_eq!(image.name_of(inner.address), "tiny::inner");
    assert_eq!(image.name_of(inner.address + 6), "tiny::inner+0x6");
    assert_eq!(image.name_of(0x2000_0402), "tiny::COUNT+0x2");
    assert_eq!(image.name_of(0x0900_0000), "0x09000000");
    assert_eq!(image.find("tiny::middle"), None);
    for function in image.functions() {
        let symbol = image.symbol_at(function.address + function.size - 1).unwrap();
        assert_eq!((symbol.name, symbol.offset), (&*function.name, function.size - 1));
    }
}

#[test]
fn data_among_code_is_no_instruction() {
    let image = tiny();
    let leaf = image.find("tiny::leaf").unwrap();
    let found: Vec<_> = image
        .instructions()
        .filter(|(at, _, _)| leaf.range().contains(at))
        .map(|(_, first, _)| first)
        .collect();
    assert_eq!(found, [0x4801, 0xBF00, 0x4770, 0xBF00]);
    assert!(image.is_code(leaf.address) && !image.is_code(leaf.address + 8));
}

#[test]
fn what_was_inlined_keeps_its_name_and_line() {
    let image = tiny();
    let outer = image.find("tiny::outer").unwrap();
    let call = image
        .instructions()
        .find(|(at, first, _)| outer.range().contains(at) && first >> 11 == 0b11110)
        .map(|(at, _, _)| at)
        .unwrap();
    let frames = image.source_frames(call);
    let names: Vec<_> = frames.iter().map(|frame| frame.function.as_deref().unwrap()).collect();
    assert_eq!(names, ["tiny::middle", "tiny::outer"]);
    for (frame, text) in frames.iter().zip(["inner(n)", "middle(i)"]) {
        let source = frame.source.as_ref().unwrap();
        assert_eq!(source.file, "tiny.rs");
        let line = include_str!("image_tiny/tiny.rs").lines().nth(source.line as usize - 1);
        assert!(line.unwrap().contains(text), "{source}: {line:?}");
    }
}

#[test]
fn a_back_trace_goes_through_an_exception_to_the_reset() {
    let mut machine = machine();
    let leaf = machine.image().find("tiny::leaf").unwrap().address;
    machine.program_mut().trap(leaf);
    assert_eq!(machine.advance_to(1_000_000), Ok(Pause::Trap));
    let load = |address| machine.memory().load(address, Width::Word);
    let trace = machine.image().backtrace(&State::of(machine.cpu()), &load);
    let names: Vec<_> = trace.frames.iter().map(|frame| frame.symbol.as_deref().unwrap()).collect();
    // `supervise` ended by jumping to `leaf`, and `main` lies within `reset`.
    assert_eq!(names, ["tiny::leaf", "svcall", "tiny::inner", "tiny::outer", "reset"]);
    let interrupted: Vec<_> = trace.frames.iter().map(|frame| frame.interrupted).collect();
    assert_eq!(interrupted, [false, false, true, false, false]);
    assert_eq!(trace.cut, None);
    let text = trace.to_string();
    for part in
        ["    --- exception ---\n#2 0x", " tiny::middle at tiny.rs:", " tiny::main at tiny.rs:"]
    {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn at_every_instruction_the_back_trace_ends_at_the_reset() {
    let mut machine = machine();
    for _ in 0..400 {
        assert_eq!(machine.step(1_000_000_000), Ok(Pause::Until));
        let load = |address| machine.memory().load(address, Width::Word);
        let trace = machine.image().backtrace(&State::of(machine.cpu()), &load);
        assert_eq!(trace.cut, None, "{trace}");
        let last = trace.frames.last().unwrap();
        assert_eq!(last.symbol.as_deref(), Some("reset"), "{trace}");
    }
}

#[test]
fn what_is_no_firmware_is_refused_in_one_line() {
    let changed = |at: usize, bytes: &[u8]| {
        let mut elf = TINY.to_vec();
        elf[at..at + bytes.len()].copy_from_slice(bytes);
        Image::parse(elf)
    };
    let program_header = |index: usize, field: usize| 52 + 32 * index + field;
    let table = 0xF4;
    let refused: Vec<String> = [
        Image::parse(vec![]),
        Image::parse(b"not an ELF".to_vec()),
        // ELFCLASS64; big-endian; a machine that is no ARM; a shared library.
        changed(4, &[2]),
        changed(5, &[2]),
        changed(18, &[62]),
        changed(16, &[3]),
        // The code's physical address: in RAM; just beyond the flash; upon the vector table.
        changed(program_header(1, 12), &0x2000_0000_u32.to_le_bytes()),
        changed(program_header(1, 12), &0x080F_FF00_u32.to_le_bytes()),
        changed(program_header(1, 12), &0x0800_4020_u32.to_le_bytes()),
        // A stack nowhere; a reset handler that is no Thumb code.
        changed(table, &0x3000_0000_u32.to_le_bytes()),
        changed(table + 4, &0x0800_4040_u32.to_le_bytes()),
    ]
    .into_iter()
    .map(|result| result.map(|_| ()).unwrap_err().to_string())
    .collect();
    for line in &refused {
        assert!(!line.contains('\n') && line.len() < 150, "{line}");
    }
    for (line, is) in refused.iter().skip(2).zip([
        "not a little-endian 32-bit ARM executable",
        "not a little-endian 32-bit ARM executable",
        "not a little-endian 32-bit ARM executable",
        "not a little-endian 32-bit ARM executable",
        "278 bytes at 0x20000000 do not lie in flash, which is 0x08000000 to 0x080fffff",
        "278 bytes at 0x080fff00 do not lie in flash, which is 0x08000000 to 0x080fffff",
        "two segments lie at 0x08004020",
        "no vector table at 0x08004000: stack pointer 0x30000000, reset handler 0x080040d1",
        "no vector table at 0x08004000: stack pointer 0x20000400, reset handler 0x08004040",
    ]) {
        assert_eq!(line, is);
    }
}

/// Variables that a reset must not clear stand in the vendor's ELF with RAM as their load address.
#[test]
fn a_segment_in_ram_that_is_no_code_is_not_flashed() {
    const WRITABLE: u32 = 6;
    let mut elf = TINY.to_vec();
    let segment = |elf: &[u8], index: usize| {
        let header = 52 + 32 * index;
        let word = |at: usize| u32::from_le_bytes(elf[at..at + 4].try_into().unwrap());
        (word(header), word(header + 16), word(header + 24), header)
    };
    let last = (0..5)
        .rev()
        .map(|index| segment(&elf, index))
        .find(|(kind, size, ..)| *kind == 1 && *size > 0);
    let (_, _, _, header) = last.unwrap();
    elf[header + 12..header + 16].copy_from_slice(&0x2000_1000_u32.to_le_bytes());
    elf[header + 24..header + 28].copy_from_slice(&WRITABLE.to_le_bytes());
    let before = tiny().segments().count();
    assert_eq!(Image::parse(elf).unwrap().segments().count(), before - 1);
}

/// A section of code that would end beyond the last address ends there.
#[test]
fn a_damaged_size_of_a_section_does_not_wrap_its_end() {
    const EXECUTED: u32 = 4;
    let mut elf = TINY.to_vec();
    let word = |elf: &[u8], at: usize| u32::from_le_bytes(elf[at..at + 4].try_into().unwrap());
    let table = word(&elf, 32) as usize;
    let entries = usize::from(u16::from_le_bytes(elf[48..50].try_into().unwrap()));
    let headers = (0..entries).map(|index| table + 40 * index);
    let code: Vec<usize> = headers.filter(|at| word(&elf, at + 8) & EXECUTED != 0).collect();
    assert!(!code.is_empty());
    for header in code {
        elf[header + 20..header + 24].copy_from_slice(&u32::MAX.to_le_bytes());
    }
    let image = Image::parse(elf).unwrap();
    assert!(image.instructions().count() < TINY.len());
    assert!(image.sizes().flash > 0);
}

/// The core clears the two lowest bits of the initial stack pointer: the vendor's ends in 0xFFFF.
#[test]
fn low_bits_of_the_initial_stack_pointer_are_ignored() {
    let mut elf = TINY.to_vec();
    elf[0xF4..0xF8].copy_from_slice(&0x2001_FFFF_u32.to_le_bytes());
    assert!(Image::parse(elf).is_ok());
}

#[test]
fn without_anything_to_load_there_is_nothing_to_fly() {
    let mut elf = TINY.to_vec();
    for index in 0..5 {
        elf[52 + 32 * index] = 4;
    }
    assert_eq!(Image::parse(elf).map(|_| ()), Err(ImageError::NothingToLoad));
}

proptest! {
    #[test]
    fn no_damage_to_a_file_is_more_than_an_error(
        damage in proptest::collection::vec((0..TINY.len(), any::<u8>()), 1..40),
        keep in 0..TINY.len(),
        cut in any::<bool>(),
    ) {
        let mut elf = TINY.to_vec();
        for (at, byte) in damage {
            elf[at] = byte;
        }
        if cut {
            elf.truncate(keep);
        }
        if let Ok(image) = Image::parse(elf) {
            let flat = image.flat();
            prop_assert!(flat.1.len() <= 1 << 20);
            prop_assert!(image.instructions().count() <= 1 << 19);
            for (at, _, _) in image.instructions().take(50) {
                let _ = (image.name_of(at), image.source_frames(at));
            }
            let state = State { registers: [0x0800_4041; 16], other_sp: 0 };
            let _ = image.backtrace(&state, &|_| Some(0xFFFF_FFF9)).to_string();
        }
    }
}
