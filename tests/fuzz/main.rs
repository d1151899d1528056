//! Fuzzing with structure: what is read from files is never met with a panic, a hang or more than 1 GiB.
//!
//! Each run replays the corpus, then makes inputs for some seconds from a fixed seed. Longer, and from another seed:
//! `SAGNAC_FUZZ_SECONDS=600 cargo test --release --test fuzz studies -- --nocapture`. A failing input is kept in the
//! corpus; `SAGNAC_FUZZ_SEED` repeats a run.

#[path = "../common/formats.rs"]
mod formats;

mod bombs;
mod campaign;
mod cases;
mod damaged;
mod databases;
mod edits;
mod limits;
mod records;
mod studies;
mod tallies;
