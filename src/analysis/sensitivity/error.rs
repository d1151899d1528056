//! Why an analysis is not possible.

use sagnac_base::source::diagnose::StudyError;
use sagnac_base::table::ColumnError;
use sagnac_engine::key::sensitivity::SENSITIVITY;
use sagnac_engine::run::RunError;
use sagnac_engine::study::Study;

/// Why an analysis is not possible.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    /// The study has no uncertain inputs.
    #[error("the study has no uncertain inputs")]
    NoInputs,
    /// This key is swept.
    #[error("{0} is swept: a sensitivity is of one point")]
    Swept(&'static str),
    /// The answer or its rows cannot be chosen.
    #[error(transparent)]
    Column(#[from] ColumnError),
    /// The study has no column by which it is judged.
    #[error("the study has no usual answer: choose one of its columns by `by = COLUMN`")]
    NoAnswer,
    /// Each point has several rows, which differ in this.
    #[error("each point has several answers: {0}; choose one by `where = COLUMN=VALUE`")]
    SeveralRows(String),
    /// The answer has no number at a point.
    #[error("{column} has no value at {at}; choose another answer by `by = COLUMN`")]
    NoValue {
        /// Column of the answer.
        column: String,
        /// Values at the point.
        at: String,
    },
    /// The answer is the same everywhere.
    #[error("{column} is {value} everywhere: it depends on none of the uncertain inputs")]
    Constant {
        /// Column of the answer.
        column: String,
        /// Its value.
        value: String,
    },
    /// A point is not valid.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The device failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl SensitivityError {
    /// The error at the place in the study that caused it; the same error where the study did not.
    ///
    /// # Errors
    /// The request, the answer or the device caused it.
    pub fn in_study(self, study: &Study) -> Result<StudyError, SensitivityError> {
        let at = |key: &str, help: &str| study.error_at(study.place_of(key), self.to_string(), help);
        Ok(match self {
            SensitivityError::NoInputs => at("kind", &format!("add one as in\n{}", SENSITIVITY.example)),
            SensitivityError::Swept(key) => {
                at(key, "give the key one value, or make it an uncertain input instead")
            }
            SensitivityError::Study(error) => error,
            other => return Err(other),
        })
    }
}
