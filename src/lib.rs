//! Monte Carlo studies for laser gyroscopes.
//!
//! ```text
//! study.toml ─ study ─▶ points ─ lower ─▶ launches ─ kernel on a backend ─▶ tallies ─ store ─▶ stats ─▶ table ─ chart
//! ```
//! What the program `sagnac` does is here as a library; this is `sagnac run` without its files:
//!
//! ```
//! use sagnac::{backend, run, share::Share, store::Store, study::Study};
//!
//! /// Nobody wants to hear how it goes on.
//! struct Silent;
//!
//! impl run::Progress for Silent {
//!     fn start(&self, _: &'static str, _: u64, _: u64) {}
//!     fn advance(&self, _: u64) {}
//!     fn note(&self, _: &str) {}
//!     fn finish(&self) {}
//! }
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
//! let plan = run::Plan::new(&study)?;
//! let folder = tempfile::tempdir()?;
//! let mut store = Store::open(folder.path(), &plan.identity())?;
//! let mut device = backend::select("cpu", 1)?.device;
//! let done = plan.run(&mut store, &mut device, Share::WHOLE, &Silent)?;
//! assert_eq!(done.trials, 4096);
//!
//! let table = plan.tables(&store, &Silent)?.points;
//! let number = |column: &str, row: usize| table.column(column).unwrap().cells[row].number().unwrap();
//! assert_eq!(table.column("filler")?.cells[1].text(), "quadratic");
//! // Z(14)–Z(18): 26.85 ″/√2 of motion and 3.81 σ of noise.
//! assert!((number("oracle_rms", 1) - 19.09).abs() < 0.005);
//! assert!((number("rms", 1) - number("oracle_rms", 1)).abs() < 5.0 * number("rms_se", 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | entry point | what for |
//! |---|---|
//! | [`study::Study`] | a study as text, checked and expanded into points |
//! | [`run::Plan`] | a study run into a [`store::Store`], and its tables |
//! | [`lower::Lowered`], [`lower::Records`] | one point in fixed point, with closed forms |
//! | [`backend::select`], [`verify::verify`] | the device that samples, and whether its bits are the right ones |
//! | [`chart::Figure`], [`chart::Map`] | pictures of a table |
//! | [`record::log::Log`], [`allan`], [`fit`], [`compare`] | recorded data |
//! | [`firmware::Firmware`], [`design::design`] | fillers for firmware, and how often to switch |
//! | [`theory`] | the closed forms by themselves |

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
pub mod picture;
pub mod record;
pub mod report;
pub mod run;
pub mod share;
pub mod stats;
pub mod store;
pub mod study;
pub mod table;
pub mod theory;
pub mod verdict;
pub mod verify;
