//! The columns of a study of a suspension, with a row for each point.

use crate::kinds::suspension::Point;
use sagnac_base::table::{ColumnOf, Role, Unit, Usual};

/// The columns except the swept keys, in the order of the file.
#[rustfmt::skip]
pub(crate) fn columns() -> Vec<ColumnOf<Point>> {
    type Of = ColumnOf<Point>;
    vec![
        Of::new("response", Unit::ARCSEC_PER_S_PER_G, "rate per acceleration", |point| point.response().amplitude().into())
            .is(Role::Estimate, "Rate of the gyro per acceleration of the base, ″/s per g.")
            .usual(Usual::Estimate),
        Of::new("phase", Unit::DEG, "phase of the rate", |point| point.response().phase_deg().into())
            .is(Role::Estimate, "Phase of the rate relative to the acceleration, °; negative where the rate lags."),
        Of::new("normalized", Unit::NONE, "response relative to the useful mode", |point| {
            (point.response().amplitude() / point.suspension.useful()).into()
        })
        .is(Role::Estimate, "`response` divided by the response at the first mode."),
    ]
}
