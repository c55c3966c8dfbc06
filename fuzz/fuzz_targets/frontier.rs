//! See `fuzz_checks::frontier`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::frontier::check(data));
