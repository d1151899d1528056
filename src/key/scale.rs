//! The scale of an axis, as charts write it and as sweeps suggest it.

use crate::key::holds::words;

words! {
    /// The scale of an axis.
    pub enum Scale {
        /// Equal ratios are equally long.
        Log = "log",
        /// Equal differences are equally long.
        Linear = "linear",
    }
}
