//! The columns of the files of commands.

use crate::kinds::gap_fill::columns::FILLER;

type Texts = &'static [(&'static str, &'static str)];

pub(crate) const DESIGN: Texts = &[
    ("filler", FILLER),
    ("interval", "Switching interval that was tried, s."),
    ("switches", "Switches in a run with that interval."),
    ("drift_q9973", "99.73 % of runs drift by less with that interval, °/h, without the non-magnetic drift."),
    ("drift_q9973_lo", "Lower end of the 95 % interval of `drift_q9973`, °/h."),
    ("drift_q9973_hi", "Upper end of the 95 % interval of `drift_q9973`, °/h."),
    (
        "drift_rms",
        "Root mean square drift with that interval, °/h, without the non-magnetic drift (measure `drift_rms`).",
    ),
    ("drift_rms_lo", "Lower end of the 95 % interval of `drift_rms`, °/h."),
    ("drift_rms_hi", "Upper end of the 95 % interval of `drift_rms`, °/h."),
    (
        "largest_q9973",
        "99.73 % level of the largest angle of a run by its duration, °/h (measure `largest_q9973`).",
    ),
    ("largest_q9973_lo", "Lower end of the 95 % interval of `largest_q9973`, °/h."),
    ("largest_q9973_hi", "Upper end of the 95 % interval of `largest_q9973`, °/h."),
    (
        "largest_rms",
        "Root mean square of the largest angle of a run by its duration, °/h (measure `largest_rms`).",
    ),
    ("largest_rms_lo", "Lower end of the 95 % interval of `largest_rms`, °/h."),
    ("largest_rms_hi", "Upper end of the 95 % interval of `largest_rms`, °/h."),
    ("closed_form_rms", "Root mean square drift in closed form, °/h."),
];
