//! The position error of navigators with the gyro of a log, as a study with the coefficients of the fit and their intervals.
//!
//! The coefficients that the record does not show count as 0 in the study. What they may cost is the error with each of them
//! at the upper end of its interval. The decision sheet is that of the study, whose parts and levers are compared with the first
//! sets of coefficients only, so that another value may meet the limit by the third digit.

use crate::analysis::decision::{Figure, Sheet, decide};
use crate::analysis::log::noise_file::{self, quantity};
use crate::analysis::log::report::{key, one_line, text};
use crate::analysis::log::{Analysis, Column};
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::quantity::Quantity;
use sagnac_base::quantity::number::{significant, with_unit};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit as TableUnit, Usual};
use sagnac_engine::device::{Cpu, Device};
use sagnac_engine::run::{Plan, Tables};
use sagnac_engine::store::Store;
use sagnac_engine::study::Study;
use sagnac_engine::tally::Share;
use sagnac_kernel::width::Width;
use sagnac_records::allan::Unit;
use sagnac_records::fit::Coefficient;
use sagnac_report::answer::{Answer, AnswerCell, AnswerTable, Fact, Kind, Reading};
use sagnac_theory::allan::Term;

/// Navigators of a study, and sets of coefficients that are drawn from the intervals.
const TRIALS: u64 = 3200;
const DRAWS: u64 = 32;
/// Sets of coefficients with which the parts of the error and the levers are compared: every change is lowered for each set.
const DRAWS_COMPARED: u64 = 8;

/// Beginning and end of the first line, which identify our files.
const START: &str = "# Navigators with three gyros like ";
const END: &str = ", by sagnac allan --navigate.";

/// Periods of a sine during the navigation beyond which it averages out. Samples are longer than half of one before long.
const MANY_PERIODS: f64 = 250.0;

/// Latitude of the navigators, and their time at rest before the start.
const LATITUDE: &str = "60 deg";
const ALIGNMENT: &str = "10 min";

/// The navigators with three gyros like a column of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Navigators {
    /// Name of the column.
    pub column: String,
    /// The study, as TOML.
    pub study: String,
    /// Time after the start, s.
    pub duration_s: f64,
    /// Radius that 95 % of them stay within, in the unit [`unit`](Navigators::unit).
    pub within: Figure,
    /// Unit of the radius.
    pub unit: &'static str,
    /// Radius that half of them stay within (CEP), in the same unit.
    pub half: f64,
    /// The class of such navigators by the growth of that radius; `none` for a worse one than all classes.
    pub class: String,
    /// Frequency of a sine that averages out and is left out, Hz.
    pub left_out_hz: Option<f64>,
    /// The coefficients that the record does not show, with the radius where all are at the upper ends of their intervals.
    pub at_bounds: Option<(Vec<String>, f64)>,
    /// The decision sheet of the study.
    pub sheet: Sheet,
}

/// The time after which navigators are asked for their place, and the limit on their distance from it.
#[derive(Debug, Clone, PartialEq)]
pub struct NavigatorRequest {
    /// Time after the start, s.
    pub duration_s: f64,
    /// The largest accepted distance from their place, for 95 % of them.
    pub limit: Option<Quantity>,
}

/// The navigators of every column of rotation with coefficients; for a column without them, why. `progress` receives the
/// evaluations of the decision.
///
/// Each navigator has three such gyros and ideal accelerometers, aligns at rest at a latitude of 60°, which also calibrates the
/// gyros, and stays there.
pub fn navigators(
    analysis: &Analysis,
    request: &NavigatorRequest,
    progress: &dyn Progress,
) -> Vec<Result<Navigators, String>> {
    let of = |column: &Column| {
        let found = of_column(analysis, column, request, progress);
        found.map_err(|why| format!("{}: no navigator: {why}", column.name))
    };
    analysis.columns.iter().map(of).collect()
}

