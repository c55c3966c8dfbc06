//! Observes an emulated drone: its log, and the account of its processor's time.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use virtual_crazyflie::board::Crazyflie;
use virtual_crazyflie::log::{Log, LogLine, Messages, Probe};
use virtual_crazyflie::machine::Machine;
use virtual_crazyflie::profile::{Profile, Report};

/// The functions whose times are kept by name: a step of the control loop, and one of the agent.
pub const CONTROL_STEP: &str = "uchain_firmware::tasks::control::step";
/// The function that runs a step of the agent; see [`CONTROL_STEP`].
pub const AGENT_STEP: &str = "uchain_firmware::tasks::mission::step";

/// The observer of a drone.
#[derive(Debug)]
pub(super) struct Watch {
    log: Option<Log>,
    /// The number of lines that were taken.
    told: usize,
    profile: Option<Arc<Mutex<Profile>>>,
    resets: u64,
}

impl Watch {
    pub(super) fn none(machine: &Machine<Crazyflie>) -> Self {
        Self { log: None, told: 0, profile: None, resets: machine.reset_count() }
    }

    pub(super) fn read_log(&mut self, messages: &Arc<Messages>) {
        self.log = Some(Log::new(Arc::clone(messages), Probe::Absent));
    }

    pub(super) fn profile(&mut self, machine: &mut Machine<Crazyflie>) {
        let image = Arc::clone(machine.image());
        let mut profile = Profile::new(&image);
        for function in [CONTROL_STEP, AGENT_STEP] {
            // A firmware without a function of that name is profiled without it.
            let _ = profile.watch(&image, function);
        }
        profile.restart(machine.cpu());
        for address in profile.traps().collect::<Vec<_>>() {
            machine.program_mut().trap(address);
        }
        let profile = Arc::new(Mutex::new(profile));
        machine.observe(Some(Box::new(Arc::clone(&profile))));
        self.profile = Some(profile);
    }

    /// Looks at the machine; to be called after each slice of time.
    pub(super) fn look(&mut self, machine: &mut Machine<Crazyflie>) {
        let now = machine.now();
        let resets = machine.reset_count();
        let Some(log) = &mut self.log else { return };
        if self.resets != resets {
            self.resets = resets;
            log.reset(machine.memory_mut(), now);
        }
        log.drain(machine.memory_mut(), now);
    }

    pub(super) fn lines(&self) -> &[LogLine] {
        self.log.as_ref().map_or(&[], Log::lines)
    }

    pub(super) fn new_lines(&mut self) -> &[LogLine] {
        let lines = self.log.as_ref().map_or(&[][..], Log::lines);
        let from = std::mem::replace(&mut self.told, lines.len());
        lines.get(from..).unwrap_or_default()
    }

    fn of(profile: &Mutex<Profile>) -> MutexGuard<'_, Profile> {
        profile.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Measures from now on.
    pub(super) fn restart(&self, machine: &Machine<Crazyflie>) {
        if let Some(profile) = &self.profile {
            Self::of(profile).restart(machine.cpu());
        }
    }

    pub(super) fn report(&self, machine: &Machine<Crazyflie>) -> Option<Report> {
        let profile = self.profile.as_ref()?;
        let core_hz = machine.core_hz() as u32;
        Some(Self::of(profile).report(machine.cpu(), machine.memory(), core_hz))
    }
}
