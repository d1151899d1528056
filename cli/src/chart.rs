//! Charts of existing results with other keys: `sagnac report DIR --chart`.

use std::path::Path;

use clap::Args;
use sagnac::run::RESOLVED;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::table::Column;
use sagnac::tally::Share;
use sagnac::view::{incomplete, pictures, shown};
use sagnac_engine::chart::{Chart, Named};
use serde::Serialize;
use toml::{Table, Value};

use crate::arg_parsers::on;
use crate::failure::Failure;
use crate::look;
use crate::output::write_pictures;
use crate::output::{print, print_drawn};
use crate::progress::{self, How, Shown};
use crate::results::{self, held, is_chart_stem, summary};
use crate::run::checked;

/// A chart of the study with other keys.
#[derive(Debug, Args)]
#[group(skip)]
pub struct Redraw {
    /// Redraw a chart of the study with other keys, by its number [default with a key: 1]
    #[arg(help_heading = "Chart", long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..))]
    chart: Option<u16>,
    #[command(flatten)]
    keys: Keys,
    /// Name of the files of a redrawn chart in DIR, without extension
    #[arg(help_heading = "Chart", long, value_name = "NAME", default_value = "redrawn", value_parser = name)]
    name: String,
    /// Also show a redrawn chart in the terminal
    #[arg(help_heading = "Chart", long)]
    plot: bool,
}

impl Redraw {
    /// Whether a chart is asked for.
    pub fn is_asked(&self) -> bool {
        let keys = Table::try_from(&self.keys).unwrap_or_default();
        let is_given = |value: &Value| value.as_array().is_none_or(|list| !list.is_empty());
        self.chart.is_some() || !self.keys.rows.is_empty() || keys.values().any(is_given)
    }
}

/// The keys of a chart, as in studies.
#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Keys of the chart, as in [chart] of a study; \"none\" removes a key")]
struct Keys {
    /// Kind of a new chart that keeps no key of the study's chart: curves, heat-map or winner-map
    #[arg(long, value_name = "KIND")]
    kind: Option<String>,
    /// Table to draw: points, coefficients or trajectories
    #[arg(long, value_name = "TABLE")]
    table: Option<String>,
    /// Title above the chart
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Column of the horizontal axis
    #[arg(long, value_name = "COLUMN")]
    x: Option<String>,
    /// Column of the vertical axis; for curves it is the estimate, or several with the same unit, separated by commas
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    y: Vec<String>,
    /// Column shown by a map
    #[arg(long, value_name = "COLUMN")]
    z: Option<String>,
    /// Column whose values compete in a winner map
    #[arg(long, value_name = "COLUMN")]
    of: Option<String>,
    /// Columns that distinguish the curves, the first by colour and the second by dash
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    series: Vec<String>,
    /// Reference curves drawn with the curves
    #[arg(long, value_name = "CURVE", value_delimiter = ',')]
    references: Vec<String>,
    /// Only rows with this value, as in filler=const or frequency="20 Hz"; may be repeated
    #[arg(long = "where", value_name = "COLUMN=VALUE", value_parser = row)]
    #[serde(skip)]
    rows: Vec<(String, String)>,
    /// Allowed value of the estimate, as in "rms=5 arcsec"
    #[arg(long, value_name = "NAME=VALUE")]
    limit: Option<String>,
    /// Scale of the horizontal axis: log or linear
    #[arg(long, value_name = "SCALE")]
    x_scale: Option<String>,
    /// Scale of the vertical axis: log or linear
    #[arg(long, value_name = "SCALE")]
    y_scale: Option<String>,
    /// Scale of the colours of a heat map: log or linear
    #[arg(long, value_name = "SCALE")]
    z_scale: Option<String>,
}

/// The value that removes a key of the study's chart.
const NONE: &str = "none";

