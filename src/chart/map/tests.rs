//! Maps as a whole.
