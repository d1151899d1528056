//! Monte Carlo studies for laser gyroscopes.
//!
//! ```text
//! study.toml ─ study ─▶ points ─ lower ─▶ launches ─ kernel on a backend ─▶ tallies ─ store ─▶ stats ─▶ table ─ chart
//! ```

#![deny(missing_docs)]

pub mod allan;
pub mod backend;
pub mod block;
pub mod chart;
pub mod compare;
pub mod design;
pub mod firmware;
pub mod fit;
pub mod id;
pub mod kernel;
pub mod lower;
pub mod record;
pub mod run;
pub mod share;
pub mod stats;
pub mod store;
pub mod study;
pub mod table;
pub mod theory;
pub mod verdict;
pub mod verify;
