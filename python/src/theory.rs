//! Closed forms over arrays: each function takes arrays of equal length and returns arrays of that length.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sagnac::theory::allan::Estimator;
use sagnac::theory::allan::Part;
use sagnac::theory::allan::Process;
use sagnac::theory::allan::flicker;
use sagnac::theory::drift::budget::{Budget, limit_as_published};
use sagnac::theory::drift::{Ending, Magnetic, Spread};
use sagnac::theory::gap::{Weights, polynomial_weights, sine_response, tick_amplitude};
use sagnac::theory::relock::{self, Relock};
use sagnac::theory::vibration::{Mode, Suspension};
use sagnac::theory::{allan, gap};

use super::compute::compute;
use super::failure::Failure;
use super::record::side_by_side;

type Numbers<'py> = PyReadonlyArray1<'py, f64>;
type Column<'py> = Bound<'py, PyArray1<f64>>;

/// Applies `of` at every index of `arrays`: M results from N values.
fn over<'py, const N: usize, const M: usize>(
    py: Python<'py>,
    arrays: &[Numbers<'py>; N],
    of: impl Fn([f64; N]) -> [f64; M] + Send + Sync,
) -> PyResult<[Column<'py>; M]> {
    // Another Python thread may write to the arrays while this one computes without Python's lock.
    let mut samples = [(); N].map(|()| Vec::new());
    for (samples, array) in samples.iter_mut().zip(arrays) {
        *samples = side_by_side(array)?.to_vec();
    }
    let columns = compute(py, || {
        let length = samples.iter().map(Vec::len).min().unwrap_or(0);
        let mut columns = [(); M].map(|()| Vec::with_capacity(length));
        for place in 0..length {
            for (column, value) in
                columns.iter_mut().zip(of(samples.each_ref().map(|samples| samples[place])))
            {
                column.push(value);
            }
        }
        Ok(columns)
    })?;
    Ok(columns.map(|column| PyArray1::from_vec(py, column)))
}

/// Applies `of` at every index of `arrays`: one result from N values.
fn each<'py, const N: usize>(
    py: Python<'py>,
    arrays: &[Numbers<'py>; N],
    of: impl Fn([f64; N]) -> f64 + Send + Sync,
) -> PyResult<Column<'py>> {
    let [column] = over(py, arrays, |values| [of(values)])?;
    Ok(column)
}

fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

/// Numerators and denominator of a polynomial's weights.
#[pyfunction]
fn polynomial(ticks: Vec<i32>, order: usize, gap_ticks: u32) -> PyResult<(Vec<i64>, i64)> {
    let weights = polynomial_weights(&ticks, order, gap_ticks).ok_or_else(|| {
        Failure::Usage(format!(
            "the ticks {ticks:?} do not determine a polynomial of order {order}\ngive at least {} different ones",
            order + 1
        ))
    })?;
    Ok((weights.numerators, weights.denominator))
}

/// Amplitude of the error of given weights, ″ per ″/s: arrays of ν and T.
#[pyfunction]
fn gap_response<'py>(
    py: Python<'py>,
    ticks: Vec<i32>,
    numerators: Vec<i64>,
    denominator: i64,
    gap_ticks: u32,
    arrays: [Numbers<'py>; 2],
) -> PyResult<Column<'py>> {
    let weights = Weights { ticks, numerators, denominator };
    each(py, &arrays, |[frequency_hz, tick_s]| {
        let nu_t = frequency_hz * tick_s;
        let (a, b) = sine_response(&weights, gap_ticks, nu_t);
        tick_amplitude(tick_s, nu_t).abs() * libm::hypot(a, b)
    })
}

/// Terms of Z(20) as a share of the rate amplitude: an array of Δt·ν.
#[pyfunction]
fn taylor<'py>(
    py: Python<'py>,
    order: usize,
    at_extremum: bool,
    arrays: [Numbers<'py>; 1],
) -> PyResult<Column<'py>> {
    let law = match at_extremum {
        true => gap::taylor_extremum_as_published,
        false => gap::taylor_zero_crossing_as_published,
    };
    each(py, &arrays, |[dt_nu]| or_nan(law(order, dt_nu)))
}

/// A of Ω_m, τ, Ω_m0.
fn magnetic([amplitude, time_s, initial]: [f64; 3]) -> Magnetic {
    Magnetic { amplitude, time_s, initial }
}

/// Ω_m and its remaining angle after a run of intervals: arrays of t, MT, A, τ, Ω_m0.
#[pyfunction]
fn magnetic_drift<'py>(py: Python<'py>, arrays: [Numbers<'py>; 5]) -> PyResult<[Column<'py>; 2]> {
    over(py, &arrays, |[t, interval, a, tau, initial]| {
        let drift = magnetic([a, tau, initial]);
        [drift.rate(t), drift.signed_integral(interval, t)]
    })
}

