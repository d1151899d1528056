//! Output for people: the charts of studies, and the pages of `sagnac-report`.

pub mod chart;
pub mod picture;

pub use sagnac_report::page as report;
