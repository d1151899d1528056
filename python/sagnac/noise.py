"""Results of the analysis of a record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import _sagnac

from . import _plot
from .errors import UsageError
from .results import Answer

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

Numbers = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Minimum:
    """The minimum of a curve up to an eighth of the record: the in-run bias stability of data sheets, not the bias instability B."""

    tau: float
    value: float
    lower: float | None
    upper: float | None
    at_end: bool
    """Whether it is the last of these points: the stability is at most ``upper``, and a longer record may show a better one."""


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
    differences: Counts
    """Number of averaged differences; those that touch a gap are omitted."""
    value: Numbers
    """Deviation; NaN where there is no term."""
    lower: Numbers
    upper: Numbers
    """Ends of the interval; NaN where it is unknown."""
    alpha: Numbers
    """The noise, S(f) ∝ f^α: 2 quantization, 0 angle random walk, −1 bias instability, −2 rate random walk; NaN where the
    record is too short."""
    alpha_carried: NDArray[np.bool_]
    """Whether α was identified at a shorter τ, because there are too few groups at this one."""
    edf: Numbers
    """Equivalent degrees of freedom of the variance."""
    minimum: Minimum | None

    def to_pandas(self) -> pandas.DataFrame:
        """The arrays as the columns of a pandas DataFrame; pandas has to be installed."""
        import pandas

        names = ["m", "tau", "differences", "value", "lower", "upper", "alpha", "alpha_carried", "edf"]
        return pandas.DataFrame({name: getattr(self, name) for name in names})


@dataclass(frozen=True)
class Allan(Mapping[str, Curve]):
    """The curves of a record by the names of their deviations: ``found["oadev"].tau``."""

    curves: dict[str, Curve]
    answer: Answer
    """The minimum of the first curve."""
    notes: tuple[str, ...]
    """What was inferred about a log, and what looks doubtful in it, each a sentence."""
    missing: int
    """Number of samples that are NaN."""
    mean_rate: float | None
    """Mean rate, °/h, or acceleration, µg; for plain numbers in their unit, or per s if they are not rates."""
    limits: list[dict[str, Any]]
    """Each limit with what the record shows of it: ``coefficient``, ``limit``, ``value``, ``lower``, ``upper``, ``unit`` and
    ``status``; ``answer.status`` has all together."""
    removed_slope_per_s: float
    """Slope of the rate that ``detrend`` removed, in the unit of the curve per s."""
    outliers: Counts
    """Indices of the samples, or for angles of the increments, that are outliers; the curves include them unless
    ``remove_outliers`` is given."""
    outlier_threshold: float
    events: list[dict[str, Any]]
    """What the record shows besides noise, as ``sagnac allan --json`` lists it: ``event``, ``size`` in ``unit``, ``time_s``, ``f_hz`` and
    others, and in ``done`` what was done with it."""

    def plot(self, *, ax: Axes | None = None, label: str | None = None, color: str | None = None) -> Axes:
        """Draws the curves with their intervals with matplotlib, which has to be installed; returns the axes.

        ``label`` names the record in the legend, and ``color`` is the colour of all its curves, so that several records share axes.
        """
        ax = _plot.axes_of(ax)
        for style, curve in enumerate(self.curves.values()):
            look = _plot.colour(style) if color is None else color
            name = curve.deviation if label is None else label if len(self.curves) == 1 else f"{label}, {curve.deviation}"
            ax.loglog(curve.tau, curve.value, color=look, marker="o", markersize=3, label=name)
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
    """Value; None if it is not estimable."""
    lower: float | None
    upper: float | None
    """Ends of the 95 % interval; without a value, ``upper`` is an upper bound."""
    status: str
    """``estimated``, or another statement."""

    @property
    def is_estimated(self) -> bool:
        """Whether the interval of its square does not contain 0, and no other term fits equally well."""
        return self.status == "estimated"


@dataclass(frozen=True)
class Fit(Mapping[str, Coefficient]):
    """The coefficients of a record by their names: ``found["N"].value``."""

    coefficients: dict[str, Coefficient]
    """Q, N, B, K, R; ``markov``, ``markov_time``, ``sine``, ``sine_frequency`` if requested; L if the record shows a filter."""
    answer: Answer
    """The coefficients, and whether they meet the limits."""
    limits: list[dict[str, Any]]
    """Each limit with what the record shows of it: ``coefficient``, ``limit``, ``value``, ``lower``, ``upper``, ``unit`` and
    ``status``; ``answer.status`` has all together."""
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
    marks: dict[str, tuple[float, float]]
    """The averaging time, s, and the deviation at which each coefficient that the record shows is read off: N at 1 s, K at 3 s, Q at √3 s,
    R at √2 s, B at 0.664 of itself where the fit is least."""
    notes: tuple[str, ...]
    missing: int
    mean_rate: float | None
    removed_slope_per_s: float
    outliers: Counts
    """The same as in :class:`Allan`."""
    events: list[dict[str, Any]]
    """The same as in :class:`Allan`, with what the fit shows besides."""

    def plot(self, *, ax: Axes | None = None, label: str | None = None, color: str | None = None) -> Axes:
        """Draws the curve, the fit and the marks of its coefficients with matplotlib, which has to be installed; returns the axes.

        ``label`` names the record in the legend, and ``color`` is the colour of all that is drawn, so that several records share axes.
        """
        ax = _plot.axes_of(ax)
        measured, fit = (color, color) if color is not None else (_plot.colour(0), _plot.colour(1))
        ax.loglog(self.tau, self.deviation, "o", color=measured, markersize=4, label=label or "overlapping Allan deviation")
        ax.loglog(self.tau, self.fitted, color=fit, label="fit" if label is None else None)
        for name, place in self.marks.items():
            ax.loglog(*place, "D", color=fit, markersize=6, markerfacecolor="white")
            ax.annotate(name, place, textcoords="offset points", xytext=(6, 6), fontsize="small")
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


class Converted(NamedTuple):
    """A coefficient in one convention and unit."""

    convention: str
    value: float
    unit: str


@dataclass(frozen=True)
class Conversion:
    """A noise coefficient in the units and conventions of data sheets."""

    quantity: str
    """The coefficient that has such a unit."""
    rows: tuple[Converted, ...]
    lines: tuple[str, ...]
    """Lines of a noise file, of which one is right; none for accelerometers."""

    def to(self, unit: str) -> float:
        """The value in another unit of the same coefficient.

        Raises
        ------
        UsageError
            The unit is unknown, or is that of another quantity.
        """
        one = convert(f"1 {unit}")
        if one.quantity != self.quantity:
            raise UsageError(f"{unit} is a unit of {one.quantity}, not of {self.quantity}")
        return self.rows[0].value / one.rows[0].value


def convert(value: str) -> Conversion:
    """A noise coefficient of a gyro or an accelerometer in other units and conventions, as ``sagnac convert`` prints them.

    Parameters
    ----------
    value
        Number and unit: a noise density, random walk, bias instability, quantization or power density.

    Notes
    -----
    N is that of IEEE 952: N² is the two-sided power density of white noise. Many data sheets give one-sided densities, which are
    √2 times as large.

    Raises
    ------
    UsageError
        It is no number with a unit, or no coefficient has such a unit.

    Examples
    --------
    >>> found = convert("0.0135 deg/s/sqrt(Hz)")
    >>> found.quantity, round(found.to("deg/sqrt(h)"), 6)
    ('angle random walk N', 0.81)
    >>> found.rows[3].convention, found.rows[3].unit
    ('density of the rate, two-sided', '°/h/√Hz')
    """
    quantity, rows, lines = _sagnac.convert(value)
    return Conversion(quantity, tuple(Converted(*row) for row in rows), tuple(lines))
