//! See `src/airlink.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| uchain_fuzz::airlink::check(data));
