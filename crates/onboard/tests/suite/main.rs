//! Tests of whole drones through their public interface: a stop that stands, the policy that a client
//! chooses, and the tables of the book.

mod common;
mod docs;
mod policy;
mod stop;
