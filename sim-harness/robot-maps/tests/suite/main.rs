//! What must be true of the readers of robots' maps.

mod damaged;
mod map_server;
mod subt;
