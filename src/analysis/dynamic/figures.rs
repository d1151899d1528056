//! The maps of `sagnac allan --dynamic`.

use sagnac_base::quantity::number::significant;
use sagnac_engine::key::sweep::Scale;
use sagnac_records::allan::{Deviation, Point};
use sagnac_report::chart::figure::Axis;
use sagnac_report::chart::map::{Cells, Estimate, Layer, Map};

use crate::analysis::dynamic::words::sentence;
use crate::analysis::dynamic::{Column, Dynamic};

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
