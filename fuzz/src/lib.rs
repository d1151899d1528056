//! What is done with an input of each target, shared with the fuzzer of `tests/fuzz`, which needs no instrumentation.

#[path = "../../tests/fuzz/cases/mod.rs"]
pub mod cases;
