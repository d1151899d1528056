//! The kinds of study, each in a folder with everything specific to it, and the keys of all of them.
//!
//! The rest of the library knows them only as entries of [`KINDS`].

pub mod plan;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::LazyLock;

use crate::chart;
use crate::key::docs::{self, Explained, OfKind, explain};
use crate::key::document::{Table, check, wrong_shape};
use crate::key::{self, KIND, TITLE, ValueType, keys, measure, sensitivity, sweep};
use crate::study::Kind;
use sagnac_base::diagnostics::{Fault, choices};
use sagnac_base::quantity::Dimension;

/// Declares the modules of the kinds, and lists their entries.
macro_rules! kinds {
    ($($vis:vis mod $module:ident = $KIND:ident;)+) => {
        $($vis mod $module;)+

        /// Names of the modules of the kinds.
        const MODULES: &[&str] = &[$(stringify!($module)),+];

        /// Every kind of study.
        pub static KINDS: [&Kind; MODULES.len()] = [$(&$module::$KIND),+];
    };
}

kinds! {
    pub mod gap_fill = GAP_FILL;
    pub mod allan = ALLAN;
    pub mod switched_run = SWITCHED_RUN;
    pub mod relock = RELOCK;
    pub mod lock_in = LOCK_IN;
    pub(crate) mod drift_budget = DRIFT_BUDGET;
    pub(crate) mod suspension = SUSPENSION;
    pub mod navigation = NAVIGATION;
}

/// The keys of all kinds, in the order of [`KINDS`].
static OF_KINDS: LazyLock<Vec<OfKind>> = LazyLock::new(|| KINDS.into_iter().map(of).collect());

fn of(kind: &Kind) -> OfKind {
    let keys =
        docs::distinct([key::KEYS, &(kind.keys)(), sweep::KEYS, sensitivity::KEYS, chart::KEYS].concat());
    let Kind { name, subject, needs, sweepable, .. } = kind;
    OfKind { name, meaning: subject, keys, needs, sweepable: sweepable() }
}

/// The names of all keys of study files, in order.
pub fn explained_keys() -> impl Iterator<Item = &'static str> {
    docs::all(&OF_KINDS).into_iter().map(|key| key.name)
}

/// Explains a key; `None` for an unknown one.
///
/// # Example
/// ```
/// # use sagnac_engine::kinds::explain_key;
/// let tick = explain_key("gyro.tick").unwrap();
/// assert_eq!(tick.example, "tick = \"5 ms\"");
/// assert_eq!((tick.range.as_str(), tick.swept), ("1 µs to 1000 s", Some("tick")));
/// ```
pub fn explain_key(key: &str) -> Option<Explained> {
    explain(&OF_KINDS, key)
}

/// The JSON schema of study files, for editors and other programs.
pub fn schema() -> String {
    docs::schema(&OF_KINDS)
}

/// The kind of a study, with its keys, after checking that the study has only these keys and that their values have the
/// right shape.
pub(crate) fn checked(study: &Table) -> Result<(&'static Kind, &'static OfKind), Fault> {
    study.needed(&TITLE)?;
    let written = study.needed(&KIND)?;
    if !written.is_text() {
        return Err(wrong_shape(written, false));
    }
    let known = || KINDS.iter().zip(OF_KINDS.iter());
    let Some((kind, keys)) = known().find(|(kind, _)| kind.name == written.text()) else {
        let help = choices(written.text(), &KINDS.map(|kind| kind.name));
        return Err(written.fault(format!("unknown value {written}"), "not one of the choices", help));
    };
    check(study, &keys.keys, &|name, span| of_others(kind, name, span))?;
    let missing = keys.keys.iter().find(|key| keys.needs.contains(&key.name) && study.find(key).is_none());
    match missing {
        Some(table) => Err(Fault::missing_table(table.name, table.example, kind.name, written.span())),
        None => Ok((kind, keys)),
    }
}

/// The fault of a key that only other kinds have.
fn of_others(kind: &Kind, name: &str, span: Range<usize>) -> Option<Fault> {
    let has = |other: &OfKind| other.keys.iter().any(|key| key.name == name);
    let others: Vec<String> = OF_KINDS
        .iter()
        .filter(|other| has(other))
        .map(|other| format!("kind = \"{}\"", other.name))
        .collect();
    let key = OF_KINDS.iter().flat_map(|other| &other.keys).find(|key| key.name == name)?;
    let what = match key.holds {
        ValueType::Table if key.table().is_empty() => format!("[{name}] is not a table"),
        _ => format!("{name} is not a key"),
    };
    let message = format!("{what} of a study of kind = \"{}\"", kind.name);
    let help = format!("leave it out, or write {}", others.join(" or "));
    Some(Fault::new(span, message, "not of this kind", help))
}

