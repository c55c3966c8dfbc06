//! See `fuzz_checks::replay`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::replay::check(data));
