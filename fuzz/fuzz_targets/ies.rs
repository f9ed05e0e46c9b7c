#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gnomon_fuzzing::run("ies", bytes));
