//! Answers, charts and pages as data, with one renderer for each output.
//!
//! ```text
//! Answer ─┬─▶ Page ─┬─ html() ─▶ one file without a network
//! Figure ─┤         ├─ text() ─▶ terminal
//! Map ────┘         └─ card() ─▶ gallery
//! ```
//!
//! ```
//! use sagnac_report::answer::{Answer, Reading};
//!
//! let value = Reading::in_unit("rms", 7.96, "″", Some([7.72, 8.31]));
//! let answer = Answer { headline: format!("Quadratic: rms error {}", value.with_interval()), ..Answer::default() };
//! assert_eq!(answer.headline, "Quadratic: rms error 7.96″ (7.72–8.31)");
//! assert!(answer.text(80).starts_with("no limit"));
//! ```

#![deny(missing_docs)]

pub mod answer;
pub mod chart;
pub mod page;
