//! Bugs of loads and stores.

use super::Mutant;

/// All of them.
pub(super) const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "LDRSB does not extend",
        forms: &["LDRSB reg", "LDRSB imm12", "LDRSB pre"],
        alter: |b| {
            let t = b.f(b't') as usize;
            b.after.r[t] &= 0xFF;
        },
    },
    Mutant {
        name: "no base is written back",
        forms: &["LDR pre", "LDR post", "STR pre", "STR post", "LDRD pre", "STM.N", "VLDM db"],
        alter: |b| {
            let n = b.f(b'n') as usize;
            b.after.r[n] = b.before.r[n];
        },
    },
    Mutant {
        name: "STRB stores a byte more",
        forms: &["STRB imm", "STRB reg", "STRB imm12"],
        alter: |b| {
            if let Some(&(place, byte)) = b.after.memory.first() {
                b.after.memory.push((place + 1, byte ^ 1));
            }
        },
    },
    Mutant {
        name: "STM stores downwards",
        forms: &["STM", "PUSH", "STMDB"],
        alter: |b| {
            let bytes: Vec<u8> = b.after.memory.iter().rev().map(|(_, byte)| *byte).collect();
            b.after.memory.iter_mut().zip(bytes).for_each(|(to, byte)| to.1 = byte);
        },
    },
    Mutant {
        name: "VLDM loads one too few",
        forms: &["VLDM ia"],
        alter: |b| {
            let count = b.encoding & 0xFF;
            let first = if b.form.name.ends_with('D') {
                (b.encoding >> 12 & 15) as usize * 2
            } else {
                b.fd()
            };
            let last = first + count as usize - 1;
            b.after.s[last] = b.before.s[last];
        },
    },
];
