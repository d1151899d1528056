//! This package runs the cases of `tests/fuzz` under libFuzzer, which guides its inputs by coverage.

#[path = "../../tests/fuzz/cases/mod.rs"]
pub mod cases;
