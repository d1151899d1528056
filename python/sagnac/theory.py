"""Closed forms over arrays: errors of gap fillers, drift of a switched gyro, relock, Allan deviation, suspension.

All numeric arguments may be arrays and are broadcast against each other; for numbers alone the result is a number.
Where a formula has no solution, or an argument is NaN, the result is NaN.

Angles are in ″, rates in ″/s, which is the same number in °/h, times in s, frequencies in Hz. Z(n) and A(n) are equations
of the two papers on the Zeeman gyro and on Allan variance; functions that end in ``as_published`` keep the errors of
the published version.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

import _sagnac

from .errors import UsageError

__all__ = [
    "DriftBound",
    "DriftOptimum",
    "MagneticDrift",
    "RelockTicks",
    "RunDrift",
    "allan_deviation",
    "drift_bound",
    "drift_from_detuning",
    "drift_from_frequency",
    "drift_of_runs",
    "drift_optimum",
    "gap_error",
    "magnetic_drift",
    "noise_of_const",
    "relock_ticks",
    "sampled_allan_deviation",
    "suspension_response",
    "taylor_term_as_published",
]

#: A float for numbers, an array for arrays.
Values: TypeAlias = Any
Numbers = NDArray[np.float64]

#: Longest gap and farthest tick for which weights are exact.
MAX_TICKS = 128


def _broadcast(*values: ArrayLike) -> tuple[list[Numbers], Callable[[NDArray[Any]], Values]]:
    """The values as flat arrays of equal length, and a function that gives a flat result their shape."""
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in values))
    shape = arrays[0].shape

    def shaped(flat: NDArray[Any]) -> Values:
        return flat.reshape(shape) if shape else flat[0].item()

    return [np.ascontiguousarray(array).reshape(-1) for array in arrays], shaped


def gap_error(
    kind: Literal["const", "linear", "quadratic"],
    gap_ticks: int,
    frequency: ArrayLike,
    *,
    amplitude: ArrayLike,
    tick: ArrayLike,
    error: Literal["residual", "extrapolation"] = "residual",
    ticks: Sequence[int] | None = None,
) -> Values:
    """Largest error of a filler over the phase of a vibration, ″; the rms error is 1/√2 of it — Z(18).

    A_Ω T sinc νT |Σ w e^{iωt} − Σ_gap e^{iωt}|, for a vibration of one frequency, without noise: with noise of σ on each tick
    the rms is √(D²/2 + σ² Σw²), where √Σw² is ``noise_gain`` of :func:`sagnac.filler`.

    Parameters
    ----------
    kind, gap_ticks
        The polynomial, and the number n of lost ticks, 1 to 64.
    frequency, amplitude, tick
        ν, Hz; the amplitude A_Ω of the rate, ″/s; T, s.
    error, ticks
        ``residual``, fitted by default to the ticks −1, 0, n + 1, n + 2, or ``extrapolation``, to −3 … 0; ticks lie within ±128.

    Examples
    --------
    >>> import numpy as np
    >>> np.round(gap_error("quadratic", 3, [10.0, 20.0], amplitude=12000.0, tick=0.005), 3)
    array([ 1.948, 26.848])
    """
    orders = {"const": 0, "linear": 1, "quadratic": 2}
    if kind not in orders:
        raise UsageError(f'kind="{kind}" is not known\naccepted: {", ".join(orders)}; for other fillers sagnac.filler gives the response')
    if error not in ("residual", "extrapolation"):
        raise UsageError(f'error="{error}" is not known\naccepted: residual, extrapolation')
    if not 1 <= gap_ticks <= 64:
        raise UsageError(f"gap_ticks={gap_ticks}\naccepted: 1 to 64")
    if ticks is None:
        ticks = [-1, 0, gap_ticks + 1, gap_ticks + 2] if error == "residual" else [-3, -2, -1, 0]
    if any(abs(place) > MAX_TICKS or 1 <= place <= gap_ticks for place in ticks):
        raise UsageError(f"ticks={list(ticks)}\naccepted: within ±{MAX_TICKS}, and not the lost ones 1 to {gap_ticks}")
    numerators, denominator = _sagnac.polynomial(list(ticks), orders[kind], gap_ticks)
    arrays, shaped = _broadcast(frequency, tick, amplitude)
    response = _sagnac.gap_response(list(ticks), numerators, denominator, gap_ticks, arrays[:2])
    return shaped(response * arrays[2])


def taylor_term_as_published(order: int, dt_nu: ArrayLike, *, at: Literal["extremum", "zero crossing"]) -> Values:
    """The first term that a Taylor polynomial of this order omits, as a fraction of A_Ω — Z(20).

    With x = 2πΔt·ν: x³/6 at a zero crossing of the rate for orders 1 and 2; at an extremum x²/2 up to order 1, x⁴/24 for order
    2. Multiplied by A_Ω·T, it is the error of a single tick, not of the angle over the gap. NaN for other orders.

    >>> round(12000 * 0.005 * taylor_term_as_published(1, 0.1, at="extremum"), 1)
    11.8
    """
    if at not in ("extremum", "zero crossing"):
        raise UsageError(f'at="{at}" is not known\naccepted: "extremum", "zero crossing"')
    arrays, shaped = _broadcast(dt_nu)
    return shaped(_sagnac.taylor(_small(order), at == "extremum", arrays))


def noise_of_const(sigma: ArrayLike, gap_ticks: ArrayLike, *, ticks: int = 4, as_published: bool = False) -> Values:
    """Noise of the angle over a gap that is filled with a constant: σ n/√ticks, n times the mean of ``ticks`` ticks.

    ``as_published`` gives σ √n/2, which is too small by √n: the filled values share one mean, so their errors add up.

    >>> noise_of_const(1.6, 3), round(noise_of_const(1.6, 3, as_published=True), 4)
    (2.4000000000000004, 1.3856)
    """
    sigmas, counts = np.asarray(sigma, dtype=np.float64), np.asarray(gap_ticks, dtype=np.float64)
    noise = sigmas * np.sqrt(counts) / 2.0 if as_published else sigmas * counts / np.sqrt(float(ticks))
    return noise if noise.ndim else noise.item()


class MagneticDrift(NamedTuple):
    """The magnetic drift of a gyro that switches modes."""

    rate: Values
    """Ω_m at the time t, ″/s."""
    angle: Values
    """Its remaining angle after a run of length t, ″."""


def magnetic_drift(
    time: ArrayLike,
    interval: ArrayLike,
    *,
    magnetic: ArrayLike,
    warm_up_time: ArrayLike,
    initial_magnetic: ArrayLike = 0.0,
) -> MagneticDrift:
    """Ω_m = A (1 − e^{−t/τ}) + Ω_m0, which grows as the gyro warms up, and its angle if every switch changes its sign — Z(5).

    ``time`` t and the ``interval`` MT between switches in s; ``magnetic`` A, ″/s; ``warm_up_time`` τ, s; ``initial_magnetic`` Ω_m0, ″/s.

    >>> round(magnetic_drift(3600.0, 40.0, magnetic=14.0, warm_up_time=3000.0).angle / 3600 + 0.05, 4)
    -0.0044
    """
    arrays, shaped = _broadcast(time, interval, magnetic, warm_up_time, initial_magnetic)
    return MagneticDrift(*map(shaped, _sagnac.magnetic_drift(arrays)))


class DriftBound(NamedTuple):
    """The paper's bound of the drift and its parts, ″/s."""

    total: Values
    non_magnetic: Values
    quasi_non_magnetic: Values
    """The remainder of two opposite intervals because of the warm-up."""
    magnetic: Values
    """The part of an interval that no other one cancels."""
    residual: Values
    """The errors at the switches, all with the same sign."""


