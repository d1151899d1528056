//! Parts of the charts that kinds supply to studies which ask for none.

use crate::chart::ground::Ground;
use crate::chart::rows::FILLER;
use crate::chart::{Chart, Named, Shows, scale_over, usual_rows};
use crate::key::scale::Scale;
use crate::key::sweep::Sweep;
use crate::table::Cell;

impl Chart {
    /// Curves of the points of a study.
    pub(crate) fn curves(x: &str, y: &str, series: Vec<Named>) -> Chart {
        let shows = Shows::Curves { series, laws: vec![] };
        Chart { x: x.into(), y: y.into(), shows, ..Chart::default() }
    }
}

/// The column `y` over the first swept key that is no name, a curve for each value of the next two.
pub(crate) fn over_first_number(sweeps: &[Sweep], ground: &Ground, y: &str) -> Option<Chart> {
    let x = sweeps.iter().find(|sweep| !sweep.key.is_name())?;
    let others: Vec<&Sweep> = sweeps.iter().filter(|sweep| sweep.key.name != x.key.name).collect();
    let series = others.iter().take(2).map(|sweep| Named::default(sweep.key.name)).collect();
    Some(Chart {
        rows: others.iter().skip(2).filter_map(|sweep| at_first(sweep)).collect(),
        x_scale: scale_over(x.key.name, sweeps, ground),
        ..Chart::curves(x.key.name, y, series)
    })
}

/// The row at the first value of a sweep: a curve runs along one key, and others stay where they are.
pub(crate) fn at_first(sweep: &Sweep) -> Option<(Named, Cell)> {
    Some((Named::default(sweep.key.name), sweep.values.first()?.cell()))
}

/// The fillers side by side where no number is swept, by two estimates, for each value of the first name that is.
pub(crate) fn side_by_side(sweeps: &[Sweep], ground: &Ground, [first, second]: [&str; 2]) -> Chart {
    let name = sweeps.first().map(|sweep| Named::default(sweep.key.name));
    Chart {
        beside: vec![Named::default(second)],
        rows: sweeps.iter().skip(1).filter_map(at_first).chain(usual_rows(ground)).collect(),
        x_scale: Scale::Linear,
        y_scale: Scale::Log,
        ..Chart::curves(FILLER, first, name.into_iter().collect())
    }
}
