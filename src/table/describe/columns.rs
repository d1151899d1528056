//! The texts.

use crate::table::describe::File;

type Columns = &'static [(&'static str, &'static str)];

pub(crate) fn of(file: File) -> Columns {
    match file {
        File::Points(kind) if kind.name == "gap-fill" => GAP_FILL,
        File::Points(kind) if kind.name == "allan" => ALLAN,
        File::Points(kind) if kind.name == "relock" => RELOCK,
        File::Points(kind) if kind.name == "switched-run" => SWITCHED_RUN,
        File::Points(kind) if kind.name == "drift-budget" => DRIFT_BUDGET,
        File::Points(_) => SUSPENSION,
        File::Coefficients => COEFFICIENTS,
        File::Trajectories => TRAJECTORIES,
        File::Design => DESIGN,
        File::LogCurve => LOG_CURVE,
        File::LogCoefficients => LOG_COEFFICIENTS,
        File::Compare => COMPARE,
        File::CompareCoefficients => COMPARE_COEFFICIENTS,
        File::Weights => WEIGHTS,
        File::TestVectors => TEST_VECTORS,
    }
}

const FILLER: &str = "Name of the gap filler, as in `switching.fillers`.";
const RMS_SE: &str =
    "Standard error (1 σ) of `rms`; 0 where every trial has the same error. The 95 % band is ±1.96 of these.";
const Q9973_LO: &str = "Lower end of the 95 % interval of `q9973`; blank where the trials cannot bound it.";
const Q9973_HI: &str = "Upper end of the 95 % interval of `q9973`; blank where the trials cannot bound it.";
const Z_RMS: &str = "How many standard errors `rms` is off `oracle_rms`: beyond ±5 something is wrong. Blank without a closed form.";

const GAP_FILL: Columns = &[
    (
        "dt_nu",
        "Δt·ν with Δt = (n+1)T/2, from the middle of the gap to the nearest valid sample; for one tone of fixed frequency, else blank.",
    ),
    (
        "amplitude_noise",
        "A_Ω·T/σ, the angle of a tick at the peak of the rate by its noise (1 σ); for one tone of fixed frequency and amplitude, else \
         blank.",
    ),
    ("filler", FILLER),
    (
        "error",
        "Which error: `residual`, left after the gap is closed and corrected; `extrapolation`, at its end before that; `in-gap`, the \
         largest while it is open.",
    ),
    ("trials", "How many trials the estimates of the row are from."),
    ("mean", "Mean error, ″, with its sign."),
    ("rms", "Root mean square error, ″, motion and noise together."),
    ("rms_se", RMS_SE),
    ("max", "The largest error seen, ″, of any sign; the noise reaches 6.3 standard deviations."),
    ("q9973", "The level, ″, that 99.73 % of errors stay below in magnitude, 3 σ of a Gaussian."),
    ("q9973_lo", Q9973_LO),
    ("q9973_hi", Q9973_HI),
    ("oracle_rms", "`rms` in closed form, ″, for the values as computed with; blank where there is none."),
    (
        "oracle_max",
        "The largest error of the motion in closed form, ″, without noise; of one tone of fixed amplitude.",
    ),
    ("z", Z_RMS),
    ("law_taylor_extremum", TAYLOR_EXTREMUM),
    ("law_taylor_zero_crossing", TAYLOR_ZERO),
    ("law_noise_as_published", NOISE_PUBLISHED),
    ("law_noise", NOISE),
];

const TAYLOR_EXTREMUM: &str = "A law of the chart, ″: the first Taylor term that the filler drops at an extremum of the rate, of a \
    single tick as published in Z(20).";
const TAYLOR_ZERO: &str = "A law of the chart, ″: the first Taylor term that the filler drops near a zero crossing of the rate, of a \
    single tick as published in Z(20).";
const NOISE_PUBLISHED: &str =
    "A law of the chart, ″: 3 σ of the constant filler as published, which grows as √n with the lost ticks.";
const NOISE: &str = "A law of the chart, ″: 3 σ of the constant filler as it should be by Z(18), which grows as n with the lost ticks.";

const ALLAN: Columns = &[
    ("tau", "Averaging time τ, s."),
    ("m", "Averaging time in samples."),
    ("terms", "Differences that one record gives at this averaging time."),
    ("trials", "Records that the estimates of the row are from."),
    ("mean_avar", "Mean Allan (or Hadamard) variance over the records, (°/h)²."),
    ("mean_avar_se", "Standard error (1 σ) of `mean_avar`, (°/h)²."),
    (
        "lo",
        "95 % of single records have a variance above this and below `hi`, (°/h)²; blank of fewer than 40 records.",
    ),
    (
        "hi",
        "95 % of single records have a variance below this and above `lo`, (°/h)²; blank of fewer than 40 records.",
    ),
    ("oracle_avar", "The variance in closed form for the noise as sampled, (°/h)²."),
    (
        "z",
        "How many standard errors `mean_avar` is off `oracle_avar`: beyond ±5 something is wrong. Of 40 records and more.",
    ),
    ("adev", "Allan (or Hadamard) deviation, the root of `mean_avar`, °/h."),
    ("adev_lo", "95 % of single records have a deviation above this and below `adev_hi`, °/h."),
    ("adev_hi", "95 % of single records have a deviation below this and above `adev_lo`, °/h."),
    ("oracle_adev", "The root of `oracle_avar`, °/h."),
];

