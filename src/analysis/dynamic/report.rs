//! The report of the noise over time: tables, charts and notes.

use crate::analysis::compare::answer::duration;
use crate::analysis::dynamic::{
    Column, Dynamic, FALSE_ALARM, MIN_PART, MIN_PARTS, Octave, PARTS, Window, clearest,
};
use crate::analysis::log::report::{key, text};
use sagnac_base::quantity::number::{probability, significant, with_unit};
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{Cell, ColumnOf, Role, Table, Unit};
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{Deviation, Point};
use sagnac_records::fit::Quantity;
use sagnac_report::chart::figure::Axis;
use sagnac_report::chart::map::{Cells, Estimate, Layer, Map};
use sagnac_theory::allan::{Estimator, Process, Term};

/// A row of `dynamic.csv`.
pub(crate) struct PointRow<'a> {
    column: &'a Column,
    window: &'a Window,
    point: &'a Point,
}

/// The columns of `dynamic.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn point_columns<'a>() -> Vec<ColumnOf<PointRow<'a>>> {
    type Of<'a> = ColumnOf<PointRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("start", Unit::S, "start", |row| Cell::Number(row.window.range_s[0]))
            .is(Role::Coordinate, "Start of the window, from the start of the file, s."),
        Of::new("end", Unit::S, "end", |row| Cell::Number(row.window.range_s[1]))
            .is(Role::Coordinate, "End of the window, from the start of the file, s."),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.point.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("differences", Unit::NONE, "differences", |row| Cell::Integer(row.point.terms as i64))
            .is(Role::Count, "Number of differences behind the value."),
        Of::new("lower", Unit::NONE, "lower", |row| row.point.interval.map(|ends| ends.0).into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("value", Unit::NONE, "value", |row| row.point.value.into())
            .is(Role::Error, "Overlapping Allan deviation of the window, in `unit`; blank where gaps leave less than half of its differences."),
        Of::new("upper", Unit::NONE, "upper", |row| row.point.interval.map(|ends| ends.1).into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `value`, `lower` and `upper`."),
    ]
}

/// The deviations of all windows: `dynamic.csv`.
pub fn windows(dynamic: &Dynamic) -> Table {
    let mut rows = Vec::new();
    for column in &dynamic.columns {
        for window in &column.windows {
            rows.extend(window.points.iter().map(|point| PointRow { column, window, point }));
        }
    }
    Table { columns: columns_of(&point_columns(), &rows) }
}

/// A row of `stationarity.csv`.
pub(crate) struct OctaveRow<'a> {
    column: &'a Column,
    octave: &'a Octave,
}

/// The columns of `stationarity.csv`, in the order of the file.
#[rustfmt::skip]
pub(crate) fn octave_columns<'a>() -> Vec<ColumnOf<OctaveRow<'a>>> {
    type Of<'a> = ColumnOf<OctaveRow<'a>>;
    vec![
        key(|row| text(&row.column.name)),
        Of::new("tau", Unit::S, "tau", |row| Cell::Number(row.octave.tau_s))
            .is(Role::Coordinate, "Averaging time τ, s."),
        Of::new("parts", Unit::NONE, "parts", |row| Cell::Integer(row.octave.parts as i64))
            .is(Role::Count, "Number of parts of the record whose variances are compared."),
        Of::new("p", Unit::NONE, "p", |row| Cell::Number(row.octave.p))
            .is(Role::Estimate, "Probability that noise that does not change looks at least as changed at any of the tested τ."),
        Of::new("at", Unit::S, "at", |row| Cell::Number(row.column.skipped_s + row.octave.at_s))
            .is(Role::Estimate, "Likeliest time of a change, from the start of the file, s."),
        Of::new("before", Unit::NONE, "before", |row| Cell::Number(row.octave.before))
            .is(Role::Error, "Overlapping Allan deviation before that time, in `unit`."),
        Of::new("after", Unit::NONE, "after", |row| Cell::Number(row.octave.after))
            .is(Role::Error, "Overlapping Allan deviation after that time, in `unit`."),
        Of::new("unit", Unit::NONE, "unit", |row| text(row.column.unit.in_files(Deviation::Oadev)))
            .is(Role::Note, "Unit of `before` and `after`."),
        Of::new("visible", Unit::NONE, "visible", |row| Cell::Number(row.octave.visible))
            .is(Role::Estimate, "Relative step of the deviation in the middle of the record that is detected with 90 % power at p < 5 %."),
    ]
}

/// The tests for a change: `stationarity.csv`.
pub fn octaves(dynamic: &Dynamic) -> Table {
    let mut rows = Vec::new();
    for column in &dynamic.columns {
        rows.extend(column.octaves.iter().map(|octave| OctaveRow { column, octave }));
    }
    Table { columns: columns_of(&octave_columns(), &rows) }
}

/// Start of the file names of all maps.
const STEM: &str = "chart-dynamic";

/// Units of time: the longest record that is shown in each, its size in s, its name.
const TIMES: [(f64, f64, &str); 3] =
    [(600.0, 1.0, "s"), (36_000.0, 60.0, "min"), (f64::INFINITY, 3600.0, "h")];

