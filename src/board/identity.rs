//! The name of the board, in the one-time programmable bytes of the processor.
#![expect(unsafe_code, reason = "reads memory outside of every variable")]

use storage::board_name::{ADDRESS, Board, LENGTH};

/// The board by its name.
#[inline(never)]
pub(crate) fn board() -> Board {
    // SAFETY: the address is that of the one-time programmable bytes, of which there are so many,
    // in memory that is read like flash; every bit pattern is a byte; nothing writes them.
    let bytes = unsafe { &*(ADDRESS as *const [u8; LENGTH]) };
    Board::named(bytes)
}
