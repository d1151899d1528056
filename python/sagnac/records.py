"""Deviations and noise coefficients of recorded data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _plot, _sagnac
from ._reading import Kind, reading_of
from .errors import UsageError
from .studies import _whole

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

Deviation = Literal["adev", "oadev", "mdev", "tdev", "hdev", "ohdev"]
Numbers = NDArray[np.float64]
Counts = NDArray[np.int64]

#: Least number of simulated records with usable 2.5 % quantiles.
LEAST_REALISATIONS = 200


@dataclass(frozen=True)
class Minimum:
    """The minimum of a curve, which data sheets call in-run bias stability. It differs from the bias instability B."""

    tau: float
    value: float
    lower: float | None
    upper: float | None
    at_end: bool
    """Whether the curve ends there, so that a longer record may show a lower one."""


@dataclass(frozen=True)
class Curve:
    """A deviation over averaging times. All arrays have one value for each time."""

    deviation: str
    unit: str
    """``deg/h``, or ``arcsec`` for a time deviation; ``ug`` and ``ug*s`` for accelerations; empty for plain numbers."""
    m: Counts
    """Averaging factors: τ in samples."""
    tau: Numbers
    """Averaging times, s."""
    terms: Counts
    """Number of averaged differences; those that touch a gap are omitted."""
    value: Numbers
    """Deviation; NaN where there is no term."""
    lower: Numbers
    upper: Numbers
    """Ends of the interval; NaN where it is unknown."""
    alpha: Numbers
    """The noise, S(f) ∝ f^α: 2 quantisation, 0 angle random walk, −1 bias instability, −2 rate random walk; NaN where the
    record is too short."""
    alpha_carried: NDArray[np.bool_]
    """Whether α was identified at a shorter τ, because there are too few groups at this one."""
    edf: Numbers
    """Equivalent degrees of freedom of the variance."""
    minimum: Minimum | None

    def to_pandas(self) -> pandas.DataFrame:
        """The arrays as the columns of a pandas DataFrame; pandas has to be installed."""
        import pandas

        names = ["m", "tau", "terms", "value", "lower", "upper", "alpha", "alpha_carried", "edf"]
        return pandas.DataFrame({name: getattr(self, name) for name in names})


@dataclass(frozen=True)
class Allan(Mapping[str, Curve]):
    """The curves of a record by the names of their deviations: ``found["oadev"].tau``."""

    curves: dict[str, Curve]
    missing: int
    """Number of samples that are NaN."""
    mean_rate: float | None
    """Mean rate, °/h, or acceleration, µg; for plain numbers in their unit, or per s if they are not rates."""
    removed_slope_per_s: float
    """Slope of the rate that ``detrend`` removed, in the unit of the curve per s."""
    outliers: Counts
    """Indices of the samples, or for angles of the increments, that are outliers; the curves include them unless
    ``remove_outliers`` is given."""
    outlier_threshold: float

    @property
    def answer(self) -> str:
        """The in-run stability in one sentence, from the first curve that has a minimum."""
        curve = next((curve for curve in self.curves.values() if curve.minimum is not None), None)
        if curve is None or curve.minimum is None:
            return "No curve has a minimum."
        least = curve.minimum
        end = ", where the curve ends" if least.at_end else ""
        return f"In-run stability {least.value:.4g} {curve.unit} at τ = {least.tau:.4g} s{end}."

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draws the curves with their intervals with matplotlib, which has to be installed; returns the axes."""
        ax = _plot.axes_of(ax)
        for style, curve in enumerate(self.curves.values()):
            look = _plot.colour(style)
            ax.loglog(curve.tau, curve.value, color=look, marker="o", markersize=3, label=curve.deviation)
            ax.fill_between(curve.tau, curve.lower, curve.upper, color=look, alpha=0.2, linewidth=0)
        units = {curve.unit for curve in self.curves.values()}
        ax.set_xlabel("averaging time τ, s")
        ax.set_ylabel(", ".join(["deviation σ(τ)", *filter(None, sorted(units))]))
        ax.legend()
        return ax

    def __getitem__(self, deviation: str) -> Curve:
        return self.curves[deviation]

    def __iter__(self) -> Iterator[str]:
        return iter(self.curves)

    def __len__(self) -> int:
        return len(self.curves)


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of a record."""

    name: str
    unit: str
    """Unit as in data sheets: Q ``arcsec``, N ``deg/sqrt(h)``, B ``deg/h``, K ``deg/h/sqrt(h)``, R ``deg/h/h``; of accelerometers
    Q ``m/s``, N ``m/s/sqrt(h)``, B ``ug``, K ``ug/sqrt(h)``, R ``ug/h``."""
    value: float | None
    """Value; None if it is not identified."""
    lower: float | None
    upper: float | None
    """Ends of the 95 % interval; without a value, ``upper`` is an upper bound."""
    verdict: str
    """``identified``, or another statement."""

    @property
    def is_identified(self) -> bool:
        """Whether the interval of its square does not contain 0, and no other term fits equally well."""
        return self.verdict == "identified"


@dataclass(frozen=True)
class Fit(Mapping[str, Coefficient]):
    """The coefficients of a record by their names: ``found["N"].value``."""

    coefficients: dict[str, Coefficient]
    """Q, N, B, K, R; ``markov``, ``markov_time``, ``sine``, ``sine_frequency`` if requested; L if the record shows a filter."""
    answer: str
    """The coefficients in one sentence."""
    described: bool
    """Whether the terms describe the curve."""
    fit_from: float
    fit_to: float
    """Shortest and longest averaging time of the fit, s."""
    intervals: str
    """Method of the intervals, such as ``bootstrap of 1000`` or ``closed form``."""
    without_bootstrap: str | None
    """Why no records were simulated, if that was not requested."""
    chi_squared: float
    """Sum of the squared residuals, weighted with the covariance of the points of the curve."""
    degrees_of_freedom: int
    p_value: float | None
    """Probability of such large residuals if the fit is right; below 1e-9 other terms are needed."""
    tau: Numbers
    """Averaging times of the fitted curve, s, up to an eighth of the record."""
    unit: str
    """Unit of ``deviation`` and ``fitted``, as of a :class:`Curve`."""
    deviation: Numbers
    """The overlapping Allan deviation at these times."""
    fitted: Numbers
    """The deviation of the best fit at this sampling rate, including terms that are not identified; NaN at averaging times that
    the fit leaves out, and everywhere if it does not describe the curve."""
    missing: int
    mean_rate: float | None
    removed_slope_per_s: float
    outliers: Counts
    """The same as in :class:`Allan`."""

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draws the curve and the fit with matplotlib, which has to be installed; returns the axes."""
        ax = _plot.axes_of(ax)
        ax.loglog(self.tau, self.deviation, "o", color=_plot.colour(0), markersize=4, label="overlapping Allan deviation")
        ax.loglog(self.tau, self.fitted, color=_plot.colour(1), label="fit")
        ax.set_xlabel("averaging time τ, s")
        ax.set_ylabel(f"deviation σ(τ), {self.unit}" if self.unit else "deviation σ(τ)")
        ax.legend()
        return ax

    def __getitem__(self, name: str) -> Coefficient:
        return self.coefficients[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.coefficients)

    def __len__(self) -> int:
        return len(self.coefficients)

    def to_pandas(self) -> pandas.DataFrame:
        """The coefficients as a pandas DataFrame, a row for each; pandas has to be installed."""
        import pandas

        return pandas.DataFrame([vars(coefficient) for coefficient in self.coefficients.values()])


