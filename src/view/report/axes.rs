//! The axes of a chart for pages, with the ticks of all parts that may be enlarged, for either scale.

use serde::Serialize;

use crate::key::scale::Scale;
use crate::view::chart::figure::{Axis, Figure};
use crate::view::chart::map::{Estimate, Map};
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
            Picture::Map(map) => of_map(map),
        }
    }
}

fn of_curves(figure: &Figure) -> Axes {
    let (mut xs, mut ys) = (vec![], vec![]);
    for point in figure.series.iter().flat_map(|series| &series.points) {
        xs.push(point.x);
        ys.push(point.y);
        ys.extend(point.band.into_iter().flat_map(|(low, high)| [low, high]));
    }
    for (x, y) in
        figure.law_places().chain(figure.series.iter().flat_map(|series| series.law.iter().copied()))
    {
        xs.push(x);
        ys.push(y);
    }
    ys.extend(figure.limit.as_ref().map(|limit| limit.value));
    Axes { x: ladders(&figure.x, &xs), y: ladders(&figure.y, &ys), z: None, edges: None }
}

fn of_map(map: &Map) -> Axes {
    let known = map.layers.iter().flat_map(|layer| &layer.values).flatten();
    let values = |(value, band): &Estimate| {
        let (low, high) = band.unwrap_or((*value, *value));
        [*value, low, high]
    };
    let mut zs: Vec<f64> = known.flat_map(values).collect();
    zs.extend(map.limit.as_ref().map(|limit| limit.value));
    Axes {
        x: ladders(&map.x, &map.columns),
        y: ladders(&map.y, &map.rows),
        z: Some(ladders(&map.z, &zs)),
        edges: Some([edges(&map.columns), edges(&map.rows)]),
    }
}

fn ladders(axis: &Axis, values: &[f64]) -> Either<Ladder> {
    Either::of(|scale| Range::around(scale, values.iter().copied()).ladder(axis.whole))
}

fn edges(values: &[f64]) -> Either<Vec<f64>> {
    Either::of(|scale| {
        let shown: Vec<f64> = values.iter().copied().filter(|value| scale.shows(*value)).collect();
        let Range { low, high, .. } = Range::around(scale, []);
        if shown.is_empty() { vec![low, high] } else { scale.edges(&shown) }
    })
}
