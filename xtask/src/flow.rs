//! One function: how deep its stack is at every instruction, and what it calls there.
//!
//! The instructions are carried out on registers that hold a known constant, a known depth below
//! the stack pointer at the function's entry, or nothing known. Where two ways meet, the deeper
//! stack counts. Whatever may move the stack pointer is either understood or an error: it is never
//! passed over.

use std::collections::{BTreeMap, BTreeSet};

use crate::disassembly::Instruction;

/// What a function does to the stack.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Flow {
    /// The most bytes that it takes itself.
    pub(crate) frame: u32,
    /// The same of other stacks that it changes over to, by their tops.
    pub(crate) elsewhere: BTreeMap<u32, u32>,
    pub(crate) calls: Vec<Call>,
    /// Whether it ever comes back.
    pub(crate) returns: bool,
}

/// A call, or a jump to another function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Call {
    /// Where.
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
    /// Out of a register whose content is not known.
    Unknown,
}

/// A function's code, and what is around it.
pub(crate) struct Code<'a> {
    pub(crate) start: u32,
    pub(crate) end: u32,
    /// All of the program's, by address.
    pub(crate) instructions: &'a BTreeMap<u32, Instruction>,
    /// The bytes of the program from one address to another.
    pub(crate) memory: &'a dyn Fn(u32, u32) -> Option<Vec<u8>>,
    /// Functions that never come back.
    pub(crate) diverging: &'a BTreeSet<u32>,
}

/// No function comes near: more than the whole memory means that a loop takes stack.
const ABSURD: u32 = 0x2_0000;

const SP: usize = 13;
const LR: usize = 14;
const PC: usize = 15;
/// Not a register: the top of another stack that has been changed over to.
const STACK: usize = 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    Unknown,
    Constant(u32),
    /// So far below the stack pointer at entry.
    Depth(i64),
}

impl Value {
    fn plus(self, amount: i64) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::Constant(value) => Self::Constant(value.wrapping_add(amount as u32)),
            Self::Depth(depth) => Self::Depth(depth - amount),
        }
    }
}

type State = [Value; 17];

/// What carrying out one instruction leads to.
struct Step {
    state: State,
    /// Goes on with the next instruction.
    falls: bool,
    /// Goes on there, within the function.
    jumps: Vec<u32>,
    returns: bool,
    call: Option<Target>,
}

/// Follows every way through the function.
pub(crate) fn analyse(code: &Code<'_>) -> Result<Flow, String> {
    let mut entry = [Value::Unknown; 17];
    entry[SP] = Value::Depth(0);
    let mut states = BTreeMap::from([(code.start, entry)]);
    let mut waiting = vec![code.start];
    while let Some(at) = waiting.pop() {
        let Some(instruction) = code.at(at) else { continue };
        let step = code.step(instruction, &states[&at])?;
        let next = step.falls.then_some(at + instruction.size);
        for to in next.into_iter().chain(step.jumps) {
            let joined = match states.get(&to) {
                None => step.state,
                Some(known) => join(known, &step.state),
            };
            if depth(&joined) > ABSURD {
                return Err(format!("{at:#010x}: a loop takes stack"));
            }
            if states.insert(to, joined) != Some(joined) {
                waiting.push(to);
            }
        }
    }
    let mut flow = Flow::default();
    for (at, state) in &states {
        let Some(instruction) = code.at(*at) else { continue };
        let step = code.step(instruction, state)?;
        for state in [state, &step.state] {
            let frame = match stack(state) {
                None => &mut flow.frame,
                Some(top) => flow.elsewhere.entry(top).or_default(),
            };
            *frame = (*frame).max(depth(state));
        }
        flow.returns |= step.returns;
        if let Some(to) = step.call {
            flow.calls.push(Call { at: *at, depth: depth(state), stack: stack(state), to });
        }
    }
    Ok(flow)
}

/// Where a branch within the function leads.
pub(crate) fn branch(instruction: &Instruction) -> Option<u32> {
    match (split_condition(&instruction.mnemonic).0, instruction.operands.as_slice()) {
        ("b", [to]) | ("cbz" | "cbnz", [_, to]) => address(to).ok(),
        _ => None,
    }
}

