//! See `fuzz_checks::surveys::walls`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::surveys::walls(data));
