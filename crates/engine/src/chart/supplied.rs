//! Default charts of studies that specify none.

use crate::chart::ground::Ground;
use crate::chart::rows::Known;
use crate::chart::{Chart, Named, Shows};
use crate::key::scale::Scale;
use crate::key::sweep::Sweep;
use sagnac_base::table::{Cell, Role, Usual};

/// A chart of the points that suits the sweeps: the default estimate over the abscissa of the table, over a coordinate
/// that follows from a swept key, or over the first swept key that is not a name, with a curve for each value of the
/// first two other columns. Without any abscissa, the compared values stand side by side. `None` where there is nothing
/// to draw over.
pub(crate) fn chart(sweeps: &[Sweep], ground: &Ground) -> Option<Chart> {
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
fn side_by_side(sweeps: &[Sweep], ground: &Ground, x: &str) -> Chart {
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
