from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._raw import RawAnalysis, RawCurves, RawFillers, RawFit, RawResults

__all__ = [
    "allan_variance",
    "colours",
    "compare",
    "curves",
    "design",
    "drift_bound",
    "drift_from_detuning",
    "drift_from_frequency",
    "drift_of_runs",
    "drift_optimum",
    "fit",
    "gap_response",
    "magnetic_drift",
    "model_of_noise",
    "model_of_record",
    "of_kinds",
    "of_study",
    "polynomial",
    "psd",
    "relock_ticks",
    "run",
    "sampled_variance",
    "sensitivity",
    "suspension_modes",
    "suspension_response",
    "taylor",
    "version",
]

version: str
colours: list[str]

_Numbers: TypeAlias = NDArray[np.float64]

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

class _Wanted(Protocol):
    @property
    def from_s(self) -> float | None: ...
    @property
    def to_s(self) -> float | None: ...
    @property
    def bound(self) -> str | None: ...
    @property
    def margin(self) -> float: ...
    @property
    def states(self) -> int | None: ...
    @property
    def is_white(self) -> bool: ...
    @property
    def filter_hz(self) -> float | None: ...
    @property
    def confidence(self) -> float: ...
    @property
    def write(self) -> list[str]: ...

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
def design(
    path: Path | None,
    text: str,
    by: str,
    latency: str | None,
    memory: int | None,
    search: bool,
    band: str | None,
    trials: int | None,
    seed: int | None,
    device: str,
    threads: int,
    progress: Callable[[int, int, str], object] | None,
) -> RawAnalysis: ...
def sensitivity(
    path: Path | None,
    text: str,
    by: str | None,
    rows: list[tuple[str, str]],
    samples: int | None,
    trials: int | None,
    seed: int | None,
    device: str,
    threads: int,
    progress: Callable[[int, int, str], object] | None,
) -> RawAnalysis: ...
def compare(
    a: _Numbers,
    b: _Numbers,
    readings: tuple[_Reading, _Reading],
    names: tuple[str, str],
    terms: list[str] | None,
    limits: list[str],
) -> RawAnalysis: ...
def psd(
    data: _Numbers,
    reading: _Reading,
    name: str,
    segment_s: float | None,
    is_linear: bool,
    confidence: float,
    terms: list[str] | None,
    bootstrap: int | None,
    limits: list[str],
) -> RawAnalysis: ...
def model_of_record(
    data: _Numbers, reading: _Reading, name: str, terms: list[str] | None, wanted: _Wanted
) -> RawAnalysis: ...
def model_of_noise(path: Path | None, text: str, wanted: _Wanted) -> RawAnalysis: ...
def curves(
    data: _Numbers,
    reading: _Reading,
    deviations: Sequence[str],
    taus: str | list[float],
    confidence: float,
    intervals: str,
    limits: list[str],
) -> RawCurves: ...
def fit(
    data: _Numbers,
    reading: _Reading,
    terms: list[str] | None,
    range: tuple[float | None, float | None],
    is_forced: bool,
    bootstrap: int | None,
    limits: list[str],
) -> RawFit: ...
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