/// The function that a call by name is of.
pub(crate) fn called(instruction: &Instruction) -> Option<u32> {
    match (split_condition(&instruction.mnemonic).0, instruction.operands.as_slice()) {
        ("bl", [to]) => address(to).ok(),
        _ => None,
    }
}

/// Whether the next instruction is never the one that comes after this.
pub(crate) fn ends_block(instruction: &Instruction) -> bool {
    let (base, conditional) = split_condition(&instruction.mnemonic);
    let pops = || instruction.operands.iter().any(|list| mentioned(list).contains(&PC));
    match base {
        "b" | "bx" => !conditional,
        "tbb" | "tbh" | "udf" => true,
        "pop" | "ldm" | "ldr" | "mov" => !conditional && pops(),
        _ => false,
    }
}

fn join(a: &State, b: &State) -> State {
    std::array::from_fn(|i| match (a[i], b[i]) {
        (a, b) if a == b => a,
        (Value::Depth(a), Value::Depth(b)) if i == SP => Value::Depth(a.max(b)),
        _ => Value::Unknown,
    })
}

fn depth(state: &State) -> u32 {
    match state[SP] {
        Value::Depth(depth) => depth.max(0) as u32,
        Value::Unknown | Value::Constant(_) => 0,
    }
}

fn stack(state: &State) -> Option<u32> {
    match state[STACK] {
        Value::Constant(top) => Some(top),
        Value::Unknown | Value::Depth(_) => None,
    }
}

impl Code<'_> {
    fn at(&self, address: u32) -> Option<&Instruction> {
        self.within(address).then(|| self.instructions.get(&address))?
    }

    fn within(&self, address: u32) -> bool {
        (self.start..self.end).contains(&address)
    }

    fn step(&self, instruction: &Instruction, before: &State) -> Result<Step, String> {
        let (base, conditional) = split_condition(&instruction.mnemonic);
        let mut step = self
            .carry_out(base, conditional, instruction, before)
            .map_err(|why| format!("{:#010x}: {why}: {instruction}", instruction.address))?;
        if conditional {
            step.state = join(before, &step.state);
            step.falls = true;
        }
        Ok(step)
    }

    fn carry_out(
        &self,
        base: &str,
        conditional: bool,
        instruction: &Instruction,
        before: &State,
    ) -> Result<Step, String> {
        let mut step =
            Step { state: *before, falls: true, jumps: vec![], returns: false, call: None };
        let operands: Vec<&str> = instruction.operands.iter().map(String::as_str).collect();
        match (base, operands.as_slice()) {
            ("b", [to]) => self.jump(&mut step, address(to)?, false),
            ("cbz" | "cbnz", [_, to]) => self.jump(&mut step, address(to)?, true),
            ("bl", [to]) => self.call(&mut step, Target::At(address(to)?)),
            ("blx", [to]) => {
                let to = target(step.state[register(to)?]);
                self.call(&mut step, to);
            }
            ("bx", ["lr"]) | ("mov", ["pc", "lr"]) => (step.falls, step.returns) = (false, true),
            ("bx", [to]) | ("mov", ["pc", to]) => {
                let to = target(step.state[register(to)?]);
                self.leave(&mut step, to);
            }
            ("tbb" | "tbh", [table]) => {
                step.falls = false;
                step.jumps = self.table(base, table, instruction)?;
            }
            ("udf", _) => step.falls = false,
            _ => {
                let popped = move_registers(base, instruction, &operands, &mut step.state, self)?;
                if popped.contains(&PC) {
                    (step.falls, step.returns) = (conditional, true);
                }
            }
        }
        Ok(step)
    }

    fn jump(&self, step: &mut Step, to: u32, or_not: bool) {
        if self.within(to) {
            step.jumps.push(to);
            step.falls = or_not;
        } else {
            self.leave(step, Target::At(to));
            step.falls = or_not;
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
        for clobbered in [0, 1, 2, 3, 12, LR] {
            step.state[clobbered] = Value::Unknown;
        }
    }

    fn diverges(&self, to: Target) -> bool {
        matches!(to, Target::At(address) if self.diverging.contains(&address))
    }

    /// Where a table branch can go: to every entry up to the next instruction.
    fn table(&self, base: &str, table: &str, from: &Instruction) -> Result<Vec<u32>, String> {
        if !table.starts_with("[pc,") {
            return Err("a table that does not follow its branch".into());
        }
        let start = from.address + 4;
        let end = self.instructions.range(start..).next().map_or(self.end, |(next, _)| *next);
        let bytes = (self.memory)(start, end.min(self.end)).ok_or("a table outside the file")?;
        let entries: Vec<u32> = match base {
            "tbb" => bytes.iter().map(|byte| u32::from(*byte)).collect(),
            _ => bytes
                .chunks_exact(2)
                .map(|pair| u32::from(u16::from_le_bytes([pair[0], pair[1]])))
                .collect(),
        };
        let to: BTreeSet<u32> = entries.into_iter().map(|entry| start + 2 * entry).collect();
        // Padding behind the table points nowhere.
        let to: Vec<u32> = to.into_iter().filter(|to| self.at(*to).is_some()).collect();
        if to.is_empty() { Err("a branch table without a target".into()) } else { Ok(to) }
    }
}

