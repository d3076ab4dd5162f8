#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| caustica_fuzz::readers::tungsten(bytes));
