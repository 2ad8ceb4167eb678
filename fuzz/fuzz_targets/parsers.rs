//! Every parser, chosen by the first byte: `cargo +nightly fuzz run parsers`.
#![no_main]

#[expect(dead_code, reason = "the tests begin with seeds; libFuzzer keeps a corpus of its own")]
#[path = "../../tests/fuzz/targets.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let [first, rest @ ..] = bytes {
        (targets::TARGETS[usize::from(*first) % targets::TARGETS.len()].run)(rest);
    }
});
