//! What the firmware's agent was told and what it decided, step by step: a recording by which the
//! same agent on the host can be asked for its opinion.

use std::sync::{Arc, Mutex};

use agent::{BodyVelocity, Fitness, Inputs, Outputs};
use chain::neighbours::Heard;
use serde::Deserialize;
use tunnel_nav::Diagonals;
use units::{Duration, Instant, Metres, Order, Radians};
use virtual_crazyflie::cpu::Cpu;
use virtual_crazyflie::machine::Observer;
use virtual_crazyflie::memory::Memory;

use super::{Emulated, Firmware};

/// One step of the agent.
#[derive(Clone, Debug)]
pub struct Decision {
    /// When, by the drone's clock.
    pub now: Instant,
    /// What it was told.
    pub told: Told,
    /// What it decided; `None` for a step that was not over when the recording ended.
    pub decided: Option<Outputs>,
}

/// What the agent was told: [`Inputs`] that owns what it has heard.
#[derive(Clone, Debug, Deserialize)]
#[expect(missing_docs, reason = "as in agent::Inputs")]
pub struct Told {
    pub ranges: Diagonals,
    pub velocity: Option<BodyVelocity>,
    pub heading: Option<Radians>,
    pub height: Option<Metres>,
    pub heard: Vec<Heard>,
    pub order: Option<Order>,
    pub fitness: Fitness,
    pub endurance: Option<Duration>,
}

impl Told {
    /// As the agent takes it.
    #[must_use]
    pub fn inputs(&self) -> Inputs<'_> {
        Inputs {
            ranges: self.ranges,
            velocity: self.velocity,
            heading: self.heading,
            height: self.height,
            heard: &self.heard,
            order: self.order,
            fitness: self.fitness,
            endurance: self.endurance,
        }
    }
}

/// A recording under way.
#[derive(Clone)]
pub struct Recorder {
    firmware: Firmware,
    decisions: Arc<Mutex<Vec<Decision>>>,
}

impl Recorder {
    /// Begins to record a drone's decisions; `None` where the ELF does not say where they are made.
    pub fn begin(emulated: &mut Emulated) -> Option<Self> {
        let firmware = emulated.firmware().clone();
        let ready = firmware.step()?.ready;
        let recorder = Self { firmware, decisions: Arc::default() };
        let machine = emulated.machine_mut();
        machine.program_mut().trap(ready);
        machine.observe(Some(Box::new(recorder.clone())));
        Some(recorder)
    }

    /// All decisions so far.
    ///
    /// # Panics
    /// When a thread has panicked while it recorded.
    #[must_use]
    pub fn end(&self, emulated: &Emulated) -> Vec<Decision> {
        let mut decisions = self.decisions.lock().expect("nobody panics there").clone();
        if let Some(last) = decisions.last_mut() {
            last.decided = emulated.outputs();
        }
        decisions
    }

    fn look(&self, cpu: &Cpu, memory: &Memory) -> Option<Decision> {
        let step = self.firmware.step()?;
        let now = step.place("now", cpu, memory)?.get(memory).ok()?;
        let told = step.place("inputs", cpu, memory)?.get(memory).ok()?;
        Some(Decision { now, told, decided: None })
    }
}

impl Observer for Recorder {
    fn trap(&mut self, cpu: &Cpu, memory: &Memory) {
        let Some(step) = self.firmware.step() else { return };
        if cpu.pc() != step.ready {
            return;
        }
        // What the step before decided has been published by now.
        let before = self.firmware.thoughts(memory);
        let Ok(mut decisions) = self.decisions.lock() else { return };
        if let Some(last) = decisions.last_mut() {
            last.decided = before;
        }
        decisions.extend(self.look(cpu, memory));
    }
}
