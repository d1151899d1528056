//! Reading of the charts of a study, and the charts of a study that names none.

use crate::chart::{
    CHART, Chart, ChartKind, KIND, LAWS, LIMIT, Law, Limit, Named, OF, Requirement, SERIES, Shows, Source,
    TABLE, TITLE, TableSchema, WHERE, X, X_SCALE, Y, Y_SCALE, Z, Z_SCALE,
};
use crate::key::document::{SpannedValue, Table};
use crate::key::sweep::{Scale, Sweep, SweepValue, scale_of};
use crate::key::{Key, ValueType, unlimited};
use sagnac_base::diagnostics::{Fault, choices};
use sagnac_base::quantity::Dimension;
use sagnac_base::table::{self, About, Cell, Cells, Column, ColumnError, Role, Unit, Usual};

/// The charts of a study: those written, or one that suits the sweeps.
///
/// # Errors
/// A key that the kind of chart lacks or does not have; a wrong number of `series`; an `of` or a `where` that names a
/// column other than a swept key or a text column; axes of a map or below a law that are not known beforehand; a
/// `limit` of another dimension or not above 0; or a value in `where` that its column does not take.
pub(crate) fn read_all(
    study: &Table,
    sweeps: &[Sweep],
    grounds: &[TableSchema],
) -> Result<Vec<Chart>, Fault> {
    let Some(charts) = study.get(&CHART) else {
        return Ok(grounds.first().and_then(|points| chart(sweeps, points)).into_iter().collect());
    };
    let tables = if charts.is_list() { charts.items() } else { vec![charts] };
    tables.iter().filter_map(SpannedValue::table).map(|table| read(&table, sweeps, grounds)).collect()
}

/// Reads a required column; the example in its fault uses the name `usual`.
fn axis<'a>(table: &Table<'a>, key: &'static Key, usual: Option<&str>) -> Result<SpannedValue<'a>, Fault> {
    table.get(key).ok_or_else(|| {
        let example = usual.map_or(key.example.to_owned(), |name| format!("{} = \"{name}\"", key.last()));
        Fault::missing_key(key.name, &example, table.span.clone())
    })
}

fn read(table: &Table, sweeps: &[Sweep], grounds: &[TableSchema]) -> Result<Chart, Fault> {
    let ground = ground(table, grounds)?;
    let known = Known { sweeps, ground };
    let usual = |usual| Some(grounds.first()?.usual(usual)?.name);
    let usual_x = usual(Usual::Abscissa).or(sweeps.first().map(|sweep| sweep.key.name));
    let limit = table.get(&LIMIT).map(|limit| read_limit(limit, ground)).transpose()?;
    let x = Named::from(axis(table, &X, usual_x)?);
    let (y, beside) = estimates(axis(table, &Y, usual(Usual::Estimate))?)?;
    let shows = shows(table, &x, &y, &beside, known)?;
    let mut rows = Vec::new();
    let mut chosen: Vec<String> = Vec::new();
    for (name, value) in table.get(&WHERE).and_then(|rows| rows.table()).iter().flat_map(|rows| rows.entries)
    {
        let name = Named { name: name.get_ref().to_string(), span: name.span() };
        let (column, cell) = known.row(&name, SpannedValue { key: &WHERE, value })?;
        if chosen.contains(&column) {
            let message = format!("`where` gives {column} twice");
            return Err(Fault::new(name.span, message, "one of the two", "leave one of them out"));
        }
        if matches!(&shows, Shows::WinnerMap { of, .. } if of.name == column) {
            let message = format!("`where` leaves one {column} only, and nothing to compare it with");
            let help = format!("leave {column} out of `where`, or name another column as `of`");
            return Err(Fault::new(name.span, message, "what the winner map compares", help));
        }
        chosen.push(column);
        rows.push((name, cell));
    }
    let scale = |key: &'static Key, column: &Named| match table.get(key) {
        None if ground.is_linear => Scale::Linear,
        None => known.scale_over(&column.name),
        written => scale_of(written),
    };
    let mut chart = Chart {
        title: table.get(&TITLE).map_or(String::new(), |title| title.text().to_owned()),
        x_scale: scale(&X_SCALE, &x),
        y_scale: scale(&Y_SCALE, &y),
        source: ground.source,
        x,
        y,
        beside,
        shows,
        rows,
        limit,
        ..Chart::default()
    };
    // Without a choice of rows, a curve would jump between rows of several errors, and a map would show two values at
    // once.
    let is_named = |column: &str| {
        let mut drawn = std::iter::once(&chart.x).chain(chart.series());
        chosen.iter().any(|name| name == column) || drawn.any(|named| named.name == column)
    };
    let supplied: Vec<_> = ground.usual_rows().filter(|(column, _)| !is_named(&column.name)).collect();
    chart.rows.extend(supplied);
    Ok(chart)
}

