//! The relock after each switch of a run.

use crate::key::holds::Holds;
use crate::key::reading::Reading;
use crate::key::row::{Key, keys};
use crate::key::setting::{self, Swept};
use crate::kinds::gap_fill::{self, GapFill};
use crate::kinds::relock::inputs::{self, Compensation, RELOCK, Relock};
use crate::source::diagnose::Fault;

/// Relock after each switch, and what is taken off its ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Relocking {
    /// What the loop does after each switch.
    pub relock: Relock,
    /// What is taken off before the filler sees the ticks.
    pub compensation: Compensation,
}

keys! {
    /// What no relock by itself has.
    static KEYS;
    /// What is taken off the ticks; "none" if absent. A study of kind = "relock" compares all.
    COMPENSATION = "relock.compensation", "compensation", Holds::Word(Compensation::WORDS), r#"compensation = "detuning""#;
}

/// Every key of it.
pub(crate) fn keys() -> Vec<&'static Key> {
    [inputs::KEYS, KEYS].concat()
}

/// Every key of it that a sweep may vary.
pub(crate) fn sweepable() -> impl Iterator<Item = &'static Key> {
    setting::keys(&inputs::SETTINGS).chain([&COMPENSATION])
}

/// The compensation that a sweep chooses.
pub(crate) fn swept(swept: &[(&'static str, Swept)]) -> Option<Compensation> {
    let name = setting::named(swept, &COMPENSATION)?;
    Compensation::ALL.into_iter().find(|compensation| compensation.name() == name)
}

/// The relock that is written, if any.
pub(crate) fn read(reading: &mut Reading, fill: Option<&GapFill>) -> Result<Option<Relocking>, Fault> {
    let Some(table) = reading.get(&RELOCK) else {
        let of_relock = |name: &str| sweepable().any(|key| key.name == name);
        return reading.sweeps.iter().find(|sweep| of_relock(sweep.key.name)).map_or(Ok(None), |sweep| {
            let message = format!("{} is swept, but there is no [relock]", sweep.key.name);
            let help = "add the table [relock], or leave the sweep out";
            Err(Fault::new(sweep.key_span.clone(), message, "not in this study", help))
        });
    };
    if fill.is_none() {
        let message = "[relock] works through fillers and ticks, and there are none";
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
