"""Deviations and noise coefficients of recorded data."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

import _sagnac

from ._reading import Record, limits_of, reading_of
from .errors import UsageError
from .logs import Kind
from .noise import Allan, Coefficient, Curve, Fit, Minimum
from .results import answer_of
from .studies import _whole

Deviation = Literal[
    "adev", "oadev", "mdev", "tdev", "hdev", "ohdev", "totdev", "mtotdev", "theo1", "theoh", "pdev", "mtie"
]

#: Least number of simulated records with usable 2.5 % quantiles.
MIN_REALIZATIONS = 200


def allan(
    data: Record,
    rate: float | None = None,
    *,
    unit: str | None = None,
    kind: Kind | None = None,
    deviation: Deviation | Sequence[Deviation] = ("oadev",),
    taus: str | ArrayLike = "octave",
    confidence: float = 0.95,
    intervals: Literal["record", "stable32"] = "record",
    limits: Mapping[str, str | float] | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Allan:
    """Deviations of a record with intervals and noise types, as computed by ``sagnac allan``.

    Parameters
    ----------
    data
        One axis: evenly spaced samples in one dimension, NaN for missing ones. A contiguous array of float64 is not copied; the
        angles computed from it take the same amount of memory. Do not write to it during the call. Or a :class:`Log` of one
        column, which has its own rate, unit and kind, or the path of a file, which :func:`read_log` reads.
    rate
        Samples per second; of a file by default that of its time stamps.
    unit
        ``deg/h``, ``deg/s``, ``rad/s``, ``arcsec``, … of gyros, ``m/s^2``, ``g``, ``mg``, ``m/s``, … of accelerometers, in accordance
        with ``kind``; pulses by their size, ``0.5 arcsec/pulse``; ``none`` for plain numbers. Of a file by default that of
        its header.
    kind
        ``rate``: the mean angular rate or acceleration over each sample; ``increment``: the angle turned or the velocity gained in
        it; ``angle``: the angle, phase or velocity since some start. The unit tells rotation from acceleration. By default ``rate``,
        or of a file what its header says.
    deviation
        One or more of ``adev``, ``oadev``, ``mdev``, ``tdev``, ``hdev``, ``ohdev``, ``totdev``, ``mtotdev``, ``theo1``,
        ``theoh``, ``pdev``, ``mtie``.
    taus
        ``octave``, ``decade10``, ``decade20``, ``all`` (of at most 200,000 samples), or seconds, each rounded to a whole
        number of samples.
    confidence
        Probability of the intervals.
    intervals
        Noise that the intervals suppose: that of the record as a whole, or with ``stable32`` the power law of each averaging time.
    limits
        Largest accepted in-run bias stability, which :attr:`Allan.limits` has with what the record shows: ``{"in_run_bias_stability": "0.01 deg/h"}``.
    detrend
        Removes a straight line from the rate.
    remove_outliers
        Treats samples more than 8 standard deviations from the median of their neighbours as missing.
    unit_check
        Warns of samples that seem to be in another unit: degrees taken for radians, means above 20 °/s or 2 g, and accelerations
        whose mean would be that of gravity in another unit.
    threads
        Threads; by default all logical cores. The curves have the same bits for any number.

    Notes
    -----
    Definitions are those of NIST SP 1065 and IEEE Std 952; a rate in °/h is the same number in ″/s. The noise is identified by its
    lag-1 autocorrelation. Intervals are those of χ² with the degrees of freedom of the noise of the record as a whole. Terms that
    touch a gap are omitted.

    Raises
    ------
    RecordError
        There are fewer than 16 samples, all are equal, some are infinite, or the unit is wrong.
    UsageError
        An argument is not accepted, or the record is too short for an averaging time.

    Examples
    --------
    >>> rates = np.random.default_rng(1).normal(0.0, 1.0, 10_000)
    >>> curve = allan(rates, 100.0, unit="deg/h")["oadev"]
    >>> curve.tau[:3], np.round(curve.value[:3], 2), curve.alpha[0]
    (array([0.01, 0.02, 0.04]), array([1.  , 0.71, 0.5 ]), np.float64(0.0))
    """
    record, reading, _ = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads)
    names = [deviation] if isinstance(deviation, str) else list(deviation)
    if not 0.0 < confidence < 1.0:
        raise UsageError(f"confidence={confidence}\naccepted: between 0 and 1, as in 0.95")
    found = _sagnac.curves(record, reading, names, times_of(taus), confidence, intervals, limits_of(limits))
    curves = {}
    for raw in found["curves"]:
        least = raw["minimum"]
        curves[raw["deviation"]] = Curve(
            deviation=raw["deviation"],
            unit=raw["unit"],
            m=raw["m"],
            tau=raw["tau"],
            differences=raw["differences"],
            value=raw["value"],
            lower=raw["lower"],
            upper=raw["upper"],
            alpha=raw["alpha"],
            alpha_carried=raw["alpha_carried"],
            edf=raw["edf"],
            minimum=None if least is None else Minimum(*least),
        )
    return Allan(
        curves=curves,
        answer=answer_of(found["answer"]),
        notes=tuple(found["notes"]),
        missing=found["missing"],
        mean_rate=found["mean_rate"],
        limits=json.loads(found["limits"]),
        removed_slope_per_s=found["removed_slope_per_s"],
        outliers=found["outliers"],
        outlier_threshold=found["outlier_threshold"],
        events=json.loads(found["events"]),
    )


def fit(
    data: Record,
    rate: float | None = None,
    *,
    unit: str | None = None,
    kind: Kind | None = None,
    terms: Literal["auto"] | Sequence[str] = "auto",
    fit_from: float | None = None,
    fit_to: float | None = None,
    force: bool = False,
    bootstrap: int | None = None,
    limits: Mapping[str, str | float] | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Fit:
    """Noise coefficients of a record with 95 % intervals and a verdict for each, as computed by ``sagnac allan``.

    Parameters
    ----------
    data, rate, unit, kind, detrend, remove_outliers, unit_check, threads
        As for :func:`allan`. ``detrend`` also removes the rate ramp R and makes K too low.
    terms
        ``auto`` for those of Q, N, B, K, R that the record supports, or a list of Q, N, B, K, R, ``markov``, ``sine``.
    fit_from, fit_to
        Shortest and longest averaging time of the fit, s. By default it starts at the shortest from which the terms describe the
        curve, and ends at an eighth of the record.
    force
        Takes the coefficients of the best fit even where it does not describe the curve; their verdict stays ``model rejected``.
    bootstrap
        Number of simulated records of the fit, from which test inversion gives the intervals: at least 200, or 0 for intervals
        in closed form. The default is 1000, or 0 for more than 2 million samples; :attr:`Fit.without_bootstrap` says so then.
    limits
        Largest accepted coefficients, which :attr:`Fit.limits` has with what the record shows: ``{"N": "0.003 deg/sqrt(h)"}``. A limit is met
        if the upper end of the 95 % interval, or the bound, is within it, and not met if the lower end is above it.

    Notes
    -----
    Least squares on the overlapping Allan variances at the octaves of τ up to an eighth of the record, with the
    covariance between them; each term is that of sampled noise. The fit takes the octaves that the terms describe; if they
    describe none, all coefficients are ``model rejected`` and have no value. Otherwise a value is given if it is estimable, else a
    bound.
    Intervals are those of a record without gaps.

    Ctrl-C takes effect when the fit is done, within some seconds unless a ``bootstrap`` simulates long records.

    Raises
    ------
    RecordError, UsageError
        As for :func:`allan`; or the noise of the record cannot be identified.

    Examples
    --------
    >>> rates = np.random.default_rng(1).normal(0.0, 1.0, 10_000)       # white: N = 1/sqrt(100) arcsec/sqrt(s)
    >>> found = fit(rates, 100.0, unit="deg/h", bootstrap=0)
    >>> [name for name, coefficient in found.items() if coefficient.is_estimated]
    ['N']
    >>> found["N"].unit, found["N"].lower < 0.1 / 60 < found["N"].upper
    ('deg/sqrt(h)', True)
    >>> found["B"].value is None, found["B"].status
    (True, 'not estimable, at most the upper limit')
    """
    record, reading, _ = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads)
    if bootstrap is not None and bootstrap != 0:
        bootstrap = _whole("bootstrap", bootstrap, MIN_REALIZATIONS, 1 << 20)
    if isinstance(terms, str) and terms != "auto":
        raise UsageError(f'terms="{terms}"\naccepted: "auto", or a list such as ["Q", "N", "B"]')
    found = _sagnac.fit(
        record,
        reading,
        None if terms == "auto" else list(terms),
        (fit_from, fit_to),
        force,
        bootstrap,
        limits_of(limits),
    )
    return Fit(
        coefficients={row[0]: Coefficient(*row) for row in found["rows"]},
        answer=answer_of(found["answer"]),
        limits=json.loads(found["limits"]),
        described=found["described"],
        fit_from=found["range"][0],
        fit_to=found["range"][1],
        intervals=found["intervals"],
        without_bootstrap=found["without_bootstrap"],
        chi_squared=found["chi_squared"],
        degrees_of_freedom=found["degrees_of_freedom"],
        p_value=found["p_value"],
        tau=found["tau"],
        unit=found["unit"],
        deviation=found["deviation"],
        fitted=found["fitted"],
        marks={name: (tau, deviation) for name, tau, deviation in found["marks"]},
        notes=tuple(found["notes"]),
        missing=found["missing"],
        mean_rate=found["mean_rate"],
        removed_slope_per_s=found["removed_slope_per_s"],
        outliers=found["outliers"],
        events=json.loads(found["events"]),
    )


def times_of(taus: str | ArrayLike) -> str | list[float]:
    """Averaging times as the native part takes them."""
    return taus if isinstance(taus, str) else [float(tau) for tau in np.atleast_1d(np.asarray(taus))]
