//! A served mission as a node of ROS 2, by the node of `ros2_topics`.
//!
//! The node publishes the topics that a bag of the mission has, at the rate of the frames, and `/clock`
//! with the time of the mission. It follows two topics, whose messages become packets for the base, so that
//! they count as those of any other client do:
//!
//! | topic | message | what it does |
//! |---|---|---|
//! | `/cmd_vel` | `geometry_msgs/msg/Twist` | the head flies at `linear.x`, m/s, for half a second |
//! | `/order` | `std_msgs/msg/String` | `return`, `land`, `perch`, `wait` or `stop`, for the whole team |
//!
//! ```text
//!   serve::Live ──frames──▶ Companion ──CDR──▶ Node ──DDS──▶ RViz, ros2 topic echo …
//!        ▲                                      │
//!        └──────── packets for the base ◀───────┘◀── /cmd_vel, /order
//! ```

#![cfg(feature = "dds")]

mod companion;

pub use companion::Companion;
