#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| makadam_fuzz::read("lammps_log", bytes));
