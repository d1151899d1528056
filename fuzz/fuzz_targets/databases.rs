#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    sagnac_fuzz::cases::databases::run(bytes);
});
