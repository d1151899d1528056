"""Records as the native part takes them."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

import _sagnac

from .errors import RecordError, UsageError
from .logs import Kind, Log, Numbers, Reading, read_log, step_of
from .studies import _threads

#: An array, a log, or the path of a file.
Record: TypeAlias = ArrayLike | Log | os.PathLike[str]

#: The samples, their reading, and what they are called.
Given: TypeAlias = tuple[_sagnac.Log | Numbers, Reading, str]


def is_curve(data: object) -> bool:
    """Whether it is a tuple of columns with averaging times and deviations, or the path of such a file."""
    if isinstance(data, (str, os.PathLike)):
        return _sagnac.is_curve(Path(data))
    return isinstance(data, tuple) and 2 <= len(data) <= 4 and all(np.ndim(column) == 1 for column in data)


def curve_of(
    data: object, rate: float | None, unit: str | None, name: str | None, interval: str | None
) -> tuple[_sagnac.Curve, str] | None:
    """A curve with what it is called, of a tuple of averaging times, deviations and perhaps the ends of their intervals, or of the path
    of such a file; None for a record."""
    if not is_curve(data):
        return None
    step = None if rate is None else step_of(rate)
    if isinstance(data, (str, os.PathLike)):
        return _sagnac.read_curve(Path(data), unit, interval, step), name or str(Path(data))
    assert isinstance(data, tuple)
    if len(data) == 3 or len({len(column) for column in data}) != 1:
        raise RecordError("the curve has columns of different lengths, or one end of its intervals\ngive (tau, sigma) or (tau, sigma, low, high)")
    if unit is None:
        raise UsageError('unit is missing, which a curve does not say\nadd for example unit="deg/h"')
    columns = [np.asarray(column, dtype=np.float64).tolist() for column in data]
    return _sagnac.curve_of(name or "curve", columns, unit, interval, step), name or "curve"


def refuse_interval(curve_interval: str | None) -> None:
    """Raises for errors of a curve where none is given."""
    if curve_interval is not None:
        raise UsageError(f'curve_interval="{curve_interval}" is that of a curve\ngive a curve, or leave curve_interval out')


def refuse_for_curve(function: Callable[..., object], given: Mapping[str, Any], accepted: Collection[str]) -> None:
    """Raises for an argument other than its default that a curve does not have."""
    for name, parameter in inspect.signature(function).parameters.items():
        is_default = given[name] is parameter.default or (
            isinstance(given[name], (str, int, float, tuple)) and given[name] == parameter.default
        )
        if name not in accepted and not is_default:
            raise UsageError(f"{name}={given[name]!r} needs a record, and a curve is given\nleave {name} out")


def reading_of(
    data: Record,
    rate: float | None,
    kind: Kind | None,
    unit: str | None,
    detrend: bool,
    remove_outliers: bool,
    unit_check: bool,
    threads: int | None,
    *,
    name: str | None = None,
    of_array: str = "record",
    remove_events: bool = False,
) -> Given:
    """A log, or the samples as a contiguous array, with their reading and what they are called: by default as their file, or
    ``of_array``."""
    if isinstance(data, (str, os.PathLike)):
        data = read_log(data, rate=rate, kind=kind, unit=unit or (), unit_check=unit_check, threads=threads)
    elif isinstance(data, Log):
        for argument, value in {"rate": rate, "kind": kind, "unit": unit}.items():
            if value is not None:
                raise UsageError(f"{argument}={value!r} is given, but a log has its own\nleave {argument} out, or give it to read_log")
    treatment = (detrend, remove_outliers, remove_events, unit_check, _threads(threads))
    if isinstance(data, Log):
        return data.native, Reading(data.kind, "", data.step, *treatment), name or str(data.path)
    for argument, value, example in (("rate", rate, "100.0"), ("unit", unit, '"deg/h"')):
        if value is None:
            raise UsageError(f"{argument} is missing, which an array does not say\nadd for example {argument}={example}")
    assert rate is not None and unit is not None
    try:
        values = np.ascontiguousarray(data, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RecordError(f"the data are not an array of numbers: {error}") from error
    if np.ndim(data) != 1:
        raise RecordError(f"the array has {np.ndim(data)} dimensions\ngive one axis, as in data[:, 0]")
    return values, Reading(kind or "rate", unit, step_of(rate), *treatment), name or of_array


def limits_of(limits: Mapping[str, str | float] | None) -> list[str]:
    """Limits as the texts that the program takes."""
    return [f"{name}={value}" for name, value in (limits or {}).items()]
