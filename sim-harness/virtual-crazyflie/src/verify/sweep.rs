//! The encodings that an ELF is made of: a linear sweep through what its mapping symbols call Thumb
//! code (ELF for the Arm Architecture, "Mapping symbols").

use std::collections::BTreeMap;

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionKind};

use super::forms;

/// How often each encoding occurs.
///
/// # Errors
/// If this is no ELF, or one without mapping symbols.
pub fn encodings(elf: &[u8]) -> Result<BTreeMap<u32, u32>, String> {
    let file = object::File::parse(elf).map_err(|error| error.to_string())?;
    let mut found = BTreeMap::new();
    let mut marked = false;
    for section in file.sections().filter(|s| s.kind() == SectionKind::Text) {
        let data = section.data().map_err(|error| error.to_string())?;
        let mut marks: Vec<(u64, bool)> = file
            .symbols()
            .filter(|symbol| symbol.section_index() == Some(section.index()))
            .filter_map(|symbol| {
                let name = symbol.name().ok()?;
                let thumb = name == "$t" || name.starts_with("$t.");
                let data = name == "$d" || name.starts_with("$d.");
                (thumb || data).then_some((symbol.address() - section.address(), thumb))
            })
            .collect();
        marks.sort_unstable();
        marked |= !marks.is_empty();
        for (index, &(from, thumb)) in marks.iter().enumerate() {
            let to = marks.get(index + 1).map_or(data.len() as u64, |(next, _)| *next);
            let (from, to) = (usize::try_from(from), usize::try_from(to));
            if let (true, Ok(from), Ok(to)) = (thumb, from, to)
                && let Some(stretch) = data.get(from..to)
            {
                sweep(stretch, &mut found);
            }
        }
    }
    if marked { Ok(found) } else { Err("there are no mapping symbols".to_owned()) }
}

fn sweep(stretch: &[u8], found: &mut BTreeMap<u32, u32>) {
    let mut halves =
        stretch.as_chunks::<2>().0.iter().map(|half| u32::from(u16::from_le_bytes(*half)));
    while let Some(first) = halves.next() {
        // DDI 0403, A5.1: 0b11101, 0b11110 and 0b11111 begin two halfwords.
        let encoding = if first >= 0xE800 {
            let Some(second) = halves.next() else { return };
            first << 16 | second
        } else {
            first
        };
        *found.entry(encoding).or_insert(0) += 1;
    }
}

/// Which forms an ELF uses, and how often; `Err` holds what has no form.
///
/// # Errors
/// The encodings that have no form.
pub fn forms_of(encodings: &BTreeMap<u32, u32>) -> Result<BTreeMap<&'static str, u32>, Vec<u32>> {
    let mut used = BTreeMap::new();
    let mut unknown = Vec::new();
    for (&encoding, &count) in encodings {
        match forms::of(encoding) {
            Some(form) => *used.entry(form.name.as_str()).or_insert(0) += count,
            None => unknown.push(encoding),
        }
    }
    if unknown.is_empty() { Ok(used) } else { Err(unknown) }
}