/// A file name that a run does not use for its own charts.
fn name(text: &str) -> Result<String, String> {
    match text {
        text if is_chart_stem(text) => Err("this name is reserved for charts of the study".to_owned()),
        text if text.is_empty() || text.contains(['/', '\\']) => {
            Err("expected a name without a folder".to_owned())
        }
        // Some file systems refuse them.
        text if text.contains([':', '*', '?', '"', '<', '>', '|']) || text.contains(char::is_control) => {
            Err("expected a name of letters, digits and the like".to_owned())
        }
        text => Ok(text.to_owned()),
    }
}

/// A column with a value.
pub fn row(text: &str) -> Result<(String, String), String> {
    let (column, value) = text.split_once('=').ok_or("expected COLUMN=VALUE, as in filler=const")?;
    Ok((column.trim().to_owned(), value.trim().to_owned()))
}

/// Redraws the results in a folder.
pub fn redraw(
    folder: &Path,
    asked: &Redraw,
    quiet: bool,
    progress: &progress::Options,
) -> Result<(), Failure> {
    let path = folder.join(RESOLVED);
    // Parsed as a study, so that errors in the file itself are reported as usual.
    let written = results::study(folder)?;
    let Redraw { name, plot, .. } = asked;
    let asked = changed(&written, asked)?;
    let study = Study::parse(&format!("{} with the requested chart", path.display()), &asked)?;
    let plan = checked(&study, progress.how(quiet), None)?;
    let results = Folder::open(folder)?;
    let store = held(&results, &plan)?;
    let tables = plan.tables(&store, &Shown::new(progress.how(quiet)))?;
    let lacking = plan.lacks(&store, Share::WHOLE)?;
    let drawn = pictures(&study, &tables, lacking)?;
    for drawn in &drawn {
        write_pictures(&results, name, &drawn.picture)?;
    }
    results.commit()?;
    // Said even where only errors are: the picture is not the one of the study.
    if let Some(sentence) = incomplete(lacking) {
        note!("{}: {sentence}", folder.display());
    }
    if quiet {
        return Ok(());
    }
    for note in drawn.iter().filter_map(|drawn| drawn.note.as_ref()) {
        note!("{note}");
    }
    for drawn in drawn.iter().filter(|_| *plot) {
        print_drawn(&format!("{}\n", drawn.picture.text(look::of_output())))?;
    }
    let curves = shown(&study, &tables)?;
    print(&summary(&study, &tables, &curves)?)?;
    say!("{name}.svg and .png are in {}", folder.display());
    Ok(())
}

/// The study with only the requested chart.
fn changed(written: &Study, asked: &Redraw) -> Result<String, Failure> {
    let unread = |error: toml::de::Error| Failure::Usage(format!("cannot read {RESOLVED}: {error}"));
    let mut study: Table = written.text().parse().map_err(unread)?;
    let charts = match study.remove("chart") {
        Some(Value::Array(charts)) => charts,
        Some(chart) => vec![chart],
        None => vec![],
    };
    let keys = &asked.keys;
    let number = usize::from(asked.chart.unwrap_or(1));
    let mut chart = match charts.get(number - 1) {
        _ if keys.kind.is_some() => Table::new(),
        Some(Value::Table(chart)) => chart.clone(),
        _ if charts.is_empty() && number <= written.charts.len() => supplied(&written.charts[number - 1]),
        _ if number == 1 => Table::new(),
        _ => {
            let charts = match charts.len() {
                0 => "no chart of its own".to_owned(),
                1 => "1 chart".to_owned(),
                count => format!("{count} charts"),
            };
            return Err(Failure::Usage(format!("--chart {number}: the study has {charts}")));
        }
    };
    // Another table has other columns, with other units.
    let own = chart.get("table").and_then(Value::as_str).unwrap_or("points").to_owned();
    if keys.table.as_ref().is_some_and(|table| *table != own) {
        chart.remove("limit");
        chart.remove("where");
    }
    let mut asked = Table::try_from(keys).map_err(|error| Failure::Usage(error.to_string()))?;
    if let Some(limit) = &keys.limit {
        let shown = ["z", "y"].into_iter().flat_map(|key| [asked.get(key), chart.get(key)]);
        let shown = shown.flatten().map(texts).find(|columns| !columns.is_empty());
        let columns = shown.unwrap_or_else(|| vec!["rms"]);
        let value = if limit == NONE { limit } else { on(limit, &columns)? };
        asked.insert("limit".to_owned(), Value::String(value.to_owned()));
    }
    for (key, value) in asked {
        let value = match value.as_array().map(Vec::as_slice) {
            Some([]) => continue,
            // One estimate is no list.
            Some([one]) if key == "y" => one.clone(),
            Some([first, ..]) if key != "y" && first.as_str() == Some(NONE) => first.clone(),
            _ => value,
        };
        set(&mut chart, &key, value);
    }
    if !keys.rows.is_empty() {
        let rows = chart.entry("where").or_insert_with(|| Value::Table(Table::new()));
        if let Some(rows) = rows.as_table_mut() {
            keys.rows.iter().for_each(|(column, value)| set(rows, column, scalar(value)));
        }
    }
    check_axes(&chart, written)?;
    study.insert("chart".to_owned(), Value::Table(chart));
    Ok(study.to_string())
}

