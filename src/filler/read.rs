//! Reading the fillers of a study, with every fault at its place.

use toml::Spanned;

use crate::filler::ticks::{Purpose, TickList};
use crate::filler::{Filler, Method, POLYNOMIALS};
use crate::key::file::either::Either;
use crate::key::file::switching::{FillerKind, FillerTable};
use crate::key::scalar::Scalar;
use crate::motion::read::band;
use crate::source::diagnose::{Fault, choices};

/// A filler, and lists of ticks of its own.
pub(crate) struct Written {
    pub(crate) filler: Filler,
    pub(crate) fit_ticks: Option<TickList>,
    pub(crate) extrapolation: Extrapolation,
    /// Of the whole entry.
    pub(crate) span: std::ops::Range<usize>,
}

/// Which ticks an extrapolation is fitted to.
pub(crate) enum Extrapolation {
    /// Those of the study.
    Common,
    Own(TickList),
    /// The fit ticks up to 0.
    OfFit,
    /// There is none.
    None,
}

type Entry = Either<FillerTable>;

pub(crate) fn read(list: &Spanned<Vec<Spanned<Entry>>>) -> Result<Vec<Written>, Fault> {
    if list.get_ref().is_empty() {
        let message = "switching.fillers is empty, there is nothing to compare";
        return Err(Fault::new(list.span(), message, "no filler", choices("", &POLYNOMIALS)));
    }
    let mut fillers: Vec<Written> = Vec::new();
    for entry in list.get_ref() {
        let written = match entry.get_ref() {
            Either::One(name) => named(name, entry)?,
            Either::Other(table) => of_table(table, entry)?,
        };
        let name = &written.filler.name;
        if fillers.iter().any(|earlier| earlier.filler.name == *name) {
            let message = format!("switching.fillers lists \"{name}\" twice");
            let help = "leave it out here, or give it another name";
            return Err(Fault::new(entry.span(), message, "listed before", help));
        }
        fillers.push(written);
    }
    Ok(fillers)
}

fn named(name: &Scalar, entry: &Spanned<Entry>) -> Result<Written, Fault> {
    let text = if let Scalar::Text(text) = name { text.as_str() } else { "" };
    let Some(order) = POLYNOMIALS.iter().position(|name| *name == text) else {
        let message = format!("switching.fillers: {name} is no filler");
        let help = format!("{}, or a table such as {EXAMPLE}", choices(text, &POLYNOMIALS));
        return Err(Fault::new(entry.span(), message, "not a filler", help));
    };
    let filler = Filler::polynomial(order);
    Ok(Written { filler, fit_ticks: None, extrapolation: Extrapolation::Common, span: entry.span() })
}

/// A filler of one's own.
const EXAMPLE: &str =
    "{ kind = \"minimum-variance\", name = \"mv8+2\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }";

fn of_table(table: &FillerTable, entry: &Spanned<Entry>) -> Result<Written, Fault> {
    let kind = *table.kind.get_ref();
    let stray = [
        (&table.weights, kind == FillerKind::Weights, "weights"),
        (&table.extrapolation_weights, kind == FillerKind::Weights, "extrapolation_weights"),
        (&table.band, kind == FillerKind::MinimumVariance, "band"),
    ];
    for (written, wanted, key) in stray {
        if let Some(written) = written.as_ref().filter(|_| !wanted) {
            let message = format!("{key} has no meaning for a filler of kind \"{}\"", kind.name());
            return Err(Fault::new(written.span(), message, "not for this kind", "leave it out"));
        }
    }
    let fit_ticks = table.fit_ticks.as_ref();
    let extrapolation_ticks = table.extrapolation_ticks.as_ref();
    let method = match kind {
        FillerKind::Const => Method::Polynomial(0),
        FillerKind::Linear => Method::Polynomial(1),
        FillerKind::Quadratic => Method::Polynomial(2),
        FillerKind::MinimumVariance => {
            let of = |ends: &Spanned<_>| band("band", ends.get_ref(), ends.span());
            Method::MinimumVariance(table.band.as_ref().map(of).transpose()?)
        }
        FillerKind::Weights => {
            let Some(weights) = &table.weights else {
                let message = "a filler of kind \"weights\" needs weights";
                let help = "add for example weights = [-1, \"5/2\", \"5/2\", -1]";
                return Err(Fault::new(entry.span(), message, "no weights", help));
            };
            let numbers =
                |list: &Spanned<Vec<_>>| list.get_ref().iter().map(weight).collect::<Result<_, _>>();
            let extrapolation = table.extrapolation_weights.as_ref().map(numbers).transpose()?;
            if let (None, Some(ticks)) = (&extrapolation, extrapolation_ticks) {
                let message = "extrapolation_ticks stand without extrapolation_weights";
                return Err(Fault::new(
                    ticks.span(),
                    message,
                    "ticks without weights",
                    "add them, or leave it out",
                ));
            }
            Method::Weights { residual: numbers(weights)?, extrapolation }
        }
    };
    let extrapolation = match (&method, extrapolation_ticks) {
        (Method::Weights { extrapolation: None, .. }, _) => Extrapolation::None,
        (_, Some(_)) => Extrapolation::Own(TickList::read(Purpose::Extrapolation, extrapolation_ticks)?),
        (Method::MinimumVariance(_), None) if fit_ticks.is_some() => Extrapolation::OfFit,
        (_, None) => Extrapolation::Common,
    };
    let name = match &table.name {
        None => kind.name().to_owned(),
        Some(name) => {
            let text = name.get_ref().trim();
            if text.is_empty() || text.chars().any(char::is_control) {
                let message = "the name of a filler is a text on one line";
                return Err(Fault::new(
                    name.span(),
                    message,
                    "no name",
                    "write for example name = \"mv8+2\"",
                ));
            }
            text.to_owned()
        }
    };
    let fit_ticks = fit_ticks.map(|_| TickList::read(Purpose::Residual, fit_ticks)).transpose()?;
    Ok(Written { filler: Filler { name, method }, fit_ticks, extrapolation, span: entry.span() })
}

/// A weight: a number, or a fraction as text.
fn weight(given: &Spanned<Scalar>) -> Result<f64, Fault> {
    let fraction = |text: &str| {
        let number = |part: &str| part.trim().replace('−', "-").parse::<f64>().ok();
        match text.split_once('/') {
            Some((above, below)) => Some(number(above)? / number(below)?),
            None => number(text),
        }
    };
    let value = match given.get_ref() {
        Scalar::Integer(i) => Some(*i as f64),
        Scalar::Float(x) => Some(*x),
        Scalar::Text(text) => fraction(text),
        Scalar::Bool(_) => None,
    };
    value.filter(|x| x.abs() <= MOST_WEIGHT).ok_or_else(|| {
        let message = format!("{} is no weight", given.get_ref());
        let help = format!("accepted: numbers up to {MOST_WEIGHT} such as -1.5, fractions such as \"5/2\"");
        Fault::new(given.span(), message, "not a weight", help)
    })
}

/// Largest weight.
const MOST_WEIGHT: f64 = 1e6;

impl FillerKind {
    /// As study files call it.
    fn name(self) -> &'static str {
        match self {
            FillerKind::Const => POLYNOMIALS[0],
            FillerKind::Linear => POLYNOMIALS[1],
            FillerKind::Quadratic => POLYNOMIALS[2],
            FillerKind::MinimumVariance => "minimum-variance",
            FillerKind::Weights => "weights",
        }
    }
}
