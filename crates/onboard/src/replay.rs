//! Runs recorded packets through a [`Drone`](crate::Drone), one step at a time, on the host and on
//! the chip alike.
//!
//! The host sends requests over a line of bytes, such as a down-channel of SEGGER's RTT, and the
//! chip answers each. The host runs the same [`Session`] with the same requests, so the two answers
//! to a request must be equal, bit for bit, but for the cycles that the step took.
//!
//! ```text
//!   host                                    chip
//!   Request ──frame──▶ down-channel ──▶ Receiver ──▶ Session ──▶ Drone
//!   Answer  ◀──frame── up-channel   ◀─────────────── Answer  ◀────┘
//! ```
//!
//! # Frames
//! A frame is a run of words of 32 bits, low byte first, in consistent overhead byte stuffing
//! (Cheshire and Baker, "Consistent overhead byte stuffing", 1999), which leaves no byte zero, and a
//! zero byte at its end. Whatever bytes are lost or damaged, the next zero byte ends the damage.
//!
//! | word | holds |
//! |---|---|
//! | first | [`MAGIC`] in the upper half, [`VERSION`] and the kind of the record in the lower two bytes |
//! | second | the number of the request, which its answer repeats |
//! | then | the record ([`Request`], [`Answer`]), as the module `words` writes its values |
//! | last | CRC-32 of all the words before |
//!
//! | kind | record | answered by |
//! |---|---|---|
//! | 1 | [`Request::Begin`] | 2 [`Answer::Begun`], or 5 [`Answer::Refused`] |
//! | 3 | [`Request::Step`] | 4 [`Answer::Stepped`], or 5 |
//!
//! | module | holds |
//! |---|---|
//! | `frame` | bytes to words and back |
//! | `record` | the requests and the answers |
//! | `session` | the drone's part: a request in, an answer out |
//! | `launch` | the launch rule over recorded strengths |

mod frame;
mod launch;
mod record;
mod session;

pub use frame::{Frame, FrameError, LONGEST, MAGIC, Receiver, VERSION};
pub use launch::LaunchRule;
pub use record::{Answer, Begin, HEARD, Refusal, Request, Step, Stepped};
pub use session::{NoStopwatch, Session, Stopwatch};
