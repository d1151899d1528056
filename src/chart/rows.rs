//! Which columns choose rows and span axes, and the rows that a chart's `where` chooses.

use std::ops::Range;

use toml::Spanned;

use crate::chart::file::Source;
use crate::fit::term::Term;
use crate::key::file::switching::Error;
use crate::key::scalar::{self, Scalar};
use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::kinds::relock::inputs::Compensation;
use crate::kinds::switched_run::Angle as RunAngle;
use crate::quantity::units::Dimension;
use crate::source::diagnose::{Fault, choices};
use crate::study::Subject;
use crate::table::{self, Cell, Column, ColumnError, Unit};

/// The columns of text of a gap-fill table.
pub(crate) const FILLER: &str = "filler";
pub(crate) const ERROR: &str = "error";

/// The column of text of a table of whole runs: which angle.
pub(crate) const ANGLE: &str = "angle";

/// The column of text of a table of trajectories.
pub(crate) const RUN: &str = "run";

/// The column of the time in a run.
pub(crate) const TIME: &str = "time";
/// The columns of text of a relock table.
pub(crate) const COMPENSATION: &str = "compensation";
pub(crate) const TICK: &str = "tick";

/// The tick of a relock as a number: blank for all together.
pub(crate) const TICK_NUMBER: &str = "tick_number";

/// What [`TICK`] is for all ticks together.
pub(crate) const ALL_TICKS: &str = "all";

/// What [`TICK`] takes.
const TICKS: [&str; 9] = ["1", "2", "3", "4", "5", "6", "7", "8", ALL_TICKS];

/// The column of text of a table of coefficients.
pub(crate) const COEFFICIENT: &str = "coefficient";

/// The column of averaging times.
pub(crate) const TAU: &str = "tau";

/// The column of Δt·ν, which follows from the inputs of a point.
pub(crate) const DT_NU: &str = "dt_nu";

/// The column of A_Ω·T/σ, which does too.
const AMPLITUDE_NOISE: &str = "amplitude_noise";

/// The columns of a table that are known before anything is sampled, besides swept keys.
pub(crate) struct Known {
    /// Of text, by which rows are told apart, each with the values that it takes.
    pub(crate) texts: Vec<(&'static str, Vec<String>)>,
    /// The names of fillers, where there is a column of them.
    pub(crate) fillers: Vec<String>,
    /// Of numbers.
    pub(crate) numbers: &'static [&'static str],
}

impl Known {
    /// Those of one of the tables of a study.
    pub(crate) fn of(subject: &Subject, source: Source) -> Known {
        match (subject, source) {
            (Subject::GapFill(gap_fill), _) => Known {
                texts: vec![(ERROR, Error::ALL.map(|error| error.name().to_owned()).to_vec())],
                fillers: gap_fill.fillers.iter().map(|filler| filler.name.clone()).collect(),
                numbers: &[DT_NU, AMPLITUDE_NOISE],
            },
            (Subject::Allan(_), Source::Points | Source::Trajectories) => {
                Known { texts: vec![], fillers: vec![], numbers: &[TAU] }
            }
            (Subject::Relock(relock), _) => {
                let ticks = TICKS[..relock.inputs.relock.ticks as usize].iter().chain([&ALL_TICKS]);
                let ticks = ticks.map(|tick| (*tick).to_owned());
                let compensations = Compensation::ALL.map(|kind| kind.name().to_owned()).to_vec();
                Known {
                    texts: vec![(COMPENSATION, compensations), (TICK, ticks.collect())],
                    fillers: vec![],
                    numbers: &[TICK_NUMBER],
                }
            }
            (Subject::DriftBudget(_) | Subject::Suspension(_), _) => {
                Known { texts: vec![], fillers: vec![], numbers: &[] }
            }
            (Subject::Allan(_), Source::Coefficients) => {
                let names = Term::ALL.map(Term::symbol).into_iter().chain(["markov_time", "sine_frequency"]);
                let names = names.map(str::to_owned).collect();
                Known { texts: vec![(COEFFICIENT, names)], fillers: vec![], numbers: &[] }
            }
            (Subject::SwitchedRun(run), source) => Known {
                texts: vec![if source == Source::Trajectories {
                    (RUN, (1..=run.trajectories).map(|number| number.to_string()).collect())
                } else {
                    (ANGLE, run.angles().iter().map(RunAngle::name).collect())
                }],
                fillers: run.fillers().iter().map(|filler| filler.name.clone()).collect(),
                numbers: &[TIME],
            },
        }
    }

    /// The names of the columns of text.
    pub(crate) fn text_names(&self) -> Vec<&'static str> {
        let fillers = (!self.fillers.is_empty()).then_some(FILLER);
        fillers.into_iter().chain(self.texts.iter().map(|(name, _)| *name)).collect()
    }
}