/// The keys of a chart that a study without its own charts is supplied with.
fn supplied(chart: &Chart) -> Table {
    let names = |columns: &mut dyn Iterator<Item = &Named>| -> Value {
        let mut names: Vec<Value> = columns.map(|named| named.name.as_str().into()).collect();
        // A single one is no list.
        if names.len() == 1 { names.remove(0) } else { names.into() }
    };
    let x = ("x".to_owned(), Value::from(chart.x.name.as_str()));
    Table::from_iter([x, ("y".to_owned(), names(&mut chart.columns()))])
}

/// The text of a key, or its list of texts.
fn texts(value: &Value) -> Vec<&str> {
    match value {
        Value::Array(texts) => texts.iter().filter_map(Value::as_str).collect(),
        text => text.as_str().into_iter().collect(),
    }
}

/// Refuses a chart without axes, in terms of the options.
fn check_axes(chart: &Table, study: &Study) -> Result<(), Failure> {
    let lacks = |key: &str| !chart.contains_key(key);
    let is_map = chart.get("kind").and_then(Value::as_str).is_some_and(|kind| kind != "curves");
    let keys: Vec<&str> =
        ["x", "y", "z"].into_iter().filter(|key| (*key != "z" || is_map) && lacks(key)).collect();
    if keys.is_empty() {
        return Ok(());
    }
    let keys: Vec<String> = keys.into_iter().map(|key| format!("--{key}")).collect();
    let plan = checked(study, How::None, None)?;
    let columns: Vec<String> = plan.blank_tables().points.columns.iter().map(Column::header).collect();
    let swept = match &study.sweeps[..] {
        [] => "the study has no sweeps".to_owned(),
        sweeps => {
            let names: Vec<&str> = sweeps.iter().map(|sweep| sweep.key.name).collect();
            format!("the study sweeps {}", names.join(", "))
        }
    };
    let message =
        format!("the chart needs {}\n{swept}; its columns are {}", keys.join(" and "), columns.join(", "));
    Err(Failure::Usage(message))
}

/// Replaces a value; [`NONE`] removes the key.
fn set(table: &mut Table, key: &str, value: Value) {
    match value.as_str() {
        Some(NONE) => table.remove(key),
        _ => table.insert(key.to_owned(), value),
    };
}

/// A value as in a study: counts as numbers, everything else as text.
fn scalar(text: &str) -> Value {
    match text.parse::<i64>() {
        Ok(count) => Value::Integer(count),
        Err(_) => text.parse::<f64>().map_or_else(|_| Value::String(text.to_owned()), Value::Float),
    }
}