/// The parts of Z(7): arrays of MT, t, A, τ, Ω_m0, Ω_nm, δP_max.
#[pyfunction]
fn drift_bound<'py>(py: Python<'py>, arrays: [Numbers<'py>; 7]) -> PyResult<[Column<'py>; 5]> {
    over(py, &arrays, |[interval, t, a, tau, initial, non_magnetic, residual_max]| {
        let budget = Budget { magnetic: magnetic([a, tau, initial]), non_magnetic, residual_max };
        let bound = budget.bound(interval, t);
        [bound.total(), bound.non_magnetic, bound.quasi_non_magnetic, bound.magnetic, bound.residual]
    })
}

/// Interval of the least bound, exact, expanded and as published, and its limits: arrays of t, A, τ, Ω_m0, Ω_nm,
/// δP_max.
#[pyfunction]
fn drift_optimum<'py>(py: Python<'py>, arrays: [Numbers<'py>; 6]) -> PyResult<[Column<'py>; 6]> {
    over(py, &arrays, |[t, a, tau, initial, non_magnetic, residual_max]| {
        let budget = Budget { magnetic: magnetic([a, tau, initial]), non_magnetic, residual_max };
        let exact = budget.optimum(t);
        [
            exact.map(|best| best.interval_s),
            exact.map(|best| best.bound),
            budget.optimum_expanded(t),
            budget.optimum_as_published(t),
            budget.limit(t),
            limit_as_published(&budget, t),
        ]
        .map(or_nan)
    })
}

/// Mean drift by the sign of the first mode, its deviation for random phases and in phase, and the best interval with
/// its rms drift: arrays of MT, t, A, τ, Ω_m0, Ω_nm, σ_δP.
#[pyfunction]
fn drift_of_runs<'py>(
    py: Python<'py>,
    first_positive: bool,
    arrays: [Numbers<'py>; 7],
) -> PyResult<[Column<'py>; 5]> {
    over(py, &arrays, |[interval, t, a, tau, initial, non_magnetic, residual_rms]| {
        let spread = Spread { magnetic: magnetic([a, tau, initial]), non_magnetic, residual_rms };
        [
            spread.mean(interval, t, first_positive),
            spread.deviation(interval, t),
            spread.deviation_in_phase(interval, t),
            or_nan(spread.best_interval(t, Ending::Even)),
            or_nan(spread.least_rms(t, Ending::Even)),
        ]
    })
}

/// The number of a tick as an integer from 1; `None` for others, which have no relock.
fn tick_number(tick: f64) -> Option<u32> {
    (tick >= 1.0 && tick <= f64::from(u16::MAX) && tick == tick.trunc()).then_some(tick as u32)
}

/// Apparent drift, error of the bias, and mean detunings of the halves: arrays of i, T, τ_L, f0, χ, Δλ0.
#[pyfunction]
fn relock_ticks<'py>(py: Python<'py>, arrays: [Numbers<'py>; 6]) -> PyResult<[Column<'py>; 4]> {
    over(py, &arrays, |[tick, tick_s, loop_s, bias, curvature, miss]| {
        let relock = Relock { tick_s, loop_s, bias, curvature, miss };
        tick_number(tick).map_or([f64::NAN; 4], |tick| {
            let [plus, minus] = relock.detuning_means(tick);
            [relock.apparent_drift(tick), relock.bias_error(tick), plus, minus]
        })
    })
}