def drift_bound(
    interval: ArrayLike,
    run: ArrayLike,
    *,
    magnetic: ArrayLike,
    warm_up_time: ArrayLike,
    residual_max: ArrayLike,
    initial_magnetic: ArrayLike = 0.0,
    non_magnetic: ArrayLike = 0.0,
) -> DriftBound:
    """The bound of the mean drift over a run — Z(7), with corrected sign and limit of Z(6).

    Ω_nm + Aτ/(2MT) (1 − e^{−MT/τ})² + MT·Ω_m(t)/t + δP_max/MT, each part as its magnitude. ``interval`` MT and ``run`` t in s,
    ``residual_max`` δP_max in ″, ``non_magnetic`` Ω_nm in ″/s, the others as for :func:`magnetic_drift`.

    >>> round(drift_bound(40.0, 3600.0, magnetic=14.0, warm_up_time=3000.0, residual_max=10.0, non_magnetic=0.05).total, 4)
    0.5008
    """
    values = (interval, run, magnetic, warm_up_time, initial_magnetic, non_magnetic, residual_max)
    arrays, shaped = _broadcast(*values)
    return DriftBound(*map(shaped, _sagnac.drift_bound(arrays)))


class DriftOptimum(NamedTuple):
    """Intervals between switches with the least bound, s; NaN where there is none."""

    interval: Values
    """The exact minimum within the run."""
    bound: Values
    """The bound at the exact minimum, ″/s."""
    expanded: Values
    """Root of Z(8) to the first order in MT/τ, the correct form of Z(9)."""
    as_published: Values
    """The smaller root of Z(9) as printed."""
    limit: Values
    """√(δP_max/(A/2τ + Ω_m/t)), for slow warm-up."""
    limit_as_published: Values
    """√(δP_max t/Ω_m)."""


