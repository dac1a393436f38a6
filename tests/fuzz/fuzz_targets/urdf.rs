#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| selftalk_tests::fuzz::urdf(bytes));
