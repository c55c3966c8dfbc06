//! Counts the encodings that a firmware's ELF is made of.

use std::collections::BTreeMap;

use virtual_crazyflie::cpu::is_wide;
use virtual_crazyflie::image::Image;

use crate::forms;

/// The number of times that each encoding occurs in a file.
///
/// # Errors
/// If the file has no mapping symbols, without which code cannot be told from constants.
pub fn encodings(image: &Image) -> Result<BTreeMap<u32, u32>, String> {
    if !image.has_mapping_symbols() {
        return Err("there are no mapping symbols".to_owned());
    }
    let mut found = BTreeMap::new();
    for (_, first, second) in image.instructions() {
        let half = u32::from(first);
        let encoding = if is_wide(first) { half << 16 | u32::from(second) } else { half };
        *found.entry(encoding).or_insert(0) += 1;
    }
    Ok(found)
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