def drift_optimum(
    run: ArrayLike,
    *,
    magnetic: ArrayLike,
    warm_up_time: ArrayLike,
    residual_max: ArrayLike,
    initial_magnetic: ArrayLike = 0.0,
    non_magnetic: ArrayLike = 0.0,
) -> DriftOptimum:
    """The interval between switches that minimizes :func:`drift_bound`, and approximations of it — Z(8), Z(9).

    >>> best = drift_optimum([600.0, 3600.0], magnetic=14.0, warm_up_time=3000.0, residual_max=10.0, non_magnetic=0.05)
    >>> best.interval.round(2), best.as_published.round(2)
    (array([39.22, 44.8 ]), array([48.84, 61.2 ]))
    """
    arrays, shaped = _broadcast(run, magnetic, warm_up_time, initial_magnetic, non_magnetic, residual_max)
    return DriftOptimum(*map(shaped, _sagnac.drift_optimum(arrays)))


class RunDrift(NamedTuple):
    """The mean drift of whole runs, ″/s."""

    mean: Values
    deviation: Values
    """Its standard deviation if switches occur at random phases of the motion, so that errors add up as √n."""
    deviation_in_phase: Values
    """Its standard deviation if all switches occur at one phase, so that errors add up as n."""
    best_interval: Values
    """The interval of the least rms drift at random phases, s, among even numbers of intervals; NaN where there is none. It does not
    depend on ``interval``."""
    least_rms: Values
    """The rms drift at that interval, without the non-magnetic drift."""


def drift_of_runs(
    interval: ArrayLike,
    run: ArrayLike,
    *,
    magnetic: ArrayLike,
    warm_up_time: ArrayLike,
    residual_rms: ArrayLike,
    initial_magnetic: ArrayLike = 0.0,
    non_magnetic: ArrayLike = 0.0,
    first_mode: Literal["positive", "negative"] = "positive",
) -> RunDrift:
    """The statistics of the drift of whole runs, as opposed to its bound; ``residual_rms`` is the rms error at a switch, ″.

    >>> found = drift_of_runs(40.0, 3600.0, magnetic=14.0, warm_up_time=3000.0, residual_rms=7.07, non_magnetic=0.05)
    >>> round(found.mean, 4), round(found.deviation, 4), round(found.best_interval, 1)
    (-0.0044, 0.0185, 15.6)
    """
    if first_mode not in ("positive", "negative"):
        raise UsageError(f'first_mode="{first_mode}" is not known\naccepted: positive, negative')
    values = (interval, run, magnetic, warm_up_time, initial_magnetic, non_magnetic, residual_rms)
    arrays, shaped = _broadcast(*values)
    return RunDrift(*map(shaped, _sagnac.drift_of_runs(first_mode == "positive", arrays)))


