//! Drift of a gyro that switches modes every MT seconds, Z(3)–Z(9).
//!
//! The magnetic drift changes its sign with the mode, the non-magnetic does not. [`Magnetic`] is what a whole run really adds
//! up, [`Budget`] the paper's bound of it with its optimum and the approximations of that, [`Spread`] what the errors at the
//! switches do to a run. Rates ″/s, angles ″, times s.

mod approximation;
mod budget;
mod magnetic;
mod spread;

pub use approximation::limit_as_published;
pub use budget::{Bound, Budget, Optimum};
pub use magnetic::{Magnetic, signed_decay, signed_time, switches};
pub use spread::Spread;
