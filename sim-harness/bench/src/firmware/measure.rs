//! Measures the load, the step times and the stack of the firmware on the emulated core, in flight.
//!
//! Times are those of the emulator's model of the core (see `virtual_crazyflie::cpu`), which is not
//! exact to the cycle, so there are two columns: with the flash accelerator as the firmware has set
//! it up, which is the figure, and with every line from flash at its full price, which bounds what
//! the accelerator's model could have got wrong.

use std::path::Path;
use world::World;

use input::InputError;
use units::NodeId;
use virtual_crazyflie::cpu::FlashTiming;
use virtual_crazyflie::machine::{FlashModel, MachineConfig};
use virtual_crazyflie::profile::{Report, WatchedTime};

use bodies::emulated::{AGENT_STEP, CONTROL_STEP, Emulated, Firmware};
use mission::Mission;
use scenario::Scenario;

/// The scenario that is flown.
pub const SCENARIO: &str = "short-hop";
/// The longest that a step of the control loop may take, in µs: a quarter of its millisecond.
pub const CONTROL_AIM_US: f64 = 250.0;
/// The longest that a step of the agent may take, in µs.
pub const AGENT_AIM_US: f64 = 200.0;
/// The largest load of the processor.
pub const LOAD_AIM: f64 = 0.4;
/// When the account begins: all drones have booted and been provisioned by then.
const BEGINS_US: u64 = 3_000_000;
/// A drone that has not begun to fly itself by then never will.
const LONGEST_BOOT_MS: u64 = 5_000;

/// The figures; of several drones, the worst.
#[derive(Clone, Debug)]
pub struct Figures {
    /// The median of the steps of the control loop, in µs.
    pub control_loop_us_p50: f64,
    /// The longest step of the control loop, in µs.
    pub control_loop_us_max: f64,
    /// The longest step of the agent, with the time of interrupts.
    pub agent_step_us_max: f64,
    /// The longest step of the agent, without the time of interrupts.
    pub agent_step_own_us_max: f64,
    /// The part of the time that the core did not sleep.
    pub cpu_load: f64,
    /// The deepest stack.
    pub stack_high_water_bytes: u32,
    /// The time from switching on to the first step of the control loop.
    pub boot_ms: f64,
    /// Each drone's account.
    pub accounts: Vec<(NodeId, Report)>,
}

/// The figures of a firmware.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The bytes of flash.
    pub flash_bytes: u32,
    /// The bytes of RAM, without the stack.
    pub ram_bytes: u32,
    /// The figures with the flash accelerator.
    pub figures: Figures,
    /// The figures without it, which bound the cost of the flash.
    pub bound: Figures,
}

/// Flies the firmware, twice.
///
/// # Errors
/// When there is no ELF to fly, or it does what the emulator does not know.
pub fn run((elf, radio): (&Path, Option<&Path>), seed: u64) -> Result<Measured, InputError> {
    let firmware = Firmware::open(elf)?.with_radio(radio)?;
    let scenario = Scenario::open(SCENARIO)?;
    let world = scenario.world();
    let sizes = firmware.image().sizes();
    let fly = |flash| measure(&firmware, &scenario, &world, seed, flash);
    Ok(Measured {
        flash_bytes: sizes.flash,
        ram_bytes: sizes.ram,
        figures: fly(FlashModel::AsConfigured)?,
        bound: fly(FlashModel::Fixed(FlashTiming::Off))?,
    })
}

fn measure(
    firmware: &Firmware,
    scenario: &Scenario,
    world: &World,
    seed: u64,
    flash: FlashModel,
) -> Result<Figures, InputError> {
    let config = MachineConfig { flash, ..MachineConfig::default() };
    let drone = |node| Emulated::on(scenario, firmware, NodeId(node), seed, config);
    let boot_ms = boot_ms(&mut drone(0));
    let drones = (0..=scenario.drones.relays as u8).map(|node| {
        let mut drone = drone(node);
        drone.profile();
        drone
    });
    let mut mission = Mission::emulated(scenario, world, seed, drones.collect());
    mission.advance(BEGINS_US);
    for member in 0..=scenario.drones.relays {
        if let Some(drone) = mission.emulated_drone_mut(member) {
            drone.restart_profile();
        }
    }
    while !mission.is_over() {
        mission.round();
    }
    if let Some(halted) = mission.halted() {
        let remedy = "the emulator has to learn it";
        return Err(InputError::new(halted.to_string(), remedy).in_file(firmware.path()));
    }
    let accounts = (0..=scenario.drones.relays).filter_map(|member| {
        Some((NodeId(member as u8), mission.emulated_drone(member)?.account()?))
    });
    Ok(Figures::of(accounts.collect(), boot_ms))
}

impl Figures {
    fn of(accounts: Vec<(NodeId, Report)>, boot_ms: f64) -> Self {
        let worst = |of: &dyn Fn(&Report) -> f64| {
            accounts.iter().map(|(_, account)| of(account)).fold(f64::NAN, f64::max)
        };
        let watched = |name: &'static str, of: fn(&WatchedTime) -> f64| {
            move |account: &Report| {
                let found = account.watched.iter().find(|watched| watched.name == name);
                found.map_or(f64::NAN, of)
            }
        };
        let stack = |account: &Report| account.stack.and_then(|stack| stack.by_paint);
        Self {
            control_loop_us_p50: worst(&watched(CONTROL_STEP, |step| step.whole.p50)),
            control_loop_us_max: worst(&watched(CONTROL_STEP, |step| step.whole.max)),
            agent_step_us_max: worst(&watched(AGENT_STEP, |step| step.whole.max)),
            agent_step_own_us_max: worst(&watched(AGENT_STEP, |step| step.own.max)),
            cpu_load: worst(&|account| account.load),
            stack_high_water_bytes: accounts
                .iter()
                .filter_map(|(_, account)| stack(account))
                .max()
                .unwrap_or(0),
            boot_ms,
            accounts,
        }
    }

    /// The aims that were missed, in words.
    #[must_use]
    pub fn missed(&self) -> Vec<String> {
        let rows = [
            ("a control step took", self.control_loop_us_max, CONTROL_AIM_US, "µs"),
            ("a step of the agent took", self.agent_step_own_us_max, AGENT_AIM_US, "µs"),
            ("the processor was busy for", 100.0 * self.cpu_load, 100.0 * LOAD_AIM, "%"),
        ];
        rows.into_iter()
            // A NaN misses its aim too.
            .filter(|(_, is, aim, _)| is.is_nan() || is > aim)
            .map(|(what, is, aim, unit)| format!("{what} {is:.1} {unit}, the aim is {aim} {unit}"))
            .collect()
    }
}

/// Milliseconds from switching on to the first step of the control loop.
fn boot_ms(drone: &mut Emulated) -> f64 {
    (1..=10 * LONGEST_BOOT_MS)
        .find(|tenths| drone.has_booted_by(tenths * 100_000))
        .map_or(f64::NAN, |tenths| tenths as f64 / 10.0)
}
