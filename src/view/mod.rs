//! Output for people: charts, verdicts and the page of a study.

pub mod chart;
pub mod picture;
pub mod report;
pub mod results;
pub mod verdict;
