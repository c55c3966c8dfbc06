//! See `fuzz_checks::surveys::visual_topo`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::surveys::visual_topo(data));
