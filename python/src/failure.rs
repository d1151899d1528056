//! Errors, as exceptions of `sagnac.errors`.

use pyo3::import_exception;
use pyo3::prelude::*;
use sagnac::allan::deviation::TauError;
use sagnac::analysis::decision::DecisionError;
use sagnac::analysis::firmware::ChoiceError;
use sagnac::analysis::model::ModelError;
use sagnac::analysis::requirement::LimitError;
use sagnac::device::select::SelectError;
use sagnac::record::RecordError as Unreadable;
use sagnac::run::RunError;
use sagnac::store::error::StoreError;
use sagnac::store::folder::FolderError;
use sagnac::use_cases::LogError;
use sagnac_base::diagnostics::{StudyError as Refused, spelled, visible};

import_exception!(sagnac.errors, DeviceError);
import_exception!(sagnac.errors, InternalError);
import_exception!(sagnac.errors, RecordError);
import_exception!(sagnac.errors, StorageError);
import_exception!(sagnac.errors, StudyError);
import_exception!(sagnac.errors, UsageError);

/// Width of the report of an error in a study, in columns.
const WIDTH: usize = 100;

/// Why a call did not complete its task.
#[derive(Debug)]
pub enum Failure {
    Study(Refused),
    /// An invalid argument.
    Usage(String),
    /// Unusable samples.
    Record(String),
    /// An unusable log.
    Log(Unreadable),
    Store(StoreError),
    Select(SelectError),
    Run(RunError),
    Write(String),
    /// A device or threads that do not work.
    Device(String),
    /// An exception raised by a function of the caller, or an interruption.
    Python(PyErr),
    /// A panic, which Rust has printed on the standard error stream.
    Panic,
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> PyErr {
        // Python prints exceptions to terminals.
        let told = |message: &str| visible(message).into_owned();
        match failure {
            Failure::Study(error) => StudyError::new_err(error.render(false, WIDTH).trim_end().to_owned()),
            Failure::Usage(message) => UsageError::new_err(told(&message)),
            Failure::Log(error) => RecordError::new_err(error.render(false, WIDTH).trim_end().to_owned()),
            Failure::Record(message) => RecordError::new_err(told(&message)),
            Failure::Store(error) => StorageError::new_err(told(&in_python(&error.to_string()))),
            Failure::Select(error) if error.is_usage() => {
                UsageError::new_err(told(&in_python(&error.to_string())))
            }
            Failure::Select(error) => DeviceError::new_err(told(&in_python(&error.to_string()))),
            Failure::Run(RunError::Store(error)) => {
                StorageError::new_err(told(&in_python(&error.to_string())))
            }
            Failure::Run(RunError::Gpu(error)) => DeviceError::new_err(format!(
                "{error}\ncompleted work is kept if out= is given: run again to continue, or use device=\"cpu\""
            )),
            Failure::Run(RunError::Refused(error)) => RecordError::new_err(told(&error.to_string())),
            Failure::Write(message) => StorageError::new_err(told(&message)),
            Failure::Device(message) => DeviceError::new_err(message),
            Failure::Python(error) => error,
            Failure::Panic => InternalError::new_err(
                "the program reached an invalid state: this is a fault of sagnac, and nothing is wrong with \
                 what it was given\nplease report it with the message above",
            ),
        }
    }
}

impl From<Refused> for Failure {
    fn from(error: Refused) -> Failure {
        Failure::Study(error)
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Failure {
        Failure::Store(error)
    }
}

impl From<FolderError> for Failure {
    fn from(error: FolderError) -> Failure {
        Failure::Write(format!("{error}\nmake room, or choose another folder with out="))
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Failure {
        Failure::Run(error)
    }
}

impl From<SelectError> for Failure {
    fn from(error: SelectError) -> Failure {
        Failure::Select(error)
    }
}

impl From<TauError> for Failure {
    fn from(error: TauError) -> Failure {
        Failure::Usage(in_python(&error.to_string()))
    }
}

impl From<LimitError> for Failure {
    fn from(error: LimitError) -> Failure {
        Failure::Usage(format!("limits: {error}"))
    }
}

impl From<ChoiceError> for Failure {
    fn from(error: ChoiceError) -> Failure {
        match error {
            ChoiceError::Asked(message) => Failure::Usage(in_python(&message)),
            ChoiceError::Study(error) => Failure::Study(error),
        }
    }
}

impl From<Unreadable> for Failure {
    fn from(error: Unreadable) -> Failure {
        Failure::Log(error.spelled(&argument))
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Failure {
        let message = in_python(&error.to_string());
        match error {
            LogError::Limit(error) | LogError::RatioLimit(error) => error.into(),
            LogError::Model(ModelError::Noise(error)) => Failure::Study(error),
            LogError::Tau(_) | LogError::Dynamic(_) => Failure::Usage(message),
            LogError::Batch(_) => Failure::Record(message),
            error if error.is_usage() => Failure::Usage(message),
            _ => Failure::Record(message),
        }
    }
}

/// Settings of the library with the corresponding arguments.
const ARGUMENTS: [(&str, &str); 30] = [
    ("at", "at"),
    ("axes", "axes"),
    ("band", "band"),
    ("binary", "binary"),
    ("bootstrap", "bootstrap"),
    ("by", "by"),
    ("column", "column"),
    ("curve_interval", "curve_interval"),
    ("data", "kind"),
    ("decimal", "decimal"),
    ("device", "device"),
    ("duplicates", "duplicates"),
    ("dynamic", "dynamic"),
    ("filler", "fillers"),
    ("length", "length"),
    ("motion", "motion"),
    ("noise", "noise"),
    ("out", "out"),
    ("rate", "rate"),
    ("scale", "unit"),
    ("segment", "segment"),
    ("skip", "skip"),
    ("switch_every", "switch_every"),
    ("tau", "taus"),
    ("temperature", "temperature"),
    ("temperature_unit", "temperature_unit"),
    ("time", "time"),
    ("time_unit", "time_unit"),
    ("unit", "unit"),
    ("unit_check", "unit_check"),
];

/// A setting as an argument.
fn argument(name: &str, value: &str) -> Option<String> {
    let (_, argument) = ARGUMENTS.iter().find(|(known, _)| *known == name)?;
    Some(format!("{argument}={value}"))
}

/// A message of the library in terms of arguments.
pub fn in_python(message: &str) -> String {
    spelled(message, &argument)
}

impl From<DecisionError> for Failure {
    fn from(error: DecisionError) -> Failure {
        match error {
            DecisionError::Study(error) => Failure::Study(error),
            DecisionError::Run(error) => Failure::Run(error),
            DecisionError::Column(_) => Failure::Usage(error.to_string()),
            DecisionError::Threads(_) => Failure::Device(error.to_string()),
        }
    }
}
