//! Instructions with random operands, whose outcomes were computed by Unicorn's Cortex-M0.
//!
//! A line has an encoding, the registers R0 to R12, SP and LR and the flags before, the same after,
//! the address of the next instruction, and the bytes of RAM that have changed; all in hexadecimal.
//! The instruction is at 0x1000. The byte `i` of the RAM, and the byte `i` from 0x1000 on behind the
//! instruction, is `37 i + 11` before it.

use nrf51_chip::core::{Core, Flags};

use crate::flat::{Flat, RAM};

/// Where the instruction is.
const CODE: u32 = 0x1000;
/// The part of the RAM, and of the code, that is filled.
const FILLED: usize = 0x1000;

fn words(text: &str) -> Vec<u32> {
    text.split_whitespace().map(|word| u32::from_str_radix(word, 16).unwrap()).collect()
}

const fn flags(bits: u32) -> Flags {
    Flags { n: bits >> 3 & 1 != 0, z: bits >> 2 & 1 != 0, c: bits >> 1 & 1 != 0, v: bits & 1 != 0 }
}

/// The outcome of a line by this core, as the line has it.
fn outcome(line: &str) -> (String, String) {
    let fields: Vec<_> = line.split(';').collect();
    let [code, before, flags_before, ..] = fields[..] else { panic!("{line}") };
    let mut memory = Flat::with(&[(0, RAM + 0x800), (4, CODE | 1)], &[]);
    let pattern = |(i, byte): (usize, &mut u8)| *byte = (i * 37 + 11) as u8;
    memory.ram[..FILLED].iter_mut().enumerate().for_each(pattern);
    memory.code[CODE as usize..][..FILLED].iter_mut().enumerate().for_each(pattern);
    let filled = memory.ram.clone();
    for (i, pair) in code.as_bytes().chunks(2).enumerate() {
        let pair = std::str::from_utf8(pair).unwrap();
        memory.code[CODE as usize + i] = u8::from_str_radix(pair, 16).unwrap();
    }
    let mut core = Core::new(&mut memory, 0).unwrap();
    for (register, value) in words(before).into_iter().enumerate() {
        core.set_register(register as u8, value);
    }
    core.set_flags(flags(words(flags_before)[0]));
    if let Err(fault) = core.step(&mut memory) {
        return (fields[3..].join(";"), fault.to_string());
    }
    let registers: Vec<_> = (0..15).map(|it| format!("{:x}", core.register(it))).collect();
    let Flags { n, z, c, v } = core.flags();
    let bits = [n, z, c, v].iter().fold(0, |bits, is| bits << 1 | u32::from(*is));
    let changed = memory.ram.iter().zip(&filled).enumerate().filter(|(_, (is, was))| is != was);
    let changed: Vec<_> = changed.map(|(i, (is, _))| format!("{i:x}:{is:x}")).collect();
    let pc = core.register(15);
    let found = format!("{};{bits:x};{pc:x};{}", registers.join(" "), changed.join(" "));
    (fields[3..].join(";"), found)
}

fn compare(lines: &str) -> usize {
    let mut wrong = Vec::new();
    for line in lines.lines() {
        let (expected, found) = outcome(line);
        if expected != found {
            wrong.push(format!("{line}\n  is {found}"));
        }
    }
    let first: Vec<_> = wrong.iter().take(20).map(String::as_str).collect();
    assert!(wrong.is_empty(), "{} outcomes differ:\n{}", wrong.len(), first.join("\n"));
    lines.lines().count()
}

#[test]
fn every_form_of_an_instruction_has_the_known_outcome() {
    assert!(compare(include_str!("outcomes.txt")) > 300);
}

#[test]
#[ignore = "needs a file of more outcomes in the same format, named by NRF51_OUTCOMES"]
fn the_outcomes_of_a_file_are_this_cores() {
    let path = std::env::var("NRF51_OUTCOMES").expect("NRF51_OUTCOMES names the file");
    let count = compare(&std::fs::read_to_string(path).unwrap());
    println!("{count} outcomes are the same");
}
