//! Reads what users write, and says in one line what is wrong with it, where, and how to correct it.
//!
//! | module | what it holds |
//! |---|---|
//! | [`InputError`] | the error for input that cannot be used |
//! | [`mod@file`] | files that the user names, read up to a size |
//! | [`reader`] | the values of a TOML file, with their lines and ranges |
//! | [`suggest`] | the name that the user probably meant |
//! | [`counted`] | a count with its noun |

mod count;
mod error;
pub mod file;
pub mod reader;
pub mod suggest;

pub use count::counted;
pub use error::InputError;
