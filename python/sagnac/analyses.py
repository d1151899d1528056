"""Designs, sensitivities, comparisons and batches, as the program gives them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import _sagnac

from ._raw import RawAnalysis
from ._reading import Record, curve_of, is_curve, limits_of, reading_of, refuse_for_curve, refuse_interval
from .errors import UsageError
from .logs import Kind, Log, Reading
from .results import Charted, Table, answer_of
from .studies import MAX_TRIALS, _source, _threads, _whole

Measure = Literal["drift_p99_73", "drift_rms", "largest_p99_73", "largest_rms"]


@dataclass(frozen=True)
class Analysis(Charted):
    """What an analysis found: the content of the page and of the files of the program."""

    data: dict[str, Any]
    """The document that the program prints with ``--json``: ``title``, ``question``, ``answer``, ``notes``, and ``tables`` by the
    names of their files without ``.csv``, each a list of rows."""
    tables: dict[str, Table]
    """The tables by the names of their files, such as ``design.csv``."""
    files: dict[str, str]
    """Further files of the program by their names, such as ``noise.toml``, as texts."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.answer}>"


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
        trials = _whole("trials", trials, 1, MAX_TRIALS)
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
        trials = _whole("trials", trials, 1, MAX_TRIALS)
    if seed is not None:
        seed = _whole("seed", seed, 0, (1 << 63) - 1)
    rows = [(str(column), str(value)) for column, value in (where or {}).items()]
    return _analysis(
        _sagnac.sensitivity(path, text, by, rows, samples, trials, seed, device, _threads(threads), progress)
    )


