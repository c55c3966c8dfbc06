//! See `fuzz_checks::surveys::therion`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::surveys::therion(data));
