//! A stretch of code, decoded beforehand.
//!
//! Each halfword is decoded as if an instruction began there: no jump can land where nothing is
//! known, and where instructions begin need not be found out. What is executed one after the other
//! stands one after the other, so that following it is counting: first the instructions that are
//! decoded one after the other from the first byte on, then, for every halfword inside one of them,
//! those that are decoded from there on, until they meet one that is there already.
//!
//! Behind all of it, the blocks of most ITs stand once more, each twice: as it is executed if the
//! condition passes, and as it is if not.
//!
//! Addresses can be marked with traps, which cost nothing anywhere else.
//!
//! It is decoded once: when flash is programmed where it has code, a new one has to be made.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::decode::{decode, is_wide};
use super::op::{Kind, Op};
use super::timing;

const NOT_YET: u32 = u32::MAX;

/// Code at an address. Copies share what they hold until one of them is marked.
#[derive(Clone)]
pub struct Program {
    base: u32,
    ops: Arc<[Op]>,
    /// The address of each.
    addresses: Arc<[u32]>,
    /// Which of them begins at each halfword.
    places: Arc<[u32]>,
    /// Where the copies of blocks begin, and ITSTATE at each of their places.
    blocks: usize,
    it_states: Arc<[u8]>,
    /// The instructions that traps replace, by address; where there are copies, the original first.
    trapped: BTreeMap<u32, Vec<(usize, Op)>>,
}

impl Program {
    /// The code in these bytes, the first of which lies at `base`, an even address.
    #[must_use]
    pub fn new(base: u32, bytes: &[u8]) -> Self {
        let halves: Vec<u16> =
            bytes.as_chunks::<2>().0.iter().map(|half| u16::from_le_bytes(*half)).collect();
        let address = |half: usize| base.wrapping_add(2 * half as u32);
        let mut ops = vec![Op::new(Kind::Outside, 2)];
        let mut addresses = vec![0];
        let mut places = vec![NOT_YET; halves.len()];
        for begin in 0..halves.len() {
            if places[begin] != NOT_YET {
                continue;
            }
            let mut half = begin;
            let last = loop {
                match (halves.get(half), halves.get(half + 1)) {
                    (Some(_), _) if places[half] != NOT_YET => break Op::goto(places[half]),
                    (Some(&first), second) if second.is_some() || !is_wide(first) => {
                        let op = decode(address(half), first, second.copied().unwrap_or(0));
                        places[half] = ops.len() as u32;
                        addresses.push(address(half));
                        ops.push(op);
                        half += usize::from(op.len) / 2;
                    }
                    (first, _) => {
                        if first.is_some() {
                            places[half] = ops.len() as u32;
                        }
                        break Op::new(Kind::Outside, 2);
                    }
                }
            };
            addresses.push(address(half));
            ops.push(last);
        }
        for (before, after) in (1..ops.len()).zip(2..ops.len()) {
            ops[before].cycles = timing::cycles_before(&ops[before], &ops[after]);
        }
        let place = |address: u32| {
            let half = (address.wrapping_sub(base) >> 1) as usize;
            places.get(half).copied()
        };
        for index in 1..ops.len() {
            if let Some(condition) = ops[index].kind.condition() {
                ops[index].d = condition;
            }
            if ops[index].kind.branches() {
                let target = ops[index].imm;
                ops[index].imm = place(target).unwrap_or_else(|| {
                    addresses.push(target);
                    ops.push(Op::new(Kind::Outside, 2));
                    ops.len() as u32 - 1
                });
            }
        }
        let blocks = ops.len();
        let it_states = copy_blocks(&mut ops, &mut addresses);
        for (op, address) in ops.iter_mut().zip(&addresses) {
            if op.kind != Kind::Outside {
                op.line = timing::line_of_code(*address);
            }
        }
        for place in 0..blocks {
            if ops[place].kind == Kind::Block {
                let end = place + usize::from(ops[place].a);
                ops[place].m |= u8::from(ops[end].line != ops[place].line);
            }
        }
        for (first, second) in (1..blocks).zip(2..blocks) {
            if ops[second].kind.condition().is_some() && ops[second].line == ops[first].line {
                ops[first].kind = ops[first].kind.with_branch();
            }
        }
        Self {
            base,
            ops: ops.into(),
            addresses: addresses.into(),
            places: places.into(),
            blocks,
            it_states: it_states.into(),
            trapped: BTreeMap::new(),
        }
    }

