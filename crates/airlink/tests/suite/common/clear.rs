//! No sealing, for what is about time and ways alone.

use airlink::{Scope, Seal};

#[derive(Clone, Copy, Debug)]
pub struct Clear;

impl Seal for Clear {
    fn seal(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8]) -> [u8; 8] {
        [0; 8]
    }

    fn open(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8], tag: &[u8; 8]) -> bool {
        *tag == [0; 8]
    }
}