/// Everything that is no branch: keeps the registers' values, and returns those that were popped.
fn move_registers(
    base: &str,
    instruction: &Instruction,
    operands: &[&str],
    state: &mut State,
    code: &Code<'_>,
) -> Result<Vec<usize>, String> {
    if let Some((bytes, popped)) = pushed_or_popped(base, operands)? {
        state[SP] = state[SP].plus(bytes);
        for register in &popped {
            state[*register] = Value::Unknown;
        }
        return Ok(popped);
    }
    if let ("msr", ["msp", top]) = (base, operands) {
        let top @ Value::Constant(_) = state[register(top)?] else {
            return Err("another stack, and not known where".into());
        };
        (state[STACK], state[SP]) = (top, Value::Depth(0));
        return Ok(vec![]);
    }
    match computed(base, instruction, operands, state, code) {
        Some((to, value)) => set(state, to, value)?,
        None => other(base, operands, state)?,
    }
    Ok(vec![])
}

/// By how much a push or a pop moves the stack pointer, and what it pops.
fn pushed_or_popped(base: &str, operands: &[&str]) -> Result<Option<(i64, Vec<usize>)>, String> {
    Ok(match (base, operands) {
        ("push" | "vpush", [list]) | ("stmdb" | "vstmdb", ["sp!", list]) => {
            Some((-list_bytes(list)?, vec![]))
        }
        ("pop" | "vpop", [list]) | ("ldm" | "ldmia" | "vldmia", ["sp!", list]) => {
            Some((list_bytes(list)?, mentioned(list)))
        }
        ("str", [_, place]) | ("strd", [_, _, place])
            if place.starts_with("[sp") && place.ends_with('!') =>
        {
            Some((immediate(place)?, vec![]))
        }
        ("ldr", [to @ .., "[sp]", by]) | ("ldrd", [to @ .., "[sp]", by]) => {
            let bytes = number(by).ok_or("an amount that is no number")?;
            Some((bytes, to.iter().flat_map(|to| mentioned(to)).collect()))
        }
        _ => None,
    })
}

/// The register that an instruction of a known kind writes, and what it then holds.
fn computed(
    base: &str,
    instruction: &Instruction,
    operands: &[&str],
    state: &State,
    code: &Code<'_>,
) -> Option<(usize, Value)> {
    let (to, rest) = operands.split_first()?;
    let to = register(to).ok()?;
    let value = match (base, rest) {
        ("add" | "adds" | "addw", [by]) => sum(state, to, by, 1),
        ("add" | "adds" | "addw", [from, by]) => sum(state, register(from).ok()?, by, 1),
        ("sub" | "subs" | "subw", [by]) => sum(state, to, by, -1),
        ("sub" | "subs" | "subw", [from, by]) => sum(state, register(from).ok()?, by, -1),
        ("mov" | "movs" | "movw", [from]) => operand(state, from),
        ("movt", [high]) => match (state[to], number(high)) {
            (Value::Constant(low), Some(high)) => {
                Value::Constant((low & 0xFFFF) | ((high as u32) << 16))
            }
            _ => Value::Unknown,
        },
        ("bfc", [low, width]) if number(low) == Some(0) => {
            let width = number(width).filter(|width| (0..16).contains(width))?;
            aligned(state[to], (1 << width) - 1)
        }
        ("bic", [from, mask]) => aligned(state[register(from).ok()?], number(mask)?),
        ("ldr", [place]) if place.starts_with("[pc") && to != PC => {
            let bytes = instruction.literal.and_then(|at| (code.memory)(at, at + 4));
            let word = bytes.and_then(|bytes| Some(u32::from_le_bytes(bytes.try_into().ok()?)));
            word.map_or(Value::Unknown, Value::Constant)
        }
        _ => return None,
    };
    Some((to, value))
}

