//! Follows one function: how deep its stack is at every instruction, and what it calls there.
//!
//! Each instruction's effect is applied to registers that hold a known constant, a known depth
//! below the stack pointer at the function's entry, or nothing known. Where two ways meet, the
//! deeper stack counts. An instruction that may move the stack pointer is either understood or an
//! error: it is never passed over.

use std::collections::{BTreeMap, BTreeSet};

use virtual_crazyflie::cpu::effect::{Effect, Instruction};

mod values;

#[cfg(test)]
mod tests;

use values::{ABSURD, State, Value};

const LR: u8 = 14;
/// The bit of PC in a list of registers.
const PC_BIT: u16 = 1 << 15;
/// R0 to R3, R12 and LR, which a call does not preserve (AAPCS32, 6.1.1).
const CALL_CLOBBERED: u16 = 0b0101_0000_0000_1111;

/// The use of the stack by a function.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Flow {
    /// The most bytes that it takes itself.
    pub(crate) frame: u32,
    /// The use of other stacks that it switches to, by their tops.
    pub(crate) elsewhere: BTreeMap<u32, u32>,
    pub(crate) calls: Vec<Call>,
    /// Whether it ever returns.
    pub(crate) returns: bool,
}

/// A call, or a jump to another function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Call {
    /// The instruction's address.
    pub(crate) at: u32,
    /// Bytes that its caller has on the stack then.
    pub(crate) depth: u32,
    /// The top of the stack, when it is not the one that the caller was called on.
    pub(crate) stack: Option<u32>,
    pub(crate) to: Target,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// A function's address.
    At(u32),
    /// The content of a register, which is not known.
    Unknown,
}

/// A function's code, and what is around it.
pub(crate) struct Code<'a> {
    pub(crate) start: u32,
    pub(crate) end: u32,
    /// All of the program's, by address.
    pub(crate) instructions: &'a BTreeMap<u32, Instruction>,
    /// Functions that never return.
    pub(crate) diverging: &'a BTreeSet<u32>,
}

/// The targets of one instruction.
struct Step {
    state: State,
    /// The next instruction is executed.
    falls: bool,
    /// These addresses within the function can be executed next.
    jumps: Vec<u32>,
    returns: bool,
    call: Option<Target>,
}

/// Follows every way through the function.
pub(crate) fn analyse(code: &Code<'_>) -> Result<Flow, String> {
    let states = code.states()?;
    let mut flow = Flow::default();
    for (at, state) in &states {
        let Some(instruction) = code.at(*at) else { continue };
        let step = code.step(instruction, state)?;
        for state in [state, &step.state] {
            let frame = match state.stack {
                None => &mut flow.frame,
                Some(top) => flow.elsewhere.entry(top).or_default(),
            };
            *frame = (*frame).max(state.depth());
        }
        flow.returns |= step.returns;
        if let Some(to) = step.call {
            flow.calls.push(Call { at: *at, depth: state.depth(), stack: state.stack, to });
        }
    }
    Ok(flow)
}

/// The address within the function that a branch leads to.
pub(crate) fn branch(instruction: &Instruction) -> Option<u32> {
    match instruction.effect {
        Effect::Jump(to) => Some(to),
        _ => None,
    }
}

/// The function that an instruction calls by its address.
pub(crate) fn called(instruction: &Instruction) -> Option<u32> {
    match instruction.effect {
        Effect::Call(to) => Some(to),
        _ => None,
    }
}

/// Whether execution never falls through to the next instruction.
pub(crate) fn ends_block(instruction: &Instruction) -> bool {
    let leaves = match instruction.effect {
        Effect::Jump(_) | Effect::JumpRegister(_) | Effect::JumpTable(_) | Effect::Fault => true,
        Effect::Stack { loaded, .. } => loaded & PC_BIT != 0,
        _ => false,
    };
    leaves && !instruction.conditional
}

