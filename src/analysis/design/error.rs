//! Why a design is not possible.

use crate::analysis::design::Measure;
use sagnac_base::source::diagnose::StudyError;
use sagnac_engine::device::GpuError;
use sagnac_engine::key::Unrepresentable;
use sagnac_engine::key::sweep::Swept;
use sagnac_engine::study::Study;

/// Why a design is not possible.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The study is of this other kind.
    #[error("a study of kind = \"{0}\" has no switching interval to choose")]
    Kind(&'static str),
    /// Nothing depends on the interval.
    #[error("there is no drift and no residual: every interval is as good as any other")]
    Nothing,
    /// The run of this time t, in s, is too short for two intervals.
    #[error("a run of {0} s has no room for two of the shortest intervals, which have to hold the fit ticks")]
    NoCandidate(f64),
    /// Constraints on fillers, where the study has none.
    #[error("latency and memory are those of fillers, and the study has none")]
    NoFillers,
    /// A band for searched fillers that reaches above half the tick rate.
    #[error("the band reaches {high_hz} Hz, above the Nyquist frequency of ticks of {tick_s} s")]
    Band {
        /// The upper end of the band, Hz.
        high_hz: f64,
        /// The tick, s.
        tick_s: f64,
    },
    /// The fillers of the search do not fit the study.
    #[error("{0}")]
    Study(#[from] StudyError),
    /// No filler meets the constraints.
    #[error("no filler has {asked}: the nearest, {nearest}, has {why}")]
    NoneLeft {
        /// The constraints.
        asked: String,
        /// The filler that is nearest to meeting them.
        nearest: String,
        /// How it breaks them.
        why: String,
        /// How far it is from that, as a ratio.
        excess: f64,
    },
    /// A run at one of the intervals does not fit into fixed point.
    #[error(transparent)]
    Lower(#[from] Unrepresentable),
    /// An error of one of several variants.
    #[error("{error}, at {at}")]
    At {
        /// The swept keys with their values.
        at: String,
        /// The error at these values.
        error: Box<DesignError>,
    },
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The runs do not say where 99.73 % of them lie.
    #[error("{trials} runs are too few for the {}", measure.label())]
    TooFew {
        /// Number of runs.
        trials: u64,
        /// Requested measure.
        measure: Measure,
    },
}

impl DesignError {
    /// The error of a variant with these values of swept keys.
    pub(crate) fn of_variant(self, swept: &[(&'static str, Swept)]) -> DesignError {
        let at: Vec<String> = swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        match self {
            DesignError::Gpu(_) => self,
            _ if at.is_empty() => self,
            _ => DesignError::At { at: at.join(", "), error: Box::new(self) },
        }
    }

    /// How far fillers are from meeting the constraints, where none does.
    pub(crate) fn excess(&self) -> Option<f64> {
        match self {
            DesignError::NoneLeft { excess, .. } => Some(*excess),
            DesignError::At { error, .. } => error.excess(),
            _ => None,
        }
    }

    /// The error at the place in the study that caused it.
    ///
    /// # Errors
    /// The device failed.
    pub fn in_study(self, study: &Study) -> Result<StudyError, GpuError> {
        if let DesignError::Study(error) = self {
            return Ok(error);
        }
        let (key, help) = self.remedy()?;
        Ok(study.error_at(study.place_of(key), self.to_string(), help))
    }

    /// The key to change, and how.
    fn remedy(&self) -> Result<(&'static str, &'static str), GpuError> {
        Ok(match self {
            DesignError::Kind(_) => ("kind", "give a study of kind = \"switched-run\""),
            DesignError::Nothing => ("drift", "give drift.magnetic, and fillers or drift.residual_max"),
            DesignError::NoCandidate(_) => ("run.duration", "lengthen the run, or sweep switching.interval"),
            DesignError::NoFillers => (
                "drift.residual_max",
                "leave the constraints out, or take fillers instead of drift.residual_max",
            ),
            DesignError::NoneLeft { .. } => {
                ("switching.fillers", "allow more, or add a filler that reads fewer ticks")
            }
            DesignError::Band { .. } => ("gyro.tick", "give a lower band, or a shorter gyro.tick"),
            DesignError::Study(_) => ("switching.fillers", "give other fillers"),
            DesignError::TooFew { .. } => ("trials", "increase them; 100_000 is usual"),
            DesignError::Lower(lower) => (lower.key, lower.help),
            DesignError::At { error, .. } => return error.remedy(),
            DesignError::Gpu(error) => return Err(error.clone()),
        })
    }
}
