//! Whole runs: the same bits everywhere, the closed forms, an independent sampler, and what is refused.

mod closed_forms;
#[path = "../devices/mod.rs"]
mod devices;
mod identity;
mod sampler;
#[path = "../studies/mod.rs"]
mod studies;
mod texts;
