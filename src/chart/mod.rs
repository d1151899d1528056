//! The specification of a chart: what a study holds, and what is drawn. Columns are named, not yet looked up in a table.

pub mod columns;
pub mod file;
pub mod ground;
pub mod law;
pub mod rows;
pub mod supplied;

use std::ops::Range;

use crate::chart::columns as chart_columns;
pub use crate::chart::file::Source;
use crate::chart::file::{
    CHART, ChartKind, KIND, LAWS, LIMIT, OF, SERIES, TABLE, TITLE, WHERE, X, X_SCALE, Y, Y_SCALE, Z, Z_SCALE,
};
use crate::chart::ground::{Ground, Text};
use crate::chart::law::Law;
use crate::chart::rows::{FILLER, chooser, coordinate, row};
use crate::key::given::Given;
use crate::key::holds::unlimited;
use crate::key::row::Key;
use crate::key::scale::Scale;
use crate::key::sweep::Sweep;
use crate::key::table::Table;
use crate::quantity::number::significant;
use crate::source::diagnose::Fault;
use crate::table::{Cell, Unit};

/// A name of a column, and where it stands in the study, so that an unknown one can be pointed at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// As written: `q9973`, `motion.frequency`.
    pub name: String,
    /// Bytes of the text; empty at 0 for a name that is not written but a default.
    pub span: Range<usize>,
}

impl From<&str> for Named {
    fn from(name: &str) -> Named {
        Named::default(name)
    }
}

impl Named {
    pub(crate) fn default(name: &str) -> Named {
        Named { name: name.to_owned(), span: 0..0 }
    }
}

impl From<Given<'_>> for Named {
    fn from(given: Given) -> Named {
        Named { span: given.span(), name: given.text().to_owned() }
    }
}

/// One chart of a table: curves, or a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// In bold over the chart.
    pub title: String,
    /// A second, smaller line; may be empty.
    pub subtitle: String,
    /// The table that it draws.
    pub source: Source,
    /// The abscissa.
    pub x: Named,
    /// Of curves the estimate, of a map an axis like x. Bands are drawn, and the closed form where the table has one.
    pub y: Named,
    /// Further columns like y, each a curve of its own colour.
    pub beside: Vec<Named>,
    /// Curves or a map.
    pub shows: Shows,
    /// Only rows in which each column, a swept key, `filler` or `error`, has the value: one of those it takes. A chart that is
    /// supplied has those of the keys that it cannot show.
    pub rows: Vec<(Named, Cell)>,
    /// A line, in a unit that the estimate must have, and what the verdict is about.
    pub limit: Option<Limit>,
    /// Of the abscissa.
    pub x_scale: Scale,
    /// Of the ordinate.
    pub y_scale: Scale,
    /// The columns by which the rows of the table are told apart, such as swept keys: only one of them may vary along a
    /// curve. Empty: not checked.
    pub apart: Vec<String>,
    /// What the points are, for the legend: `Monte Carlo`, `measured`. Empty: not said.
    pub points: String,
    /// What the bands are: `95 % band`.
    pub bands: String,
}

impl Default for Chart {
    /// Curves without columns, over logarithmic axes.
    fn default() -> Chart {
        Chart {
            title: String::new(),
            subtitle: String::new(),
            source: Source::Points,
            x: Named::default(""),
            y: Named::default(""),
            beside: vec![],
            shows: Shows::Curves { series: vec![], laws: vec![] },
            rows: vec![],
            limit: None,
            x_scale: Scale::Log,
            y_scale: Scale::Log,
            apart: vec![],
            points: String::new(),
            bands: String::new(),
        }
    }
}

/// What is allowed of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Above 0.
    pub value: f64,
    /// Of the column that it is about.
    pub unit: Unit,
}

impl Limit {
    /// For sentences: `10 ″`, `5 %`.
    pub fn text(&self) -> String {
        match self.unit.symbol {
            "" => format!("{} %", significant(100.0 * self.value, 6)),
            symbol => format!("{} {symbol}", significant(self.value, 6)),
        }
    }
}

