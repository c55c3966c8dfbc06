//! Messages of ROS 2, and the topics that a program adds to a sink: a file, or a node that publishes
//! them. It knows nothing of missions, drones or stations.
//!
//! ```text
//!   a mission, a station ──Topic::put──▶ CDR ──▶ Sink: a bag, or a Node ──DDS──▶ RViz, ros2 topic echo …
//!                                                      Commands ◀──DDS── /cmd_vel, /order
//! ```
//!
//! `Node`, `Commands` and `Domain` come with the feature `dds`.
//!
//! ```
//! use ros2_topics::messages::Float32;
//! use ros2_topics::{About, Sink, Topic};
//!
//! struct Bytes(Vec<u8>);
//! impl Sink for Bytes {
//!     fn topic(&mut self, about: &About<'_>) -> std::io::Result<usize> {
//!         assert_eq!(about.kind, "std_msgs/msg/Float32");
//!         Ok(0)
//!     }
//!     fn put(&mut self, _: usize, _: u64, cdr: &[u8]) -> std::io::Result<()> {
//!         self.0.extend(cdr);
//!         Ok(())
//!     }
//! }
//! let mut bytes = Bytes(Vec::new());
//! let strength = Topic::<Float32>::add(&mut bytes, "/drone_1/link/back/filtered_dbm", false)?;
//! strength.put(&mut bytes, 0, &Float32 { data: -60.0 })?;
//! assert_eq!(bytes.0, (-60.0_f32).to_le_bytes());
//! # Ok::<(), std::io::Error>(())
//! ```

#[cfg(feature = "dds")]
mod domain;
pub mod messages;
#[cfg(feature = "dds")]
mod node;
mod topic;

#[cfg(feature = "dds")]
pub use domain::{Domain, LARGEST_DOMAIN};
#[cfg(feature = "dds")]
pub use node::{Commands, Node, Received};
pub use topic::{About, Sink, Topic};
