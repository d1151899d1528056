//! Charts as asked for: names of columns, not yet looked up in a table.

use std::ops::Range;

use toml::Spanned;

use super::chart_file::{ChartKind, ChartTable, Charts, Scale};
use super::diagnose::Fault;
use super::file::Error;
use super::filler::Filler;
use super::key::FREQUENCY;
use super::law::Law;
use super::rows::{DT_NU, ERROR, FILLER, chooser, coordinate, row};
use super::scalar::{self, Scalar};
use super::sweep::Sweep;
use super::units::Dimension;
use crate::table::Cell;

/// A name of a column, and where it stands in the study, so that an unknown one can be pointed at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    pub name: String,
    /// Bytes of the text; empty at 0 for a name that is not written but a default.
    pub span: Range<usize>,
}

impl Named {
    fn default(name: &str) -> Named {
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
    pub x: Named,
    /// Of curves the estimate, of a map an axis like x.
    pub y: Named,
    pub shows: Shows,
    /// Only rows in which each column, a swept key, `filler` or `error`, has the value: one of those it takes. A chart that is
    /// supplied has those of the keys that it cannot show.
    pub rows: Vec<(Named, Cell)>,
    /// Allowed error, ″, above 0.
    pub limit_arcsec: Option<f64>,
    pub x_scale: Scale,
    pub y_scale: Scale,
}

/// What a chart shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    Curves {
        /// One or two columns whose values make the curves: the first gives the colour, the second the dash.
        series: Vec<Named>,
        /// Each once; with any, x is a swept key or `dt_nu`.
        laws: Vec<Law>,
    },
    /// z by colour, over x and y.
    HeatMap { z: Named, z_scale: Scale },
    /// Over x and y, which value of the column `of`, a swept key, `filler` or `error`, has the least z.
    WinnerMap { z: Named, of: Named },
}

