//! Instructions, as `llvm-objdump` prints them.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Result;

/// One instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Instruction {
    pub(crate) address: u32,
    /// In bytes: two or four.
    pub(crate) size: u32,
    pub(crate) mnemonic: String,
    pub(crate) operands: Vec<String>,
    /// The address that the comment behind names: of a constant that is loaded.
    pub(crate) literal: Option<u32>,
}

impl fmt::Display for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.mnemonic, self.operands.join(", "))
    }
}

/// Disassembles the file with the toolchain's own tool.
pub(crate) fn of(elf: &Path) -> Result<Vec<Instruction>> {
    let output = Command::new(objdump()?)
        .arg("-d")
        .arg(elf)
        .output()
        .map_err(|why| format!("llvm-objdump: {why}"))?;
    if !output.status.success() {
        let why = String::from_utf8_lossy(&output.stderr);
        return Err(format!("llvm-objdump: {}", why.trim()));
    }
    Ok(parse(&String::from_utf8_lossy(&output.stdout)))
}

fn objdump() -> Result<PathBuf> {
    let ask = |arguments: &[&str]| {
        let output = Command::new("rustc").args(arguments).output();
        let output = output.map_err(|why| format!("rustc: {why}"))?;
        Ok::<_, String>(String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let sysroot = ask(&["--print", "sysroot"])?;
    let version = ask(&["-vV"])?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).unwrap_or_default();
    let tool = PathBuf::from(sysroot.trim()).join("lib/rustlib").join(host).join("bin");
    let tool = tool.join(format!("llvm-objdump{}", std::env::consts::EXE_SUFFIX));
    if tool.is_file() {
        Ok(tool)
    } else {
        Err("llvm-objdump is not there; install it with: rustup component add llvm-tools".into())
    }
}

/// The instructions of a listing; labels, headings and data are left out.
pub(crate) fn parse(listing: &str) -> Vec<Instruction> {
    listing.lines().filter_map(instruction).collect()
}

/// ` 80041c6: f002 fead    \tbl\t0x8006f24 <main>        @ imm = #0x2d5a`
fn instruction(line: &str) -> Option<Instruction> {
    let mut columns = line.splitn(3, '\t');
    let (address, code) = columns.next()?.split_once(':')?;
    let address = u32::from_str_radix(address.trim(), 16).ok()?;
    let mnemonic = columns.next()?.trim();
    if mnemonic.starts_with('.') || mnemonic.is_empty() {
        return None;
    }
    let size = code.chars().filter(char::is_ascii_hexdigit).count() as u32 / 2;
    let (operands, comment) = columns.next().unwrap_or("").split_once('@').map_or_else(
        || (line.splitn(3, '\t').nth(2).unwrap_or(""), ""),
        |(operands, comment)| (operands, comment),
    );
    // A few mnemonics are printed with their operand behind a space: `cpsid i`.
    let (mnemonic, inline) = mnemonic.split_once(' ').unwrap_or((mnemonic, ""));
    let mut operands = split(operands);
    operands.extend(split(inline));
    let literal = comment.trim().strip_prefix("0x").and_then(|rest| {
        let digits = rest.split(|c: char| !c.is_ascii_hexdigit()).next()?;
        u32::from_str_radix(digits, 16).ok()
    });
    Some(Instruction { address, size, mnemonic: mnemonic.to_owned(), operands, literal })
}

/// Splits at the commas that are in no bracket.
fn split(operands: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut depth = 0_u32;
    for c in operands.chars() {
        match c {
            '[' | '{' | '<' => depth += 1,
            ']' | '}' | '>' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts.into_iter().map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LISTING: &str = "
fw:\tfile format elf32-littlearm

Disassembly of section .text:

08004188 <__stext>:
 8004188: 4810         \tldr\tr0, [pc, #0x40]         @ 0x80041cc <__stext+0x44>
 800418e: f003 fa8a    \tbl\t0x80076a6 <_defmt_timestamp> @ imm = #0x3514
 800419c: c004         \tstm\tr0!, {r2, r3}
 80041a0: b672         \tcpsid i
 80041ca: de00         \tudf\t#0x0
 80041cc: 08 ed 00 e0  \t.word\t0xe000ed08
 8008e92: bf00         \tnop
";

    #[test]
    fn instructions_are_read_and_data_is_not() {
        let is = parse(LISTING);
        let short: Vec<_> = is.iter().map(|i| (i.address, i.size, i.mnemonic.as_str())).collect();
        let expected = [
            (0x0800_4188, 2, "ldr"),
            (0x0800_418E, 4, "bl"),
            (0x0800_419C, 2, "stm"),
            (0x0800_41A0, 2, "cpsid"),
            (0x0800_41CA, 2, "udf"),
            (0x0800_8E92, 2, "nop"),
        ];
        assert_eq!(short, expected);
        assert_eq!(is[0].operands, ["r0", "[pc, #0x40]"]);
        assert_eq!(is[0].literal, Some(0x0800_41CC));
        assert_eq!(is[1].operands, ["0x80076a6 <_defmt_timestamp>"]);
        assert_eq!(is[1].literal, None);
        assert_eq!(is[2].operands, ["r0!", "{r2, r3}"]);
    }
}
