//! The keys of fillers and their reading.

use std::sync::Arc;

use crate::filler::{
    self, CLOSED, FARTHEST, Filler, LISTED, MINIMUM_VARIANCE, Method, Purpose, Specification, Target,
    TickList, WEIGHTS, named,
};
use crate::key::document::{SpannedValue, Table};
use crate::key::{ValueType, keys, words};
use crate::motion::keys::{FREQUENCIES, band};
use sagnac_base::diagnostics::{Fault, choices};

words! {
    /// An error of a filler.
    pub enum Error {
        /// Permanent error of the angle, after the gap is closed and corrected.
        Residual = "residual",
        /// Error of the angle at the end of the gap, before it is corrected.
        Extrapolation = "extrapolation",
        /// Largest error of the angle while the gap is open.
        InGap = "in-gap",
    }
}

/// Longest gap, ticks.
const MAX_GAP: i64 = FARTHEST;

const LIST: ValueType = ValueType::List(&ValueType::Any);

keys! {
    /// The keys of the gap and its fillers.
    pub(crate) static KEYS;
    /// The mode switch, and the fillers of the lost ticks.
    pub(crate) SWITCHING = "switching", "", Fixed, ValueType::Table, "[switching]\ngap_ticks = 3\nfillers = [\"const\", \"quadratic\"]";
    /// Number n of lost ticks; they are numbered 1 … n.
    pub GAP_TICKS = "switching.gap_ticks", "lost ticks n", Condition, ValueType::Whole(1, MAX_GAP), "gap_ticks = 3";
    /// Ticks to which the residual is fitted; -1, 0, n+1, n+2 if absent. A tick is a number or "n+1"; "-7..0" is a
    /// range of ticks.
    pub(crate) FIT_TICKS = "switching.fit_ticks", "", Fixed, LIST, r#"fit_ticks = [-1, 0, "n+1", "n+2"]"#;
    /// Ticks to which the extrapolation is fitted, none after 0; -3, -2, -1, 0 if absent.
    pub(crate) EXTRAPOLATION_TICKS = "switching.extrapolation_ticks", "", Fixed, LIST, "extrapolation_ticks = [-3, -2, -1, 0]";
    /// Fillers to compare, each once: a polynomial "const", "linear" or "quadratic", fitted to switching.fit_ticks, or
    /// a table with its own kind, name and ticks, such as a minimum-variance filler.
    pub FILLERS = "switching.fillers", "", Fixed, ValueType::List(&ValueType::Either(&[ValueType::Any, ValueType::Word(filler::NAMES), ValueType::Table])), r#"fillers = ["const", "quadratic", { kind = "minimum-variance", name = "mv8+2", fit_ticks = ["-7..0", "n+1", "n+2"] }]"#;
    /// Method by which the filler weights its ticks.
    pub(crate) FILLER_KIND = "switching.fillers.kind", "", Fixed, ValueType::Word(filler::KINDS), r#"kind = "minimum-variance""#, required;
    /// Name in tables and charts; the kind if absent.
    pub(crate) FILLER_NAME = "switching.fillers.name", "", Fixed, ValueType::Text, r#"name = "mv8+2""#;
    /// Ticks to which the residual is fitted; switching.fit_ticks if absent.
    pub(crate) FILLER_FIT_TICKS = "switching.fillers.fit_ticks", "", Fixed, LIST, r#"fit_ticks = ["-7..0", "n+1", "n+2"]"#;
    /// Ticks to which the extrapolation is fitted. If absent, they are the fit ticks up to 0 for a minimum-variance
    /// filler with its own fit_ticks, else switching.extrapolation_ticks.
    pub(crate) FILLER_EXTRAPOLATION_TICKS = "switching.fillers.extrapolation_ticks", "", Fixed, LIST, r#"extrapolation_ticks = ["-7..0"]"#;
    /// Vibration band for which a minimum-variance filler is designed, ["18 Hz", "22 Hz"]; the study's own motion if
    /// absent.
    pub(crate) FILLER_BAND = "switching.fillers.band", "", Fixed, ValueType::Pair(&FREQUENCIES), r#"band = ["18 Hz", "22 Hz"]"#;
    /// Weights of the residual in the order of its ticks; their sum is n. They are numbers, or fractions such as "5/2".
    pub(crate) FILLER_WEIGHTS = "switching.fillers.weights", "", Fixed, LIST, r#"weights = [-1, "5/2", "5/2", -1]"#;
    /// Weights of the extrapolation. If absent, the filler does not extrapolate.
    pub(crate) FILLER_EXTRAPOLATION_WEIGHTS = "switching.fillers.extrapolation_weights", "", Fixed, LIST, r#"extrapolation_weights = ["3/4", "3/4", "3/4", "3/4"]"#;
}

