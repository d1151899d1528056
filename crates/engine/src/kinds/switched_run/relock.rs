//! The relock after each switch of a run.

use crate::key::row::{Holds, Key, Reading, keys};
use crate::key::sweep::{self, Swept};
use crate::kinds::gap_fill::{self, GapFill};
use crate::kinds::relock::inputs::{self, Compensation, RELOCK, Relock};
use sagnac_base::source::diagnose::Fault;

/// Relock after each switch, with the compensation of its ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Relocking {
    /// Relock after each switch.
    pub relock: Relock,
    /// Compensation applied before the filler reads the ticks.
    pub compensation: Compensation,
}

keys! {
    /// The key that a relock study does not have.
    static KEYS;
    /// Compensation of the ticks; "none" if absent. A study of kind = "relock" compares all compensations.
    COMPENSATION = "relock.compensation", "compensation", Choice, Holds::Word(Compensation::WORDS), r#"compensation = "detuning""#;
}

/// Every key of a relock in a run.
pub(crate) fn keys() -> Vec<&'static Key> {
    [inputs::KEYS, KEYS].concat()
}

/// The keys of a relock that can be swept.
pub(crate) fn sweepable() -> impl Iterator<Item = &'static Key> {
    sweep::keys(&inputs::SETTINGS).chain([&COMPENSATION])
}

/// The compensation selected by a sweep.
pub(crate) fn swept(swept: &[(&'static str, Swept)]) -> Option<Compensation> {
    let name = sweep::named(swept, &COMPENSATION)?;
    Compensation::ALL.into_iter().find(|compensation| compensation.name() == name)
}

/// Reads the relock, if there is one.
pub(crate) fn read(reading: &mut Reading, fill: Option<&GapFill>) -> Result<Option<Relocking>, Fault> {
    let Some(table) = reading.get(&RELOCK) else {
        let of_relock = |name: &str| sweepable().any(|key| key.name == name);
        return reading.sweeps.iter().find(|sweep| of_relock(sweep.key.name)).map_or(Ok(None), |sweep| {
            let message = format!("{} is swept, but there is no [relock]", sweep.key.name);
            let help = "add the table [relock], or leave the sweep out";
            Err(sweep.fault(message, "not in this study", help))
        });
    };
    if fill.is_none() {
        let message = "[relock] needs fillers and ticks, and there are none";
        let help = "add [gyro], [motion] and switching.fillers, or leave [relock] out";
        return Err(table.fault(message, "without fillers", help));
    }
    if let Some(list) = reading.get(&gap_fill::keys::RELOCK) {
        let message = "gyro.relock conflicts with [relock]";
        return Err(list.fault(message, "a second relock", "leave one of them out"));
    }
    let relock = inputs::read(reading)?;
    reading.note(&[&RELOCK]);
    Ok(Some(Relocking { relock, compensation: Compensation::of(reading.get(&COMPENSATION)) }))
}
