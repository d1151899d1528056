//! The relock after each switch of a run.

use toml::Spanned;

use crate::study::diagnose::Fault;
use crate::study::file::StudyFile;
use crate::study::gap_fill::GapFill;
use crate::study::place::Places;
use crate::study::relock::{Compensation, RELOCK_SETTINGS, Relock, read_relock};
use crate::study::sweep::Sweep;

/// Relock after each switch, and what is taken off its ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Relocking {
    pub relock: Relock,
    pub compensation: Compensation,
}

/// The relock that is written, if any.
pub(super) fn read(
    file: &StudyFile,
    fill: Option<&GapFill>,
    sweeps: &[Sweep],
    places: &mut Places,
) -> Result<Option<Relocking>, Fault> {
    let Some(table) = &file.relock else {
        let of_relock = |key: &str| RELOCK_SETTINGS.iter().any(|setting| setting.name == key);
        let swept = sweeps.iter().zip(&file.sweep).find(|(sweep, _)| of_relock(sweep.key.name));
        return swept.map_or(Ok(None), |(sweep, written)| {
            let message = format!("{} is swept, but there is no [relock]", sweep.key.name);
            let help = "add the table [relock], or leave the sweep out";
            Err(Fault::new(written.key.span(), message, "not in this study", help))
        });
    };
    if fill.is_none() {
        let message = "[relock] works through fillers and ticks, and there are none";
        let help = "add [gyro], [motion] and switching.fillers, or leave [relock] out";
        return Err(Fault::new(table.span(), message, "without fillers", help));
    }
    if let Some(list) = file.gyro.as_ref().and_then(|gyro| gyro.get_ref().relock.as_ref()) {
        let message = "gyro.relock stands beside [relock]";
        return Err(Fault::new(list.span(), message, "a second relock", "leave one of them out"));
    }
    let relock = read_relock(table.get_ref(), places)?;
    places.add("relock", table.span());
    let compensation =
        table.get_ref().compensation.as_ref().map_or(Compensation::None, |c| *Spanned::get_ref(c));
    Ok(Some(Relocking { relock, compensation }))
}