    /// The core stops before it executes the instruction at this address. False where the program
    /// has none.
    pub fn trap(&mut self, address: u32) -> bool {
        if self.trapped.contains_key(&address) {
            return true;
        }
        let place = self.place(address);
        if address & 1 != 0 || place == Self::OUTSIDE {
            return false;
        }
        let copies = (self.blocks..self.ops.len())
            .filter(|&copy| self.addresses[copy] == address && self.ops[copy].kind != Kind::Goto);
        let all: Vec<usize> = std::iter::once(place).chain(copies).collect();
        let ops = Arc::make_mut(&mut self.ops);
        let mut real = Vec::with_capacity(all.len());
        for place in all {
            real.push((place, ops[place]));
            ops[place] = ops[place].as_kind(Kind::Trap);
        }
        self.trapped.insert(address, real);
        true
    }

    /// Removes a trap.
    pub fn untrap(&mut self, address: u32) {
        for (place, op) in self.trapped.remove(&address).unwrap_or_default() {
            Arc::make_mut(&mut self.ops)[place] = op;
        }
    }

    /// Whether it would.
    #[must_use]
    pub fn is_trapped(&self, address: u32) -> bool {
        self.trapped.contains_key(&address)
    }

    /// The place of what is not part of the program.
    pub(super) const OUTSIDE: usize = 0;

    /// The place of the instruction at an address.
    #[inline(always)]
    pub(super) fn place(&self, address: u32) -> usize {
        let half = (address.wrapping_sub(self.base) >> 1) as usize;
        self.places.get(half).map_or(Self::OUTSIDE, |&place| place as usize)
    }

    /// The instruction at a place, or the trap on it.
    #[inline(always)]
    pub(super) fn op(&self, place: usize) -> &Op {
        &self.ops[place]
    }

    /// The address of a place.
    #[inline(always)]
    pub(super) fn address(&self, place: usize) -> u32 {
        self.addresses[place]
    }

    /// An instruction as it is outside the program.
    pub(super) fn alone(&self, op: &Op) -> Op {
        if op.kind.branches() { Op { imm: self.address(op.imm as usize), ..*op } } else { *op }
    }

    /// ITSTATE at a place in a copy of a block.
    #[inline(always)]
    pub(super) fn it_state(&self, place: usize) -> Option<u8> {
        self.it_states.get(place.wrapping_sub(self.blocks)).copied()
    }

    /// The instruction at a place, without the trap on it.
    pub(super) fn real_op(&self, place: usize) -> &Op {
        match self.ops[place] {
            Op { kind: Kind::Trap, .. } => &self.trapped[&self.addresses[place]][0].1,
            _ => &self.ops[place],
        }
    }
}

/// Copies the blocks of ITs behind everything else. Returns ITSTATE at each place of the copies.
fn copy_blocks(ops: &mut Vec<Op>, addresses: &mut Vec<u32>) -> Vec<u8> {
    let mut it_states = Vec::new();
    for place in 0..ops.len() {
        let (Kind::It, first) = (ops[place].kind, ops[place].imm as u8) else { continue };
        let count = 4 - first.trailing_zeros() as usize;
        let Some(block) = ops.get(place + 1..place + 1 + count) else { continue };
        let (Some(end), Some(&behind)) = (block.last(), addresses.get(place + 1 + count)) else {
            continue;
        };
        let inner = &block[..count - 1];
        if !inner.iter().all(|op| op.in_it().kind.falls_through()) || !end.in_it().kind.ends_block()
        {
            continue;
        }
        let block = block.to_vec();
        let states: Vec<u8> =
            std::iter::successors(Some(first), |&it| Some(advanced(it))).take(count).collect();
        let executed = |passes: bool, it: u8| (it >> 4 & 1 == first >> 4 & 1) == passes;
        ops[place] = Op {
            d: first,
            a: count as u8,
            m: u8::from(states.iter().any(|&it| executed(false, it))),
            imm: ops.len() as u32,
            ..ops[place].as_kind(Kind::Block)
        };
        for passes in [true, false] {
            for (index, (op, &it)) in block.iter().zip(&states).enumerate() {
                let skipped = Op { len: op.len, ..Op::new(Kind::Nop, op.len) };
                ops.push(if executed(passes, it) { op.in_it() } else { skipped });
                addresses.push(addresses[place + 1 + index]);
                it_states.push(it);
            }
            ops.push(Op::goto((place + 1 + count) as u32));
            addresses.push(behind);
            it_states.push(0);
        }
    }
    it_states
}

/// ITAdvance (DDI 0403, A7.3.3).
pub(super) const fn advanced(it: u8) -> u8 {
    if it & 7 == 0 { 0 } else { it & 0xE0 | it << 1 & 0x1F }
}

#[cfg(test)]
mod tests;
