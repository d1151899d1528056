//! Output for people: charts and pages.

pub mod chart;
pub mod picture;
pub mod report;
