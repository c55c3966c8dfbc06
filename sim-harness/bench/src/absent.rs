//! The stand-in for the tables of benchmarks that fly an ELF, in a build without the feature
//! `virtual`: asking for one is answered with the command that has it.

use input::InputError;

use super::{Outcome, Session};
use bodies::without_emulator;

pub(super) fn outcome<A>(session: &Session<'_>, _: A) -> Result<Outcome, InputError> {
    Err(without_emulator(&format!("bench {}", session.name)))
}
