//! Charts as asked for: names of columns, not yet looked up in a table.

pub mod columns;
pub mod file;
pub mod ground;
pub mod law;
pub mod rows;
pub mod supplied;

use std::ops::Range;

use toml::Spanned;

use crate::chart::columns as chart_columns;
pub use crate::chart::file::Source;
use crate::chart::file::{ChartKind, ChartTable, Charts, Scale};
use crate::chart::ground::{Ground, Text};
use crate::chart::law::Law;
use crate::chart::rows::{FILLER, chooser, coordinate, row};
use crate::key::scalar::{self, Scalar};
use crate::key::sweep::Sweep;
use crate::quantity::number::significant;
use crate::quantity::percent::percent;
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

impl Named {
    pub(crate) fn default(name: &str) -> Named {
        Named { name: name.to_owned(), span: 0..0 }
    }
}

impl From<Spanned<String>> for Named {
    fn from(name: Spanned<String>) -> Named {
        Named { span: name.span(), name: name.into_inner() }
    }
}

/// One chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Absent: the study's.
    pub title: Option<String>,
    /// The table that it draws.
    pub source: Source,
    /// The abscissa.
    pub x: Named,
    /// Of curves the estimate, of a map an axis like x.
    pub y: Named,
    /// Further columns like y, each a curve of its own colour.
    pub beside: Vec<Named>,
    /// Curves or a map.
    pub shows: Shows,
    /// Only rows in which each column, a swept key, `filler` or `error`, has the value: one of those it takes. A chart that is
    /// supplied has those of the keys that it cannot show.
    pub rows: Vec<(Named, Cell)>,
    /// A line, and what the verdict is about.
    pub limit: Option<Limit>,
    /// Of the abscissa.
    pub x_scale: Scale,
    /// Of the ordinate.
    pub y_scale: Scale,
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
        /// Each once; with any, x is a swept key or `dt_nu`.
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
    charts: Charts,
    sweeps: &[Sweep],
    grounds: &[Ground],
    supplied: impl FnOnce() -> Option<Chart>,
) -> Result<Vec<Chart>, Fault> {
    let read = |table| read(table, sweeps, grounds);
    match charts {
        Charts::Default => Ok(supplied().into_iter().collect()),
        Charts::One(table) => Ok(vec![read(*table)?]),
        Charts::Several(tables) => tables.into_iter().map(read).collect(),
    }
}

fn read(mut table: ChartTable, sweeps: &[Sweep], grounds: &[Ground]) -> Result<Chart, Fault> {
    let ground = ground(&table, grounds)?;
    let limit = table.limit.as_ref().map(|limit| read_limit(limit, ground)).transpose()?;
    let (y, beside) = chart_columns::read(&table)?;
    let shows = shows(&mut table, &y, &beside, sweeps, ground)?;
    let mut rows = Vec::new();
    let mut chosen: Vec<String> = Vec::new();
    for (name, value) in table.rows.unwrap_or_default() {
        let (column, cell) = row(&name, &value, sweeps, ground)?;
        if chosen.contains(&column) {
            let message = format!("`where` gives {column} twice");
            return Err(Fault::new(name.span(), message, "one of the two", "leave one of them out"));
        }
        if matches!(&shows, Shows::WinnerMap { of, .. } if of.name == column) {
            let message = format!("`where` leaves one {column} only, and nothing to compare it with");
            let help = format!("leave {column} out of `where`, or name another column as `of`");
            return Err(Fault::new(name.span(), message, "what the winner map compares", help));
        }
        chosen.push(column);
        rows.push((Named::from(name), cell));
    }
    let usual_scale = |name: &str| match ground.is_linear {
        true => Scale::Linear,
        false => scale_over(name, sweeps, ground),
    };
    let chart = Chart {
        title: table.title,
        x_scale: table.x_scale.unwrap_or_else(|| usual_scale(table.x.get_ref())),
        y_scale: table.y_scale.unwrap_or_else(|| usual_scale(&y.name)),
        source: ground.source,
        x: table.x.into(),
        y,
        beside,
        shows,
        rows,
        limit,
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
fn ground<'g>(table: &ChartTable, grounds: &'g [Ground]) -> Result<&'g Ground, Fault> {
    let (source, span) = match &table.table {
        None => (Source::Points, 0..0),
        Some(written) => (*written.get_ref(), written.span()),
    };
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
    table: &mut ChartTable,
    y: &Named,
    beside: &[Named],
    sweeps: &[Sweep],
    ground: &Ground,
) -> Result<Shows, Fault> {
    let kind = table.kind.as_ref().map_or(ChartKind::Curves, |kind| *kind.get_ref());
    let maps = [ChartKind::HeatMap, ChartKind::WinnerMap];
    only_for(kind, &maps, "z", table.z.as_ref())?;
    only_for(kind, &maps[..1], "z_scale", table.z_scale.as_ref())?;
    only_for(kind, &maps[1..], "of", table.of.as_ref())?;
    only_for(kind, &[ChartKind::Curves], "series", table.series.as_ref())?;
    only_for(kind, &[ChartKind::Curves], "laws", table.laws.as_ref())?;
    if kind == ChartKind::Curves {
        let laws = laws(table, sweeps, ground)?;
        if !beside.is_empty() {
            chart_columns::check_beside(table, &laws)?;
        }
        let mut series = series(table.series.take(), table.x.get_ref(), sweeps, ground)?;
        if !beside.is_empty() {
            series.truncate(1);
        }
        return Ok(Shows::Curves { series, laws });
    }
    if !beside.is_empty() {
        let message = format!("a chart of kind = \"{}\" has one column y", kind.name());
        return Err(Fault::new(table.y.span(), message, "a list", "name one column"));
    }
    let Some(z) = table.z.take().map(Named::from) else {
        let span = table.kind.as_ref().map_or(0..0, Spanned::span);
        let message = format!("a chart of kind = \"{}\" needs z, the column that it shows", kind.name());
        return Err(Fault::new(span, message, "a map of what?", "add it as in\nz = \"q9973\""));
    };
    let x = Named::from(table.x.clone());
    for (name, axis) in [("x", &x), ("y", y)] {
        let cannot = format!("a map cannot have as its {name}");
        coordinate(sweeps, ground, &axis.name, axis.span.clone(), &cannot)?;
    }
    if kind == ChartKind::HeatMap {
        let z_scale = table.z_scale.as_ref().map_or(Scale::default(), |scale| *scale.get_ref());
        return Ok(Shows::HeatMap { z, z_scale });
    }
    let of = match table.of.take() {
        None if ground.values(FILLER).is_none() => {
            let span = table.kind.as_ref().map_or(0..0, Spanned::span);
            let message = "a winner map needs of, the swept key whose values compete";
            return Err(Fault::new(span, message, "the winner of what?", "add it as in\nof = \"length\""));
        }
        None => Named::default(FILLER),
        Some(of) => {
            let name = chooser(sweeps, ground, of.get_ref(), of.span(), "a winner map cannot compare by")?;
            Named { name, span: of.span() }
        }
    };
    Ok(Shows::WinnerMap { z, of })
}

