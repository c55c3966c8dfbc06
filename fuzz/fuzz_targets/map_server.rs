//! See `fuzz_checks::maps::map_server`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| fuzz_checks::maps::map_server(data));
