//! Lists the instructions of an image with their effects.

use std::ops::Range;

use crate::cpu::effect::{Decoder, Instruction, Surroundings};
use crate::cpu::is_wide;

use super::Image;

impl Image {
    /// Every instruction in flash, by address. The list is made when it is first asked for.
    #[must_use]
    pub fn listing(&self) -> &[Instruction] {
        self.listing.get_or_init(|| list(self))
    }

    /// The instructions that begin in a range of addresses.
    #[must_use]
    pub fn listing_in(&self, range: Range<u32>) -> &[Instruction] {
        let place = |address| self.listing().partition_point(|i| i.address < address);
        &self.listing()[place(range.start)..place(range.end)]
    }
}

fn list(image: &Image) -> Vec<Instruction> {
    let half = |address: u32| image.half(address);
    let mut instructions = image.instructions().peekable();
    let mut listing = Vec::new();
    let mut decoder = Decoder::default();
    while let Some((address, first, second)) = instructions.next() {
        let end = address + if is_wide(first) { 4 } else { 2 };
        let next = instructions.peek().map_or(end, |(next, ..)| *next);
        listing.push(decoder.next(address, (first, second), &Surroundings { half: &half, next }));
    }
    listing
}