fn of_column(
    analysis: &Analysis,
    column: &Column,
    request: &NavigatorRequest,
    progress: &dyn Progress,
) -> Result<Navigators, String> {
    if column.unit != Unit::Angular {
        return Err("it is not a gyro".to_owned());
    }
    let noise = column.noise().ok_or("its noise has no coefficients")?;
    let fast_hz = |one: &Coefficient| {
        let frequency = one.shape.filter(|_| one.term == Term::Sine && one.value.is_some())?.value;
        (frequency * request.duration_s > MANY_PERIODS).then_some(frequency)
    };
    let left_out_hz = noise.fit.coefficients.iter().find_map(fast_hz);
    let coefficients: Vec<&Coefficient> =
        noise.fit.coefficients.iter().filter(|one| fast_hz(one).is_none()).collect();
    let lines: Vec<String> = coefficients.iter().copied().filter_map(entry).collect();
    if lines.is_empty() {
        return Err("its record shows no coefficient".to_owned());
    }
    let file = analysis.path.file_name().unwrap_or(analysis.path.as_os_str()).to_string_lossy();
    let about = format!("{START}{} of {}", one_line(&column.name), one_line(&file));
    let spreads: Vec<String> = coefficients.iter().copied().filter_map(spread).collect();
    let study = study_of(&about, request, DRAWS, &lines, &spreads);
    let tables = tables(&study)?;
    let (within, unit) = radius(&tables)?;
    let (half, class) = circular(&tables).ok_or("no navigator has a circular error")?;
    let compared = parsed(&study_of(&about, request, DRAWS_COMPARED, &lines, &spreads))?;
    let sheet = decide(&compared, &tables, progress).map_err(|error| error.to_string())?;
    let sheet = sheet.ok_or("the study judges nothing")?;
    let bounds: Vec<(&Coefficient, String)> =
        coefficients.iter().filter_map(|one| Some((*one, bound(one)?))).collect();
    let at_bounds = match bounds.is_empty() {
        true => None,
        false => {
            let all: Vec<String> =
                lines.iter().cloned().chain(bounds.iter().map(|one| one.1.clone())).collect();
            let names = bounds.iter().map(|(one, _)| one.term.symbol().to_owned()).collect();
            let tables = self::tables(&study_of(&about, request, DRAWS, &all, &spreads))?;
            Some((names, radius(&tables)?.0.value))
        }
    };
    let (column, duration_s) = (column.name.clone(), request.duration_s);
    Ok(Navigators { column, study, duration_s, within, unit, half, class, left_out_hz, at_bounds, sheet })
}

/// The line of a coefficient with a value that a study has.
fn entry(coefficient: &Coefficient) -> Option<String> {
    (coefficient.term != Term::BandLimit).then(|| noise_file::entry(coefficient)).flatten()
}

/// The line of a coefficient without a value, at the upper end of its interval.
fn bound(coefficient: &Coefficient) -> Option<String> {
    let (None, None, Some([_, most])) = (coefficient.value, coefficient.term.shape(), coefficient.interval)
    else {
        return None;
    };
    let key = coefficient.term.row().key.trim_start_matches("noise.");
    (coefficient.term != Term::BandLimit && most > 0.0)
        .then(|| format!("{key} = \"{}\"", quantity(coefficient.term, most)))
}

/// The distribution of a coefficient, if its value lies within its interval.
fn spread(coefficient: &Coefficient) -> Option<String> {
    let (term, value, [low, high]) = (coefficient.term, coefficient.value?, coefficient.interval?);
    let key = term.row().key;
    let key = if term.shape().is_some() { format!("{key}.amplitude") } else { key.to_owned() };
    let is_inside = low < value && value < high && high.is_finite();
    (term != Term::BandLimit && is_inside).then(|| {
        let [value, low, high] = [value, low, high].map(|one| quantity(term, one));
        format!(
            "\n[[sensitivity]]\nkey = \"{key}\"\ninterval = {{ value = \"{value}\", low = \"{low}\", high = \"{high}\" }}\n"
        )
    })
}

