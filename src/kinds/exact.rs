//! Studies whose values are all closed forms; their points become a table at once.

use crate::progress::Progress;
use crate::sampling::plan::{Plan, RunError};
use crate::sampling::tables::Tables;
use crate::store::Store;
use crate::store::error::StoreError;
use crate::table::Table;

/// The plan of such a study, which consists of its table only.
#[derive(Debug)]
pub(crate) struct Exact(pub(crate) Table);

impl Plan for Exact {
    fn tables(&self, _: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Ok(Tables::of_points(self.0.clone()))
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(vec!["all values are closed forms: trials, seed and device are not used".to_owned()])
    }
}
