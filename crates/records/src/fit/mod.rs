//! The fit of noise coefficients to an Allan (or Hadamard) curve, with the uncertainty of each.
//!
//! ```
//! use sagnac_records::fit::{Curve, Term, Terms, Verdict, fit_record};
//! use sagnac_theory::allan::{Difference, Estimator, Part, Process};
//!
//! // The curve that a record of 36000 s of a gyro with N = 0.03 ″/√s gives on average.
//! let gyro = Process { sample_s: 1.0, parts: vec![Part::angle_random_walk(0.03)] };
//! let ms: Vec<u64> = (0..14).map(|octave| 1 << octave).collect();
//! let at = |&m: &u64| gyro.expected(Estimator::OVERLAPPING, 36_000, m).unwrap();
//! let variances = ms.iter().map(at).collect();
//! let curve = Curve::new(1.0, 36_000, Difference::Second, ms, variances)?;
//!
//! let fit = fit_record(&curve, &Terms::Auto(Term::MODEL.to_vec()))?;
//! let n = fit.coefficient(Term::AngleRandomWalk).unwrap();
//! assert_eq!(n.verdict, Verdict::Identified);
//! assert!((n.value.unwrap() - 0.03).abs() < 1e-9);
//! assert_ne!(fit.coefficient(Term::BiasInstability).unwrap().verdict, Verdict::Identified);
//! # Ok::<(), sagnac_records::fit::curve::FitError>(())
//! ```
//!
//! **Method.** A curve is a sum of terms, linear in the squares of their coefficients. Each term is the closed form of
//! the *sampled* noise ([`sagnac_theory::allan`]), so short τ cause no bias. The squares are found by non-negative
//! least squares (Lawson and Hanson) with the full covariance between the estimates. The correlation time of Markov
//! noise and the frequency of a sine are found by an outer search (variable projection). Weights come from the
//! covariance of a model ([`Covariance`]) instead of the estimates themselves, because low estimates would then get the
//! largest weights.
//!
//! **Results.** A term has a value only where the 95 % interval of its square does not contain 0; otherwise it has a
//! bound, or the statement that the curve gives none ([`Verdict`]). Intervals hold for the terms of the fit; those of
//! [`Terms::Auto`] cover all [likely](LIKELY) choices of terms.
//!
//! Linear algebra is that of [`sagnac_theory::cholesky`]. Systems have at most nine columns, and loops in fixed order
//! give the same digits on every machine, unlike a library that selects its kernels at run time.

pub(crate) mod assess;
pub(crate) mod chi_squared;
pub mod choose;
pub mod coefficient;
pub mod covariance;
pub mod curve;
pub mod evidence;
pub mod fitter;
pub mod interval;
pub mod nnls;
pub mod quantity;
pub mod range;
pub mod record;
pub mod regression;
pub(crate) mod search;

pub use crate::fit::chi_squared::survival;
pub use crate::fit::choose::{LIKELY, PENALTY, PENALTY_OF_LIMIT, PENALTY_OF_SHAPE, RIVAL, Terms};
pub use crate::fit::coefficient::{Coefficient, Fit, Shape, Verdict};
pub use crate::fit::covariance::Covariance;
pub use crate::fit::curve::{Curve, FitError};
pub use crate::fit::fitter::{Errors, Fitter, fit, fit_record};
pub use crate::fit::nnls::nnls;
pub use crate::fit::quantity::Quantity;
pub use crate::fit::range::{Described, Fitting, describe};
pub use crate::fit::range::{
    describe_without_shortest, is_fast, room_for_correlation, white_beside_correlation, with_correlation,
};
pub use crate::fit::record::curve_of;
pub use sagnac_theory::allan::terms::Term;
