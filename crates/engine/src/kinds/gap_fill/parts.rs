//! The parts of the error of a filler.

use std::sync::Arc;

use crate::kinds::gap_fill::inputs::{Inputs, TickNoise};
use crate::kinds::gap_fill::point::Point;
use crate::motion::Motion;
use crate::study::{self, Part};

/// All parts, each of which adds to the ticks.
pub(crate) static PARTS: [Part<Inputs>; 4] = [
    Part { name: "motion", off: rest },
    Part { name: "noise of the ticks", off: |inputs| inputs.tick_noise = TickNoise::Std(0.0) },
    Part { name: "whole pulses of the readout", off: |inputs| inputs.readout_lsb = 0.0 },
    Part { name: "angles of the relock", off: |inputs| inputs.relock.clear() },
];

/// Takes away the motion, and that of the specification.
fn rest(inputs: &mut Inputs) {
    inputs.motion = Motion::default();
    inputs.specification = inputs.specification.take().map(|_| Arc::default());
}

/// A point as it is, and without each of its parts in turn; its fillers keep their weights.
pub(crate) fn dissected(point: &Point) -> (Vec<&'static str>, Vec<Point>) {
    let (names, inputs) = study::points(&point.inputs, &PARTS);
    let design = point.design.clone().or_else(|| Some(Box::new(point.inputs.clone())));
    let of = |inputs: Inputs| Point { inputs, design: design.clone(), ..point.clone() };
    (names, inputs.into_iter().map(of).collect())
}
