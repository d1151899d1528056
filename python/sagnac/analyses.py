"""Designs, sensitivities, comparisons and spectra, as the program gives them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import ArrayLike

from . import _sagnac
from ._raw import RawAnalysis
from ._reading import Kind, limits_of, reading_of
from .errors import UsageError
from .records import LEAST_REALIZATIONS
from .results import Charted, Table, answer_of
from .studies import MOST_TRIALS, _source, _threads, _whole

Measure = Literal["drift_p99_73", "drift_rms", "largest_p99_73", "largest_rms"]


@dataclass(frozen=True)
class Analysis(Charted):
    """What an analysis found: the content of the page and of the files of the program."""

    data: dict[str, Any]
    """The document that the program prints with ``--json``: ``title``, ``question``, ``answer``, ``notes``, and ``tables`` by the
    names of their files without ``.csv``, each a list of rows."""
    tables: dict[str, Table]
    """The tables by the names of their files, such as ``design.csv``."""

    def __repr__(self) -> str:
        return f"<Analysis: {self.answer}>"


def design(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    by: Measure = "drift_p99_73",
    latency: str | None = None,
    memory: int | None = None,
    search: bool = False,
    band: str | None = None,
    trials: int | None = None,
    seed: int | None = None,
    device: str = "auto",
    threads: int | None = None,
    progress: Callable[[int, int, str], object] | None = None,
) -> Analysis:
    """The best switching interval and filler of a study of whole runs, as ``sagnac design`` finds them.

    Parameters
    ----------
    study
        As for :func:`run`; of ``kind = "switched-run"``. The candidates are its swept intervals, or intervals that suit the run.
        Other swept keys are choices too: each combination of their values is a variant, and the best one wins.
    by
        Estimate to minimize.
    latency
        Longest time from the end of the gap to the correction, such as ``"10 ms"``; fillers that read later ticks are left out.
    memory
        Largest memory of a filler in firmware, bytes; larger fillers are left out.
    search
        Whether a handful of minimum-variance fillers that meet these constraints are tried too.
    band
        Band of the vibration for which searched fillers are designed, such as ``"18 Hz,22 Hz"``, instead of the motion of the study.
    trials
        Runs of each candidate instead of the number in the study, rounded up to 32 times a power of two.
    seed, device, threads, progress
        As for :func:`run`.

    Raises
    ------
    StudyError, DeviceError, UsageError
        The study is invalid or of another kind, the device fails, or an argument is not accepted.

    Examples
    --------
    >>> gyro = {
    ...     "title": "The paper's hour",
    ...     "kind": "switched-run",
    ...     "streams": "common",
    ...     "drift": {"magnetic": "14 arcsec/s", "warm_up_time": "3000 s", "residual_max": "10 arcsec"},
    ...     "switching": {"interval": "40 s"},
    ...     "run": {"duration": "1 h"},
    ... }
    >>> found = design(gyro, by="drift_rms", trials=8192, device="cpu")
    >>> [best] = found.data["tables"]["fillers"]
    >>> 20.0 < best["interval_s"] < 25.0, found.answer[:12]       # in closed form 22.4 s
    (True, 'Switch every')
    """
    path, text = _source(study)
    if band is not None and not search:
        raise UsageError("band is that of searched fillers\nadd search=True, or leave band out")
    if memory is not None:
        memory = _whole("memory", memory, 0, 1 << 32)
    if trials is not None:
        trials = _whole("trials", trials, 1, MOST_TRIALS)
    if seed is not None:
        seed = _whole("seed", seed, 0, (1 << 63) - 1)
    return _analysis(_sagnac.design(path, text, by, latency, memory, search, band, trials, seed, device, _threads(threads), progress))


def sensitivity(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    by: str | None = None,
    where: Mapping[str, object] | None = None,
    samples: int | None = None,
    trials: int | None = None,
    seed: int | None = None,
    device: str = "auto",
    threads: int | None = None,
    progress: Callable[[int, int, str], object] | None = None,
) -> Analysis:
    """Which uncertain input decides the answer of a study, as ``sagnac sensitivity`` finds it.

    Parameters
    ----------
    study
        As for :func:`run`, with uncertain inputs in ``sensitivity``.
    by
        Column of the points whose value is the answer; one in closed form, such as ``theory_rms``, needs no sampling. By default
        the answer by which the study is judged.
    where
        Values of columns that choose one row of each point, such as ``{"filler": "const"}``.
    samples
        Number of samples, rounded up to 32 times a power of two.
    trials
        Trials of each evaluation of a sampled answer.
    seed, device, threads, progress
        As for :func:`run`.

    Raises
    ------
    StudyError, DeviceError, UsageError
        The study is invalid or has no uncertain inputs, the device fails, or an argument is not accepted.

    Examples
    --------
    >>> gap = {
    ...     "title": "A gap",
    ...     "kind": "gap-fill",
    ...     "gyro": {"tick": "5 ms", "tick_noise": {"std": "0.5 arcsec"}},
    ...     "motion": {"amplitude": "12000 arcsec/s", "frequency": "5 Hz"},
    ...     "switching": {"gap_ticks": 3, "fillers": ["quadratic"]},
    ...     "sensitivity": [
    ...         {"key": "gyro.tick_noise.std", "normal": {"mean": "0.5 arcsec", "sd": "0.05 arcsec"}},
    ...         {"key": "motion.frequency", "uniform": {"from": "4 Hz", "to": "6 Hz"}},
    ...     ],
    ... }
    >>> found = sensitivity(gap, by="theory_rms", samples=1024, device="cpu")
    >>> first = found.data["tables"]["sensitivity"][0]
    >>> first["input"], first["first"] > 0.9
    ('gyro.tick_noise.std', True)
    """
    path, text = _source(study)
    if samples is not None:
        samples = _whole("samples", samples, 1, 1 << 21)
    if trials is not None:
        trials = _whole("trials", trials, 1, MOST_TRIALS)
    if seed is not None:
        seed = _whole("seed", seed, 0, (1 << 63) - 1)
    rows = [(str(column), str(value)) for column, value in (where or {}).items()]
    return _analysis(
        _sagnac.sensitivity(path, text, by, rows, samples, trials, seed, device, _threads(threads), progress)
    )


def compare(
    a: ArrayLike,
    b: ArrayLike,
    rate: float | tuple[float, float],
    *,
    unit: str | tuple[str, str],
    kind: Kind = "rate",
    names: tuple[str, str] = ("A", "B"),
    terms: Literal["auto"] | Sequence[str] = "auto",
    limits: Mapping[str, float] | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """Whether the noise of two records differs, and in which coefficients, as ``sagnac compare`` tells.

    Parameters
    ----------
    a, b
        The records, as for :func:`allan`. They are copied.
    rate, unit
        As for :func:`allan`, for both records or one for each.
    names
        What the records are called.
    terms, kind, detrend, remove_outliers, unit_check, threads
        As for :func:`fit`.
    limits
        Largest accepted ratios of coefficients, b over a, which ``tables["limits.csv"]`` has with what the records show: ``{"N": 1.1}``.

    Raises
    ------
    RecordError, UsageError
        The samples are unusable or have nothing in common to compare, or an argument is not accepted.

    Examples
    --------
    >>> import numpy as np
    >>> draw = np.random.default_rng(1).normal
    >>> found = compare(draw(0.0, 1.0, 20_000), draw(0.0, 1.3, 20_000), 100.0, unit="deg/h", names=("before", "after"))
    >>> [(row["coefficient"], row["status"]) for row in found.data["tables"]["coefficients"]]
    [('N', 'after higher')]
    """
    rates = rate if isinstance(rate, tuple) else (rate, rate)
    units = unit if isinstance(unit, tuple) else (unit, unit)
    records = [
        reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads)
        for data, rate, unit in zip((a, b), rates, units)
    ]
    (first, of_first), (second, of_second) = records
    return _analysis(
        _sagnac.compare(first, second, (of_first, of_second), names, _terms(terms), limits_of(limits))
    )


def psd(
    data: ArrayLike,
    rate: float,
    *,
    unit: str,
    kind: Kind = "rate",
    name: str = "record",
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
        As for :func:`allan`. The record is copied.
    name
        What the record is called.
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
    values, reading = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads)
    if not 0.0 < confidence < 1.0:
        raise UsageError(f"confidence={confidence}\naccepted: between 0 and 1, as in 0.95")
    if segment_detrend not in ("constant", "linear"):
        raise UsageError(f'segment_detrend="{segment_detrend}"\naccepted: "constant", "linear"')
    if bootstrap is not None and bootstrap != 0:
        bootstrap = _whole("bootstrap", bootstrap, LEAST_REALIZATIONS, 1 << 20)
    is_linear = segment_detrend == "linear"
    return _analysis(
        _sagnac.psd(
            values, reading, name, segment, is_linear, confidence, _terms(terms), bootstrap, limits_of(limits)
        )
    )


def _terms(terms: str | Sequence[str]) -> list[str] | None:
    if isinstance(terms, str) and terms != "auto":
        raise UsageError(f'terms="{terms}"\naccepted: "auto", or a list such as ["Q", "N", "B"]')
    return None if isinstance(terms, str) else list(terms)


def _analysis(found: RawAnalysis) -> Analysis:
    return Analysis(
        title=found["title"],
        answer=answer_of(found["answer"]),
        notes=tuple(found["notes"]),
        charts={name: svg for name, svg, _ in found["charts"]},
        report=found["report"],
        pictures={name: json.loads(picture) for name, _, picture in found["charts"]},
        data=json.loads(found["data"]),
        tables={name: Table(columns) for name, columns in found["tables"]},
    )