/// An address with its low bits cleared: deeper by all of them, if it was a multiple of four only.
fn aligned(value: Value, mask: i64) -> Value {
    match value {
        Value::Depth(depth) if mask >= 0 && mask < ABSURD.into() && (mask & (mask + 1)) == 0 => {
            Value::Depth(depth + (mask + 1 - 4).max(0))
        }
        _ => Value::Unknown,
    }
}

/// An instruction that is not looked into. Every register that it may write is unknown afterwards;
/// the stack pointer and the program counter it must not write.
fn other(base: &str, operands: &[&str], state: &mut State) -> Result<(), String> {
    const READS: [&str; 18] = [
        "cmp", "cmn", "tst", "teq", "str", "strb", "strh", "strd", "stm", "stmia", "stmib", "vstr",
        "vstm", "vstmia", "msr", "pld", "it", "nop",
    ];
    let reads = READS.contains(&base);
    let first = operands.first().copied().unwrap_or_default();
    let loads_list = matches!(base, "ldm" | "ldmia" | "vldmia" | "vldm");
    if matches!(first, "sp" | "pc") && !reads && !loads_list {
        return Err(format!("what this does to {first} is not understood"));
    }
    if base == "msr" && matches!(first, "psp" | "control") {
        return Err("the process stack, which this firmware does not use".into());
    }
    for (i, operand) in operands.iter().enumerate() {
        let is_place = operand.starts_with('[');
        let moves_base = operand.ends_with('!')
            || is_place && operands.get(i + 1).is_some_and(|by| by.starts_with('#'));
        // Of a load of a list, the first operand is the place.
        let written = moves_base || !(is_place || reads || loads_list && i == 0);
        for register in mentioned(operand) {
            match register {
                SP if moves_base => return Err("this moves the stack pointer".into()),
                PC if written => return Err("a jump through memory".into()),
                SP => {}
                _ if written => state[register] = Value::Unknown,
                _ => {}
            }
        }
    }
    Ok(())
}

fn set(state: &mut State, register: usize, value: Value) -> Result<(), String> {
    match (register, value) {
        (SP, Value::Depth(_)) => {}
        (SP, _) => return Err("the stack pointer is set to what is not known".into()),
        (PC, _) => return Err("a computed jump".into()),
        _ => {}
    }
    state[register] = value;
    Ok(())
}

/// What a register or a number stands for.
fn operand(state: &State, text: &str) -> Value {
    match (register(text), number(text)) {
        (Ok(register), _) => state[register],
        (_, Some(number)) => Value::Constant(number as u32),
        _ => Value::Unknown,
    }
}

/// A register plus or minus another or a number.
fn sum(state: &State, from: usize, by: &str, sign: i64) -> Value {
    match (state[from], operand(state, by)) {
        (value, Value::Constant(by)) => value.plus(sign * i64::from(by as i32)),
        (Value::Constant(from), depth @ Value::Depth(_)) if sign > 0 => {
            depth.plus(i64::from(from as i32))
        }
        _ => Value::Unknown,
    }
}

fn target(value: Value) -> Target {
    match value {
        Value::Constant(address) => Target::At(address & !1),
        Value::Unknown | Value::Depth(_) => Target::Unknown,
    }
}

const CONDITIONS: [&str; 16] = [
    "eq", "ne", "hs", "cs", "lo", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le",
];