def compare(
    a: Record | Mapping[str, Any],
    b: Record | Mapping[str, Any],
    rate: float | tuple[float, float] | None = None,
    *,
    unit: str | tuple[str, str] | None = None,
    kind: Kind | None = None,
    names: tuple[str, str] | None = None,
    terms: Literal["auto"] | Sequence[str] = "auto",
    limits: Mapping[str, float] | None = None,
    curve_interval: str | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """Whether the noise of two records differs, and in which coefficients, as ``sagnac compare`` tells.

    Parameters
    ----------
    a, b
        The records, as for :func:`allan`. They are copied. A curve may stand for a record, as for :func:`analyze`, and noise for one of
        them, such as the numbers of a data sheet: a path of a noise.toml, or a dictionary as for :func:`model`.
    rate, unit
        As for :func:`allan`, for both records or one for each.
    names
        What the records are called; by default the names of their files, or A and B for arrays.
    terms, kind, detrend, remove_outliers, unit_check, threads
        As for :func:`fit`.
    curve_interval
        As for :func:`analyze`.
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
    given = dict(locals())

    def is_noise(data: object) -> bool:
        return isinstance(data, Mapping) or (isinstance(data, (str, os.PathLike)) and str(data).endswith(".toml"))

    # One rate beside a record is that of the record.
    has_record = not all(is_noise(data) or is_curve(data) for data in (a, b))
    curve_rates = (None, None) if has_record and not isinstance(rate, tuple) else rates

    def side(place: int, data: Any) -> tuple[Any, str]:
        name = names[place] if names else None
        if is_noise(data):
            path, text = _source(data)
            return (path, text), name or (str(path) if path else "AB"[place])
        called = name or (None if isinstance(data, (str, os.PathLike)) else "AB"[place])
        curve = curve_of(data, curve_rates[place], units[place], called, curve_interval)
        if curve is not None:
            return curve
        record, reading, called = reading_of(
            data, rates[place], kind, units[place], detrend, remove_outliers, unit_check, threads, name=name, of_array="AB"[place]
        )
        return (record, reading), called

    (first, one), (second, other) = side(0, a), side(1, b)
    if not any(isinstance(found, _sagnac.Curve) for found in (first, second)):
        refuse_interval(curve_interval)
    if not any(isinstance(found, tuple) and isinstance(found[-1], Reading) for found in (first, second)):
        refuse_for_curve(compare, given, ("a", "b", "rate", "unit", "names", "terms", "limits", "curve_interval"))
    return _analysis(_sagnac.compare((first, second), (one, other), _terms(terms), limits_of(limits)))


def batch(
    records: Sequence[Record] | Log,
    rate: float | None = None,
    *,
    unit: str | None = None,
    kind: Kind | None = None,
    names: Sequence[str] | None = None,
    terms: Literal["auto"] | Sequence[str] = "auto",
    limits: Mapping[str, str | float] | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    remove_events: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """The noise of a batch of units: its median, the scatter between units, the next unit, and outliers, as ``sagnac compare`` of three
    and more logs finds them.

    Parameters
    ----------
    records
        A record of each unit, as for :func:`allan`; each column of a log is a unit. Arrays are copied.
    rate, unit, kind
        As for :func:`allan`, for all records that are no :class:`Log`.
    names
        What the records are called; by default the names of their files, or ``unit 1`` and so on for arrays.
    limits
        Largest accepted values of each unit, as for :func:`fit`; ``in_run_bias_stability`` can be limited too.
    terms, detrend, remove_outliers, unit_check, threads
        As for :func:`fit`.
    remove_events
        As for :func:`analyze`.

    Raises
    ------
    RecordError, UsageError
        The samples are unusable, two records are the same, or an argument is not accepted.

    Examples
    --------
    >>> import numpy as np
    >>> draw = np.random.default_rng(1).normal
    >>> found = batch([draw(0.0, sigma, 20_000) for sigma in (1.0, 1.02, 0.98, 1.01, 3.0)], 100.0, unit="deg/h")
    >>> found.answer.split(":")[0]
    'unit 5 is an outlier'
    """
    samples, readings, called = _records(
        records, rate, unit, kind, names, detrend, remove_outliers, remove_events, unit_check, threads
    )
    return _analysis(_sagnac.batch(samples, readings, called, _terms(terms), limits_of(limits)))


def hat(
    records: Sequence[Record] | Log,
    rate: float | None = None,
    *,
    unit: str | None = None,
    kind: Kind | None = None,
    names: Sequence[str] | None = None,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """The noise of each of three units that ran together, without what they measure in common (three-cornered hat), as
    ``sagnac compare --hat`` gives it.

    Parameters
    ----------
    records
        The records of the three units, of one length and sampling, or a log with three columns.
    rate, unit, kind, names, remove_outliers, unit_check, threads
        As for :func:`batch`.

    Raises
    ------
    RecordError, UsageError
        There are not three records, they were not sampled together, or an argument is not accepted.

    Examples
    --------
    >>> import numpy as np
    >>> draw = np.random.default_rng(1).normal
    >>> table = 30.0 * np.sin(0.01 * np.arange(20_000))                     # all three stand on it
    >>> found = hat([table + draw(0.0, sigma, table.size) for sigma in (1.0, 2.0, 0.5)], 1.0, unit="deg/h")
    >>> np.round(found.tables["hat.csv"]["deviation"][[0, 14, 28]], 1)
    array([1. , 2. , 0.5])
    """
    samples, readings, called = _records(
        records, rate, unit, kind, names, False, remove_outliers, False, unit_check, threads
    )
    return _analysis(_sagnac.hat(samples, readings, called))


def _records(
    records: Sequence[Record] | Log,
    rate: float | None,
    unit: str | None,
    kind: Kind | None,
    names: Sequence[str] | None,
    detrend: bool,
    remove_outliers: bool,
    remove_events: bool,
    unit_check: bool,
    threads: int | None,
) -> tuple[list[Any], list[Reading], list[str]]:
    """Samples, readings and names of several records."""
    each: Sequence[Record] = [records] if isinstance(records, Log) else list(records)
    if names is not None and len(names) != len(each):
        raise UsageError(f"there are {len(each)} records and {len(names)} names\ngive one name for each record")
    given = []
    for place, record in enumerate(each):
        stated = (None, None, None) if isinstance(record, Log) else (rate, kind, unit)
        name, of_array = names[place] if names else None, f"unit {place + 1}"
        given.append(
            reading_of(
                record, *stated, detrend, remove_outliers, unit_check, threads,
                name=name, of_array=of_array, remove_events=remove_events,
            )
        )  # fmt: skip
    return [one for one, _, _ in given], [reading for _, reading, _ in given], [name for _, _, name in given]


def _terms(terms: str | Sequence[str]) -> list[str] | None:
    if isinstance(terms, str) and terms != "auto":
        raise UsageError(f'terms="{terms}"\naccepted: "auto", or a list such as ["Q", "N", "B"]')
    return None if isinstance(terms, str) else list(terms)


def _analysis(found: RawAnalysis) -> Analysis:
    return Analysis(**_found(found))


def _found(found: RawAnalysis) -> dict[str, Any]:
    """The fields of an analysis."""
    return dict(
        title=found["title"],
        answer=answer_of(found["answer"]),
        notes=tuple(found["notes"]),
        charts={name: svg for name, svg, _ in found["charts"]},
        report=found["report"],
        pictures={name: json.loads(picture) for name, _, picture in found["charts"]},
        data=json.loads(found["data"]),
        tables={name: Table(columns) for name, columns in found["tables"]},
        files=dict(found["files"]),
    )
