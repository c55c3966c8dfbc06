//! The formats: every value survives its encoding, and no bytes break a parser.

mod corpus;
mod crtp;
mod docs;
mod epoch_record;
mod keys_record;
mod messages;
mod p2p;
mod settings;
mod syslink;