keys! {
    /// The key of the tick.
    pub(crate) static KEYS;
    /// Length of a tick, the time between two readings of the angle: "5 ms".
    pub TICK = "gyro.tick", "tick", Choice, measure(&[Dimension::Time], 1e-6, 1e3, "1 µs to 1000 s"), r#"tick = "5 ms""#, required;
}

#[cfg(test)]
mod keys_tests {
    use super::*;
    use crate::key::Key;
    use crate::key::document::READ;
    use crate::study::Study;
    use std::path::Path;

    #[test]
    fn every_key_is_explained_and_the_example_names_it() {
        for key in explained_keys() {
            let found = explain_key(key).unwrap_or_else(|| panic!("{key} is not in the schema"));
            let last = key.rsplit('.').next().unwrap();
            assert!(found.example.contains(last), "the example of {key} is {}", found.example);
            assert!(!found.kinds.is_empty(), "{key} is of no kind");
            assert!(!found.meaning.is_empty(), "nothing is said of {key}");
        }
        for key in KINDS.into_iter().flat_map(|kind| (kind.sweepable)()) {
            // The ends of bands occur only in sweeps.
            assert!(
                explain_key(key.name).is_some() || key.name.ends_with("low") || key.name.ends_with("high"),
                "{}",
                key.name
            );
        }
    }

    /// A key without a setting would be accepted and have no effect.
    #[test]
    fn keys_with_a_label_are_those_that_a_sweep_may_vary() {
        let swept: Vec<&Key> = KINDS.iter().flat_map(|kind| (kind.sweepable)()).collect();
        for key in KINDS.iter().flat_map(|kind| (kind.keys)()).chain(swept.iter().copied()) {
            let is_swept = swept.iter().any(|known| known.name == key.name);
            assert_eq!(is_swept, !key.label.is_empty(), "{}", key.name);
        }
    }

    /// A key that nothing asks for would be accepted and have no effect.
    #[test]
    fn every_listed_key_is_read_by_some_study() {
        let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies");
        for path in std::fs::read_dir(studies).unwrap().map(|entry| entry.unwrap().path()) {
            if path.extension().is_some_and(|end| end == "toml") {
                Study::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            }
        }
        let modes = r#"modes = [{ frequency = "80 Hz", q = 50, response = "1 deg/s/g" }]"#;
        let gap = format!(
            r#"title = "A line, a band and modes"
               kind = "gap-fill"
               trials = 64
               [gyro]
               tick = "2 ms"
               tick_noise = {{ std = "0.2 arcsec" }}
               [motion]
               suspension = {{ {modes}, sine = {{ acceleration = "1 g", frequency = "50 Hz" }} }}
               [specification]
               lines = [{{ amplitude = "90 arcsec", frequency = "345 Hz", tolerance = "0.1 %" }}]
               bands = [{{ rms = "1 deg/s", band = ["30 Hz", "80 Hz"], tolerance = "5 %" }}]
               [switching]
               gap_ticks = 3
               fillers = ["const"]
               errors = ["residual"]"#
        );
        let response =
            format!("title = \"Modes\"\nkind = \"suspension\"\n[suspension]\nfrequency = \"20 Hz\"\n{modes}");
        for text in [gap, response] {
            Study::parse("study.toml", &text).unwrap_or_else(|error| panic!("{error:?}"));
        }
        let read = READ.take();
        // A table by itself has no value, and tables of lists are read by the names of their keys.
        let all = docs::distinct(OF_KINDS.iter().flat_map(|kind| kind.keys.clone()).collect::<Vec<_>>());
        let is_read = |key: &Key| key.holds.is_table() || read.contains(key.name);
        let unread: Vec<&str> = all.iter().filter(|key| !is_read(key)).map(|key| key.name).collect();
        assert!(unread.is_empty(), "nothing reads {unread:?}");
    }

    #[test]
    fn units_range_choices_and_kinds_are_told() {
        let amplitude = explain_key("motion.amplitude").unwrap();
        assert!(amplitude.meaning.starts_with("Amplitude of the rate"), "{}", amplitude.meaning);
        assert!(
            amplitude.accepted.contains("arcsec/s, deg/s") && amplitude.range.starts_with("0 to 1e9"),
            "{amplitude:?}"
        );
        let phase = explain_key("motion.phase").unwrap();
        let words: Vec<&str> = phase.choices.iter().map(|(word, _)| *word).collect();
        assert_eq!(words, ["uniform", "zero-crossing", "extremum"]);
        assert_eq!(explain_key("relock.initial_detuning").unwrap().kinds, ["switched-run", "relock"]);
        assert_eq!(explain_key("title").unwrap().kinds.len(), KINDS.len());
        assert_eq!(explain_key("motion.amplitud"), None);
    }
}
