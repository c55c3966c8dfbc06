//! Tests of whole drones through their public interface: a stop that stands, and the tables of the
//! book.

mod common;
mod docs;
mod stop;
