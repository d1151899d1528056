//! Requirements on the noise of sensors: limits on coefficients, and the decision to which records lead.
//!
//! ```text
//! text ─ Limit::parse ─▶ Limit ─┐
//! log, lot ─▶ Subject ──────────┴─ Judged ─▶ Standing ─┬─ what decides it ─▶ Decision: five lines, judgements
//!                  fit ─ largest ──────────────────────┘
//! ```
//!
//! A limit is met if the upper end of the 95 % interval of the coefficient is at most the limit. It is not met if the lower end is
//! above it. If the interval contains the limit, the record does not decide. A coefficient that is not identified has an
//! upper bound only, which meets the limit or does not decide. Coefficients of a fit that does not describe its curve decide
//! nothing.

mod best;
mod decision;
mod judged;
mod largest;
mod lever;
mod limit;
mod subject;

pub use crate::analysis::requirement::decision::{Decision, decide};
pub use crate::analysis::requirement::judged::{Judgement, Standing};
pub use crate::analysis::requirement::limit::{Limit, LimitError, Limited, applies, check};
pub use crate::analysis::requirement::subject::Subject;

pub(crate) use crate::analysis::requirement::judged::met;
pub(crate) use crate::analysis::requirement::limit::{is_fitted, named, twice};