keys! {
    /// The keys that apply only where single switches are studied.
    pub(crate) static OF_ONE_SWITCH;
    /// Errors to sample, each once; ["residual", "extrapolation"] if absent.
    pub ERRORS = "switching.errors", "", Fixed, ValueType::List(&ValueType::Word(Error::WORDS)), r#"errors = ["residual", "extrapolation", "in-gap"]"#;
}

/// A filler, with its own lists of ticks.
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) filler: Filler,
    pub(crate) fit_ticks: Option<TickList>,
    pub(crate) extrapolation: Extrapolation,
    /// Place of the whole entry.
    pub(crate) span: std::ops::Range<usize>,
}

/// The ticks to which an extrapolation is fitted.
#[derive(Debug)]
pub(crate) enum Extrapolation {
    /// The ticks of the study.
    Common,
    Own(TickList),
    /// The fit ticks up to 0.
    OfFit,
    /// No ticks, as there is no extrapolation.
    None,
}

/// Most fillers of a study.
const MAX_FILLERS: usize = 1000;

/// Reads the fillers; those of least variance without a band are designed for the specification, if there is one.
pub(crate) fn read(
    list: SpannedValue,
    specification: Option<&Arc<Specification>>,
) -> Result<Vec<Written>, Fault> {
    if list.items().is_empty() {
        let message = "switching.fillers is empty, there is nothing to compare";
        return Err(list.fault(message, "no filler", choices("", LISTED)));
    }
    let count = list.items().len();
    if count > MAX_FILLERS {
        let help = format!("accepted: up to {MAX_FILLERS}; `sagnac design` searches fillers by itself");
        return Err(list.fault(format!("switching.fillers lists {count} fillers"), "too many", help));
    }
    let mut fillers: Vec<Written> = Vec::new();
    for entry in list.items() {
        let written = match entry.table() {
            None => of_name(entry)?,
            Some(table) => of_table(&table, specification)?,
        };
        let name = &written.filler.name;
        if fillers.iter().any(|earlier| earlier.filler.name == *name) {
            let message = format!("switching.fillers lists \"{name}\" twice");
            let help = "leave it out here, or give it another name";
            return Err(entry.fault(message, "listed before", help));
        }
        fillers.push(written);
    }
    Ok(fillers)
}

fn of_name(entry: SpannedValue) -> Result<Written, Fault> {
    let text = entry.text();
    let Some(closed) = named(text) else {
        let message = format!("switching.fillers: {entry} is not a filler");
        let help = format!("{}, or a table such as {EXAMPLE}", choices(text, LISTED));
        return Err(entry.fault(message, "not a filler", help));
    };
    let filler = Filler::closed(closed);
    Ok(Written { filler, fit_ticks: None, extrapolation: Extrapolation::Common, span: entry.span() })
}

/// An example of a filler given as a table.
const EXAMPLE: &str =
    "{ kind = \"minimum-variance\", name = \"mv8+2\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }";