const COEFFICIENTS: Columns = &[
    (
        "coefficient",
        "Which one: Q, N, B, K, R of data sheets, `markov`, `markov_time`, `sine`, `sine_frequency`.",
    ),
    ("unit", "Unit of `truth`, `mean`, `sd` and `rmse`."),
    ("truth", "The coefficient that the study gives the gyro."),
    ("mean", "Mean of the estimates, over records that show the coefficient."),
    ("sd", "Standard deviation of the estimates from record to record."),
    ("rmse", "Root mean square of estimate less truth."),
    (
        "coverage95",
        "Part of the 95 % intervals, bounds included, that hold the truth: 0.95 where they are right.",
    ),
    (
        "relative_rmse",
        "`rmse` by `truth`: 0.1 is 10 %. Blank where fewer than half of the records show the coefficient: those would be the ones in \
         which it came out too large.",
    ),
    ("identified", "Part of the records that show the coefficient, 0 to 1."),
    ("trials", "Records."),
    ("verdict", "What the records say of the coefficient, in words."),
];

const RELOCK: Columns = &[
    ("compensation", "`none`, `frequency` or `detuning`: which compensation of the paper is taken off."),
    ("tick", "Which tick after the switch, `1`, `2`, …, or `all` for their sum."),
    ("tick_number", "The same as a number, for charts over ticks; blank for all together."),
    ("trials", "How many switches the estimates of the row are from."),
    ("mean", "Mean of the faked angle less its compensation, ″, with its sign."),
    ("rms", "Root mean square of the faked angle less its compensation, ″."),
    ("rms_se", RMS_SE),
    ("max", "The largest angle left that was seen, ″, of any sign."),
    ("q9973", "The level, ″, that 99.73 % of what is left stays below in magnitude."),
    ("q9973_lo", Q9973_LO),
    ("q9973_hi", Q9973_HI),
    (
        "oracle_mean",
        "`mean` in closed form, ″: uncompensated, the first tick by frequency, and by detuning without noise and steps.",
    ),
    ("oracle_rms", "`rms` in closed form, ″, where there is one."),
    ("z", Z_RMS),
    ("drift", "ΔΩ_i, the rate that the loop fakes in this tick for the miss as asked, ″/s, Z(11)."),
    ("bias", "f, the bias frequency at the start of the tick for the miss as asked, Hz, Z(2)."),
    ("bias_error", "y_i, the error of the bias frequency in the tick for the miss as asked, Hz, Z(10)."),
    (
        "detuning",
        "Δλ, the detuning at the start of the tick for the miss as asked, parts of the wavelength, Z(12).",
    ),
    ("detuning_plus", "h_i⁺, the mean detuning of the first half of the tick, parts of the wavelength."),
    ("detuning_minus", "h_i⁻, the mean detuning of the second half of the tick, parts of the wavelength."),
    (
        "signal",
        "A_I, the signal of the detuning at the start of the tick, in the unit of `relock.signal_gain`, Z(1).",
    ),
    ("law_zeeman_tables", "A law of the chart, ″: tables 1 and 2 of the paper, measured and compensated."),
];

const SWITCHED_RUN: Columns = &[
    ("filler", FILLER),
    (
        "angle",
        "Which angle: `end` of the run, `largest` (just before or after a switch or at the end), `at 600 s`.",
    ),
    ("time", "When the angle is read, s; blank of the largest."),
    ("switches", "Switches before the time of the row."),
    ("residual_rms", "What one switch leaves, with its relock, ″ rms."),
    ("trials", "Runs that the estimates of the row are from."),
    ("mean", "Mean error of the angle, ″, with its sign."),
    ("rms", "Root mean square error of the angle, ″."),
    ("rms_se", RMS_SE),
    ("max", "The largest error of the angle seen, ″, of any sign."),
    ("q9973", "The level, ″, that 99.73 % of runs stay below in magnitude."),
    ("q9973_lo", Q9973_LO),
    ("q9973_hi", Q9973_HI),
    ("drift_mean", "`mean` over the time, °/h; blank of the largest."),
    ("drift_rms", "`rms` over the time, °/h; blank of the largest."),
    ("drift_q9973", "`q9973` over the time, °/h: 99.73 % of runs drift by less. Blank of the largest."),
    ("drift_q9973_lo", "Lower end of the 95 % interval of `drift_q9973`, °/h."),
    ("drift_q9973_hi", "Upper end of the 95 % interval of `drift_q9973`, °/h."),
    ("oracle_mean", "`mean` in closed form, ″; none of the largest."),
    ("oracle_rms", "`rms` in closed form, ″; none of the largest."),
    ("oracle_drift_mean", "`drift_mean` in closed form, °/h."),
    ("oracle_drift_rms", "`drift_rms` in closed form, °/h."),
    ("z_mean", "How many standard errors `mean` is off `oracle_mean`: beyond ±5 something is wrong."),
    ("z", Z_RMS),
];

