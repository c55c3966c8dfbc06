//! The stand-in for the tables of benchmarks that fly an ELF, in a build without the feature
//! `virtual`: asking for one is answered with the command that has it.

use super::{Outcome, Session};
use crate::bodies::emulated::without_emulator;
use crate::input_error::InputError;

pub(super) fn outcome<A>(session: &Session<'_>, _: A) -> Result<Outcome, InputError> {
    Err(without_emulator(&format!("bench {}", session.name)))
}
