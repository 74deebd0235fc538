#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| makadam_fuzz::read("yade_driven_walls", bytes));
