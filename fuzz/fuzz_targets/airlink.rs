//! See `fuzz_checks::airlink`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::airlink::check(data));
