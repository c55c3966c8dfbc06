//! Tests of the link through its public interface: turns, delays, a Stop that stands, and sealed
//! packets.

mod common;
mod delay;
mod secure;
mod stop;
mod turns;
