//! Measures the speed of the core, for each model of the flash.
//!
//! ```text
//! cargo run --release -p virtual-crazyflie --example mips
//! ```

use virtual_crazyflie::cpu::FlashTiming;
use virtual_crazyflie::speed;

fn main() {
    for timing in [FlashTiming::Ideal, FlashTiming::Accelerated, FlashTiming::Off] {
        let Some(speed) = speed::measure(timing) else { continue };
        println!(
            "{timing:?}: {:.0} MIPS, {:.2} cycles per instruction, {:.2} x real time, {} rounds",
            speed.mips, speed.cycles_per_instruction, speed.times, speed.rounds
        );
    }
}
