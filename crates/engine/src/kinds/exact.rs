//! Studies whose values are all closed forms; their points become a table at once.

use crate::sampling::{Done, Plan, RunError, Tables, Worker};
use crate::store::Store;
use crate::store::error::StoreError;
use crate::store::index::Index;
use crate::tally::{Id, Share};
use sagnac_base::progress::Progress;
use sagnac_base::table::Table;

/// The plan of such a study, which consists of its table only.
#[derive(Debug)]
pub(crate) struct Exact(pub(crate) Table);

impl Plan for Exact {
    fn run(&self, _: &mut Store, _: &mut Worker, _: Share, _: &dyn Progress) -> Result<Done, RunError> {
        Ok(Done { trials: 0, seconds: 0.0, stopped: false, degraded: vec![] })
    }

    fn lacks(&self, _: &Store, _: Share) -> Result<u64, StoreError> {
        Ok(0)
    }

    fn tables(&self, _: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Ok(Tables::of_points(self.0.clone()))
    }

    fn held(&self, _: &Index) -> Result<Option<u64>, StoreError> {
        Ok(None)
    }

    fn ids(&self) -> Vec<Id> {
        vec![]
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(vec!["all values are closed forms: trials, seed and device are not used".to_owned()])
    }

    fn all_trials(&self) -> u64 {
        u64::MAX
    }
}