class RelockTicks(NamedTuple):
    """The ticks after a mode switch."""

    apparent_drift: Values
    """ΔΩ_i, the apparent rotation caused by the loop, in the unit of f0 — Z(11)."""
    bias_error: Values
    """Error of the bias, y_i = f_i − f0."""
    detuning_plus: Values
    detuning_minus: Values
    """Mean detunings over the halves of the tick, h⁺ and h⁻, as fractions of the wavelength — Z(12)."""


def relock_ticks(
    tick_number: ArrayLike,
    *,
    tick: ArrayLike,
    loop_time: ArrayLike,
    bias: ArrayLike,
    curvature: ArrayLike,
    miss: ArrayLike,
) -> RelockTicks:
    """The effect of the path-length control loop while it removes the detuning after a mode switch — Z(2), Z(10)–Z(12).

    Parameters
    ----------
    tick_number
        i, counted from 1, the first tick after the loop closes.
    tick, loop_time
        T and τ_L, s.
    bias, curvature
        f0, in ″/s as Hz × pulse weight, and χ of f = f0 (1 − χΔλ²).
    miss
        Δλ0, as a fraction of the wavelength.

    Notes
    -----
    Signs are for the negative half-period first. The printed Z(11) lacks χ, and the printed Z(12) has other exponents for i > 1.

    >>> found = relock_ticks([1, 2], tick=0.005, loop_time=0.012, bias=2e5, curvature=40.0, miss=0.059)
    >>> found.apparent_drift.round(1)
    array([3880.3, 1686.4])
    """
    arrays, shaped = _broadcast(tick_number, tick, loop_time, bias, curvature, miss)
    return RelockTicks(*map(shaped, _sagnac.relock_ticks(arrays)))


def drift_from_frequency(first: ArrayLike, error: ArrayLike, tick_number: ArrayLike) -> Values:
    """ΔΩ_i from the frequency of the bias: −y_i (1 − q)/(1 + q) with q = (y_i/y_1)^{1/2(i−1)}, i ≥ 2.

    ``first`` is y_1, ``error`` y_i. The result is NaN where they are not negative or do not decay.

    >>> round(drift_from_frequency(-4000.0, -1000.0, 2), 3)
    333.333
    """
    arrays, shaped = _broadcast(first, error, tick_number)
    return shaped(_sagnac.drift_from_frequency(arrays))


def drift_from_detuning(bias: ArrayLike, curvature: ArrayLike, plus: ArrayLike, minus: ArrayLike) -> Values:
    """ΔΩ_i from the mean detunings of the halves of a tick, Z(13) in Z(11): χ f0 h⁺² (−ln r)(1 + r)²/4 with r = h⁻/h⁺.

    The result is NaN where r is not between 0 and 1.

    >>> ticks = relock_ticks(1, tick=0.005, loop_time=0.012, bias=2e5, curvature=40.0, miss=0.059)
    >>> round(drift_from_detuning(2e5, 40.0, ticks.detuning_plus, ticks.detuning_minus) / ticks.apparent_drift, 9)
    1.0
    """
    arrays, shaped = _broadcast(bias, curvature, plus, minus)
    return shaped(_sagnac.drift_from_detuning(arrays))


class _Noise(NamedTuple):
    q: float
    n: float
    b: float
    k: float
    r: float
    markov: tuple[float, float] | None
    sine: tuple[float, float] | None


def _noise(
    quantization: float,
    angle_random_walk: float,
    bias_instability: float,
    rate_random_walk: float,
    rate_ramp: float,
    markov: tuple[float, float] | None,
    sine: tuple[float, float] | None,
) -> _Noise:
    """Converts from the units of data sheets to ″ and s."""
    return _Noise(
        quantization, 60.0 * angle_random_walk, bias_instability, rate_random_walk / 60.0, rate_ramp / 3600.0, markov, sine
    )


