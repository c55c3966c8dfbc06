//! See `fuzz_checks::capsule`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::capsule::check(data));
