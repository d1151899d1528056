//! The power spectral density of a record, the lines in it, and the level of its white noise.
//!
//! ```text
//! Angles, Welch ─ Density::of ─▶ Density ─ lines ─▶ Lines ─ Floor::of ─▶ Floor
//! ```
//!
//! All densities are **one-sided**: their integral from 0 to half the sampling rate is the variance of the rate. White
//! rate of the coefficient N has the density 2N². Rates are those between the angles of a record, in ″/s, so densities
//! are in (″/s)²/Hz, which is the same number in (°/h)²/Hz.
//!
//! ```
//! use sagnac_records::allan::{Angles, Trend};
//! use sagnac_records::spectrum::{Density, Floor, Welch, lines};
//!
//! // Scattered rates and a sine of 20 Hz with the amplitude 3.
//! let mut state = 1_u64;
//! let mut scattered = || {
//!     state = 16_807 * state % 2_147_483_647;
//!     state as f64 / 2_147_483_647.0
//! };
//! let sine = |i: u32| 3.0 * (0.4 * std::f64::consts::PI * f64::from(i)).sin();
//! let rates: Vec<f64> = (0..8192).map(|i| scattered() + sine(i)).collect();
//! let angles = Angles::from_increments(&rates, 0.01, 0.01, Trend::None);
//!
//! let density = Density::of(&angles, &Welch::default())?;
//! assert_eq!((density.segment, density.segments), (1024, 15));
//! let lines = lines(&density);
//! assert_eq!(lines.len(), 1);
//! assert!((lines[0].frequency_hz - 20.0).abs() < 3e-3 && (lines[0].amplitude - 3.0).abs() < 0.02);
//! // Uniform numbers between 0 and 1 have the variance 1/12.
//! let floor = Floor::of(&density, &lines).unwrap();
//! assert!((floor.density / (2.0 * 0.01 / 12.0) - 1.0).abs() < 0.1);
//! # Ok::<(), sagnac_records::spectrum::SpectrumError>(())
//! ```
//!
//! Method: P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio
//! Electroacoust. 15 (1967); F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978).

pub mod floor;
pub mod lines;
pub(crate) mod median;
pub mod welch;

pub use crate::spectrum::floor::Floor;
pub use crate::spectrum::lines::{FALSE_ALARM, Line, lines};
pub use crate::spectrum::welch::MAX_USUAL;
pub use crate::spectrum::welch::{Density, MIN_SEGMENT, Point, SpectrumError, Welch};

/// Correlation of the densities at frequencies one and two places apart, for the Hann window: the squares of its
/// squared window's Fourier coefficients ⅔ and ⅙.
pub(crate) const NEIGHBOURS: [f64; 2] = [4.0 / 9.0, 1.0 / 36.0];