/// ΔΩ_i from frequency: arrays of y_1, y_i, i.
#[pyfunction]
fn drift_from_frequency<'py>(py: Python<'py>, arrays: [Numbers<'py>; 3]) -> PyResult<Column<'py>> {
    each(py, &arrays, |[first, error, tick]| {
        or_nan(tick_number(tick).and_then(|tick| relock::drift_from_frequency(first, error, tick)))
    })
}

/// ΔΩ_i from detuning: arrays of f0, χ, h⁺, h⁻.
#[pyfunction]
fn drift_from_detuning<'py>(py: Python<'py>, arrays: [Numbers<'py>; 4]) -> PyResult<Column<'py>> {
    each(py, &arrays, |[bias, curvature, plus, minus]| {
        or_nan(relock::drift_from_detuning(bias, curvature, [plus, minus]))
    })
}

/// Noise in ″ and s; terms that are 0 are absent.
#[derive(FromPyObject)]
struct Noise {
    q: f64,
    n: f64,
    b: f64,
    k: f64,
    r: f64,
    /// rms rate and correlation time.
    markov: Option<(f64, f64)>,
    /// Amplitude and frequency.
    sine: Option<(f64, f64)>,
}

impl Noise {
    fn parts(&self, octaves: usize) -> Vec<Part> {
        let Noise { q, n, b, k, r, markov, sine } = *self;
        let mut parts = vec![
            Part::quantization(q),
            Part::angle_random_walk(n),
            Part::bias_instability(b, octaves),
            Part::rate_random_walk(k),
            Part::rate_ramp(r),
        ];
        parts.extend(markov.map(|(rms, time_s)| Part::markov(rms * (2.0 / time_s).sqrt(), time_s)));
        parts.extend(sine.map(|(amplitude, frequency_hz)| Part::sine(amplitude, frequency_hz)));
        parts
    }
}

/// Allan variance of continuous noise, A(4): an array of τ.
#[pyfunction]
fn allan_variance<'py>(py: Python<'py>, noise: Noise, arrays: [Numbers<'py>; 1]) -> PyResult<Column<'py>> {
    let parts = noise.parts(flicker::OCTAVES);
    each(py, &arrays, |[tau]| parts.iter().filter_map(|part| allan::continuous_variance(part, tau)).sum())
}

/// Mean of an estimator over records of sampled noise: an array of m.
#[pyfunction]
fn sampled_variance<'py>(
    py: Python<'py>,
    noise: Noise,
    estimator: &str,
    sample_s: f64,
    samples: u64,
    arrays: [Numbers<'py>; 1],
) -> PyResult<Column<'py>> {
    let estimator = match estimator {
        "overlapping" => Estimator::OVERLAPPING,
        "non-overlapping" => Estimator::NON_OVERLAPPING,
        "hadamard" => Estimator::HADAMARD,
        other => {
            let accepted = "accepted: \"overlapping\", \"non-overlapping\", \"hadamard\"";
            return Err(Failure::Usage(format!("estimator=\"{other}\" is not known\n{accepted}")).into());
        }
    };
    let octaves = flicker::octaves(samples).ok_or_else(|| {
        Failure::Usage(format!(
            "a record of {samples} samples is too long\naccepted: up to {} samples",
            1_u64 << 27
        ))
    })?;
    let process = Process { sample_s, parts: noise.parts(octaves) };
    each(py, &arrays, |[m]| {
        let whole = (m >= 1.0 && m <= samples as f64 && m == m.trunc()).then_some(m as u64);
        or_nan(whole.and_then(|m| process.expected(estimator, samples, m)))
    })
}

/// Real and imaginary part of a suspension's response, ″/s per g: an array of f. Modes: frequency, Q, response.
#[pyfunction]
fn suspension_response<'py>(
    py: Python<'py>,
    modes: Vec<(f64, f64, f64)>,
    arrays: [Numbers<'py>; 1],
) -> PyResult<[Column<'py>; 2]> {
    let mode = |(frequency_hz, q, response)| Mode { frequency_hz, q, response };
    let suspension = Suspension::new(modes.into_iter().map(mode).collect());
    over(py, &arrays, |[frequency_hz]| {
        let response = suspension.response(frequency_hz);
        [response.re, response.im]
    })
}

/// The modes of a named suspension: frequency, Q, response.
#[pyfunction]
fn suspension_modes(name: &str) -> Option<Vec<(f64, f64, f64)>> {
    let suspension = Suspension::named(name)?;
    Some(suspension.modes().iter().map(|mode| (mode.frequency_hz, mode.q, mode.response)).collect())
}

/// Adds all functions to the module.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(polynomial, module)?)?;
    module.add_function(wrap_pyfunction!(gap_response, module)?)?;
    module.add_function(wrap_pyfunction!(taylor, module)?)?;
    module.add_function(wrap_pyfunction!(magnetic_drift, module)?)?;
    module.add_function(wrap_pyfunction!(drift_bound, module)?)?;
    module.add_function(wrap_pyfunction!(drift_optimum, module)?)?;
    module.add_function(wrap_pyfunction!(drift_of_runs, module)?)?;
    module.add_function(wrap_pyfunction!(relock_ticks, module)?)?;
    module.add_function(wrap_pyfunction!(drift_from_frequency, module)?)?;
    module.add_function(wrap_pyfunction!(drift_from_detuning, module)?)?;
    module.add_function(wrap_pyfunction!(allan_variance, module)?)?;
    module.add_function(wrap_pyfunction!(sampled_variance, module)?)?;
    module.add_function(wrap_pyfunction!(suspension_response, module)?)?;
    module.add_function(wrap_pyfunction!(suspension_modes, module)?)
}