/// The table of results to draw.
fn ground<'g>(table: &Table, grounds: &'g [TableSchema]) -> Result<&'g TableSchema, Fault> {
    let (source, span) = (Source::from_value(table.get(&TABLE)), table.span_of(&TABLE).unwrap_or_default());
    let Some(ground) = grounds.iter().find(|ground| ground.source == source) else {
        let message = "a study of this kind has no such table";
        return Err(Fault::new(span, message, "no such table", "leave chart.table out"));
    };
    match ground.absent {
        Some((message, help)) => Err(Fault::new(span, message, "an empty table", help)),
        None => Ok(ground),
    }
}

/// Reads the content of a chart, by its kind.
fn shows(table: &Table, x: &Named, y: &Named, beside: &[Named], known: Known) -> Result<Shows, Fault> {
    let kind = ChartKind::from_value(table.get(&KIND));
    let kind_span = || table.span_of(&KIND).unwrap_or_default();
    let maps = [ChartKind::HeatMap, ChartKind::WinnerMap];
    for (key, kinds) in [
        (&Z, &maps[..]),
        (&Z_SCALE, &maps[..1]),
        (&OF, &maps[1..]),
        (&SERIES, &[ChartKind::Curves]),
        (&LAWS, &[ChartKind::Curves]),
    ] {
        if let Some(written) = table.get(key).filter(|_| !kinds.contains(&kind)) {
            let others: Vec<String> =
                kinds.iter().map(|kind| format!("kind = \"{}\"", kind.name())).collect();
            let message = format!("{} is not a key of a chart of kind = \"{}\"", key.name, kind.name());
            let help = format!("leave it out, or write {}", others.join(" or "));
            return Err(written.fault(message, "not of this kind", help));
        }
    }
    if kind == ChartKind::Curves {
        let laws = laws(table, x, known)?;
        if !beside.is_empty() {
            check_beside(table, &laws)?;
        }
        let mut series = series(table.get(&SERIES), &x.name, known)?;
        if !beside.is_empty() {
            series.truncate(1);
        }
        return Ok(Shows::Curves { series, laws });
    }
    if let (Some(y), false) = (table.get(&Y), beside.is_empty()) {
        let message = format!("a chart of kind = \"{}\" has one column y", kind.name());
        return Err(y.fault(message, "a list", "name one column"));
    }
    let Some(z) = table.get(&Z).map(Named::from) else {
        let message = format!("a chart of kind = \"{}\" needs z, the column that it shows", kind.name());
        return Err(Fault::new(kind_span(), message, "a map of what?", "add it as in\nz = \"p99_73\""));
    };
    for (name, axis) in [("x", x), ("y", y)] {
        known.coordinate(axis, &format!("a map cannot have as its {name}"))?;
    }
    if kind == ChartKind::HeatMap {
        return Ok(Shows::HeatMap { z, z_scale: scale_of(table.get(&Z_SCALE)) });
    }
    let of = match table.get(&OF) {
        None => {
            let message = "a winner map needs of, the swept key whose values compete";
            let help = "add it as in\nof = \"length\"";
            let none = || Fault::new(kind_span(), message, "the winner of what?", help);
            known.ground.rivals().ok_or_else(none)?.into()
        }
        Some(of) => {
            let name = known.chooser(&of.into(), "a winner map cannot compare by")?;
            Named { name, span: of.span() }
        }
    };
    Ok(Shows::WinnerMap { z, of })
}

/// Most columns shown at once.
const MAX_COLUMNS: usize = 8;

/// Reads the column y, and the further columns where y is a list.
fn estimates(y: SpannedValue) -> Result<(Named, Vec<Named>), Fault> {
    if !y.is_list() {
        return Ok((Named::from(y), vec![]));
    }
    let mut names = y.items().into_iter().map(Named::from);
    let count = names.len();
    if let (Some(first), 2..=MAX_COLUMNS) = (names.next(), count) {
        return Ok((first, names.collect()));
    }
    let label = if count < 2 { "too few for a list" } else { "too many columns" };
    let help = format!(
        "accepted: the name of a column, or a list of names as in [\"bound\", \"mean_drift\"], 2 to {MAX_COLUMNS}"
    );
    Err(y.fault(format!("chart.y lists {count} columns"), label, help))
}

