//! Whole runs: the same bits everywhere, the closed forms, an independent sampler, and what is refused.

mod closed_forms;
mod identity;
mod pulses;
mod sampler;
mod texts;