impl Code<'_> {
    fn at(&self, address: u32) -> Option<&Instruction> {
        self.within(address).then(|| self.instructions.get(&address))?
    }

    fn within(&self, address: u32) -> bool {
        (self.start..self.end).contains(&address)
    }

    /// The known values before each instruction that can be reached.
    fn states(&self) -> Result<BTreeMap<u32, State>, String> {
        let mut states = BTreeMap::from([(self.start, State::at_entry())]);
        let mut waiting = vec![self.start];
        while let Some(at) = waiting.pop() {
            let Some(instruction) = self.at(at) else { continue };
            let step = self.step(instruction, &states[&at])?;
            let next = step.falls.then_some(at + instruction.size);
            for to in next.into_iter().chain(step.jumps) {
                let joined = states.get(&to).map_or(step.state, |known| known.join(&step.state));
                if joined.depth() > ABSURD {
                    return Err(format!("{at:#010x}: a loop takes stack"));
                }
                if states.insert(to, joined) != Some(joined) {
                    waiting.push(to);
                }
            }
        }
        Ok(states)
    }

    fn step(&self, instruction: &Instruction, before: &State) -> Result<Step, String> {
        let mut step = self
            .apply(&instruction.effect, before)
            .map_err(|why| format!("{:#010x}: {why}", instruction.address))?;
        if instruction.conditional {
            step.state = before.join(&step.state);
            step.falls = true;
        }
        Ok(step)
    }

    fn apply(&self, effect: &Effect, before: &State) -> Result<Step, String> {
        let mut step =
            Step { state: *before, falls: true, jumps: vec![], returns: false, call: None };
        match *effect {
            Effect::Jump(to) => self.jump(&mut step, to),
            Effect::JumpRegister(LR) => (step.falls, step.returns) = (false, true),
            Effect::JumpRegister(register) => {
                self.leave(&mut step, target(before.register(register)));
            }
            Effect::JumpTable(ref targets) => {
                step.falls = false;
                step.jumps = self.known(targets)?;
            }
            Effect::Call(to) => self.call(&mut step, Target::At(to)),
            Effect::CallRegister(register) => {
                self.call(&mut step, target(before.register(register)));
            }
            Effect::Fault => step.falls = false,
            Effect::Stack { by, loaded } => {
                step.state.move_stack(by);
                step.state.forget(loaded);
                step.returns = loaded & PC_BIT != 0;
                step.falls = !step.returns;
            }
            Effect::Set { register, value } => step.state.set(register, value)?,
            Effect::SetMainStack(register) => step.state.change_stack(before.register(register))?,
            Effect::StoreExclusive { status, .. } => step.state.forget(1 << status),
            Effect::Clobbers(registers) => step.state.forget(registers),
            Effect::Opaque(why) => return Err(why.into()),
        }
        Ok(step)
    }

    fn jump(&self, step: &mut Step, to: u32) {
        if self.within(to) {
            step.jumps.push(to);
            step.falls = false;
        } else {
            self.leave(step, Target::At(to));
        }
    }

    /// A jump to another function, which returns in this one's stead.
    fn leave(&self, step: &mut Step, to: Target) {
        step.falls = false;
        step.returns = !self.diverges(to);
        step.call = Some(to);
    }

    fn call(&self, step: &mut Step, to: Target) {
        step.falls = !self.diverges(to);
        step.call = Some(to);
        step.state.forget(CALL_CLOBBERED);
    }

    fn diverges(&self, to: Target) -> bool {
        matches!(to, Target::At(address) if self.diverging.contains(&address))
    }

    /// The targets of a branch table at which an instruction lies; padding behind the table has
    /// none.
    fn known(&self, targets: &[u32]) -> Result<Vec<u32>, String> {
        let known: Vec<u32> = targets.iter().copied().filter(|to| self.at(*to).is_some()).collect();
        if known.is_empty() { Err("a branch table without a target".into()) } else { Ok(known) }
    }
}

fn target(value: Value) -> Target {
    match value {
        Value::Constant(address) => Target::At(address & !1),
        Value::Unknown | Value::Depth(_) => Target::Unknown,
    }
}
