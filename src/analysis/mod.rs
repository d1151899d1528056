//! Analyses beyond studies: noise of logs, over time and with temperature, requirements on it, spectra of logs, comparison of logs,
//! batches of units, models for filters, pages of logs, switching interval, firmware, sensitivity.

pub mod answer;
pub mod batch;
pub mod compare;
pub mod data_sheet;
pub mod decision;
pub mod design;
pub mod dynamic;
pub mod firmware;
pub mod given_curve;
pub mod hat;
pub mod log;
pub mod model;
pub mod navigators;
pub mod page;
pub(crate) mod question;
pub mod requirement;
pub mod sensitivity;
pub mod spectrum;
pub mod temperature;
