//! The response of a suspension at a point.

use crate::kinds::suspension::Point as SuspensionPoint;
use crate::run::column;
use crate::table::{Cell, Column, Unit};

pub(crate) fn columns() -> Vec<Column> {
    vec![
        column("response", "rate per acceleration", Unit::ARCSEC_PER_S_PER_G),
        column("phase", "phase of the rate", Unit::DEG),
        column("normalised", "response by that of the useful mode", Unit::NONE),
    ]
}

pub(crate) fn row(point: &SuspensionPoint) -> Vec<Cell> {
    let response = point.suspension.response(point.frequency_hz);
    let normalised = response.amplitude() / point.suspension.useful();
    [response.amplitude(), response.phase_deg(), normalised].map(|x| Some(x).into()).to_vec()
}
