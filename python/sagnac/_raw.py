"""What the native part returns."""

from __future__ import annotations

from typing import Any, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[np.float64]
Counts: TypeAlias = NDArray[np.int64]

#: Header, label, symbol of the unit, values.
RawColumn: TypeAlias = "tuple[str, str, str, NDArray[Any] | list[str | None]]"


#: Name of a chart, the chart as SVG, and its content as JSON.
RawChart: TypeAlias = "tuple[str, str, str]"


#: Headline of an answer, the answer as text, as HTML and as JSON.
RawAnswer: TypeAlias = "tuple[str, str, str, str]"


class RawAnalysis(TypedDict):
    title: str
    answer: RawAnswer
    notes: list[str]
    data: str
    tables: list[tuple[str, list[RawColumn]]]
    charts: list[RawChart]
    files: list[tuple[str, str]]
    report: str


class RawResults(TypedDict):
    title: str
    answer: RawAnswer
    question: str
    kind: str
    seed: int | None
    trials: int | None
    device: str | None
    sampled_trials: int | None
    seconds: float | None
    notes: list[str]
    charts: list[RawChart]
    report: str
    points: list[RawColumn]
    coefficients: list[RawColumn] | None
    trajectories: list[RawColumn] | None


class RawCurve(TypedDict):
    deviation: str
    unit: str
    m: Counts
    tau: Numbers
    differences: Counts
    value: Numbers
    lower: Numbers
    upper: Numbers
    alpha: Numbers
    alpha_carried: NDArray[np.bool_]
    edf: Numbers
    minimum: tuple[float, float, float | None, float | None, bool] | None


class RawRecord(TypedDict):
    notes: list[str]
    missing: int
    mean_rate: float | None
    removed_slope_per_s: float
    outliers: Counts
    outlier_threshold: float
    unit: str
    events: str


class RawCurves(RawRecord):
    answer: RawAnswer
    limits: str
    curves: list[RawCurve]


class RawFit(RawRecord):
    answer: RawAnswer
    limits: str
    rows: list[tuple[str, str, float | None, float | None, float | None, str]]
    intervals: str
    without_bootstrap: str | None
    described: bool
    range: tuple[float, float]
    chi_squared: float
    degrees_of_freedom: int
    p_value: float | None
    tau: Numbers
    deviation: Numbers
    fitted: Numbers
    marks: list[tuple[str, float, float]]


class RawRule(TypedDict):
    error: str
    ticks: list[int]
    denominator: int
    exact: bool
    rows: list[list[int]]
    noise_gain: float
    largest_gain: float
    largest_input: int
    amplitude: float | None
    rms: float | None


class RawFillers(RawAnalysis):
    at: list[tuple[str, str]]
    tick_s: float | None
    gap_ticks: int
    no_rms_because: str | None
    fillers: list[tuple[str, str, list[RawRule]]]