def allan(
    data: ArrayLike,
    rate: float,
    *,
    unit: str,
    kind: Kind = "rate",
    deviation: Deviation | Sequence[Deviation] = ("oadev",),
    taus: str | ArrayLike = "octave",
    confidence: float = 0.95,
    intervals: Literal["record", "stable32"] = "record",
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
        angles computed from it take the same amount of memory. Do not write to it during the call.
    rate
        Samples per second.
    unit
        ``deg/h``, ``deg/s``, ``rad/s``, ``arcsec``, … of gyros, ``m/s^2``, ``g``, ``mg``, ``m/s``, … of accelerometers, in accordance
        with ``kind``; pulses by their size, ``0.5 arcsec/pulse``; ``none`` for plain numbers.
    kind
        ``rate``: the mean angular rate or acceleration over each sample; ``increment``: the angle turned or the velocity gained in
        it; ``angle``: the angle, phase or velocity since some start. The unit tells rotation from acceleration.
    deviation
        One or more of ``adev``, ``oadev``, ``mdev``, ``tdev``, ``hdev``, ``ohdev``.
    taus
        ``octave``, ``decade10``, ``decade20``, ``all`` (of at most 200,000 samples), or seconds, each rounded to a whole
        number of samples.
    confidence
        Probability of the intervals.
    intervals
        Noise that the intervals suppose: that of the record as a whole, or with ``stable32`` the power law of each averaging time.
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
    values, reading = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads)
    names = [deviation] if isinstance(deviation, str) else list(deviation)
    if not 0.0 < confidence < 1.0:
        raise UsageError(f"confidence={confidence}\naccepted: between 0 and 1, as in 0.95")
    times = taus if isinstance(taus, str) else [float(tau) for tau in np.atleast_1d(np.asarray(taus))]
    found = _sagnac.curves(values, reading, names, times, confidence, intervals)
    curves = {}
    for raw in found["curves"]:
        least = raw["minimum"]
        curves[raw["deviation"]] = Curve(
            deviation=raw["deviation"],
            unit=raw["unit"],
            m=raw["m"],
            tau=raw["tau"],
            terms=raw["terms"],
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
        missing=found["missing"],
        mean_rate=found["mean_rate"],
        removed_slope_per_s=found["removed_slope_per_s"],
        outliers=found["outliers"],
        outlier_threshold=found["outlier_threshold"],
    )


