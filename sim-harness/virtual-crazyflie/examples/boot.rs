//! Boots an ELF on a drone that lies on the ground, and says what it logs and how it went:
//! `cargo run --release --package virtual-crazyflie --example boot -- ELF [SECONDS [FLASH]]`.
//!
//! FLASH is what fetching costs: `set` as the firmware has set it up, `ideal`, `accelerated`, `off`.

use std::sync::Arc;
use std::time::Instant;

use virtual_crazyflie::board::{Config, Crazyflie, InertialNoise};
use virtual_crazyflie::cpu::FlashTiming;
use virtual_crazyflie::image::Image;
use virtual_crazyflie::log::{Log, Messages, Probe};
use virtual_crazyflie::machine::{FlashModel, Machine, MachineConfig};

const STEP: u64 = 1_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("an ELF file is missing")?;
    let seconds: u64 = arguments.next().map_or(Ok(5), |seconds| seconds.parse())?;
    let flash = match arguments.next().as_deref() {
        None | Some("set") => FlashModel::AsConfigured,
        Some("ideal") => FlashModel::Fixed(FlashTiming::Ideal),
        Some("accelerated") => FlashModel::Fixed(FlashTiming::Accelerated),
        Some("off") => FlashModel::Fixed(FlashTiming::Off),
        Some(other) => return Err(format!("no model of the flash is called {other}").into()),
    };
    let image = Arc::new(Image::parse(std::fs::read(path)?)?);
    let mut log = Log::new(Arc::new(Messages::of(&image)?), Probe::Attached);
    // A sensor without noise is one that has frozen, to the firmware.
    let noise = Some(InertialNoise { seed: 1, gyro: 4, accel: 4 });
    let board = Crazyflie::new(&Config { noise, ..Config::default() });
    let mut machine =
        Machine::new(image, board, MachineConfig { flash, ..MachineConfig::default() });
    let started = Instant::now();
    let mut end = Ok(());
    for step in 1..=seconds * 1000 {
        end = machine.run_until(step * STEP);
        log.drain(machine.memory_mut(), step * STEP);
        for line in log.take() {
            println!("{line}");
        }
        if end.is_err() {
            break;
        }
    }
    let took = started.elapsed().as_secs_f64();
    let (cpu, now) = (machine.cpu(), machine.now() as f64 / 1e9);
    let millions = cpu.instructions() as f64 / 1e6;
    println!("{now:.3} s in {took:.2} s: {:.1} times real time", now / took);
    println!("{millions:.1} million instructions, {:.0} million a second", millions / took);
    println!("asleep {:.1} % of the cycles", 100.0 * cpu.slept() as f64 / cpu.cycles() as f64);
    println!("resets {:?}", machine.resets());
    println!("faults {:?}", machine.fault_reports());
    println!("LEDs {}", machine.board_mut().take_blinks().len());
    println!("state {:016x}", machine.state_hash());
    Ok(end?)
}
