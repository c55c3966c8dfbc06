//! A seal that leaves everything in clear, for tests of turns and delays alone.

use airlink::{Scope, Seal};

/// A seal whose tag is always zero.
#[derive(Clone, Copy, Debug)]
pub struct Unsealed;

impl Seal for Unsealed {
    fn seal(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8]) -> [u8; 8] {
        [0; 8]
    }

    fn open(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8], tag: &[u8; 8]) -> bool {
        *tag == [0; 8]
    }
}