def fit(
    data: ArrayLike,
    rate: float,
    *,
    unit: str,
    kind: Kind = "rate",
    terms: Literal["auto"] | Sequence[str] = "auto",
    fit_from: float | None = None,
    fit_to: float | None = None,
    force: bool = False,
    bootstrap: int | None = None,
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
        Takes the coefficients of the best fit even where it does not describe the curve; their verdict stays ``not described``.
    bootstrap
        Number of simulated records of the fit, from which test inversion gives the intervals: at least 200, or 0 for intervals
        in closed form. The default is 1000, or 0 for more than 2 million samples; :attr:`Fit.without_bootstrap` says so then.

    Notes
    -----
    Least squares on the overlapping Allan variances at the octaves of τ up to an eighth of the record, with the
    covariance between them; each term is that of sampled noise. The fit takes the octaves that the terms describe; if they
    describe none, all coefficients are ``not described`` and have no value. Otherwise a value is given if it is identified, else a
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
    >>> [name for name, coefficient in found.items() if coefficient.is_identified]
    ['N']
    >>> found["N"].unit, found["N"].lower < 0.1 / 60 < found["N"].upper
    ('deg/sqrt(h)', True)
    >>> found["B"].value is None, found["B"].verdict
    (True, 'not identifiable, at most the upper end')
    """
    values, reading = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads)
    if bootstrap is not None and bootstrap != 0:
        bootstrap = _whole("bootstrap", bootstrap, LEAST_REALISATIONS, 1 << 20)
    if isinstance(terms, str) and terms != "auto":
        raise UsageError(f'terms="{terms}"\naccepted: "auto", or a list such as ["Q", "N", "B"]')
    found = _sagnac.fit(
        values, reading, None if terms == "auto" else list(terms), (fit_from, fit_to), force, bootstrap
    )
    return Fit(
        coefficients={row[0]: Coefficient(*row) for row in found["rows"]},
        answer=found["answer"],
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
        missing=found["missing"],
        mean_rate=found["mean_rate"],
        removed_slope_per_s=found["removed_slope_per_s"],
        outliers=found["outliers"],
    )