/// Refuses what cannot be combined with several columns y: more than one further column of series, and laws.
fn check_beside(table: &Table, laws: &[Law]) -> Result<(), Fault> {
    if let Some(series) = table.get(&SERIES).filter(|series| series.items().len() > 1) {
        let message = "series names two columns, but y lists several";
        let help = "name one column, for the dash: the columns y have the colours";
        return Err(series.fault(message, "one too many", help));
    }
    match table.get(&LAWS).filter(|_| !laws.is_empty()) {
        Some(written) => {
            let message = "chart.references conflict with several columns y";
            Err(written.fault(message, "of one column", "leave them out, or name one column y"))
        }
        None => Ok(()),
    }
}

/// The columns that distinguish curves. If none are written, and the table has neither fillers nor coefficients, they
/// are the swept keys other than x.
fn series(written: Option<SpannedValue>, x: &str, known: Known) -> Result<Vec<Named>, Fault> {
    let Some(written) = written else {
        return Ok(match known.ground.texts.first() {
            // Columns side by side need no further distinction.
            Some(text) if text.name == x => vec![],
            Some(text) => vec![text.name.into()],
            None => {
                let across = known.coordinate(&x.into(), "no axis over").ok();
                let swept = known.sweeps.iter().map(|sweep| sweep.key.name);
                swept.filter(|name| Some(*name) != across.as_deref()).take(2).map(Named::from).collect()
            }
        });
    };
    let names: Vec<Named> = written.items().into_iter().map(Named::from).collect();
    if (1..=2).contains(&names.len()) {
        return Ok(names);
    }
    let message = format!("series names {} columns", names.len());
    let help = "accepted: one name (colour) or two (colour, dash), as in [\"filler\", \"gap_ticks\"]";
    Err(written.fault(message, "not one or two names", help))
}

fn laws(table: &Table, x: &Named, known: Known) -> Result<Vec<Law>, Fault> {
    let written = table.get(&LAWS).map(|laws| laws.items()).unwrap_or_default();
    let mut laws = Vec::new();
    for item in &written {
        let law = Law::from_value(Some(*item));
        if laws.contains(&law) {
            let message = format!("chart.references lists \"{}\" twice", law.name());
            return Err(item.fault(message, "listed before", "leave it out here"));
        }
        laws.push(law);
    }
    if let Some((item, law)) = written.iter().zip(&laws).find(|(_, law)| !known.ground.laws.contains(law)) {
        let message =
            format!("chart.references: \"{}\" is a reference curve of {}", law.name(), law.subject());
        return Err(item.fault(message, "not of this kind of study", "leave it out"));
    }
    if !laws.is_empty() {
        known.coordinate(x, "reference curves cannot be drawn over")?;
    }
    Ok(laws)
}

const PERCENT: &str = "accepted: a percentage such as \"10 %\", of a relative column";

/// Reads the requirement of a study on one of its tables, and gives it to the charts of that estimate that lack a limit. A
/// supplied chart becomes one of that estimate.
///
/// # Errors
/// No table has an estimate of that dimension, or it is not above 0.
pub(crate) fn read_requirement(
    given: SpannedValue,
    grounds: &[TableSchema],
    charts: &mut [Chart],
) -> Result<Requirement, Fault> {
    let present = || grounds.iter().filter(|ground| ground.absent.is_none());
    let fits =
        |ground: &&TableSchema| read_limit(given, ground).is_ok_and(|limit| ground.judged(limit).is_some());
    let Some(ground) = present().find(fits).or_else(|| present().next()) else {
        return Err(given.fault(
            "limit: this kind of study has no results to limit",
            "no limit",
            "leave it out",
        ));
    };
    let limit = read_limit(given, ground)?;
    let Some(column) = ground.judged(limit) else {
        return Err(given.fault(
            "limit: no estimate of this study has that unit",
            "no such estimate",
            "leave it out",
        ));
    };
    for chart in charts.iter_mut().filter(|chart| chart.source == ground.source) {
        // A supplied chart shows what is judged instead of the default estimates.
        let is_supplied = chart.x.span.is_empty() && matches!(chart.shows, Shows::Curves { .. });
        if is_supplied && chart.estimate().name != column.name {
            (chart.y, chart.beside) = (column.name.into(), vec![]);
            chart.y_scale = if column.is_linear { Scale::Linear } else { chart.y_scale };
        }
        // Of several columns side by side, the limit belongs to one only.
        if chart.limit.is_none() && chart.beside.is_empty() && chart.estimate().name == column.name {
            chart.limit = Some(limit);
        }
    }
    Ok(Requirement { source: ground.source, column: column.name, limit })
}

