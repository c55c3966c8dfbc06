//! A stretch of code, decoded beforehand.
//!
//! Each halfword is decoded as if an instruction began there: no jump can land where nothing is
//! known, and where instructions begin need not be found out. What is executed one after the other
//! stands one after the other, so that following it is counting: first all that a reader from the
//! first byte on comes across, then, for every halfword that he has skipped, what a reader finds
//! who begins there, until he meets one who was there before.
//!
//! Addresses can be marked with traps, which cost nothing anywhere else.
//!
//! It is decoded once: whoever lets flash be programmed where it has code makes a new one.

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
    /// What a trap stands in for, by address.
    trapped: BTreeMap<u32, Op>,
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
            ops[after].new_line = timing::line(addresses[before]) != timing::line(addresses[after]);
        }
        Self {
            base,
            ops: ops.into(),
            addresses: addresses.into(),
            places: places.into(),
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
        let op = &mut Arc::make_mut(&mut self.ops)[place];
        self.trapped.insert(address, *op);
        *op = op.as_kind(Kind::Trap);
        true
    }

    /// It no longer does.
    pub fn untrap(&mut self, address: u32) {
        let place = self.place(address);
        if let Some(op) = self.trapped.remove(&address) {
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

    /// Where the instruction at an address stands.
    #[inline(always)]
    pub(super) fn place(&self, address: u32) -> usize {
        let half = (address.wrapping_sub(self.base) >> 1) as usize;
        self.places.get(half).map_or(Self::OUTSIDE, |&place| place as usize)
    }

    /// What stands at a place, traps and all.
    #[inline(always)]
    pub(super) fn op(&self, place: usize) -> &Op {
        &self.ops[place]
    }

    /// Where in memory a place is.
    #[inline(always)]
    pub(super) fn address(&self, place: usize) -> u32 {
        self.addresses[place]
    }

    /// What stands at a place, seen through the traps.
    pub(super) fn real_op(&self, place: usize) -> &Op {
        match self.ops[place] {
            Op { kind: Kind::Trap, .. } => &self.trapped[&self.addresses[place]],
            _ => &self.ops[place],
        }
    }
}
