//! The relock after each switch of a run.

use toml::Spanned;

use crate::key::file::StudyFile;
use crate::key::setting::{Key, Swept};
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::GapFill;
use crate::kinds::relock::inputs::{Compensation, Relock, SETTINGS as RELOCK_SETTINGS, read as read_relock};
use crate::source::diagnose::Fault;
use crate::source::place::Places;

/// Relock after each switch, and what is taken off its ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Relocking {
    /// What the loop does after each switch.
    pub relock: Relock,
    /// What is taken off before the filler sees the ticks.
    pub compensation: Compensation,
}

/// Every key of it that a sweep may vary.
pub(crate) fn keys() -> impl Iterator<Item = &'static Key> {
    RELOCK_SETTINGS.iter().map(|setting| &setting.key).chain([&COMPENSATION])
}

static COMPENSATION: Key = Key {
    name: "relock.compensation",
    label: "compensation",
    accepts: &[],
    limits: (0.0, 0.0, "none, frequency, detuning"),
};

/// The compensation that a sweep chooses.
pub(crate) fn swept(swept: &[(&'static str, Swept)]) -> Option<Compensation> {
    swept.iter().find_map(|(name, value)| match value {
        Swept::Name(chosen) if *name == COMPENSATION.name => {
            Compensation::ALL.into_iter().find(|compensation| compensation.name() == chosen)
        }
        _ => None,
    })
}

/// The relock that is written, if any.
pub(crate) fn read(
    file: &StudyFile,
    fill: Option<&GapFill>,
    sweeps: &[Sweep],
    places: &mut Places,
) -> Result<Option<Relocking>, Fault> {
    let Some(table) = &file.relock else {
        let of_relock = |name: &str| keys().any(|key| key.name == name);
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
    if let Some(gain) = &table.get_ref().signal_gain {
        let message = "relock.signal_gain is no key of a study of kind = \"switched-run\"";
        return Err(Fault::new(gain.span(), message, "not of this kind", "leave it out"));
    }
    let relock = read_relock(table.get_ref(), places)?;
    places.add("relock", table.span());
    let compensation =
        table.get_ref().compensation.as_ref().map_or(Compensation::None, |c| *Spanned::get_ref(c));
    Ok(Some(Relocking { relock, compensation }))
}