impl Chart {
    /// The column of the estimates.
    pub fn estimate(&self) -> &Named {
        match &self.shows {
            Shows::Curves { .. } => &self.y,
            Shows::HeatMap { z, .. } | Shows::WinnerMap { z, .. } => z,
        }
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
/// column than a swept key, `filler` and `error`, axes of a map or below a law that are no swept key and not `dt_nu`, a
/// `limit` that is no angle above 0, a value in `where` that its column does not take.
pub(super) fn read_all(charts: Charts, sweeps: &[Sweep], fillers: &[Filler]) -> Result<Vec<Chart>, Fault> {
    let read = |table| read(table, sweeps, fillers);
    match charts {
        Charts::Default => Ok(default_for(sweeps).into_iter().collect()),
        Charts::One(table) => Ok(vec![read(*table)?]),
        Charts::Several(tables) => tables.into_iter().map(read).collect(),
    }
}

fn read(mut table: ChartTable, sweeps: &[Sweep], fillers: &[Filler]) -> Result<Chart, Fault> {
    let limit = table.limit.as_ref().map(limit).transpose()?;
    let shows = shows(&mut table, sweeps)?;
    let mut rows = Vec::new();
    let mut chosen: Vec<String> = Vec::new();
    for (name, value) in table.rows.unwrap_or_default() {
        let (column, cell) = row(&name, &value, sweeps, fillers)?;
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
    let chart = Chart {
        title: table.title,
        x_scale: table.x_scale.unwrap_or_else(|| scale_over(table.x.get_ref(), sweeps)),
        y_scale: table.y_scale.unwrap_or_else(|| scale_over(table.y.get_ref(), sweeps)),
        x: table.x.into(),
        y: table.y.into(),
        shows,
        rows,
        limit_arcsec: limit,
    };
    // Without a word on errors a curve would jump between the two, and a map show two values at once.
    let told_apart = chosen.iter().any(|column| column == ERROR);
    if told_apart || chart.series().iter().any(|named| named.name == ERROR) {
        return Ok(chart);
    }
    Ok(Chart { rows: chart.rows.into_iter().chain(only_residuals()).collect(), ..chart })
}

/// What a table asks to be shown, by its kind.
fn shows(table: &mut ChartTable, sweeps: &[Sweep]) -> Result<Shows, Fault> {
    let kind = table.kind.as_ref().map_or(ChartKind::Curves, |kind| *kind.get_ref());
    let maps = [ChartKind::HeatMap, ChartKind::WinnerMap];
    only_for(kind, &maps, "z", table.z.as_ref())?;
    only_for(kind, &maps[..1], "z_scale", table.z_scale.as_ref())?;
    only_for(kind, &maps[1..], "of", table.of.as_ref())?;
    only_for(kind, &[ChartKind::Curves], "series", table.series.as_ref())?;
    only_for(kind, &[ChartKind::Curves], "laws", table.laws.as_ref())?;
    if kind == ChartKind::Curves {
        let laws = laws(table, sweeps)?;
        return Ok(Shows::Curves { series: series(table.series.take())?, laws });
    }
    let Some(z) = table.z.take().map(Named::from) else {
        let span = table.kind.as_ref().map_or(0..0, Spanned::span);
        let message = format!("a chart of kind = \"{}\" needs z, the column that it shows", kind.name());
        return Err(Fault::new(span, message, "a map of what?", "add it as in\nz = \"q9973\""));
    };
    for (name, axis) in [("x", &table.x), ("y", &table.y)] {
        let cannot = format!("a map cannot have as its {name}");
        coordinate(sweeps, axis.get_ref(), axis.span(), &cannot)?;
    }
    if kind == ChartKind::HeatMap {
        let z_scale = table.z_scale.as_ref().map_or(Scale::default(), |scale| *scale.get_ref());
        return Ok(Shows::HeatMap { z, z_scale });
    }
    let of = match table.of.take() {
        None => Named::default(FILLER),
        Some(of) => {
            let name = chooser(sweeps, of.get_ref(), of.span(), "a winner map cannot compare by")?;
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

fn series(written: Option<Spanned<Vec<Spanned<String>>>>) -> Result<Vec<Named>, Fault> {
    match written {
        None => Ok(vec![Named::default(FILLER)]),
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

fn laws(table: &ChartTable, sweeps: &[Sweep]) -> Result<Vec<Law>, Fault> {
    let mut laws = Vec::new();
    for law in table.laws.iter().flat_map(|laws| laws.get_ref()) {
        if laws.contains(law.get_ref()) {
            let message = format!("chart.laws lists \"{}\" twice", law.get_ref().name());
            return Err(Fault::new(law.span(), message, "listed before", "leave it out here"));
        }
        laws.push(*law.get_ref());
    }
    if !laws.is_empty() {
        coordinate(sweeps, table.x.get_ref(), table.x.span(), "laws cannot be drawn over")?;
    }
    Ok(laws)
}

/// Over Δt·ν if the frequency is swept, else over the first swept key; nothing to draw if none is.
fn default_for(sweeps: &[Sweep]) -> Option<Chart> {
    let mut names: Vec<&str> = sweeps.iter().map(|sweep| sweep.key.name).collect();
    let x = match names.iter().position(|name| *name == FREQUENCY.name) {
        Some(frequency) => {
            names.remove(frequency);
            DT_NU
        }
        None if names.is_empty() => return None,
        None => names.remove(0),
    };
    let series = std::iter::once(FILLER).chain(names.first().copied());
    // A curve runs along one key: further ones stay at their first value.
    let first = |name: &&str| sweeps.iter().find(|sweep| sweep.key.name == *name)?.values.first().copied();
    let fixed = names.iter().skip(1).filter_map(|name| Some((Named::default(name), first(name)?.cell())));
    Some(Chart {
        title: None,
        x: Named::default(x),
        y: Named::default("rms"),
        shows: Shows::Curves { series: series.map(Named::default).collect(), laws: vec![] },
        rows: fixed.chain(only_residuals()).collect(),
        limit_arcsec: None,
        x_scale: scale_over(x, sweeps),
        y_scale: Scale::default(),
    })
}

/// The scale of an axis over this column where none is written: that of its sweep, of Δt·ν that of the frequency.
fn scale_over(name: &str, sweeps: &[Sweep]) -> Scale {
    let column = coordinate(sweeps, name, 0..0, "no axis over").ok();
    let key = column.as_deref().map(|column| if column == DT_NU { FREQUENCY.name } else { column });
    let sweep = sweeps.iter().find(|sweep| Some(sweep.key.name) == key);
    sweep.map_or(Scale::default(), |sweep| sweep.scale)
}

fn only_residuals() -> Vec<(Named, Cell)> {
    vec![(Named::default(ERROR), Cell::Text(Error::Residual.name().to_owned()))]
}

/// A limit in ″.
fn limit(given: &Spanned<Scalar>) -> Result<f64, Fault> {
    let limit = scalar::quantity("chart.limit", given, &[Dimension::Angle])?;
    if limit.value > 0.0 {
        return Ok(limit.value);
    }
    let message = format!("chart.limit = {limit}, and no error stays within that");
    Err(Fault::new(given.span(), message, "not above 0", "accepted: an angle above 0, or no limit"))
}
