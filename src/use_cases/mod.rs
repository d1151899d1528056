//! The use cases: each is a function from a request to an [`Outcome`](crate::outcome::Outcome), for any front end.

mod convert;
mod logs;
mod studies;

pub use convert::{Conversion, Converted, convert};
pub use logs::{
    AllanRequest, BatchRequest, CompareRequest, LogError, ModelSource, Segments, allan, compare_logs,
    compare_units, model_noise,
};
pub use studies::{Sampled, StudyOutcome, study_outcome};
