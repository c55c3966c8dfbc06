//! Reads recordings: logs of radio packets and of flights, from any bytes to checked samples.
//!
//! | module | holds |
//! |---|---|
//! | [`formats`] | one parser per kind of log |
//! | [`mcap_file`] | the messages of an MCAP file, as far as it is sound |
//! | [`messages`] | the messages of a `trace.mcap` that are this project's own |
//! | [`recording`] | the samples, and the anomalies of the other rows |
//! | [`mod@fit`] | a radio model, fitted to the packets |
//! | [`recorded`] | a channel that plays the packets of a log back |
//! | [`variables`] | all variables of a log of the µSD card deck |
//! | `channel` | reads a log as such a channel |

mod channel;
pub mod fit;
pub mod formats;
pub mod mcap_file;
pub mod messages;
pub mod recorded;
pub mod recording;
pub mod variables;

pub use channel::recorded_channel;
pub use formats::Format;
pub use recorded::{RecordedChannel, Residual};