/// What a chart shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    /// y over x.
    Curves {
        /// At most two columns whose values make the curves: the first gives the colour, the second the dash. At most one, for
        /// the dash, where several columns are shown.
        series: Vec<Named>,
        /// Each once, angles in ″; with any, x of a study is a swept key or `dt_nu`.
        laws: Vec<Law>,
    },
    /// z by colour, over x and y.
    HeatMap {
        /// The column by colour.
        z: Named,
        /// Of the colours.
        z_scale: Scale,
    },
    /// Over x and y, which value of the column `of`, a swept key, `filler` or `error`, has the least z.
    WinnerMap {
        /// The column that competes, the least wins.
        z: Named,
        /// Who competes.
        of: Named,
    },
}

impl Chart {
    /// The column of the estimates.
    pub fn estimate(&self) -> &Named {
        match &self.shows {
            Shows::Curves { .. } => &self.y,
            Shows::HeatMap { z, .. } | Shows::WinnerMap { z, .. } => z,
        }
    }

    /// Whether it is one that was not written but supplied, as fillers side by side are where nothing is swept.
    pub fn is_supplied(&self) -> bool {
        self.x.span.is_empty() && self.x.name == FILLER
    }

    /// The columns that curves show: y and those beside it.
    pub fn columns(&self) -> impl Iterator<Item = &Named> {
        std::iter::once(&self.y).chain(&self.beside)
    }

    /// The columns whose values are told apart.
    pub fn series(&self) -> &[Named] {
        match &self.shows {
            Shows::Curves { series, .. } => series,
            Shows::HeatMap { .. } => &[],
            Shows::WinnerMap { of, .. } => std::slice::from_ref(of),
        }
    }

    /// The second line, if it has one.
    pub fn subtitle(&self) -> Option<String> {
        Some(self.subtitle.clone()).filter(|text| !text.is_empty())
    }

    /// The rows that are drawn: (column, value as files show it).
    pub fn filter(&self) -> Vec<(String, String)> {
        self.rows.iter().map(|(column, value)| (column.name.clone(), value.text())).collect()
    }

    /// The laws drawn beside curves.
    pub fn laws(&self) -> &[Law] {
        match &self.shows {
            Shows::Curves { laws, .. } => laws,
            Shows::HeatMap { .. } | Shows::WinnerMap { .. } => &[],
        }
    }
}

/// The charts of a study: those written, or one that suits the sweeps.
///
/// # Errors
/// A key that the kind of chart lacks or does not have, not one or two `series`, an `of` or a `where` that names another
/// column than a swept key or one of text, axes of a map or below a law that are not known beforehand, a `limit` of
/// another dimension or not above 0, a value in `where` that its column does not take.
pub(crate) fn read_all(
    study: &Table,
    sweeps: &[Sweep],
    grounds: &[Ground],
    usual: [Option<&str>; 2],
    supplied: impl FnOnce() -> Option<Chart>,
) -> Result<Vec<Chart>, Fault> {
    let Some(charts) = study.get(&CHART) else {
        return Ok(supplied().into_iter().collect());
    };
    let tables = if charts.is_list() { charts.items() } else { vec![charts] };
    tables.iter().filter_map(Given::table).map(|table| read(&table, sweeps, grounds, usual)).collect()
}

/// A column that a chart needs; in the example it has the `usual` name.
fn axis<'a>(table: &Table<'a>, key: &'static Key, usual: Option<&str>) -> Result<Given<'a>, Fault> {
    table.get(key).ok_or_else(|| {
        let example = usual.map_or(key.example.to_owned(), |name| format!("{} = \"{name}\"", key.last()));
        Fault::missing_key(key.name, &example, table.span.clone())
    })
}

