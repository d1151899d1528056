from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

version: str

_Numbers: TypeAlias = NDArray[np.float64]
_Counts: TypeAlias = NDArray[np.int64]

# Header, label, symbol of the unit, values.
RawColumn: TypeAlias = tuple[str, str, str, NDArray[Any] | list[str | None]]

class RawResults(TypedDict):
    title: str
    question: str
    kind: str
    seed: int | None
    trials: int | None
    device: str | None
    sampled_trials: int | None
    seconds: float | None
    notes: list[str]
    verdicts: list[tuple[str, str]]
    charts: list[tuple[str, str]]
    points: list[RawColumn]
    coefficients: list[RawColumn] | None
    trajectories: list[RawColumn] | None

class RawCurve(TypedDict):
    deviation: str
    unit: str
    m: _Counts
    tau: _Numbers
    terms: _Counts
    value: _Numbers
    lower: _Numbers
    upper: _Numbers
    alpha: _Numbers
    alpha_carried: NDArray[np.bool_]
    edf: _Numbers
    minimum: tuple[float, float, float | None, float | None, bool] | None

class _RawRecord(TypedDict):
    missing: int
    mean_rate: float | None
    removed_slope_per_s: float
    outliers: _Counts
    outlier_threshold: float
    unit: str

class RawCurves(_RawRecord):
    curves: list[RawCurve]

class RawFit(_RawRecord):
    rows: list[tuple[str, str, float | None, float | None, float | None, str]]
    intervals: str
    without_bootstrap: str | None
    chi_squared: float
    degrees_of_freedom: int
    p_value: float | None
    tau: _Numbers
    deviation: _Numbers
    fitted: _Numbers

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

class RawFillers(TypedDict):
    title: str
    at: list[tuple[str, str]]
    tick_s: float | None
    gap_ticks: int
    no_rms_because: str | None
    fillers: list[tuple[str, str, list[RawRule]]]
    header: str

class _Reading(Protocol):
    @property
    def kind(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def step_s(self) -> float: ...
    @property
    def detrend(self) -> bool: ...
    @property
    def remove_outliers(self) -> bool: ...
    @property
    def unit_check(self) -> bool: ...
    @property
    def threads(self) -> int: ...

class _Made(Protocol):
    @property
    def gap_ticks(self) -> int: ...
    @property
    def tick(self) -> str | None: ...
    @property
    def fit_ticks(self) -> str | None: ...
    @property
    def extrapolation_ticks(self) -> str | None: ...
    @property
    def band(self) -> str | None: ...
    @property
    def amplitude(self) -> str | None: ...
    @property
    def noise(self) -> str | None: ...

class _Noise(Protocol):
    @property
    def q(self) -> float: ...
    @property
    def n(self) -> float: ...
    @property
    def b(self) -> float: ...
    @property
    def k(self) -> float: ...
    @property
    def r(self) -> float: ...
    @property
    def markov(self) -> tuple[float, float] | None: ...
    @property
    def sine(self) -> tuple[float, float] | None: ...

def run(
    path: Path | None,
    text: str,
    trials: int | None,
    seed: int | None,
    device: str,
    threads: int,
    folder: Path,
    is_kept: bool,
    progress: Callable[[int, int, str], object] | None,
) -> RawResults: ...
def curves(
    data: _Numbers, reading: _Reading, deviations: Sequence[str], taus: str | list[float], confidence: float
) -> RawCurves: ...
def fit(data: _Numbers, reading: _Reading, terms: list[str] | None, bootstrap: int | None) -> RawFit: ...
def of_kinds(kinds: Sequence[str], made: _Made) -> RawFillers: ...
def of_study(path: Path, at: Sequence[str], fillers: Sequence[str]) -> RawFillers: ...
def polynomial(ticks: Sequence[int], order: int, gap_ticks: int) -> tuple[list[int], int]: ...
def gap_response(
    ticks: Sequence[int], numerators: Sequence[int], denominator: int, gap_ticks: int, arrays: Sequence[_Numbers]
) -> _Numbers: ...
def taylor(order: int, at_extremum: bool, arrays: Sequence[_Numbers]) -> _Numbers: ...
def magnetic_drift(arrays: Sequence[_Numbers]) -> list[_Numbers]: ...
def drift_bound(arrays: Sequence[_Numbers]) -> list[_Numbers]: ...
def drift_optimum(arrays: Sequence[_Numbers]) -> list[_Numbers]: ...
def drift_of_runs(first_positive: bool, arrays: Sequence[_Numbers]) -> list[_Numbers]: ...
def relock_ticks(arrays: Sequence[_Numbers]) -> list[_Numbers]: ...
def drift_from_frequency(arrays: Sequence[_Numbers]) -> _Numbers: ...
def drift_from_detuning(arrays: Sequence[_Numbers]) -> _Numbers: ...
def allan_variance(noise: _Noise, arrays: Sequence[_Numbers]) -> _Numbers: ...
def sampled_variance(
    noise: _Noise, estimator: str, sample_s: float, samples: int, arrays: Sequence[_Numbers]
) -> _Numbers: ...
def suspension_response(modes: Sequence[tuple[float, float, float]], arrays: Sequence[_Numbers]) -> list[_Numbers]: ...
def suspension_modes(name: str) -> list[tuple[float, float, float]] | None: ...
