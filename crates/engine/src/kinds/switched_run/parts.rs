//! The parts of the error of a run.

use crate::drift::Drift;
use crate::kinds::gap_fill;
use crate::kinds::switched_run::point::Point;
use crate::study::{self, Part};

/// The parts of the drift.
static OF_DRIFT: [Part<Drift>; 4] = [
    Part {
        name: "magnetic drift",
        off: |drift| {
            (drift.magnetic, drift.magnetic_spread) = (0.0, 0.0);
            (drift.initial_magnetic, drift.initial_magnetic_spread) = (0.0, 0.0);
        },
    },
    Part {
        name: "non-magnetic drift with its spread",
        off: |drift| (drift.non_magnetic, drift.non_magnetic_spread) = (0.0, 0.0),
    },
    Part { name: "angle random walk", off: |drift| drift.angle_random_walk = 0.0 },
    Part { name: "residuals of the switches", off: |drift| drift.residual_max = 0.0 },
];

/// The relock after each switch.
static OF_RELOCK: [Part<Point>; 1] = [Part { name: "relock", off: |point| point.relock = None }];

/// A point as it is, and without each of its parts in turn; its fillers keep their weights.
pub(crate) fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let designed = |point: &Point| Point {
        fill: point.fill.as_ref().map(|fill| gap_fill::parts::dissected(fill).1.swap_remove(0)),
        ..point.clone()
    };
    let point = designed(point);
    let (mut names, drifts) = study::points(&point.drift, &OF_DRIFT);
    let mut points: Vec<Point> = drifts.into_iter().map(|drift| Point { drift, ..point.clone() }).collect();
    if let Some(fill) = &point.fill {
        let (of_fill, fills) = gap_fill::parts::dissected(fill);
        names.extend(of_fill);
        points.extend(fills.into_iter().skip(1).map(|fill| Point { fill: Some(fill), ..point.clone() }));
    }
    let (of_relock, relocked) = study::points(&point, &OF_RELOCK);
    names.extend(of_relock);
    points.extend(relocked.into_iter().skip(1));
    (names, points)
}