fn study_of(
    about: &str,
    request: &NavigatorRequest,
    draws: u64,
    noise: &[String],
    spreads: &[String],
) -> String {
    let duration_s = request.duration_s;
    let draws = if spreads.is_empty() { String::new() } else { format!("draws = {draws}\n") };
    let limit = request.limit.map_or_else(String::new, |limit| format!("limit = \"{limit}\"\n"));
    let (after, duration, noise) = (spoken(duration_s), significant(duration_s, 12), noise.join("\n"));
    format!(
        "{about}{END}\n\
         title = \"Position error with the noise of a record and its uncertainty\"\n\
         question = \"Within how many nautical miles are 95 % of navigators after {after}?\"\n\
         kind = \"navigation\"\ntrials = {TRIALS}\n{limit}\n\
         [navigation]\nduration = \"{duration} s\"\nalignment = \"{ALIGNMENT}\"\ncalibration = true\nlatitude = \"{LATITUDE}\"\n{draws}\n\
         [noise]\n{noise}\n{}",
        spreads.concat()
    )
}

fn parsed(text: &str) -> Result<Study, String> {
    Study::parse("navigation.toml", text).map_err(|error| error.to_string())
}

/// Runs a study with a single point.
fn tables(text: &str) -> Result<Tables, String> {
    let study = parsed(text)?;
    let plan = Plan::new(&study).map_err(|error| error.to_string())?;
    let mut store = Store::in_memory(&plan.identity());
    let mut device = Device::Cpu(Cpu::new(Width::widest(), 0).map_err(|error| error.to_string())?);
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).map_err(|error| error.to_string())?;
    plan.tables(&store, &Silent).map_err(|error| error.to_string())
}

/// The usual answer of a table with a single row, with its unit.
fn radius(tables: &Tables) -> Result<(Figure, &'static str), String> {
    let answer = [Usual::Answer, Usual::Estimate].into_iter().find_map(|usual| tables.points.usual(usual));
    let column = answer.ok_or("the study has no answer")?;
    let value = column.cells.get(0).and_then(|cell| cell.number()).ok_or("no navigator has a value")?;
    Ok((Figure { value, interval: column.interval(0) }, column.unit.symbol))
}

/// The circular error and the class of navigators in a table with a single row.
fn circular(tables: &Tables) -> Option<(f64, String)> {
    let cell = |name: &str| Some(tables.points.column(name).ok()?.cells.get(0)?.clone());
    Some((cell("position_cep")?.number()?, cell("grade")?.text()))
}

/// A time in hours, minutes or seconds, whichever is the longest unit that is not longer than it.
fn spoken(time_s: f64) -> String {
    let (unit_s, unit) = match time_s {
        3600.0.. => (3600.0, "h"),
        60.0.. => (60.0, "min"),
        _ => (1.0, "s"),
    };
    with_unit(time_s / unit_s, 4, unit)
}

/// The columns of `navigation.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<&'a Navigators>> {
    type Of<'a> = ColumnOf<&'a Navigators>;
    vec![
        key(|row| text(&row.column)),
        Of::new("duration", TableUnit::S, "duration", |row| Cell::Number(row.duration_s))
            .is(Role::Coordinate, "Time after the start, s."),
        Of::new("p95", TableUnit::NONE, "R95", |row| Cell::Number(row.within.value))
            .is(Role::Error, "Radius that 95 % of navigators stay within, in `unit`."),
        Of::new("lower", TableUnit::NONE, "lower", |row| row.within.interval.map(|ends| ends.0).into())
            .is_of("p95", Role::Lower, "Lower end of the 95 % interval of `p95`."),
        Of::new("upper", TableUnit::NONE, "upper", |row| row.within.interval.map(|ends| ends.1).into())
            .is_of("p95", Role::Upper, "Upper end of the 95 % interval of `p95`."),
        Of::new("cep", TableUnit::NONE, "CEP", |row| Cell::Number(row.half))
            .is(Role::Error, "Radius that half of them stay within, in `unit`."),
        Of::new("p95_at_bounds", TableUnit::NONE, "R95 at the bounds", |row| row.at_bounds.as_ref().map(|(_, radius)| *radius).into())
            .is(Role::Estimate, "The same radius as `p95` with the coefficients that the record does not show at the upper ends of their intervals."),
        Of::new("unit", TableUnit::NONE, "unit", |row| text(row.unit))
            .is(Role::Note, "Unit of the radii."),
        Of::new("class", TableUnit::NONE, "class", |row| text(&row.class))
            .is(Role::Note, "The class of such navigators by the growth of that radius; `none` for a worse one than all classes."),
    ]
}

