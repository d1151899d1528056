"""Simulated records."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

import _sagnac

from .errors import UsageError
from .logs import step_of
from .studies import MAX_TRIALS, _source, _threads, _whole

#: Most records of a call.
MAX_RECORDS = 100_000


class Wanted(NamedTuple):
    """The records as the native part takes them."""

    step_s: float | None
    length_s: float | None
    at: list[str]
    seed: int | None
    motion: tuple[str, str] | None
    data: str
    first: int
    records: int
    threads: int


def simulate(
    noise_or_study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    rate: float | None = None,
    length: float | None = None,
    at: Mapping[str, object] | None = None,
    records: int = 1,
    first: int = 0,
    seed: int | None = None,
    motion: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    data: Literal["rate", "increment", "angle", "pulses"] = "rate",
    threads: int | None = None,
) -> NDArray[np.float64]:
    """Records of a gyro with some noise, at rest or with a motion, as ``sagnac simulate`` writes them, to the last bit.

    Parameters
    ----------
    noise_or_study
        A noise, as ``sagnac allan`` writes it, or a study of kind ``allan``, whose trials the records are: the path of the file, its
        text, which is recognized by its line ends, or a dictionary of its keys.
    rate, length
        Samples per second, and time in s, for a noise.
    at
        Values of swept keys, for a study with sweeps, such as ``{"length": "4 h"}``.
    records, first
        Number of records, and the number of the first one. A record of a seed is the same wherever it is made.
    seed
        By default that of the study, or 1.
    motion
        Motion of the base: the keys of ``[motion]`` of a study, as a path, a text or a dictionary.
    data
        ``rate`` in °/h, or angles in ″: ``increment`` of each sample, or ``angle`` from the start; or ``pulses`` of each sample.
    threads
        Threads of the processor; by default all logical cores.

    Returns
    -------
    array
        A row for each record, a column for each sample.

    Raises
    ------
    StudyError
        The noise or the study is invalid; the message shows the place.
    UsageError
        An argument is missing or not accepted, or the file cannot be read.

    Examples
    --------
    >>> noise = {"angle_random_walk": "0.003 deg/sqrt(h)"}
    >>> rates = simulate(noise, rate=1.0, length=3600.0, records=2, seed=3)
    >>> rates.shape, round(float(rates.std()) / 60.0, 3)
    ((2, 3600), 0.003)
    """
    path, text = _source(noise_or_study)
    wanted = Wanted(
        None if rate is None else step_of(rate),
        None if length is None else float(length),
        [f"{key}={value}" for key, value in (at or {}).items()],
        None if seed is None else _whole("seed", seed, 0, (1 << 63) - 1),
        None if motion is None else _motion(motion),
        data,
        _whole("first", first, 0, MAX_TRIALS - MAX_RECORDS),
        _whole("records", records, 1, MAX_RECORDS),
        _threads(threads),
    )
    return _sagnac.simulate(path, text, wanted)


def _motion(motion: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str]:
    """The path and the text of a motion."""
    path, text = _source(motion)
    if path is None:
        return "motion", text
    try:
        return str(path), path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read the motion {path}: {error}") from None
