"""Records as the native part takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import RecordError, UsageError
from .studies import _threads

Kind = Literal["rate", "increment", "angle"]
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Reading:
    """The kind of the samples, and their treatment."""

    kind: str
    unit: str
    step_s: float
    detrend: bool
    remove_outliers: bool
    unit_check: bool
    threads: int


def reading_of(
    data: ArrayLike,
    rate: float,
    kind: str,
    unit: str,
    detrend: bool,
    remove_outliers: bool,
    unit_check: bool,
    threads: int | None,
) -> tuple[Numbers, Reading]:
    """The samples as a contiguous array, with their reading."""
    try:
        values = np.ascontiguousarray(data, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordError(f"the data are not an array of numbers: {error}") from error
    if np.ndim(data) != 1:
        raise RecordError(f"the array has {np.ndim(data)} dimensions\ngive one axis, as in data[:, 0]")
    step = 1.0 / rate if rate > 0.0 else 0.0
    if not 1e-9 <= step <= 1e9:
        raise UsageError(f"rate={rate}\naccepted: samples per second from 1e-9 to 1e9")
    return values, Reading(kind, unit, step, detrend, remove_outliers, unit_check, _threads(threads))


def limits_of(limits: Mapping[str, str | float] | None) -> list[str]:
    """Limits as the texts that the program takes."""
    return [f"{name}={value}" for name, value in (limits or {}).items()]