def allan_deviation(
    tau: ArrayLike,
    *,
    quantization: float = 0.0,
    angle_random_walk: float = 0.0,
    bias_instability: float = 0.0,
    rate_random_walk: float = 0.0,
    rate_ramp: float = 0.0,
    markov: tuple[float, float] | None = None,
    sine: tuple[float, float] | None = None,
) -> Values:
    """Allan deviation of continuous noise, °/h — A(4).

    The root of 3Q²/τ² + N²/τ + (2 ln2/π)B² + K²τ/3 + R²τ²/2, with exponentially correlated noise and a sine. Definitions are
    those of IEEE Std 952 and 647. Sampled records differ at short τ: see :func:`sampled_allan_deviation`.

    Parameters
    ----------
    tau
        Averaging times, s.
    quantization, angle_random_walk, bias_instability, rate_random_walk, rate_ramp
        Q, ″ rms; N, °/√h; B, °/h; K, °/h/√h; R, °/h/h.
    markov
        rms rate, °/h, and correlation time, s.
    sine
        Amplitude, °/h, and frequency, Hz.

    Examples
    --------
    >>> import numpy as np
    >>> lgv1 = {"quantization": 0.11, "angle_random_walk": 0.00048, "bias_instability": 0.00164}
    >>> np.round(allan_deviation([1.0, 100.0], **lgv1), 4)
    array([0.1927, 0.0036])
    """
    noise = _noise(quantization, angle_random_walk, bias_instability, rate_random_walk, rate_ramp, markov, sine)
    arrays, shaped = _broadcast(tau)
    return shaped(np.sqrt(_sagnac.allan_variance(noise, arrays)))


def sampled_allan_deviation(
    m: ArrayLike,
    *,
    sample: float,
    samples: int,
    estimator: Literal["overlapping", "non-overlapping", "hadamard"] = "overlapping",
    quantization: float = 0.0,
    angle_random_walk: float = 0.0,
    bias_instability: float = 0.0,
    rate_random_walk: float = 0.0,
    rate_ramp: float = 0.0,
    markov: tuple[float, float] | None = None,
    sine: tuple[float, float] | None = None,
) -> Values:
    """Root of the mean of an estimator over records of sampled noise, °/h: the closed form of studies and the basis of fits.

    ``m`` are averaging factors, τ in samples; ``sample`` is the time between samples, s; ``samples`` is their number in a record, up
    to 2**27. The noise is that of :func:`allan_deviation`. The result is NaN where the record has no difference at m.

    >>> round(sampled_allan_deviation(1, sample=1.0, samples=1000, rate_random_walk=60.0) ** 2, 3)      # not 1/3
    0.5
    """
    if not (np.isfinite(sample) and sample > 0.0):
        raise UsageError(f"sample={sample}\naccepted: the time between samples, s")
    noise = _noise(quantization, angle_random_walk, bias_instability, rate_random_walk, rate_ramp, markov, sine)
    arrays, shaped = _broadcast(m)
    return shaped(np.sqrt(_sagnac.sampled_variance(noise, estimator, sample, _small(samples), arrays)))


def suspension_response(
    frequency: ArrayLike, suspension: str | Sequence[tuple[float, float, float]] = "LGK-400"
) -> Values:
    """Rate of the block on its suspension per acceleration of its base, ″/s per g, as complex numbers.

    H(f) = Σ g_i/(1 − (f/f_i)² + j f/(f_i Q_i)); the real part is in phase with the acceleration. ``suspension`` is ``LGK-400`` or
    ``LGV-1``, whose frequencies are published and whose **Q factors and responses are assumed**, or a list of modes, each with its
    frequency, Hz, its Q factor and its response at resonance, ″/s per g.

    >>> round(abs(suspension_response(380.0, [(380.0, 100.0, 20000.0)])))
    20000
    """
    if isinstance(suspension, str):
        modes = _sagnac.suspension_modes(suspension)
        if modes is None:
            raise UsageError(f'suspension="{suspension}" is not known\naccepted: LGK-400, LGV-1, or modes')
    else:
        modes = [(float(natural), float(q), float(response)) for natural, q, response in suspension]
    if not modes:
        raise UsageError("the suspension has no modes\ngive at least one, as (380.0, 100.0, 20000.0)")
    arrays, shaped = _broadcast(frequency)
    found = np.empty(len(arrays[0]), dtype=np.complex128)
    found.real, found.imag = _sagnac.suspension_response(modes, arrays)
    return shaped(found)


def _small(count: int) -> int:
    if not 0 <= count <= 1 << 62:
        raise UsageError(f"{count} is not a count")
    return int(count)