fn of_table(table: &Table, specification: Option<&Arc<Specification>>) -> Result<Written, Fault> {
    let kind = table.get(&FILLER_KIND).map_or(CLOSED[0].name, |kind| kind.text());
    for (key, wanted) in [
        (&FILLER_WEIGHTS, WEIGHTS),
        (&FILLER_EXTRAPOLATION_WEIGHTS, WEIGHTS),
        (&FILLER_BAND, MINIMUM_VARIANCE),
    ] {
        if let Some(written) = table.get(key).filter(|_| kind != wanted) {
            let message = format!("{} has no meaning for a filler of kind \"{kind}\"", key.last());
            return Err(written.fault(message, "not for this kind", "leave it out"));
        }
    }
    let [fit_ticks, extrapolation_ticks, weights, extrapolation_weights] =
        [&FILLER_FIT_TICKS, &FILLER_EXTRAPOLATION_TICKS, &FILLER_WEIGHTS, &FILLER_EXTRAPOLATION_WEIGHTS]
            .map(|key| table.get(key));
    let method = match kind {
        MINIMUM_VARIANCE => {
            let band = table.get(&FILLER_BAND).map(band).transpose()?;
            Method::MinimumVariance(Target::new(band, specification))
        }
        WEIGHTS => {
            let Some(weights) = weights else {
                let message = "a filler of kind \"weights\" needs weights";
                let help = format!("add for example {}", FILLER_WEIGHTS.example);
                return Err(Fault::new(table.span.clone(), message, "no weights", help));
            };
            let numbers = |list: SpannedValue| list.items().into_iter().map(weight).collect::<Result<_, _>>();
            let extrapolation = extrapolation_weights.map(numbers).transpose()?;
            if let (None, Some(ticks)) = (&extrapolation, extrapolation_ticks) {
                let message = "extrapolation_ticks are given without extrapolation_weights";
                return Err(ticks.fault(message, "ticks without weights", "add them, or leave it out"));
            }
            Method::Weights { residual: numbers(weights)?, extrapolation }
        }
        name => Method::Closed(named(name).unwrap_or(&CLOSED[0])),
    };
    let extrapolation = match (&method, extrapolation_ticks) {
        (Method::Weights { extrapolation: None, .. }, _) => Extrapolation::None,
        (_, Some(_)) => Extrapolation::Own(TickList::read(Purpose::Extrapolation, extrapolation_ticks)?),
        (Method::MinimumVariance(_), None) if fit_ticks.is_some() => Extrapolation::OfFit,
        (_, None) => Extrapolation::Common,
    };
    let name = match table.get(&FILLER_NAME) {
        None => kind.to_owned(),
        Some(name) => {
            let text = name.text().trim();
            if text.is_empty() || text.chars().any(char::is_control) {
                let message = "the name of a filler is a text on one line";
                return Err(name.fault(message, "not a name", "write for example name = \"mv8+2\""));
            }
            text.to_owned()
        }
    };
    let fit_ticks = fit_ticks.map(|_| TickList::read(Purpose::Residual, fit_ticks)).transpose()?;
    Ok(Written { filler: Filler { name, method }, fit_ticks, extrapolation, span: table.span.clone() })
}

/// Reads a weight: a number, or a fraction as text.
fn weight(given: SpannedValue) -> Result<f64, Fault> {
    let fraction = |text: &str| {
        let number = |part: &str| part.trim().replace('−', "-").parse::<f64>().ok();
        match text.split_once('/') {
            Some((above, below)) => Some(number(above)? / number(below)?),
            None => number(text),
        }
    };
    let value = if given.is_text() { fraction(given.text()) } else { given.number() };
    value.filter(|x| x.abs() <= MAX_WEIGHT).ok_or_else(|| {
        let help = format!("accepted: numbers up to {MAX_WEIGHT} such as -1.5, fractions such as \"5/2\"");
        given.fault(format!("{given} is not a weight"), "not a weight", help)
    })
}

/// Largest weight.
const MAX_WEIGHT: f64 = 1e6;
