//! See `src/wire/syslink.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| uchain_fuzz::wire::syslink::check(data));
