"""The whole analysis of a record, and its spectrum, as ``sagnac allan`` gives them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from numpy.typing import ArrayLike

import _sagnac

from ._reading import Record, curve_of, limits_of, reading_of, refuse_for_curve, refuse_interval
from .analyses import Analysis, _analysis, _terms
from .errors import UsageError
from .logs import Kind, effects_of
from .records import MIN_REALIZATIONS, Deviation, times_of
from .studies import _whole


#: What a curve takes of the arguments of :func:`analyze`.
CURVE_ARGUMENTS = ("data", "rate", "unit", "name", "terms", "fit_from", "fit_to", "force", "limits", "curve_interval")


@dataclass(frozen=True)
class _Whole:
    """What is asked for of a record."""

    deviations: list[str] = field(default_factory=lambda: ["oadev"])
    taus: str | list[float] = "octave"
    confidence: float = 0.95
    intervals: str = "record"
    is_fitted: bool = True
    terms: list[str] | None = None
    range: tuple[float | None, float | None] = (None, None)
    is_forced: bool = False
    bootstrap: int | None = None
    limits: list[str] = field(default_factory=list)
    has_spectrum: bool = True
    needs_spectrum: bool = False
    segment_s: float | None = None
    is_linear: bool = False
    effects: str = "auto"
    is_compensated: bool = False
    is_dynamic: bool = False
    window_s: float | None = None
    navigate_s: float | None = None
    position_limit: str | None = None


def analyze(
    data: Record,
    rate: float | None = None,
    *,
    unit: str | None = None,
    kind: Kind | None = None,
    name: str | None = None,
    deviation: Deviation | Sequence[Deviation] = ("oadev",),
    taus: str | ArrayLike = "octave",
    confidence: float = 0.95,
    intervals: Literal["record", "stable32"] = "record",
    terms: Literal["auto"] | Sequence[str] | None = "auto",
    fit_from: float | None = None,
    fit_to: float | None = None,
    force: bool = False,
    bootstrap: int | None = None,
    temperature_terms: Literal["auto"] | Sequence[str] = "auto",
    compensate: bool = False,
    dynamic: bool | float = False,
    navigate: float | None = None,
    position_limit: str | None = None,
    spectrum: bool = True,
    segment: float | None = None,
    segment_detrend: Literal["constant", "linear"] = "constant",
    limits: Mapping[str, str | float] | None = None,
    curve_interval: str | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    remove_events: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """The whole analysis of a record, as ``sagnac allan`` gives it: deviations, coefficients and spectrum of all columns, and on request
    the dependence on temperature, the change of the noise over time, and the position error of navigators.

    Parameters
    ----------
    data, rate, unit, kind, deviation, taus, confidence, intervals, detrend, remove_outliers, unit_check, threads
        As for :func:`allan`; a log may have several columns. The record is copied. Or a curve of a paper or another tool: a tuple of
        averaging times, s, and Allan deviations, and of the lower and upper ends of their 95 % intervals, which are else taken as ±10 %;
        or the path of a file with such columns. It takes ``rate``, ``unit``, ``name``, ``terms``, ``fit_from``, ``fit_to``, ``force``, ``limits`` and ``curve_interval``.
    name
        What the record is called; by default the name of its file, or ``record`` for an array.
    terms, fit_from, fit_to, force, bootstrap
        As for :func:`fit`; None for no coefficients.
    temperature_terms
        Terms of the dependence on the ``temperature`` with which :func:`read_log` read the log: ``auto``, or some of T, T2, dT,
        ``warm-up``, ``aging``. It is in ``temperature.csv``, and the noise before and after compensation in ``compensation.csv``.
    compensate
        Computes all results from the record without this dependence.
    dynamic
        Length of the windows, s, in which the deviation is computed over time, or True for a sixteenth of the record: ``dynamic.csv``.
        Whether the noise changes is in ``stationarity.csv``.
    navigate
        Time, s, after which navigators with three such gyros are asked for their distance from their place: ``navigation.csv``. They are
        aligned and calibrated for 10 min at a latitude of 60°, then at rest. ``files`` has the study behind it.
    position_limit
        Largest accepted distance for 95 % of them, such as ``"0.5 nmi"``.
    spectrum
        Whether the spectrum is computed.
    segment, segment_detrend, limits
        As for :func:`psd`.
    curve_interval
        Half the 95 % interval of each point of a curve, such as ``"10%"``, or the length of its record, such as ``"9 h"``,
        with which ``rate`` makes its fit that of the record.
    remove_events
        Removes what the record holds besides noise, as it is listed in ``events.csv``.

    Raises
    ------
    RecordError, UsageError
        The record is too short or unusable, or an argument is not accepted.

    Examples
    --------
    >>> import numpy as np
    >>> rates = np.random.default_rng(1).normal(0.0, 0.03, 40_000)
    >>> rates[20_000:] *= 1.5
    >>> found = analyze(rates, 10.0, unit="deg/h", dynamic=100.0, bootstrap=0)
    >>> bool(found.tables["stationarity.csv"]["p"][0] < 1e-6)
    True
    >>> tau = 2.0 ** np.arange(10)
    >>> analyze((tau, 3.0 / np.sqrt(tau)), unit="deg/h").answer[:12]       # a curve
    'N = 0.05 °/√'
    """
    given = dict(locals())
    if (curve := curve_of(data, rate, unit, name, curve_interval)) is not None:
        refuse_for_curve(analyze, given, CURVE_ARGUMENTS)
        return _analysis(
            _sagnac.analyze_curve(
                *curve, terms is not None, None if terms is None else _terms(terms), (fit_from, fit_to), force, limits_of(limits)
            )
        )
    refuse_interval(curve_interval)
    if navigate is None and position_limit is not None:
        raise UsageError("position_limit is that of navigators\nadd for example navigate=3600.0, or leave position_limit out")
    if navigate is not None and terms is None:
        raise UsageError("navigate needs coefficients\nleave terms=None out")
    for argument, value in {"navigate": navigate, "dynamic": dynamic}.items():
        if value is not None and not isinstance(value, bool) and not 0.0 < value < float("inf"):
            raise UsageError(f"{argument}={value}\naccepted: seconds above 0")
    record = reading_of(
        data, rate, kind, unit, detrend, remove_outliers, unit_check, threads, name=name, remove_events=remove_events
    )
    asked = _Whole(
        deviations=[deviation] if isinstance(deviation, str) else list(deviation),
        taus=times_of(taus),
        confidence=_probability(confidence),
        intervals=intervals,
        is_fitted=terms is not None,
        terms=None if terms is None else _terms(terms),
        range=(fit_from, fit_to),
        is_forced=force,
        bootstrap=_bootstrap(bootstrap),
        limits=limits_of(limits),
        has_spectrum=spectrum,
        segment_s=segment,
        is_linear=_is_linear(segment_detrend),
        effects=effects_of(temperature_terms),
        is_compensated=compensate,
        is_dynamic=dynamic is not False,
        window_s=None if isinstance(dynamic, bool) else float(dynamic),
        navigate_s=navigate,
        position_limit=position_limit,
    )
    return _analysis(_sagnac.analyze(*record, asked))


def psd(
    data: Record,
    rate: float | None = None,
    *,
    unit: str | None = None,
    kind: Kind | None = None,
    name: str | None = None,
    segment: float | None = None,
    segment_detrend: Literal["constant", "linear"] = "constant",
    confidence: float = 0.95,
    terms: Literal["auto"] | Sequence[str] = "auto",
    bootstrap: int | None = None,
    limits: Mapping[str, str | float] | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """The power spectral density of a record with its lines and its white noise, as ``sagnac allan`` computes them.

    Parameters
    ----------
    data, rate, unit, kind, detrend, remove_outliers, unit_check, threads
        As for :func:`allan`; a log may have several columns. The record is copied.
    name
        What the record is called; by default the name of its file, or ``record`` for an array.
    segment
        Length of the segments, s; by default an eighth of the record and at most 16384 samples.
    segment_detrend
        What is removed from each segment: its mean, or its straight line.
    confidence
        Probability of the intervals.
    terms, bootstrap
        As for :func:`fit`, of the fit whose density is drawn beside.
    limits
        As for :func:`fit`; ``in_run_bias_stability`` and ``floor``, the N of the flat part of the density, can be limited too.

    Raises
    ------
    RecordError, UsageError
        The record is too short or unusable, or an argument is not accepted.

    Examples
    --------
    >>> import numpy as np
    >>> times = np.arange(20_000) / 100.0
    >>> rates = np.random.default_rng(1).normal(0.0, 1.0, times.size) + np.sin(2 * np.pi * 20.0 * times)
    >>> found = psd(rates, 100.0, unit="deg/h", bootstrap=0)
    >>> [round(float(line), 1) for line in found.tables["lines.csv"]["f_hz"]]
    [20.0]
    """
    record = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads, name=name)
    asked = _Whole(
        confidence=_probability(confidence),
        terms=_terms(terms),
        bootstrap=_bootstrap(bootstrap),
        limits=limits_of(limits),
        needs_spectrum=True,
        segment_s=segment,
        is_linear=_is_linear(segment_detrend),
    )
    return _analysis(_sagnac.analyze(*record, asked))


def _probability(confidence: float) -> float:
    if not 0.0 < confidence < 1.0:
        raise UsageError(f"confidence={confidence}\naccepted: between 0 and 1, as in 0.95")
    return confidence


def _bootstrap(bootstrap: int | None) -> int | None:
    if bootstrap is None or bootstrap == 0:
        return bootstrap
    return _whole("bootstrap", bootstrap, MIN_REALIZATIONS, 1 << 20)


def _is_linear(segment_detrend: str) -> bool:
    if segment_detrend not in ("constant", "linear"):
        raise UsageError(f'segment_detrend="{segment_detrend}"\naccepted: "constant", "linear"')
    return segment_detrend == "linear"
