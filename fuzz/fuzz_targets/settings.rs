//! See `src/wire/settings.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| uchain_fuzz::wire::settings::check(data));