/// Instructions whose meaning matters here.
const KNOWN: [&str; 37] = [
    "b", "bl", "blx", "bx", "cbz", "cbnz", "tbb", "tbh", "udf", "push", "pop", "vpush", "vpop",
    "stmdb", "vstmdb", "ldm", "ldmia", "vldmia", "stm", "str", "strd", "ldr", "ldrd", "add",
    "adds", "addw", "sub", "subs", "subw", "mov", "movs", "movw", "movt", "bfc", "bic", "cmp",
    "tst",
];

/// The instruction without its width, and whether it carries a condition.
fn split_condition(mnemonic: &str) -> (&str, bool) {
    let plain = mnemonic.strip_suffix(".w").or(mnemonic.strip_suffix(".n")).unwrap_or(mnemonic);
    if KNOWN.contains(&plain) {
        return (plain, false);
    }
    let known = CONDITIONS
        .iter()
        .find_map(|condition| plain.strip_suffix(condition).filter(|base| KNOWN.contains(base)));
    known.map_or((plain, false), |base| (base, true))
}

fn register(name: &str) -> Result<usize, String> {
    let number = match name {
        "sp" => Some(SP),
        "lr" => Some(LR),
        "pc" => Some(PC),
        _ => name.strip_prefix('r').and_then(|digits| digits.parse().ok()),
    };
    number.filter(|number| *number <= PC).ok_or_else(|| format!("no register: {name}"))
}

/// The registers in an operand, be it a list, an address or one of them.
fn mentioned(operand: &str) -> Vec<usize> {
    operand
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter_map(|word| register(word).ok())
        .collect()
}

/// The bytes of `{r4, r5, lr}` or `{d8, d9}`.
fn list_bytes(list: &str) -> Result<i64, String> {
    let inner = list.strip_prefix('{').and_then(|rest| rest.strip_suffix('}'));
    let inner = inner.ok_or("no list of registers")?;
    let mut bytes = 0;
    for item in inner.split(',').map(str::trim) {
        let width = if item.starts_with('d') { 8 } else { 4 };
        let count = match item.split_once('-') {
            None => 1,
            Some((first, last)) => {
                let number =
                    |name: &str| name.trim_start_matches(char::is_alphabetic).parse::<i64>();
                match (number(first), number(last)) {
                    (Ok(first), Ok(last)) if last >= first => last - first + 1,
                    _ => return Err(format!("no range of registers: {item}")),
                }
            }
        };
        bytes += width * count;
    }
    Ok(bytes)
}

/// `#0x78`, `#-22`, `#-0x10`.
fn number(text: &str) -> Option<i64> {
    let text = text.strip_prefix('#')?;
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    let value = match digits.strip_prefix("0x") {
        Some(hex) => i64::from_str_radix(hex, 16),
        None => digits.parse(),
    };
    value.ok().map(|value| sign * value)
}

/// The number in `[sp, #-8]!`.
fn immediate(place: &str) -> Result<i64, String> {
    let inner = place.trim_start_matches('[').trim_end_matches(['!', ']']);
    inner
        .split(',')
        .nth(1)
        .and_then(|by| number(by.trim()))
        .ok_or_else(|| format!("no number in {place}"))
}

