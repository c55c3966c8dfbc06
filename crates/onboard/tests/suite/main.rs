//! Tests of whole drones through their public interface: a stop that stands, the policy that a
//! client chooses, what cfclient's window asks for, a run that begins anew, positions from outside,
//! how well a drone knows where it is, and the tables of the book.

mod common;
mod docs;
mod estimate;
mod hardware;
mod policy;
mod positions;
mod replay;
mod restart;
mod stop;
mod window;
