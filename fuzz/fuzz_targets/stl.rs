#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bhs_fuzz::run("stl", data));
