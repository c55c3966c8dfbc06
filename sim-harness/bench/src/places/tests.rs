//! The benchmark in a small folder.
