//! See `fuzz_checks::storage`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::storage::check(data));
