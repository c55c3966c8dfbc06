//! Packs the built firmware for the bootloader, and measures its memory, panics and stack.
//!
//! | command | does |
//! |---|---|
//! | `cargo fw-bin` | builds it and writes the flat image that `cfloader` takes |
//! | `cargo fw-sizes` | builds it and measures memory, panics and worst-case stack against budgets |
//!
//! Both build for a Crazyflie 2.1, and with `--plus` for a 2.1+.
//!
//! | module | what it holds |
//! |---|---|
//! | [`firmware`] | building it, as `cargo fw` does |
//! | [`image`] | the flat image and what must be true of it |
//! | [`elf`] | sections, functions, instructions and vector table of the ELF file |
//! | [`flow`] | one function: the depth of its stack at each call |
//! | [`graph`] | the call graph, and the depth of the stack below each function |
//! | [`inlining`] | which functions an instruction was inlined from |
//! | [`stack`] | executors and interrupts: the worst nesting |
//! | [`panics`] | the panics that are left, and why each cannot happen |
//! | [`mod@sizes`] | the table, and the budgets |
//! | [`rules`] | names with wildcards, and the two tables `panics.toml` and `stack.toml` |

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use firmware::Board;
use virtual_crazyflie::image::Image;

mod elf;
mod firmware;
mod flow;
mod graph;
mod image;
mod inlining;
mod panics;
mod rules;
mod sizes;
mod stack;
#[cfg(test)]
mod synthetic;

#[derive(Parser)]
#[command(name = "xtask", about = "Packs and weighs the firmware")]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Build the firmware and write the flat image for the bootloader beside the ELF file
    Bin {
        /// For a Crazyflie 2.1+ instead of a 2.1
        #[arg(long)]
        plus: bool,
    },
    /// Build the firmware and weigh it; exit status 1 when a budget or a rule is broken
    Sizes {
        /// Weigh this ELF file instead of building one
        #[arg(conflicts_with = "plus")]
        elf: Option<PathBuf>,
        /// For a Crazyflie 2.1+ instead of a 2.1
        #[arg(long)]
        plus: bool,
    },
}

/// An error is one line that says what is wrong with the input.
type Result<T> = std::result::Result<T, String>;

fn main() -> ExitCode {
    let outcome = match Arguments::parse().verb {
        Verb::Bin { plus } => bin(Board::of(plus)),
        Verb::Sizes { elf, plus } => sizes(elf, Board::of(plus)),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("xtask: {why}");
            ExitCode::from(2)
        }
    }
}

fn bin(board: Board) -> Result<bool> {
    let elf = firmware::build(board)?;
    let image = image::flatten(&open(&elf)?).map_err(|why| format!("{}: {why}", elf.display()))?;
    let path = elf.with_extension("bin");
    write_whole(&path, &image)?;
    println!("{}", path.display());
    println!("{} bytes for {:#010x}", image.len(), image::FLASH.start);
    println!("CRC-32 {:08x}", crc32fast::hash(&image));
    println!("cfloader flash {} stm32-fw", path.display());
    Ok(true)
}

fn sizes(elf: Option<PathBuf>, board: Board) -> Result<bool> {
    let elf = match elf {
        Some(elf) => elf,
        None => firmware::build(board)?,
    };
    sizes::report(&elf)
}

fn open(elf: &Path) -> Result<Image> {
    Image::open(elf).map_err(|why| format!("{why}; build it with: cargo fw"))
}

/// Writes the file, or leaves what was there.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let part = path.with_extension("bin.part");
    std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, path)).map_err(|why| {
        let _ = std::fs::remove_file(&part);
        format!("{}: {why}", path.display())
    })
}
