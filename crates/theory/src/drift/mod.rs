//! Drift of a gyro that switches modes every MT seconds, Z(3)–Z(9).
//!
//! The magnetic drift changes its sign with the mode, the non-magnetic drift does not. [`Magnetic`] is the drift
//! accumulated over a whole run, [`Budget`] the paper's bound of it with its optimum and approximations, and [`Spread`]
//! the effect of the errors at the switches on a run. Rates are in ″/s, angles in ″ and times in s. The paper's case
//! for one hour:
//!
//! ```
//! use sagnac_theory::drift::{Budget, Ending, Magnetic, Spread, limit_as_published};
//!
//! let magnetic = Magnetic { amplitude: 14.0, time_s: 3000.0, initial: 0.0 };
//! let budget = Budget { magnetic, non_magnetic: 0.05, residual_max: 10.0 };
//! let best = budget.optimum(3600.0).unwrap();
//! assert!((best.interval_s - 44.80).abs() < 0.005 && (best.bound - 0.4979).abs() < 5e-5);
//! assert!((budget.optimum_as_published(3600.0).unwrap() - 61.20).abs() < 0.005);
//! assert!((limit_as_published(&budget, 3600.0).unwrap() - 60.66).abs() < 0.005);
//!
//! let run = Spread { magnetic, non_magnetic: 0.05, residual_rms: 10.0 / 2_f64.sqrt() };
//! assert!((run.mean(40.0, 3600.0, true) + 0.0044).abs() < 5e-5);
//! assert!((run.deviation(40.0, 3600.0) - 0.0185).abs() < 5e-5);
//! assert!((run.best_interval(3600.0, Ending::Even).unwrap() - 15.6).abs() < 0.05);
//! assert!((run.best_interval(3600.0, Ending::Any).unwrap() - 22.4).abs() < 0.05);
//! ```

pub mod approximation;
pub mod budget;
pub mod magnetic;
pub mod spread;

pub use crate::drift::approximation::limit_as_published;
pub use crate::drift::budget::{Bound, Budget, Optimum};
pub use crate::drift::magnetic::{Magnetic, signed_decay, signed_time, switches};
pub use crate::drift::spread::{Ending, Spread};
