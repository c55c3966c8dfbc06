//! See `fuzz_checks::surveys::three_d`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::surveys::three_d(data));
