//! The axes of a chart for pages, with the ticks of all parts that may be enlarged, for either scale.

use serde::Serialize;

use crate::key::scale::Scale;
use crate::view::chart::figure::{Axis, Figure};
use crate::view::chart::map::Estimate;
use crate::view::chart::picture::Picture;
use crate::view::chart::scale::Range;
use crate::view::chart::ticks::Ladder;

/// The axes of a picture.
#[derive(Serialize)]
pub(crate) struct Axes {
    x: Either<Ladder>,
    y: Either<Ladder>,
    /// Axis z of a map.
    z: Option<Either<Ladder>>,
    /// The edges of the cells of a map along x and y, where they can be shown.
    edges: Option<[Either<Vec<f64>>; 2]>,
}

/// Data for a logarithmic and for a linear axis.
#[derive(Serialize)]
struct Either<T> {
    log: T,
    linear: T,
}

impl<T> Either<T> {
    fn of(of: impl Fn(Scale) -> T) -> Either<T> {
        Either { log: of(Scale::Log), linear: of(Scale::Linear) }
    }
}

impl Axes {
    pub(crate) fn of(picture: &Picture) -> Axes {
        match picture {
            Picture::Curves(figure) => of_curves(figure),
            Picture::Map(map) => {
                let interval = |(value, band): &Estimate| {
                    let (low, high) = band.unwrap_or((*value, *value));
                    [*value, low, high]
                };
                let known = map.layers.iter().flat_map(|layer| &layer.values).flatten();
                let limit = map.limit.iter().map(|limit| limit.value);
                let zs: Vec<f64> = known.flat_map(interval).chain(limit).collect();
                Axes {
                    x: ladders(&map.x, &map.columns),
                    y: ladders(&map.y, &map.rows),
                    z: Some(ladders(&map.z, &zs)),
                    edges: Some([edges(&map.columns), edges(&map.rows)]),
                }
            }
        }
    }
}

fn of_curves(figure: &Figure) -> Axes {
    let laws = || figure.series.iter().flat_map(|series| &series.law).copied().chain(figure.law_places());
    let bands = figure.all_points().filter_map(|point| point.band).flat_map(|(low, high)| [low, high]);
    let limit = figure.limit.iter().map(|limit| limit.value);
    let xs: Vec<f64> = figure.all_points().map(|point| point.x).chain(laws().map(|place| place.0)).collect();
    let ys = figure.all_points().map(|point| point.y).chain(laws().map(|place| place.1));
    let ys: Vec<f64> = ys.chain(bands).chain(limit).collect();
    Axes { x: ladders(&figure.x, &xs), y: ladders(&figure.y, &ys), z: None, edges: None }
}

fn ladders(axis: &Axis, values: &[f64]) -> Either<Ladder> {
    Either::of(|scale| axis.ladder(Range::around(scale, values.iter().copied())))
}

fn edges(values: &[f64]) -> Either<Vec<f64>> {
    Either::of(|scale| {
        let shown: Vec<f64> = values.iter().copied().filter(|value| scale.shows(*value)).collect();
        let Range { low, high, .. } = Range::around(scale, []);
        if shown.is_empty() { vec![low, high] } else { scale.edges(&shown) }
    })
}
