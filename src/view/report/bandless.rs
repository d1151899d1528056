//! Fillers that firmware cannot have.

use crate::filler::{FILLERS, Filler, Method};
use crate::kinds::gap_fill::GapFill;
use crate::kinds::switched_run::SwitchedRun;
use crate::motion::Frequency;
use crate::motion::keys::{FREQUENCY_HIGH, FREQUENCY_LOW};
use crate::study::Study;
use crate::table::{Column, Table};

/// The ends of the band from which a frequency is drawn.
const BAND: [&str; 2] = [FREQUENCY_LOW.name, FREQUENCY_HIGH.name];

/// The fillers that are designed without a band, whose weights firmware cannot have: they follow the motion of each
/// point, or one frequency to the last digit. For a motion that is drawn from a band, they are those of the band.
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
        let gap_fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref())?;
        let is_bandless = |filler: &&Filler| filler.method == Method::MinimumVariance(None);
        let names = gap_fill.fillers.iter().filter(is_bandless).map(|filler| filler.name.as_str());
        let names: Vec<&str> = names.collect();
        let tones = &gap_fill.inputs.motion.tones;
        let is_tuned = tones.iter().any(|tone| matches!(tone.frequency, Frequency::Fixed(_)));
        // A band that is swept is known to the designer, who designs for each.
        let is_band = |key: &str| !is_tuned && !tones.is_empty() && BAND.contains(&key);
        let of_design = |key: &str| {
            ["motion.", "gyro.", "noise."].iter().any(|table| key.starts_with(table)) && !is_band(key)
        };
        let varies = study.sweeps.iter().any(|sweep| sweep.values.len() > 1 && of_design(sweep.key.name));
        let why = match (varies, is_tuned) {
            (true, _) => "the very motion of each point",
            (false, true) => "exactly this frequency",
            (false, false) => return None,
        };
        (!names.is_empty()).then_some(Bandless { column, names, why })
    }
}
