//! Requirements on the noise of sensors: limits on coefficients, and the answer of records.
//!
//! ```text
//! text ─ Limit::parse ─▶ Limit ─┐
//! log, batch ─▶ Subject ────────┴─ Judged ─▶ Standing ─▶ Decision: Answer, judgements
//! ```
//!
//! A limit is met if the upper end of the 95 % interval of the coefficient is at most the limit. It is not met if the lower end is
//! above it. If the interval contains the limit, the record does not decide. A coefficient that is not identified has an
//! upper bound only, which meets the limit or does not decide. Coefficients of a fit that does not describe its curve decide
//! nothing.

mod answer;
mod check;
mod limit;

pub use crate::analysis::requirement::answer::{Decision, decide};
pub use crate::analysis::requirement::check::{Judgement, Standing, Subject};
pub use crate::analysis::requirement::limit::{Limit, LimitError, Limited, applies, check};

pub(crate) use crate::analysis::requirement::answer::{status, value_or_bound};
pub(crate) use crate::analysis::requirement::check::columns;
pub(crate) use crate::analysis::requirement::limit::{is_fitted, named, twice};