/// Reads a limit in the unit of the table's estimates.
fn read_limit(given: SpannedValue, ground: &TableSchema) -> Result<Limit, Fault> {
    if ground.limits.is_empty() {
        return Ok(Limit { value: given.percent(PERCENT)?, unit: Unit::NONE });
    }
    let limit = given.read(&unlimited(ground.limits))?;
    if limit.value > 0.0 {
        return Ok(Limit { value: limit.shown(), unit: limit.dimension.unit() });
    }
    let message = format!("{} = {limit}, but no error stays within that", given.key.name);
    let help = format!("accepted: {} above 0, or no limit", limit.dimension.name());
    Err(given.fault(message, "not above 0", help))
}

/// A chart of the points that suits the sweeps: the default estimate over the abscissa of the table, over a coordinate
/// that follows from a swept key, or over the first swept key that is not a name, with a curve for each value of the
/// first two other columns. Without any abscissa, the compared values stand side by side. `None` where there is nothing
/// to draw over.
fn chart(sweeps: &[Sweep], ground: &TableSchema) -> Option<Chart> {
    let y = ground.usual(Usual::Estimate)?.name;
    let is_swept = |name: &str| sweeps.iter().any(|sweep| sweep.key.name == name);
    let abscissa = ground.usual(Usual::Abscissa);
    let followed =
        ground.coordinates().find(|column| is_swept(column.of)).map(|column| (column.name, column.of));
    let number =
        || sweeps.iter().find(|sweep| !sweep.key.is_name()).map(|sweep| (sweep.key.name, sweep.key.name));
    let along = |column: Option<&sagnac_base::table::About>| column.map(|column| (column.name, ""));
    // A column with a default value is not compared.
    let compared = || ground.texts.iter().filter(|text| text.usual.is_none() && text.whole.is_none());
    let Some((x, swept)) = along(ground.along()).or(followed).or_else(number).or(along(abscissa)) else {
        return compared().next().map(|text| side_by_side(sweeps, ground, text.name));
    };
    let others = || sweeps.iter().map(|sweep| sweep.key.name).filter(|name| *name != swept);
    let series: Vec<&str> = compared().map(|text| text.name).chain(others()).take(2).collect();
    let fixed = sweeps.iter().filter(|sweep| sweep.key.name != swept && !series.contains(&sweep.key.name));
    let whole = ground.texts.iter().filter(|_| !swept.is_empty());
    let whole = whole.filter_map(|text| Some((text.name.into(), Cell::from(text.whole?))));
    let x_scale = match abscissa.filter(|column| column.name == x) {
        Some(_) if ground.along().is_some() => Scale::Log,
        Some(_) => Scale::Linear,
        None => Known { sweeps, ground }.scale_over(x),
    };
    Some(Chart {
        rows: whole.chain(fixed.filter_map(at_first)).chain(ground.usual_rows()).collect(),
        x_scale,
        ..curves(x, y, series)
    })
}

/// Curves of the points of a study.
fn curves(x: &str, y: &str, series: Vec<&str>) -> Chart {
    let shows = Shows::Curves { series: series.into_iter().map(Named::from).collect(), laws: vec![] };
    Chart { x: x.into(), y: y.into(), shows, ..Chart::default() }
}

/// The row at the first value of a sweep, because a curve varies one key while others stay fixed.
fn at_first(sweep: &Sweep) -> Option<(Named, Cell)> {
    Some((sweep.key.name.into(), sweep.values.first()?.cell()))
}

/// A chart with the values of a column side by side, where no number is swept, by the estimates of a summary, for each
/// value of the first swept name.
fn side_by_side(sweeps: &[Sweep], ground: &TableSchema, x: &str) -> Chart {
    let mut estimates = ground
        .columns
        .iter()
        .filter(|column| column.brief && column.role == Role::Error)
        .map(|column| column.name);
    let first = estimates.next().unwrap_or_default();
    Chart {
        beside: estimates.map(Named::from).collect(),
        rows: sweeps.iter().skip(1).filter_map(at_first).chain(ground.usual_rows()).collect(),
        x_scale: Scale::Linear,
        y_scale: Scale::Log,
        ..curves(x, first, sweeps.iter().take(1).map(|sweep| sweep.key.name).collect())
    }
}

/// Values of τ.
const TIMES: ValueType = unlimited(&[Dimension::Time]);

/// Most values of a sweep that a message lists.
const MAX_LISTED: usize = 12;

/// The columns of a table that are known before anything is sampled: the swept keys, and those of its ground.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    pub(crate) sweeps: &'a [Sweep],
    pub(crate) ground: &'a TableSchema,
}