const TRAJECTORIES: Columns = &[
    ("filler", FILLER),
    ("run", "Number of the run, from 1: the first of those sampled."),
    ("time", "Time in the run, s."),
    ("error", "Error of the angle at that time, ″."),
];

const DRIFT_BUDGET: Columns = &[
    ("bound", "The paper's bound on the drift of the run, ″/s, Z(7): the sum of its four parts."),
    ("bound_non_magnetic", "The non-magnetic part of `bound`, ″/s."),
    (
        "bound_quasi_non_magnetic",
        "The quasi-non-magnetic part of `bound`, ″/s: what the warm-up leaves of a pair of modes, Z(6).",
    ),
    ("bound_magnetic", "The magnetic part of `bound`, ″/s: an odd interval without its partner."),
    ("bound_residual", "The part of `bound` from residuals of switches, ″/s."),
    ("switches", "Switches within the run."),
    ("mean_drift", "What a run really adds up, ″/s, with the magnetic drift positive in the first mode."),
    ("mean_drift_negative", "The same with the magnetic drift negative in the first mode, ″/s."),
    (
        "magnetic_angle",
        "The angle that the magnetic drift leaves of the run, ″, signed, the first mode positive.",
    ),
    ("switching_drift", "Magnitude of `mean_drift` without the non-magnetic drift, ″/s."),
    (
        "rms_drift",
        "Root mean square drift, ″/s, with residuals of δP_max/√2 at switches of random phase, which add up as √n.",
    ),
    ("rms_drift_in_phase", "The same with residuals of one phase, which add up as n, ″/s."),
    (
        "rms_switching",
        "`rms_drift` without the non-magnetic drift, ″/s: what the choice of the interval decides.",
    ),
    ("optimum", "The interval of the least bound, s: the root of Z(8)."),
    ("optimum_bound", "The bound there, ″/s."),
    ("optimum_as_published", "The smaller root of Z(9) as printed, s; blank where it has none."),
    ("optimum_expanded", "The root of the equation that Z(9) should be, s."),
    ("optimum_limit", "√(δP_max t/Ω_m) as printed, s; blank without residuals."),
    (
        "optimum_limit_small",
        "The limit for a small A or a large τ that it should be, s; blank without residuals.",
    ),
    ("optimum_true", "The interval of the least `rms_switching` among even counts of intervals, s."),
    ("optimum_true_rms", "`rms_switching` at that interval, ″/s."),
];

const SUSPENSION: Columns = &[
    ("response", "Rate of the gyro per acceleration of the base, ″/s per g."),
    ("phase", "Phase of the rate behind the acceleration, °."),
    ("normalised", "`response` by that at the first mode."),
];

const DESIGN: Columns = &[
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

const LOG_CURVE: Columns = &[
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

const LOG_COEFFICIENTS: Columns = &[
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

const COMPARE: Columns = &[
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

const COMPARE_COEFFICIENTS: Columns = &[
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

const WEIGHTS: Columns = &[
    ("filler", FILLER),
    (
        "error",
        "`extrapolation`: the weights deliver E_j while the gap is open; `residual`: they give I_j once the ticks after it are known.",
    ),
    ("row", "The lost tick that the weights give, from 1, or `sum`, all of them together."),
    ("tick", "The valid tick that is weighted: up to 0 before the gap, from n+1 on behind it."),
    ("numerator", "The weight as a whole number over `denominator`."),
    ("denominator", "Common denominator of a filler's weights."),
    ("weight", "The weight as a number."),
];

const TEST_VECTORS: Columns = &[
    ("filler", FILLER),
    ("P[…]", "Angle of this valid tick, a whole number of units: an input."),
    (
        "E[…]",
        "What is delivered in place of this lost tick while the gap is open; blank where the filler has no extrapolation.",
    ),
    ("I[…]", "What the filler makes of this lost tick once the ticks after the gap are known."),
    ("sum_E", "Sum of all E."),
    ("sum_I", "Sum of all I."),
    ("dP", "ΔP, the correction once the gap is closed, as `sagnac_correction` of the C header gives it."),
];
