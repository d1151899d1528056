//! Monte Carlo studies for laser gyroscopes.
//!
//! ```text
//! study.toml ─ study ─▶ points ─ lower ─▶ launches ─ kernel on a backend ─▶ tallies ─ store ─▶ stats ─▶ table ─ chart
//! ```
//!
//! The library does what the program `sagnac` does. This example is `sagnac run` without its files:
//!
//! ```
//! use sagnac::verify::select;
//! use sagnac::progress::Silent;
//! use sagnac::run::Plan;
//! use sagnac::store::Store;
//! use sagnac::study::Study;
//! use sagnac::tally::Share;
//!
//! let study = Study::parse("gap.toml", r#"
//!     title = "A gap of three ticks"
//!     kind = "gap-fill"
//!     trials = 4096
//!     [gyro]
//!     tick = "5 ms"
//!     tick_noise = { std = "0.533 arcsec" }
//!     [motion]
//!     amplitude = "12000 arcsec/s"
//!     frequency = "20 Hz"
//!     [switching]
//!     gap_ticks = 3
//!     fillers = ["const", "quadratic"]
//!     errors = ["residual"]
//! "#)?;
//! let plan = Plan::new(&study)?;
//! let folder = tempfile::tempdir()?;
//! let mut store = Store::open(folder.path(), &plan.identity())?;
//! let mut device = select("cpu", 1)?.device;
//! let done = plan.run(&mut store, &mut device, Share::WHOLE, &Silent)?;
//! assert_eq!(done.trials, 4096);
//!
//! let table = plan.tables(&store, &Silent)?.points;
//! let number = |column: &str, row: usize| table.column(column).unwrap().cells[row].number().unwrap();
//! assert_eq!(table.column("filler")?.cells[1].text(), "quadratic");
//! // Z(14)–Z(18): 26.85 ″/√2 of motion and 3.81 σ of noise.
//! assert!((number("theory_rms", 1) - 19.09).abs() < 0.005);
//! assert!((number("rms", 1) - number("theory_rms", 1)).abs() < 5.0 * number("rms_se", 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | name | purpose |
//! |---|---|
//! | [`Study`](study::Study) | a study: text, checked and expanded into points |
//! | [`Plan`](run::Plan), [`RunStats`](run::RunStats), [`Tables`](run::Tables) | the plan of a study, the work done by a run, and its tables |
//! | [`Store`](store::Store), [`Source`](store::source::Source), [`Share`](tally::Share) | results folders, and shares of a study |
//! | [`Progress`](progress::Progress), [`Silent`](progress::Silent) | progress of a run, and a way to stop it |
//! | [`select`](verify::select), [`verify`](verify::verify) | the choice of a device, and the check of its bits |
//! | [`Table`](table::Table), [`Column`](table::Column) | results, with units and bands |
//! | [`Page`](report::page::Page), [`Figure`](report::chart::figure::Figure), [`pictures`](view::pictures) | pages, and charts |
//! | [`Log`](record::log::Log), [`Samples`](record::log::Samples) | recorded data, from files and from memory |
//! | [`curve`](allan::curve()), [`DataSheet`](analysis::data_sheet::DataSheet) | deviations of a record, and noise coefficients fitted to them |
//! | [`Density`](spectrum::Density), [`lines`](spectrum::lines()), [`Floor`](spectrum::Floor) | the power spectral density of a record, its lines and its white floor |
//! | [`log::Analysis`](analysis::log::Analysis), [`compare`](analysis::compare::compare) | the noise of a log, and the comparison of two logs |
//! | [`allan`](use_cases::allan), [`compare_logs`](use_cases::compare_logs), [`compare_units`](use_cases::compare_units), [`three_cornered_hat`](use_cases::three_cornered_hat), [`model_noise`](use_cases::model_noise) | what the commands on logs do, each from a request to an [`Outcome`](use_cases::Outcome) |
//! | [`Dynamic`](analysis::dynamic::Dynamic), [`Batch`](analysis::batch::Batch) | the noise of a log over time, and a batch of units with its outliers |
//! | [`design`](analysis::design::design), [`filler`](analysis::firmware::filler), [`sensitivity`](analysis::sensitivity::sensitivity) | the best switching interval and filler, fillers for firmware, and which uncertain input decides |
//! | [`check`](check::check) | whether a results folder is intact and complete |
//! | [`theory`] | closed forms |
//!
//! Messages write settings as `name = value` in backticks; [`spelled`](sagnac_base::diagnostics::spelled) turns them into the options of a front end.

#![deny(missing_docs)]
#![warn(unreachable_pub)]

pub mod analysis;
#[cfg(feature = "store")]
pub mod check;
pub mod described;
pub mod use_cases;
pub mod view;

pub use sagnac_base::{progress, table};
pub use sagnac_engine::{device, run, store, study, tally, verify};
pub use sagnac_records::{allan, events, fit, record, spectrum};
pub use sagnac_report as report;
pub use sagnac_theory as theory;