fn read(
    table: &Table,
    sweeps: &[Sweep],
    grounds: &[Ground],
    [usual_x, usual_y]: [Option<&str>; 2],
) -> Result<Chart, Fault> {
    let ground = ground(table, grounds)?;
    let limit = table.get(&LIMIT).map(|limit| read_limit(limit, ground)).transpose()?;
    let x = Named::from(axis(table, &X, usual_x)?);
    let (y, beside) = chart_columns::read(axis(table, &Y, usual_y)?)?;
    let shows = shows(table, &x, &y, &beside, sweeps, ground)?;
    let mut rows = Vec::new();
    let mut chosen: Vec<String> = Vec::new();
    for (name, value) in table.get(&WHERE).and_then(|rows| rows.table()).iter().flat_map(|rows| rows.entries)
    {
        let name = Named { name: name.get_ref().to_string(), span: name.span() };
        let (column, cell) = row(&name, Given { key: &WHERE, value }, sweeps, ground)?;
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
    let usual_scale = |name: &str| match ground.is_linear {
        true => Scale::Linear,
        false => scale_over(name, sweeps, ground),
    };
    let chart = Chart {
        title: table.get(&TITLE).map_or(String::new(), |title| title.text().to_owned()),
        x_scale: table.get(&X_SCALE).map_or_else(|| usual_scale(&x.name), |scale| Scale::of(Some(scale))),
        y_scale: table.get(&Y_SCALE).map_or_else(|| usual_scale(&y.name), |scale| Scale::of(Some(scale))),
        source: ground.source,
        x,
        y,
        beside,
        shows,
        rows,
        limit,
        ..Chart::default()
    };
    // Without a word on them a curve would jump between rows of several errors, and a map show two values at once.
    let is_named = |column: &str| {
        let mut drawn = std::iter::once(&chart.x).chain(chart.series());
        chosen.iter().any(|name| name == column) || drawn.any(|named| named.name == column)
    };
    let supplied = usual_rows(ground).into_iter().filter(|(column, _)| !is_named(&column.name));
    let supplied: Vec<(Named, Cell)> = supplied.collect();
    Ok(Chart { rows: chart.rows.into_iter().chain(supplied).collect(), ..chart })
}

/// The table of results that is drawn.
fn ground<'g>(table: &Table, grounds: &'g [Ground]) -> Result<&'g Ground, Fault> {
    let (source, span) = (Source::of(table.get(&TABLE)), table.span_of(&TABLE).unwrap_or_default());
    let Some(ground) = grounds.iter().find(|ground| ground.source == source) else {
        let message = "a study of this kind has no such table";
        return Err(Fault::new(span, message, "no such table", "leave chart.table out"));
    };
    match ground.absent {
        Some((message, help)) => Err(Fault::new(span, message, "an empty table", help)),
        None => Ok(ground),
    }
}

/// What a table asks to be shown, by its kind.
fn shows(
    table: &Table,
    x: &Named,
    y: &Named,
    beside: &[Named],
    sweeps: &[Sweep],
    ground: &Ground,
) -> Result<Shows, Fault> {
    let kind = ChartKind::of(table.get(&KIND));
    let kind_span = || table.span_of(&KIND).unwrap_or_default();
    let maps = [ChartKind::HeatMap, ChartKind::WinnerMap];
    for (key, kinds) in [
        (&Z, &maps[..]),
        (&Z_SCALE, &maps[..1]),
        (&OF, &maps[1..]),
        (&SERIES, &[ChartKind::Curves]),
        (&LAWS, &[ChartKind::Curves]),
    ] {
        only_for(kind, kinds, table.get(key))?;
    }
    if kind == ChartKind::Curves {
        let laws = laws(table, x, sweeps, ground)?;
        if !beside.is_empty() {
            chart_columns::check_beside(table, &laws)?;
        }
        let mut series = series(table.get(&SERIES), &x.name, sweeps, ground)?;
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
        return Err(Fault::new(kind_span(), message, "a map of what?", "add it as in\nz = \"q9973\""));
    };
    for (name, axis) in [("x", x), ("y", y)] {
        let cannot = format!("a map cannot have as its {name}");
        coordinate(sweeps, ground, &axis.name, axis.span.clone(), &cannot)?;
    }
    if kind == ChartKind::HeatMap {
        return Ok(Shows::HeatMap { z, z_scale: Scale::of(table.get(&Z_SCALE)) });
    }
    let of = match table.get(&OF) {
        None if ground.values(FILLER).is_none() => {
            let message = "a winner map needs of, the swept key whose values compete";
            let help = "add it as in\nof = \"length\"";
            return Err(Fault::new(kind_span(), message, "the winner of what?", help));
        }
        None => Named::default(FILLER),
        Some(of) => {
            let name = chooser(sweeps, ground, of.text(), of.span(), "a winner map cannot compare by")?;
            Named { name, span: of.span() }
        }
    };
    Ok(Shows::WinnerMap { z, of })
}

