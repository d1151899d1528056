//! Monte Carlo studies for laser gyroscopes.
//!
//! ```text
//! study.toml ─ study ─▶ points ─ lower ─▶ launches ─ kernel on a backend ─▶ tallies ─ store ─▶ stats ─▶ table ─ chart
//! ```
//!
//! What the program `sagnac` does is here as a library; this is `sagnac run` without its files:
//!
//! ```
//! use sagnac::device::select::select;
//! use sagnac::progress::Silent;
//! use sagnac::run::Plan;
//! use sagnac::store::Store;
//! use sagnac::study::Study;
//! use sagnac::tally::share::Share;
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
//! assert!((number("oracle_rms", 1) - 19.09).abs() < 0.005);
//! assert!((number("rms", 1) - number("oracle_rms", 1)).abs() < 5.0 * number("rms_se", 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | entry point | what for |
//! |---|---|
//! | [`crate::study::Study`] | a study as text, checked and expanded into points |
//! | [`crate::run::Plan`] | a study run into a [`crate::store::Store`], and its tables |
//! | [`crate::kinds::gap_fill::lower::Lowered`], [`crate::kinds::allan::lower::Records`] | one point in fixed point, with closed forms |
//! | [`crate::device::select`], [`crate::verify::verify`] | the device that samples, and whether its bits are the right ones |
//! | [`crate::view::chart::figure::Figure`], [`crate::view::chart::map::Map`], [`crate::view::report::Report`] | pictures of a table, and the page that has all of them |
//! | [`crate::described`] | what the columns mean |
//! | [`crate::record::log::channel::Log`], [`allan`], [`fit`], [`compare`] | recorded data |
//! | [`crate::analysis::firmware::design::Firmware`], [`crate::analysis::design::design`] | fillers for firmware, and how often to switch |
//! | [`theory`] | the closed forms by themselves |

pub use sagnac_kernel as kernel;

pub mod allan;
pub mod analysis;
pub mod chart;
pub mod described;
pub mod device;
pub mod drift;
pub mod filler;
pub mod fit;
pub mod key;
pub mod kinds;
pub mod motion;
pub mod noise;
pub mod progress;
pub mod quantity;
pub mod record;
pub mod run;
pub mod sampling;
pub mod source;
pub mod store;
pub mod study;
pub mod table;
pub mod tally;
pub mod theory;
pub mod verify;
pub mod view;