/// `0x8006f24 <main>`.
fn address(operand: &str) -> Result<u32, String> {
    let digits = operand.split(' ').next().unwrap_or_default();
    digits
        .strip_prefix("0x")
        .and_then(|hex| u32::from_str_radix(hex, 16).ok())
        .ok_or_else(|| format!("no address: {operand}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disassembly;

    /// The flow of the listing, one instruction on a line, all of four bytes, the first at 0x100.
    /// `0xc000` and up are other functions; the one at `0xdead` never comes back.
    fn flow(listing: &str) -> Result<Flow, String> {
        flow_with(listing, |_, _| None)
    }

    fn flow_with(
        listing: &str,
        memory: impl Fn(u32, u32) -> Option<Vec<u8>>,
    ) -> Result<Flow, String> {
        let mut text = String::new();
        let mut at = 0x100;
        for line in listing.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let (mnemonic, operands) = line.split_once(' ').unwrap_or((line, ""));
            text += &format!(" {at:x}: 0000 0000 \t{mnemonic}\t{operands}\n");
            at += 4;
        }
        let instructions: BTreeMap<u32, Instruction> =
            disassembly::parse(&text).into_iter().map(|i| (i.address, i)).collect();
        analyse(&Code {
            start: 0x100,
            end: at,
            instructions: &instructions,
            memory: &memory,
            diverging: &BTreeSet::from([0xDEAD]),
        })
    }

    fn calls(flow: &Flow) -> Vec<(u32, Target)> {
        flow.calls.iter().map(|call| (call.depth, call.to)).collect()
    }

    #[test]
    fn pushes_and_subtractions_add_up() {
        let flow = flow(
            "push {r4, r5, r7, lr}
             add r7, sp, #0x8
             push.w {r8, r9, r10, r11}
             vpush {d8, d9}
             sub sp, #0x78
             bl 0xc000 <other>
             add sp, #0x78
             vpop {d8, d9}
             pop.w {r8, r9, r10, r11}
             pop {r4, r5, r7, pc}",
        )
        .unwrap();
        assert_eq!(flow.frame, 16 + 16 + 16 + 0x78);
        assert_eq!(calls(&flow), [(168, Target::At(0xC000))]);
        assert!(flow.returns);
    }

    #[test]
    fn every_way_of_taking_stack_counts() {
        for (take, bytes) in [
            ("sub.w sp, sp, #0x1000", 4096),
            ("subw sp, sp, #0x410", 1040),
            ("sub sp, sp, #8", 8),
            ("stmdb sp!, {r4, lr}", 8),
            ("vstmdb sp!, {s16, s17, s18}", 12),
            ("vpush {d8-d13}", 48),
            ("str lr, [sp, #-8]!", 8),
            ("strd r4, lr, [sp, #-0x10]!", 16),
            ("movw r12, #0x1234\nsub.w sp, sp, r12", 0x1234),
            ("movw r4, #0x10\nmovt r4, #0x1\nsub.w sp, sp, r4", 0x1_0010),
            ("mov r4, sp\nsub.w r4, r4, #0x40\nbfc r4, #0, #4\nmov sp, r4", 0x40 + 12),
            ("sub.w r4, sp, #0x40\nbic r4, r4, #0x1f\nmov sp, r4", 0x40 + 28),
        ] {
            assert_eq!(flow(&format!("{take}\nbl 0xdead")).map(|f| f.frame), Ok(bytes), "{take}");
        }
    }

    #[test]
    fn the_stack_of_a_size_only_known_when_running_is_an_error() {
        for unknown in [
            "sub.w sp, sp, r0",
            "mov sp, r4",
            "ldr sp, [r0]",
            "msr msp, r0",
            "ands sp, r1",
            "ldrb r0, [sp], #1",
            "push {r4}\nb 0x100",
        ] {
            let listing = format!("{unknown}\nbx lr");
            assert!(flow(&listing).is_err(), "{unknown}");
        }
    }

    #[test]
    fn what_is_on_another_stack_is_counted_apart() {
        let flow = flow(
            "push {r4, lr}
             movw r1, #0x480
             movt r1, #0x1000
             msr msp, r1
             push {r4, r5, r6, lr}
             bl 0xc000
             b 0xc100",
        )
        .unwrap();
        assert_eq!((flow.frame, flow.elsewhere), (8, BTreeMap::from([(0x1000_0480, 16)])));
        assert_eq!(flow.calls[0].stack, Some(0x1000_0480));
        assert_eq!(flow.calls[0].depth, 16);
    }

    #[test]
    fn a_frame_pointer_leads_back() {
        let flow = flow(
            "push {r4, r7, lr}
             add r7, sp, #0x4
             sub sp, #0x20
             bl 0xc000
             sub.w r4, r7, #0x4
             mov sp, r4
             bl 0xc000
             pop {r4, r7, pc}",
        )
        .unwrap();
        assert_eq!(calls(&flow), [(44, Target::At(0xC000)), (12, Target::At(0xC000))]);
    }

    #[test]
    fn a_jump_to_another_function_leaves_the_frame_behind() {
        let flow = flow(
            "cbz r0, 0x110
             push {r7, lr}
             pop.w {r7, lr}
             b.w 0xc000 <tail>
             bx lr",
        )
        .unwrap();
        assert_eq!(flow.frame, 8);
        assert_eq!(calls(&flow), [(0, Target::At(0xC000))]);
        assert!(flow.returns);
    }

    #[test]
    fn what_follows_a_call_without_return_is_not_its_continuation() {
        let flow = flow(
            "cbnz r0, 0x110
             push {r7, lr}
             sub sp, #0x40
             bl 0xdead <panic>
             bx lr",
        )
        .unwrap();
        assert_eq!(calls(&flow), [(72, Target::At(0xDEAD))]);
        assert!(flow.returns);
        let flow = self::flow("push {r7, lr}\nbl 0xdead").unwrap();
        assert!(!flow.returns);
    }

    #[test]
    fn where_ways_meet_the_deeper_counts() {
        let flow = flow(
            "cbz r0, 0x10c
             sub sp, #0x10
             b 0x110
             sub sp, #0x30
             bl 0xc000
             bx lr",
        )
        .unwrap();
        assert_eq!(calls(&flow), [(0x30, Target::At(0xC000))]);
    }

    #[test]
    fn a_return_on_condition_may_not_be_taken() {
        let flow = flow(
            "push {r4, lr}
             popne {r4, pc}
             bl 0xc000
             bxeq lr
             pop {r4, pc}",
        )
        .unwrap();
        assert_eq!(calls(&flow), [(8, Target::At(0xC000))]);
    }

    #[test]
    fn a_call_through_a_known_constant_is_a_direct_one() {
        let flow = flow(
            "movw r1, #0x6b09
             movt r1, #0x800
             blx r1
             blx r1",
        )
        .unwrap();
        assert_eq!(calls(&flow), [(0, Target::At(0x0800_6B08)), (0, Target::Unknown)]);
        let literal = |at, _| (at == 0x200).then(|| 0x0800_1235_u32.to_le_bytes().to_vec());
        let flow = flow_with("ldr r3, [pc, #0x4] @ 0x200\nbx r3", literal).unwrap();
        assert_eq!(calls(&flow), [(0, Target::At(0x0800_1234))]);
    }

    #[test]
    fn a_branch_table_leads_to_each_of_its_entries() {
        // The branch at 0x104, the table at 0x108; then instructions at 0x10c and 0x110.
        let text = " 100: 0000 0000 \tsub\tsp, #0x8
 104: 0000 0000 \ttbb\t[pc, r0]
 108: 02 04 04 00  \t.word\t0x00040402
 10c: 0000 0000 \tbl\t0xc000
 110: 0000 0000 \tbl\t0xdead
";
        let instructions: BTreeMap<u32, Instruction> =
            disassembly::parse(text).into_iter().map(|i| (i.address, i)).collect();
        let memory = |at, end| {
            assert_eq!((at, end), (0x108, 0x10C));
            Some(vec![2, 4, 4, 0])
        };
        let diverging = BTreeSet::from([0xDEAD]);
        let code = Code {
            start: 0x100,
            end: 0x114,
            instructions: &instructions,
            memory: &memory,
            diverging: &diverging,
        };
        let flow = analyse(&code).unwrap();
        assert_eq!(calls(&flow), [(8, Target::At(0xC000)), (8, Target::At(0xDEAD))]);
    }

    #[test]
    fn conditions_are_told_from_other_letters() {
        for (mnemonic, is) in [
            ("bls", ("b", true)),
            ("ble.w", ("b", true)),
            ("bl", ("bl", false)),
            ("blt", ("b", true)),
            ("blne", ("bl", true)),
            ("bxeq", ("bx", true)),
            ("bic", ("bic", false)),
            ("subs", ("subs", false)),
            ("movs", ("movs", false)),
            ("movlo", ("mov", true)),
            ("teq.w", ("teq", false)),
            ("vmov.f32", ("vmov.f32", false)),
        ] {
            assert_eq!(split_condition(mnemonic), is, "{mnemonic}");
        }
    }
}