impl Known<'_> {
    /// Finds the column that `named` means among those that distinguish rows: a swept key, a text column, or τ.
    ///
    /// # Errors
    /// No column or several columns match; `cannot` begins the message, such as "`where` cannot choose rows by".
    fn chooser(self, named: &Named, cannot: &str) -> Result<String, Fault> {
        let texts = self.ground.texts.iter().map(|text| About::named(text.name));
        self.find(texts.chain(self.ground.along().copied()).collect(), named, cannot)
    }

    /// Finds the column that `named` means among the numeric ones: a swept key, or one that follows from it.
    ///
    /// # Errors
    /// It fails where [`Known::chooser`] does.
    fn coordinate(self, named: &Named, cannot: &str) -> Result<String, Fault> {
        self.find(self.ground.coordinates().copied().collect(), named, cannot)
    }

    /// Finds the column that `named` means among the swept keys and some `more`.
    fn find(self, more: Vec<About>, named: &Named, cannot: &str) -> Result<String, Fault> {
        let unit = |sweep: &Sweep| sweep.values.first().map_or(Unit::NONE, SweepValue::unit);
        let swept =
            self.sweeps.iter().map(|sweep| About { unit: unit(sweep), ..About::named(sweep.key.name) });
        let columns: Vec<Column> =
            swept.chain(more.iter().copied()).map(|about| about.with(Cells::default())).collect();
        let (name, span) = (&named.name, named.span.clone());
        let found = table::find(&columns, name).map_err(|error| match error {
            ColumnError::Ambiguous { .. } => {
                Fault::new(span, error.to_string(), "more than one", "write the whole name")
            }
            _ => {
                let known: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
                let more: Vec<&str> = more.iter().map(|about| about.name).collect();
                let label = match &more[..] {
                    [] => "not swept".to_owned(),
                    more => format!("neither swept nor {}", more.join(" nor ")),
                };
                Fault::new(span, format!("{cannot} `{name}`"), label, choices(name, &known))
            }
        })?;
        Ok(found.name.clone())
    }

    /// The default scale of an axis over this column: that of its sweep, or of the sweep on which it depends, else its own.
    fn scale_over(self, name: &str) -> Scale {
        if self.ground.columns.iter().any(|known| known.is_linear && known.is_called(name)) {
            return Scale::Linear;
        }
        let Ok(column) = self.coordinate(&name.into(), "no axis over") else { return Scale::default() };
        let followed = self.ground.coordinates().find(|known| known.name == column).map(|known| known.of);
        let key = followed.filter(|of| !of.is_empty()).unwrap_or(&column);
        self.sweeps.iter().find(|sweep| sweep.key.name == key).map_or(Scale::default(), |sweep| sweep.scale)
    }

    /// The column that one entry of `where` names, with its value there.
    pub(crate) fn row(self, named: &Named, given: SpannedValue) -> Result<(String, Cell), Fault> {
        let column = self.chooser(named, "`where` cannot choose rows by")?;
        let cell = if let Some(sweep) = self.sweeps.iter().find(|sweep| sweep.key.name == column) {
            swept_value(sweep, given)?.cell()
        } else if let Some(text) = self.ground.texts.iter().find(|text| text.name == column) {
            let known: Vec<&str> = text.values.iter().map(String::as_str).collect();
            if !given.is_text() || !known.contains(&given.text()) {
                let message = format!("no row has {column} = {given}");
                return Err(given.fault(message, "not in this study", choices(given.text(), &known)));
            }
            given.text().into()
        } else {
            // Whether the table has that τ is found out when the chart is drawn without estimates.
            given.read(&TIMES)?.into()
        };
        Ok((column, cell))
    }
}

/// The value of a sweep that tables show like the given one.
fn swept_value<'s>(sweep: &'s Sweep, given: SpannedValue) -> Result<&'s SweepValue, Fault> {
    let wanted = match sweep.key.is_name() {
        true => SweepValue::Name(given.text().to_owned()),
        false => SweepValue::Quantity(given.of(sweep.key).quantity()?),
    };
    let is_meant =
        |value: &&SweepValue| value.unit() == wanted.unit() && value.cell().text() == wanted.cell().text();
    sweep.values.iter().find(is_meant).ok_or_else(|| {
        let listed: Vec<String> = sweep.values.iter().take(MAX_LISTED).map(SweepValue::to_string).collect();
        let more = if sweep.values.len() > MAX_LISTED { ", …" } else { "" };
        let message = format!("no point has {} = {wanted}", sweep.key.name);
        let help = format!("accepted: {}{more}", listed.join(", "));
        given.fault(message, "not among the swept values", help)
    })
}