/// Refuses a key that is written but belongs to other kinds.
fn only_for(kind: ChartKind, kinds: &[ChartKind], written: Option<Given>) -> Result<(), Fault> {
    let Some(written) = written.filter(|_| !kinds.contains(&kind)) else {
        return Ok(());
    };
    let others: Vec<String> = kinds.iter().map(|kind| format!("kind = \"{}\"", kind.name())).collect();
    let message = format!("{} is not a key of a chart of kind = \"{}\"", written.key.name, kind.name());
    let help = format!("leave it out, or write {}", others.join(" or "));
    Err(written.fault(message, "not of this kind", help))
}

/// The columns that tell curves apart. Where none are written, and a table has neither fillers nor coefficients, swept keys
/// other than x do.
fn series(written: Option<Given>, x: &str, sweeps: &[Sweep], ground: &Ground) -> Result<Vec<Named>, Fault> {
    let Some(written) = written else {
        return Ok(match ground.text_names().first() {
            // Side by side they are told apart already.
            Some(name) if *name == x => vec![],
            Some(name) => vec![Named::default(name)],
            None => {
                let across = coordinate(sweeps, ground, x, 0..0, "no axis over").ok();
                let others =
                    sweeps.iter().map(|sweep| sweep.key.name).filter(|name| Some(*name) != across.as_deref());
                others.take(2).map(Named::default).collect()
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

fn laws(table: &Table, x: &Named, sweeps: &[Sweep], ground: &Ground) -> Result<Vec<Law>, Fault> {
    let written = table.get(&LAWS).map(|laws| laws.items()).unwrap_or_default();
    let mut laws = Vec::new();
    for item in &written {
        let law = Law::of(Some(*item));
        if laws.contains(&law) {
            let message = format!("chart.laws lists \"{}\" twice", law.name());
            return Err(item.fault(message, "listed before", "leave it out here"));
        }
        laws.push(law);
    }
    for (item, law) in written.iter().zip(&laws) {
        if !ground.laws.contains(law) {
            let message = format!("chart.laws: \"{}\" is a law of {}", law.name(), law.subject());
            return Err(item.fault(message, "not of this kind of study", "leave it out"));
        }
    }
    if !laws.is_empty() {
        coordinate(sweeps, ground, &x.name, x.span.clone(), "laws cannot be drawn over")?;
    }
    Ok(laws)
}

/// The scale of an axis over this column where none is written: that of its sweep, or of the sweep that it follows.
pub(crate) fn scale_over(name: &str, sweeps: &[Sweep], ground: &Ground) -> Scale {
    let column = coordinate(sweeps, ground, name, 0..0, "no axis over").ok();
    let follows = |column: &str| ground.numbers.iter().find(|number| number.name == column)?.follows;
    let key = column.as_deref().map(|column| follows(column).unwrap_or(column));
    let sweep = sweeps.iter().find(|sweep| Some(sweep.key.name) == key);
    sweep.map_or(Scale::default(), |sweep| sweep.scale)
}

/// The rows that are meant where nothing is said.
pub(crate) fn usual_rows(ground: &Ground) -> Vec<(Named, Cell)> {
    let usual = |text: &Text| Some((Named::default(text.name), Cell::Text(text.usual.clone()?)));
    ground.texts.iter().filter_map(usual).collect()
}

const PERCENT: &str = "accepted: a part in percent such as \"10 %\", of a relative column";

/// A limit in the unit of what the table is about.
fn read_limit(given: Given, ground: &Ground) -> Result<Limit, Fault> {
    if ground.limits.is_empty() {
        return Ok(Limit { value: given.percent(PERCENT)?, unit: Unit::NONE });
    }
    let limit = given.read(&unlimited(ground.limits))?;
    if limit.value > 0.0 {
        return Ok(Limit { value: limit.value, unit: limit.dimension.unit() });
    }
    let message = format!("chart.limit = {limit}, and no error stays within that");
    let help = format!("accepted: {} above 0, or no limit", limit.dimension.name());
    Err(given.fault(message, "not above 0", help))
}
