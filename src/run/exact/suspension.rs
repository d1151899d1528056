//! The response of a suspension at a point.

use super::super::column;
use crate::study::SuspensionPoint;
use crate::table::{Cell, Column, Unit};

pub(super) fn columns() -> Vec<Column> {
    vec![
        column("response", "rate per acceleration", Unit::ARCSEC_PER_S_PER_G),
        column("phase", "phase of the rate", Unit::DEG),
        column("normalised", "response by that of the useful mode", Unit::NONE),
    ]
}

pub(super) fn row(point: &SuspensionPoint) -> Vec<Cell> {
    let response = point.suspension.response(point.frequency_hz);
    let normalised = response.amplitude() / point.suspension.useful();
    [response.amplitude(), response.phase_deg(), normalised].map(|x| Some(x).into()).to_vec()
}