/// Most values of a sweep that a message lists.
const MOST_LISTED: usize = 12;

/// The column by which rows are told apart that `name` at `span` means: a swept key, a column of text, or τ.
///
/// # Errors
/// It means no such column, or several; `cannot` begins the message: "`where` cannot choose rows by".
pub(crate) fn chooser(
    sweeps: &[Sweep],
    known: &Known,
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    let taus = known.numbers.iter().copied().filter(|name| *name == TAU);
    input(sweeps, &known.text_names().into_iter().chain(taus).collect::<Vec<_>>(), name, span, cannot)
}

/// The column of numbers known before anything is sampled that `name` at `span` means: a swept key, or one that follows
/// from it.
///
/// # Errors
/// As those of [`chooser`].
pub(crate) fn coordinate(
    sweeps: &[Sweep],
    known: &Known,
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    input(sweeps, known.numbers, name, span, cannot)
}

/// The column that `name` means among the swept keys and some `more`.
fn input(
    sweeps: &[Sweep],
    more: &[&str],
    name: &str,
    span: Range<usize>,
    cannot: &str,
) -> Result<String, Fault> {
    let unit = |sweep: &Sweep| sweep.values.first().map_or(Unit::NONE, Swept::unit);
    let swept = sweeps.iter().map(|sweep| (sweep.key.name, unit(sweep)));
    let columns: Vec<Column> = swept
        .chain(more.iter().map(|name| (*name, if [TAU, TIME].contains(name) { Unit::S } else { Unit::NONE })))
        .map(|(name, unit)| Column {
            name: name.to_owned(),
            label: name.to_owned(),
            unit,
            cells: vec![],
            band: None,
        })
        .collect();
    let found = table::find(&columns, name).map_err(|error| match error {
        ColumnError::Ambiguous { .. } => {
            Fault::new(span, error.to_string(), "more than one", "write the whole name")
        }
        _ => {
            let known: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            let label = match more {
                [] => "not swept".to_owned(),
                more => format!("neither swept nor {}", more.join(" nor ")),
            };
            Fault::new(span, format!("{cannot} `{name}`"), label, choices(name, &known))
        }
    })?;
    Ok(found.name.clone())
}

/// The column that one entry of `where` names, and its value there.
pub(crate) fn row(
    name: &Spanned<String>,
    value: &Spanned<Scalar>,
    sweeps: &[Sweep],
    known: &Known,
) -> Result<(String, Cell), Fault> {
    let column = chooser(sweeps, known, name.get_ref(), name.span(), "`where` cannot choose rows by")?;
    let of_texts = || known.texts.iter().find(|(text, _)| *text == column);
    let cell = if let Some(sweep) = sweeps.iter().find(|sweep| sweep.key.name == column) {
        swept_value(sweep, value)?.cell()
    } else if column == FILLER {
        text(FILLER, value, known.fillers.iter().map(String::as_str))?
    } else if let Some((column, values)) = of_texts() {
        text(column, value, values.iter().map(String::as_str))?
    } else {
        // Whether the table has that τ shows when the chart is drawn without estimates.
        scalar::quantity(&column, value, &[Dimension::Time])?.cell()
    };
    Ok((column, cell))
}

/// The value of a sweep that is meant: the one which tables show like the one given.
fn swept_value<'s>(sweep: &'s Sweep, given: &Spanned<Scalar>) -> Result<&'s Swept, Fault> {
    let wanted = match given.get_ref() {
        Scalar::Text(name) if sweep.key.is_name() => Swept::Name(name.clone()),
        _ => Swept::Quantity(sweep.key.read(given)?),
    };
    let is_meant =
        |value: &&Swept| value.unit() == wanted.unit() && value.cell().text() == wanted.cell().text();
    sweep.values.iter().find(is_meant).ok_or_else(|| {
        let listed: Vec<String> = sweep.values.iter().take(MOST_LISTED).map(Swept::to_string).collect();
        let more = if sweep.values.len() > MOST_LISTED { ", …" } else { "" };
        let message = format!("no point has {} = {wanted}", sweep.key.name);
        let help = format!("accepted: {}{more}", listed.join(", "));
        Fault::new(given.span(), message, "not among the swept values", help)
    })
}

/// One of the texts that a column takes.
fn text<'a>(
    column: &str,
    given: &Spanned<Scalar>,
    known: impl Iterator<Item = &'a str>,
) -> Result<Cell, Fault> {
    let known: Vec<&str> = known.collect();
    match given.get_ref() {
        Scalar::Text(text) if known.contains(&text.as_str()) => Ok(Cell::Text(text.clone())),
        other => {
            let found = if let Scalar::Text(text) = other { text } else { "" };
            let message = format!("no row has {column} = {other}");
            Err(Fault::new(given.span(), message, "not in this study", choices(found, &known)))
        }
    }
}