/// Two maps of each column with the stems of their file names: of its deviations over time and τ over those of the whole record,
/// which shows changes of any τ alike, and of the deviations themselves.
pub fn figures(dynamic: &Dynamic) -> Vec<(String, Map)> {
    let of = |(column, number): (&Column, usize)| {
        let title = "Overlapping Allan deviation over time";
        let z = Axis::new("deviation σ(τ)", column.unit.symbol(Deviation::Oadev));
        let deviations = map(dynamic, column, title, z, |point, _| cell(point, 1.0));
        let title = "Overlapping Allan deviation over that of the record";
        let z = Axis::new("deviation over that of the record", "");
        let ratios = map(dynamic, column, title, z, |point, whole| {
            cell(point, whole.value.filter(|value| *value > 0.0)?)
        });
        let stem = if dynamic.columns.len() > 1 { format!("{STEM}-{number}") } else { STEM.to_owned() };
        [(format!("{stem}-ratio"), ratios), (stem, deviations)]
    };
    dynamic.columns.iter().zip(1..).flat_map(of).collect()
}

/// A value with its interval, over another one.
fn cell(point: &Point, over: f64) -> Option<Estimate> {
    let band = point.interval.map(|(lower, upper)| (lower / over, upper / over));
    Some((point.value.filter(|value| *value > 0.0)? / over, band))
}

fn map(
    dynamic: &Dynamic,
    column: &Column,
    title: &str,
    z: Axis,
    cell: impl Fn(&Point, &Point) -> Option<Estimate>,
) -> Map {
    let last_s = column.windows.last().map_or(0.0, |window| window.range_s[1]);
    let (_, size, unit) = TIMES.into_iter().find(|(most, ..)| last_s < *most).unwrap_or(TIMES[2]);
    let values: Vec<Option<Estimate>> = column
        .whole
        .iter()
        .enumerate()
        .flat_map(|(row, whole)| column.windows.iter().map(move |window| (&window.points[row], whole)))
        .map(|(point, whole)| cell(point, whole))
        .collect();
    let middle = |range_s: [f64; 2]| 0.5 * (range_s[0] + range_s[1]) / size;
    Map {
        title: format!("{title}: {}", column.name),
        subtitle: Some(format!(
            "windows of {} s, half overlapped; {}",
            significant(dynamic.window_s, 6),
            sentence(column)
        )),
        x: Axis { scale: Scale::Linear, ..Axis::new("time from the start of the file", unit) },
        y: Axis::new("averaging time τ", "s"),
        z,
        columns: column.windows.iter().map(|window| middle(window.range_s)).collect(),
        rows: column.whole.iter().map(|point| point.tau_s).collect(),
        cells: Cells::Values(values.iter().map(|value| value.map(|(value, _)| value)).collect()),
        layers: vec![Layer { style: 0, name: String::new(), values }],
        limit: None,
        chosen: vec![],
    }
}

/// Part of the variance that white noise must have at a τ for a change there to be one of N.
const MOSTLY: f64 = 0.8;

/// The change of a column, or the step that would have been seen.
pub fn sentence(column: &Column) -> String {
    let tests = column.octaves.len();
    let Some(octave) = clearest(&column.octaves) else {
        return format!(
            "no test for a change, which takes {PARTS} parts of {MIN_PART} samples or more, {MIN_PARTS} of them neither missing nor constant"
        );
    };
    let counted = format!("{}, counting {tests} averaging times", probability(octave.p));
    if octave.p < FALSE_ALARM {
        let at = duration(column.skipped_s + octave.at_s);
        return format!("{} from {at} on ({counted})", change(column, octave));
    }
    let finest = column.octaves.iter().min_by(|a, b| a.visible.total_cmp(&b.visible)).unwrap_or(octave);
    let of = match white(column, finest) {
        Some(_) => "N".to_owned(),
        None => format!("σ({} s)", significant(finest.tau_s, 4)),
    };
    format!(
        "no change seen ({counted}): a step of {of} by {} % in the middle of the record would have been detected with 90 % power",
        significant(100.0 * finest.visible, 2)
    )
}

/// The values before and after a change: of N where it makes up most of the noise at that τ, else of the deviation.
fn change(column: &Column, octave: &Octave) -> String {
    match white(column, octave) {
        Some(n) => {
            let (factor, _, symbol) = Quantity::Coefficient(Term::AngleRandomWalk).unit(column.unit);
            let [before, after] = [octave.before, octave.after].map(|end| factor * n * end / octave.whole);
            format!("N changes: {} → {}", significant(before, 3), with_unit(after, 3, symbol))
        }
        None => {
            let (tau, before) = (significant(octave.tau_s, 4), significant(octave.before, 3));
            let after = with_unit(octave.after, 3, column.unit.symbol(Deviation::Oadev));
            format!("σ({tau} s) changes: {before} → {after}")
        }
    }
}

/// N of the record, if it makes up most of the noise at the τ of an octave.
fn white(column: &Column, octave: &Octave) -> Option<f64> {
    let model = column.model.as_ref()?;
    let part = model.parts.iter().find(|part| part.term == Term::AngleRandomWalk)?;
    let alone = Process { sample_s: model.sample_s, parts: vec![*part] };
    let variance =
        |process: &Process| process.expected(Estimator::OVERLAPPING, column.samples as u64, octave.m as u64);
    (variance(&alone)? > MOSTLY * variance(model)?).then(|| libm::sqrt(part.square()))
}
