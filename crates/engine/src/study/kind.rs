//! A kind of study, as the rest of the library sees it.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use crate::chart::file::Source;
use crate::chart::ground::Ground;
use crate::device::load::Load;
use crate::key::reading::Reading;
use crate::key::row::Key;
use crate::sampling::Planned;
use crate::study::Study;
use crate::study::part::Dissected;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::Quantity;
use sagnac_base::source::diagnose::Wrong;
use sagnac_base::table::About;

/// A table of results, with its columns except the swept keys.
pub(crate) type TableColumns = (Source, fn() -> Vec<About>);

/// An entry of the list of kinds. Help, schema, documents, verification and tests iterate that list.
pub struct Kind {
    /// The name in study files, such as `gap-fill`.
    pub name: &'static str,
    /// The subject of such a study, in one sentence.
    pub subject: &'static str,
    /// A description of the simulation and of the columns of its results that hold the answer.
    pub about: &'static str,
    /// A study of this kind with every key explained.
    pub template: &'static str,
    /// Whether every value is a closed form, so that nothing is sampled.
    pub is_exact: bool,
    /// The number of trials at each point if the study gives none.
    pub(crate) trials: u64,
    /// The tables that it requires.
    pub(crate) needs: &'static [&'static str],
    /// Its keys, except those that every study has.
    pub keys: fn() -> Vec<&'static Key>,
    /// The keys that can be swept.
    pub sweepable: fn() -> Vec<&'static Key>,
    /// The columns of each of its tables except the swept keys.
    pub columns: &'static [TableColumns],
    /// The kernels that sample it, with their versions.
    pub kernels: fn() -> String,
    /// The loads on which its kernels are checked; none for closed forms.
    pub(crate) loads: fn() -> Vec<Load>,
    /// Reads the part of a study that belongs to this kind.
    pub(crate) read: fn(&mut Reading) -> Result<Arc<dyn Subject>, Wrong>,
}

impl PartialEq for Kind {
    fn eq(&self, other: &Kind) -> bool {
        self.name == other.name
    }
}

impl Eq for Kind {}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// Bytes of memory that a row of a table takes, with the charts and pages that show it.
pub(crate) const ROW: u64 = 1150;

/// The part of a study that belongs to its kind.
pub trait Subject: Any + fmt::Debug + Send + Sync {
    /// Lowers every point. `progress` receives their number, and each as it is lowered.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a>;

    /// The subject with a single one of its points: as it is, and without each part of its error in turn, everything
    /// else unchanged; fillers keep the weights that they have at the point. `None` where an error has no parts.
    fn dissected(&self, _point: usize) -> Option<Dissected> {
        None
    }

    /// The subject with only what one row of each point needs, by the place of the row among those of its point, and the
    /// place of the row then. `None` where a single row costs as much as all.
    fn only(&self, _row: usize) -> Option<(Arc<dyn Subject>, usize)> {
        None
    }

    /// Quantities at a point that the study does not contain itself, such as those in a file that it names, by the keys
    /// that set them.
    fn values(&self, _point: usize) -> Vec<(&'static Key, Quantity)> {
        vec![]
    }

    /// Bytes of memory that its points and their rows in tables take, about, where that may be more than the bounds of sweeps
    /// allow.
    fn bytes(&self) -> u64 {
        0
    }

    /// The tables of its results, as far as they are known before anything is sampled, with that of the points first.
    fn grounds(&self) -> Vec<Ground>;
}
