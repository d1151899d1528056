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

pub(crate) const LOG_CURVE: Texts = &[
    ("column", "Column of the log that the row is about."),
    ("deviation", "Which deviation: `adev`, `oadev`, `mdev`, `tdev`, `hdev`, `ohdev`."),
    ("m", "Averaging time in samples."),
    ("tau", "Averaging time τ, s."),
    ("terms", "Differences that the value is from."),
    (
        "alpha",
        "α of the noise that the interval supposes, from a spectral density of the rate as f^α: 2 quantisation, 1 flicker of the angle, \
         0 angle random walk, -1 bias instability, -2 rate random walk.",
    ),
    ("lower", "Lower end of the 95 % interval of `value`."),
    ("value", "The deviation, in `unit`."),
    ("upper", "Upper end of the 95 % interval of `value`."),
    ("unit", "Unit of `value`, `lower` and `upper`."),
    (
        "alpha_from",
        "`identified` at this τ, or `carried` from a shorter one, as where there are fewer than 30 groups.",
    ),
    ("treatment", "What was done to the record: skipped, cut, a line removed, outliers removed."),
];

pub(crate) const LOG_COEFFICIENTS: Texts = &[
    ("column", "Column of the log that the row is about."),
    (
        "coefficient",
        "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`, and `in_run_stability`, the minimum of the \
         curve, with its `in_run_stability_tau`.",
    ),
    ("value", "The coefficient in `unit`; blank where the record does not show it."),
    ("lower", "Lower end of the 95 % interval."),
    ("upper", "Upper end of the 95 % interval; without a `value` the coefficient is at most this."),
    ("unit", "Unit of `value`, `lower` and `upper`."),
    ("verdict", "Whether the record identifies the coefficient, in words."),
    (
        "intervals",
        "How the intervals were found: by bootstrap or in closed form; of the minimum, those of the curve.",
    ),
];

pub(crate) const COMPARE: Texts = &[
    ("tau", "Averaging time τ, s."),
    ("m_a", "The same in samples of A."),
    ("m_b", "The same in samples of B."),
    ("a", "Overlapping Allan deviation of A, in `unit`."),
    ("b", "Overlapping Allan deviation of B, in `unit`."),
    ("ratio", "B over A."),
    ("lower", "Lower end of the 95 % interval of `ratio`."),
    ("upper", "Upper end of the 95 % interval of `ratio`."),
    ("unit", "Unit of `a` and `b`."),
    ("p", "How often a ratio as far from 1 comes by chance where both have the same noise."),
    ("verdict", "`B higher`, `B lower` or `not told apart`, at 95 %."),
];

pub(crate) const COMPARE_COEFFICIENTS: Texts = &[
    ("coefficient", "Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`."),
    ("unit", "Unit of `a`, `b` and `difference`."),
    ("a", "The coefficient of A; blank where its record does not show it."),
    ("b", "The coefficient of B; blank where its record does not show it."),
    ("difference", "B less A."),
    ("lower", "Lower end of the 95 % interval of `difference`."),
    ("upper", "Upper end of the 95 % interval of `difference`."),
    ("p", "How often as large a difference comes by chance where both have the same coefficient."),
    ("length_needed", "Length of records, s, that tells such values apart in 9 of 10 cases."),
    ("verdict", "`B higher`, `B lower`, `not told apart`, `equal` or `in neither record`."),
    ("ratio", "B over A."),
    ("ratio_lower", "Lower end of the 95 % interval of `ratio`."),
    ("ratio_upper", "Upper end of the 95 % interval of `ratio`."),
    ("a_at_most", "The coefficient of A is at most this, where its record does not show it."),
    ("b_at_most", "The coefficient of B is at most this, where its record does not show it."),
    ("length_beyond", "Length of records, s, up to which none was found that would tell such values apart."),
];
