//! Bounds the memory that a mission's record and its report take, so that a mission for which there is
//! too little is refused before it is flown. An allocation that fails ends a program at once.

use std::hint::black_box;

use input::InputError;
use mission::ROUND_US;
use mission::trace::MOST_FRAMES;
use scenario::Scenario;

/// What a mission takes that does not grow with its frames, in bytes.
const WHOLE: usize = 6 << 20;
/// What each frame takes for each member, in the record and in the report that is made of it, in bytes.
/// `uchain run --out` needed 13 MiB and 77 MiB for 6000 frames of 3 and of 16 members (`ulimit -d`).
const EACH: usize = 800;

/// Makes sure that there is the memory for the record and the report of a mission.
///
/// # Errors
/// If the system would not give so much to this process.
pub fn is_enough_for(scenario: &Scenario) -> Result<(), InputError> {
    let rounds = usize::try_from(scenario.duration_us / ROUND_US).unwrap_or(usize::MAX);
    let bytes = WHOLE + EACH * rounds.min(MOST_FRAMES) * scenario.drones.members();
    let mut room = Vec::<u8>::new();
    // The room is looked at, so that no compiler leaves the reservation away.
    let reserved = black_box(&mut room).try_reserve_exact(bytes);
    reserved.map_err(|_| {
        InputError::new(
            format!(
                "there is too little memory: this mission and its report take {} MiB",
                bytes >> 20
            ),
            "end other programs, or raise the limit of this one (ulimit -d, ulimit -v)",
        )
    })
}
