"""Running studies."""

from __future__ import annotations

import json
import operator
import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import _sagnac

from ._raw import RawResults
from ._toml import text_of
from .errors import StorageError, UsageError
from .results import Results, Table, answer_of

#: Most trials at a point.
MAX_TRIALS = 1 << 40

#: Most threads of the processor.
MAX_THREADS = 4096


def run(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    trials: int | None = None,
    seed: int | None = None,
    device: str = "auto",
    threads: int | None = None,
    out: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, str], object] | None = None,
) -> Results:
    """Runs a study: samples the trials that its results folder lacks, and returns all tables and charts.

    The numbers are those of ``sagnac run``, to the last bit, on every device and with any number of threads.

    Parameters
    ----------
    study
        The path of a study file; its text, which is recognized by its line ends; or a dictionary of its keys, in which tables are
        dictionaries, and values are texts with units or numbers as in the file. Files named in a text or a dictionary are
        relative to the working directory.
    trials, seed
        Values that replace those of the study: 1 to 2**40 trials at each point, a seed below 2**63.
    device
        ``auto``, ``cpu``, ``gpu``, a width of the processor such as ``avx2``, ``gpu:0`` for the first adapter, part of an
        adapter's name or its PCI address. ``auto`` is a GPU that passes its self-test, else the processor. Several devices
        share the work: ``all``, or a list such as ``cpu,gpu:0``.
    threads
        Threads of the processor; by default all logical cores.
    out
        The results folder. It keeps the exact tallies, from which a later run, also one of the program, continues; the tables
        as CSV; the report; and the study as it was run. ``sagnac run`` on that study adds the charts. Without ``out`` nothing
        is kept.
    progress
        Called as ``progress(done, total, unit)`` several times a second; ``unit`` is ``trials``, ``samples`` or ``fits``,
        then ``evaluations`` for the error budget and the changes in the answer.
        An exception that it raises ends the run and is raised here.

    Notes
    -----
    Other Python threads continue during the run. Ctrl-C ends it with a KeyboardInterrupt after the current batch, which takes
    a third of a second, or longer for studies of more than a billion trials. With ``out``, completed work is kept, and the
    same call continues from there.

    Raises
    ------
    StudyError
        The study is invalid; the message shows the place.
    StorageError, DeviceError, UsageError
        The folder or the device cannot be used, or an argument is not accepted.

    Examples
    --------
    >>> results = run({
    ...     "title": "A gap of three ticks",
    ...     "kind": "gap-fill",
    ...     "trials": 1000,
    ...     "gyro": {"tick": "5 ms", "tick_noise": {"std": "0.5 arcsec"}},
    ...     "motion": {"amplitude": "12000 arcsec/s", "frequency": "20 Hz"},
    ...     "switching": {"gap_ticks": 3, "fillers": ["const", "quadratic"], "errors": ["residual"]},
    ... })
    >>> [f"{filler}: {rms:.3g}" for filler, rms in zip(results.points["filler"], results.points["theory_rms_arcsec"])]
    ['const: 109', 'quadratic: 19.1']
    """
    path, text = _source(study)
    if trials is not None:
        trials = _whole("trials", trials, 1, MAX_TRIALS)
    if seed is not None:
        seed = _whole("seed", seed, 0, (1 << 63) - 1)
    threads = _threads(threads)

    def within(folder: Path) -> Results:
        kept = out is not None
        found = _sagnac.run(path, text, trials, seed, device, threads, folder, kept, progress)
        return _results(found, folder if kept else None)

    if out is not None:
        return within(Path(out))
    try:
        folder = tempfile.TemporaryDirectory(prefix="sagnac-")
    except OSError as error:
        raise StorageError(f"cannot make a folder for the tallies: {error}\nmake room, or give one with out=") from error
    with folder:
        return within(Path(folder.name))


def _threads(threads: int | None) -> int:
    return 0 if threads is None else _whole("threads", threads, 1, MAX_THREADS)


def _source(study: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[Path | None, str]:
    if isinstance(study, Mapping):
        return None, text_of(study)
    if isinstance(study, str) and "\n" in study:
        return None, study
    return Path(study), ""


def _whole(name: str, value: int, least: int, most: int) -> int:
    """The value as a whole number within the limits, from any integer type."""
    try:
        whole = operator.index(value)
    except TypeError:
        raise UsageError(f"{name}={value!r} is not a whole number\naccepted: {least} to {most}") from None
    if not least <= whole <= most:
        raise UsageError(f"{name}={whole}\naccepted: {least} to {most}")
    return whole


def _results(found: RawResults, folder: Path | None) -> Results:
    coefficients, trajectories = found["coefficients"], found["trajectories"]
    return Results(
        title=found["title"],
        answer=answer_of(found["answer"]),
        question=found["question"],
        kind=found["kind"],
        points=Table(found["points"]),
        coefficients=None if coefficients is None else Table(coefficients),
        trajectories=None if trajectories is None else Table(trajectories),
        notes=tuple(found["notes"]),
        charts={name: svg for name, svg, _ in found["charts"]},
        report=found["report"],
        pictures={name: json.loads(picture) for name, _, picture in found["charts"]},
        seed=found["seed"],
        trials=found["trials"],
        device=found["device"],
        sampled_trials=found["sampled_trials"],
        seconds=found["seconds"],
        folder=folder,
    )
