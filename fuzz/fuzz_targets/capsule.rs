//! See `src/wire/capsule.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| uchain_fuzz::wire::capsule::check(data));
