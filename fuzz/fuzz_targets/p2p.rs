//! See `fuzz_checks::p2p`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::p2p::check(data));
