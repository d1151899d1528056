//! The decision to which a log leads.

use crate::analysis::requirement::{Decision, Limit, Subject, decide};
use crate::analysis::spectrum::Analysis;

impl Analysis {
    /// The decision to which the columns of the log lead: its coefficients, the minima of its curves, and N of its densities
    /// where there are some.
    pub fn decision(&self, limits: &[Limit]) -> Decision {
        let floor = |place: usize| self.spectra.get(place)?.white.from_floor.as_ref();
        let columns = self.noise.columns.iter().enumerate();
        let subjects: Vec<Subject> =
            columns.map(|(place, column)| Subject::of_column(&self.noise, column, floor(place))).collect();
        decide(&subjects, limits, "column")
    }
}
