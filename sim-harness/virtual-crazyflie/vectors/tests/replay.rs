//! Replays every kept outcome on the emulated core; `README.md` says where the outcomes come from.

use std::collections::BTreeSet;

use core_vectors::vectors::{self, Vector};
use core_vectors::{Rig, forms, sweep};
use virtual_crazyflie::image::{Image, built_elf};

/// What leaves the stream of instructions, or needs more than one: the emulator's own tests of
/// sequences have these.
const ELSEWHERE: [&str; 12] = [
    "BKPT", "IT", "SVC", "UDF.N", "UDF.W", "WFE.N", "WFE.W", "WFI.N", "WFI.W", "YIELD.N",
    "YIELD.W", "(none)",
];

fn kept() -> Vec<Vector> {
    vectors::read(include_bytes!("../core.bin")).expect("core.bin is a vector file")
}

fn name(encoding: u32) -> &'static str {
    forms::of(encoding).map_or("(none)", |form| form.name.as_str())
}

#[test]
fn every_outcome_is_the_one_that_is_kept() {
    let vectors = kept();
    let states: u32 = vectors.iter().map(|vector| vector.compared.count_ones()).sum();
    assert!(vectors.len() > 5000 && states > 80_000, "{} and {states}", vectors.len());
    let mut rig = Rig::new();
    let wrong: Vec<String> = vectors
        .iter()
        .map(|vector| (vector, vector.wrong(&mut rig)))
        .filter(|(_, states)| !states.is_empty())
        .map(|(vector, states)| {
            format!("{} {:08x}, states {states:?}", name(vector.encoding), vector.encoding)
        })
        .collect();
    let first = wrong.iter().take(20).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {} encodings:\n{first}", wrong.len(), vectors.len());
}

#[test]
fn an_outcome_that_is_not_the_kept_one_is_noticed() {
    let mut rig = Rig::new();
    for mut vector in kept().into_iter().step_by(97) {
        let index = vector.compared.trailing_zeros() as usize;
        vector.hashes[index] ^= 1;
        assert_eq!(vector.wrong(&mut rig), [index]);
    }
}

#[test]
fn every_form_has_a_vector() {
    let kept: BTreeSet<&str> = kept().iter().map(|vector| name(vector.encoding)).collect();
    let missing: Vec<&str> = forms::all()
        .iter()
        .map(|form| form.name.as_str())
        .filter(|name| !kept.contains(name) && !ELSEWHERE.contains(name))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
#[ignore = "needs the firmware's ELF, which `cargo fw` builds"]
fn the_firmware_uses_no_form_without_a_vector() {
    let image = Image::open(&built_elf(env!("CARGO_TARGET_TMPDIR"))).expect("`cargo fw` builds it");
    let encodings = sweep::encodings(&image).expect("it has mapping symbols");
    let used = sweep::forms_of(&encodings).expect("every encoding has a form");
    let kept: BTreeSet<&str> = kept().iter().map(|vector| name(vector.encoding)).collect();
    let missing: Vec<_> = used
        .iter()
        .filter(|(form, _)| !kept.contains(*form) && !ELSEWHERE.contains(form))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}
