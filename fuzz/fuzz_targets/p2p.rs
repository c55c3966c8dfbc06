//! See `src/wire/p2p.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| uchain_fuzz::wire::p2p::check(data));
