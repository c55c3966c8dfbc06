//! See `fuzz_checks::crtp`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::crtp::check(data));
