//! What must be true of the readers of robots' maps.

mod map_server;
mod subt;