/// The navigators of the columns that have some: `navigation.csv`.
pub fn table(found: &[Result<Navigators, String>]) -> Table {
    Table { columns: columns_of(&columns(), &found.iter().flatten().collect::<Vec<_>>()) }
}

/// The answer of the navigators of a log: those that are off by most, and a row for each column; `None` without any.
pub fn answer(found: &[Result<Navigators, String>]) -> Option<Answer> {
    let mut all: Vec<&Navigators> = found.iter().flatten().collect();
    all.sort_by(|a, b| b.within.value.total_cmp(&a.within.value));
    let worst = all.first()?;
    let reading = |one: &Navigators, value: f64, interval: Option<(f64, f64)>| {
        Reading::in_unit("position_p95", value, one.unit, interval.map(|(low, high)| [low, high]))
    };
    let within = |one: &Navigators| reading(one, one.within.value, one.within.interval);
    let after = spoken(worst.duration_s);
    let name = if found.len() > 1 { format!("{}: ", worst.column) } else { String::new() };
    let row = |one: &&Navigators| -> Vec<AnswerCell> {
        let value = within(one);
        let ends = value.ends_text().unwrap_or_default();
        let class = if one.class == "none" { "worse than tactical" } else { &one.class };
        vec![
            one.column.clone().into(),
            value.into(),
            ends.into(),
            reading(one, one.half, None).into(),
            class.to_owned().into(),
        ]
    };
    let mut facts: Vec<Fact> =
        worst.sheet.facts().into_iter().filter(|fact| !matches!(fact, Fact::WorstCase { .. })).collect();
    facts.extend(worst.at_bounds.as_ref().map(|(names, radius)| Fact::Value {
        name: "At upper limits".to_owned(),
        value: reading(worst, *radius, None),
        at: format!("with {} as large as the record allows", names.join(", ")),
    }));
    facts.extend(worst.left_out_hz.map(|frequency| Fact::Caveat {
        text: format!("the line at {} averages out and is left out", with_unit(frequency, 4, "Hz")),
    }));
    facts.extend(
        found.iter().filter_map(|one| one.as_ref().err()).map(|why| Fact::Caveat { text: why.clone() }),
    );
    let heads = ["column", "R95", "95 % interval", "CEP", "class"];
    Some(Answer {
        kind: Kind::Requirement,
        status: worst.sheet.status(),
        headline: format!("{name}{} R95 after {after}{}", within(worst).text(), within(worst).in_brackets()),
        value: Some(within(worst)),
        limit: worst.sheet.limit.map(|limit| reading(worst, limit.value, None)),
        table: AnswerTable { best: Some(0), ..AnswerTable::new(heads, all.iter().map(row)) },
        facts,
        checks: vec![],
    })
}

/// The name of the file of each study, for the columns of a log.
pub fn names(analysis: &Analysis) -> Vec<String> {
    let noise = noise_file::names(&analysis.columns);
    noise.into_iter().map(|name| name.replacen("noise", "navigation", 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_longest_unit_that_fits() {
        assert_eq!([3600.0, 5400.0, 600.0, 30.0].map(spoken), ["1 h", "1.5 h", "10 min", "30 s"]);
    }

    #[test]
    fn a_study_is_that_of_the_shipped_one_for_the_same_gyro() {
        let lines = [
            "angle_random_walk = \"0.00048 deg/sqrt(h)\"".to_owned(),
            "bias_instability = \"0.00164 deg/h\"".to_owned(),
        ];
        let request = NavigatorRequest { duration_s: 3600.0, limit: None };
        let tables = tables(&study_of("# A gyro", &request, DRAWS, &lines, &[])).unwrap();
        let (found, unit) = radius(&tables).unwrap();
        // LGV-1 without its Q, which changes the third digit: 0.3675 nmi.
        assert!((found.value - 0.3675).abs() < 0.03 * 0.3675, "{found:?}");
        assert_eq!(unit, "nmi");
        let (low, high) = found.interval.unwrap();
        assert!(low < found.value && found.value < high && high - low < 0.1 * found.value);
    }
}
