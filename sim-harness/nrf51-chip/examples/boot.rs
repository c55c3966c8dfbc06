//! Boots the radio chip's firmware and prints what its pins do.

use std::sync::Arc;

use nrf51_chip::image::Program;
use nrf51_chip::{Chip, Config, MICROSECOND};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the firmware's file")?;
    let program = Arc::new(Program::open(path.as_ref())?);
    let mut chip = Chip::new(program, Config::default())?;
    let started = std::time::Instant::now();
    let result = chip.run_until(1_000_000 * MICROSECOND);
    let wall = started.elapsed().as_secs_f64();
    for change in chip.take_pin_changes() {
        let ms = change.at as f64 / (1000 * MICROSECOND) as f64;
        if change.pin != 8 {
            println!("{ms:9.3} ms  P0.{:<2} {:?}", change.pin, change.level);
        }
    }
    println!(
        "{:?} now {} ms pc {:#x} exc {} {:?}",
        result,
        chip.now() / 16000,
        chip.pc(),
        chip.exception(),
        chip.radio()
    );
    for u in chip.unknown() {
        println!("unknown {:#x} {}", u.address, u.is_write);
    }
    println!(
        "{} instructions, {:.1} M/s",
        chip.instructions(),
        chip.instructions() as f64 / wall / 1e6
    );
    Ok(())
}