/// Refuses a key that is written but belongs to other kinds.
fn only_for<T>(
    kind: ChartKind,
    kinds: &[ChartKind],
    key: &str,
    written: Option<&Spanned<T>>,
) -> Result<(), Fault> {
    let Some(written) = written.filter(|_| !kinds.contains(&kind)) else {
        return Ok(());
    };
    let others: Vec<String> = kinds.iter().map(|kind| format!("kind = \"{}\"", kind.name())).collect();
    let message = format!("chart.{key} is no key of a chart of kind = \"{}\"", kind.name());
    let help = format!("leave it out, or write {}", others.join(" or "));
    Err(Fault::new(written.span(), message, "not of this kind", help))
}

/// The columns that tell curves apart. Where none are written, and a table has neither fillers nor coefficients, swept keys
/// other than x do.
fn series(
    written: Option<Spanned<Vec<Spanned<String>>>>,
    x: &str,
    sweeps: &[Sweep],
    ground: &Ground,
) -> Result<Vec<Named>, Fault> {
    match written {
        None => Ok(match ground.text_names().first() {
            // Side by side they are told apart already.
            Some(name) if *name == x => vec![],
            Some(name) => vec![Named::default(name)],
            None => {
                let across = coordinate(sweeps, ground, x, 0..0, "no axis over").ok();
                let others =
                    sweeps.iter().map(|sweep| sweep.key.name).filter(|name| Some(*name) != across.as_deref());
                others.take(2).map(Named::default).collect()
            }
        }),
        Some(names) if (1..=2).contains(&names.get_ref().len()) => {
            Ok(names.into_inner().into_iter().map(Named::from).collect())
        }
        Some(names) => {
            let message = format!("series names {} columns", names.get_ref().len());
            let help = "accepted: one name (colour) or two (colour, dash), as in [\"filler\", \"gap_ticks\"]";
            Err(Fault::new(names.span(), message, "not one or two names", help))
        }
    }
}

fn laws(table: &ChartTable, sweeps: &[Sweep], ground: &Ground) -> Result<Vec<Law>, Fault> {
    let mut laws = Vec::new();
    for law in table.laws.iter().flat_map(|laws| laws.get_ref()) {
        if laws.contains(law.get_ref()) {
            let message = format!("chart.laws lists \"{}\" twice", law.get_ref().name());
            return Err(Fault::new(law.span(), message, "listed before", "leave it out here"));
        }
        laws.push(*law.get_ref());
    }
    for law in table.laws.iter().flat_map(|laws| laws.get_ref()) {
        if !ground.laws.contains(law.get_ref()) {
            let message =
                format!("chart.laws: \"{}\" is a law of {}", law.get_ref().name(), law.get_ref().subject());
            return Err(Fault::new(law.span(), message, "not of this kind of study", "leave it out"));
        }
    }
    if !laws.is_empty() {
        coordinate(sweeps, ground, table.x.get_ref(), table.x.span(), "laws cannot be drawn over")?;
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
fn read_limit(given: &Spanned<Scalar>, ground: &Ground) -> Result<Limit, Fault> {
    if ground.limits.is_empty() {
        return Ok(Limit { value: percent("chart.limit", given, PERCENT)?, unit: Unit::NONE });
    }
    let limit = scalar::quantity("chart.limit", given, ground.limits)?;
    if limit.value > 0.0 {
        return Ok(Limit { value: limit.value, unit: limit.dimension.unit() });
    }
    let message = format!("chart.limit = {limit}, and no error stays within that");
    let help = format!("accepted: {} above 0, or no limit", limit.dimension.name());
    Err(Fault::new(given.span(), message, "not above 0", help))
}
