//! Fillers that firmware cannot have.

use crate::filler::FILLERS;
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::tuning::{Tuning, tuned};
use crate::kinds::switched_run::SwitchedRun;
use crate::study::Study;
use crate::table::{Column, Table};

/// The fillers that are designed without a band, whose weights firmware cannot have: they follow the motion of each
/// point, or one motion to the last digit. For a motion that is drawn from a band, they are those of the band.
pub(crate) struct Bandless<'a> {
    /// The column of all fillers.
    pub(crate) column: &'a Column,
    pub(crate) names: Vec<&'a str>,
    /// What they are designed for.
    pub(crate) why: &'static str,
}

impl<'a> Bandless<'a> {
    pub(crate) fn of(study: &'a Study, table: &'a Table) -> Option<Bandless<'a>> {
        let column = table.listed_by(FILLERS)?;
        let fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref())?;
        let (tuning, names) = tuned(study, fill)?;
        let why = match tuning {
            Tuning::Points => "the very motion of each point",
            Tuning::Frequency => "exactly this motion",
        };
        Some(Bandless { column, names, why })
    }
}
