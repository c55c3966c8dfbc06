//! Encodings against what an assembler says they are.
//!
//! `table.txt` was made with LLVM 14's `llvm-mc -triple=thumbv7em-none-eabihf
//! -mattr=+vfp4d16sp,+dsp --show-encoding` from the instructions in its second column; the third is
//! what is decoded at address 0x0800_1000.

use std::fmt::Write as _;

use super::*;
use proptest::prelude::*;

const ADDRESS: u32 = 0x0800_1000;
const TABLE: &str = include_str!("table.txt");

fn halves(encoding: &str) -> (u16, u16) {
    let bits = u32::from_str_radix(encoding, 16).expect("it is hexadecimal");
    if encoding.len() == 8 { ((bits >> 16) as u16, bits as u16) } else { (bits as u16, 0) }
}

/// An operation with the fields that are not zero.
fn description(op: &Op) -> String {
    let mut text = format!("{:?}", op.kind);
    for (name, value) in [("d", op.d), ("n", op.n), ("m", op.m), ("a", op.a)] {
        if value != 0 {
            write!(text, " {name}{value}").expect("a string takes it");
        }
    }
    if op.imm != 0 {
        write!(text, " {:#x}", op.imm).expect("a string takes it");
    }
    if op.quiet_in_it {
        text.push_str(" quiet-in-it");
    }
    text
}

#[test]
fn every_encoding_of_the_table_is_what_the_assembler_made_it_of() {
    let mut wrong = String::new();
    let mut count = 0;
    for line in TABLE.lines() {
        let (encoding, rest) = line.split_once(" | ").expect("three columns");
        let (text, expected) = rest.split_once(" | ").unwrap_or((rest, ""));
        let (first, second) = halves(encoding);
        let op = decode(ADDRESS, first, second);
        let found = description(&op);
        assert_eq!(usize::from(op.len), encoding.len() / 2, "{text}");
        if found != expected {
            writeln!(wrong, "{encoding} | {text} | {found}").expect("a string takes it");
        }
        count += 1;
    }
    assert!(wrong.is_empty(), "\n{wrong}");
    assert!(count > 650, "{count}");
}

#[test]
fn no_encoding_of_the_table_is_unknown() {
    for line in TABLE.lines() {
        let (first, second) = halves(line.split(' ').next().expect("a column"));
        let op = decode(ADDRESS, first, second);
        let meant = line.contains("udf");
        let unknown = matches!(op.kind, Kind::Undefined | Kind::Unpredictable);
        assert_eq!(unknown, meant, "{line}");
    }
}

proptest! {
    /// Whatever the bits, something is decoded, as long as its first half says, and no operand is
    /// the program counter.
    #[test]
    fn every_encoding_is_something(first: u16, second: u16) {
        let op = decode(ADDRESS, first, second);
        prop_assert_eq!(op.len == 4, is_wide(first));
        prop_assert!(op.cycles >= 1);
        prop_assert!(std::mem::size_of::<Op>() <= 16);
    }
}
