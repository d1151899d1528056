//! Fillers for firmware: integers with one rounding rule, a C header, and vectors to test an implementation.
//!
//! ```text
//! Study, Point ─ design ─▶ Firmware ─┬─ header ─▶ sagnac_filler.h
//!                                    ├─ vectors ─▶ test_vectors.csv
//!                                    ├─ weights ─▶ weights.csv
//!                                    ├─ answer ─▶ Answer
//!                                    └─ response ─▶ Figure
//! ```
//!
//! The algorithm is that of Z(14)–Z(17). While the gap 1 … n is open, the extrapolation E_j is delivered instead of
//! tick j. Once the fit ticks after it are known, ΔP = Σ(E_j − I_j) is subtracted from the next tick, where I_j is the
//! interpolation.
//!
//! ```
//! # use sagnac::analysis::firmware::design::Firmware;
//! # use sagnac::study::Study;
//! # let text = include_str!("../../../studies/error_vs_dtnu.toml");
//! let study = Study::parse("study.toml", text)?;
//! let gap_fill = study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap();
//! let firmware = Firmware::new(&study, &gap_fill.points[0], &gap_fill.fillers)?;
//! let quadratic = &firmware.designs[2];
//! // The first point has a gap of one tick: (−1, 4, 4, −1)/6.
//! assert_eq!(quadratic.interpolation.fill(&[0, 10, 14, 0]), [16]);
//! assert!(firmware.header().contains("sagnac_quadratic"));
//! # Ok::<(), sagnac_base::diagnostics::StudyError>(())
//! ```

pub mod choice;
pub mod design;
pub(crate) mod export;
pub mod fixed_point_filter;
pub(crate) mod report;
pub mod search;
pub mod standalone;

pub use crate::analysis::firmware::choice::{
    ChoiceError, FillerRequest, FillerSource, choose_fillers, choose_point, filler,
};
pub use crate::analysis::firmware::design::{Closed, Design, Firmware, rules};
pub use crate::analysis::firmware::export::Vectors;
pub use crate::analysis::firmware::export::identifiers;
pub use crate::analysis::firmware::fixed_point_filter::Memory;
pub use crate::analysis::firmware::fixed_point_filter::Rule;
pub use crate::analysis::firmware::search::{Asked, Candidate, Trade};
pub use crate::analysis::firmware::standalone::{Alone, KINDS, MINIMUM_VARIANCE, in_properties};
