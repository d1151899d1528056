//! Output for people: charts and the page of a study.

pub mod chart;
pub mod picture;
pub mod report;
pub mod results;
