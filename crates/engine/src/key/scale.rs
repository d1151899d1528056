//! The scale of an axis, as charts write it and as sweeps suggest it.

pub use sagnac_base::scale::Scale;

use crate::key::given::Given;

/// The scale as written, or the default.
pub(crate) fn scale_of(given: Option<Given>) -> Scale {
    let named = |given: Given| Scale::ALL.into_iter().find(|known| known.name() == given.text());
    given.and_then(named).unwrap_or_default()
}
