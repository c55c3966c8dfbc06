//! The target of an emulated Crazyflie, which runs the firmware's ELF on the ground.

use input::InputError;
use units::{Duration, Instant};
use virtual_crazyflie::board::{Config, Crazyflie, InertialNoise};
use virtual_crazyflie::machine::{Halt, Machine, MachineConfig};
use virtual_crazyflie::rtt::ControlBlock;

use super::target::{BUILD, DOWN, Lost, Target, UP};
use bodies::emulated::Firmware;

/// The time until the firmware has written its control block, which it does before `main`.
const BOOT_NS: u64 = 20_000_000;

/// An emulated Crazyflie at an emulated debug probe.
pub struct EmulatedTarget {
    machine: Machine<Crazyflie>,
    block: ControlBlock,
}

impl EmulatedTarget {
    /// A Crazyflie that was just switched on, without keys and settings, with a debugger attached.
    ///
    /// # Errors
    /// When the firmware does not run, or has no channel for a replay.
    pub fn new(firmware: &Firmware) -> Result<Self, InputError> {
        // A sensor without noise is one that has frozen, to the firmware.
        let noise = Some(InertialNoise { seed: 1, gyro: 4, accel: 4 });
        let board = Crazyflie::new(&Config { noise, ..Config::default() });
        let mut machine = firmware.machine(board, MachineConfig::default());
        machine.cpu_mut().set_debugger(true);
        Self::of(machine).map_err(|error| error.in_file(firmware.path()))
    }

    /// This machine, whether a debugger is attached or not.
    ///
    /// # Errors
    /// When its firmware does not run, or has no channel for a replay.
    pub fn of(mut machine: Machine<Crazyflie>) -> Result<Self, InputError> {
        let wrong = |what: String| InputError::new(what, BUILD);
        let boots = machine.now() + BOOT_NS;
        machine.run_until(boots).map_err(|halt| wrong(format!("does not run: {halt}")))?;
        let block = ControlBlock::of(machine.image())
            .filter(|block| {
                let memory = machine.memory();
                block.down(memory, DOWN).is_some() && block.up(memory, UP).is_some()
            })
            .ok_or_else(|| wrong("has no channel for a replay".into()))?;
        Ok(Self { machine, block })
    }

    /// The machine, for observation.
    #[must_use]
    pub const fn machine(&self) -> &Machine<Crazyflie> {
        &self.machine
    }

    /// The machine, to act on it from outside.
    pub const fn machine_mut(&mut self) -> &mut Machine<Crazyflie> {
        &mut self.machine
    }
}

impl From<Halt> for Lost {
    fn from(halt: Halt) -> Self {
        Self(halt.to_string())
    }
}

/// The firmware's control block is whole from its boot on.
fn spoilt() -> Lost {
    Lost("the firmware's control block was overwritten".into())
}

impl Target for EmulatedTarget {
    const NAME: &'static str = "virtual";

    fn write(&mut self, bytes: &[u8]) -> Result<usize, Lost> {
        let channel = self.block.down(self.machine.memory(), DOWN).ok_or_else(spoilt)?;
        Ok(channel.write(self.machine.memory_mut(), bytes))
    }

    fn read(&mut self) -> Result<Vec<u8>, Lost> {
        let channel = self.block.up(self.machine.memory(), UP).ok_or_else(spoilt)?;
        Ok(channel.take(self.machine.memory_mut()))
    }

    fn run(&mut self, span: Duration) -> Result<(), Lost> {
        let until = self.machine.now() + 1_000 * span.as_micros();
        Ok(self.machine.run_until(until)?)
    }

    fn now(&self) -> Instant {
        Instant::from_micros(self.machine.now() / 1_000)
    }
}
