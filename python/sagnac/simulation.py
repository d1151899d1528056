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
    switch_every_s: float | None
    at: list[str]
    seed: int | None
    axes: int
    motions: list[tuple[int, str, str]]
    misalignment: list[str]
    scale_factor: list[str]
    warming: tuple[str, str] | None
    truth: bool
    data: str
    first: int
    records: int
    device: str
    threads: int


def simulate(
    noise_or_study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    rate: float | None = None,
    length: float | None = None,
    switch_every: float | None = None,
    at: Mapping[str, object] | None = None,
    records: int = 1,
    first: int = 0,
    seed: int | None = None,
    axes: Literal[1, 3] = 1,
    motion: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    misalignment: Mapping[str, str] | None = None,
    scale_factor: str | Mapping[str, str] | None = None,
    temperature: tuple[float, float] | None = None,
    temperature_coefficient: str | None = None,
    truth: bool = False,
    data: Literal["rate", "increment", "angle", "pulses"] = "rate",
    device: str = "cpu",
    threads: int | None = None,
) -> NDArray[np.float64]:
    """Records of a gyro with some noise, at rest or with a motion, as ``sagnac simulate`` writes them, to the last bit.

    Parameters
    ----------
    noise_or_study
        A noise, as ``sagnac allan`` writes it, a study of kind ``allan``, whose trials the records are, or one of kind ``gap-fill``,
        ``switched-run`` or ``lock-in``: the path of the file, its text, which is recognized by its line ends, or a dictionary of
        its keys.
    rate, length
        Samples per second, for a noise, and time in s, for a noise, for ``gap-fill``, or instead of the run time of ``switched-run``.
    switch_every
        Time between mode switches in s, for ``gap-fill``. The samples of the gap after each are lost, which is NaN; those of the true
        motion are not.
    at
        Values of swept keys, for a study with sweeps, such as ``{"length": "4 h"}``.
    records, first
        Number of records, and the number of the first one. A record of a seed is the same wherever it is made.
    seed
        By default that of the study, or 1.
    axes
        1, or 3 with noise of their own.
    motion
        Motion of the base: the keys of ``[motion]`` of a study, as a path, a text or a dictionary. With three axes it is about z, or
        a dictionary has the motion about each axis, such as ``{"x": "roll.toml", "z": {"rate": "10 deg/s"}}``.
    misalignment
        Angles by which an axis senses the motion about another, such as ``{"xy": "10 arcsec"}``.
    scale_factor
        Errors of scale factors, such as ``{"x": "10 ppm"}``, or ``"10 ppm"`` for the only axis.
    temperature, temperature_coefficient
        Temperatures at the start and at the end in °C, and the rate per kelvin above that at the start, such as ``"0.02 deg/h/K"``.
    truth
        Whether the true motion is returned too.
    data
        ``rate`` in °/h, or angles in ″: ``increment`` of each sample, or ``angle`` from the start; or ``pulses`` of each sample.
    device
        The device that makes the noise, as of :func:`run`.
    threads
        Threads of the processor; by default all logical cores.

    Returns
    -------
    array
        Of shape (records, samples); or (records, columns, samples) where the files of the program have several columns besides the
        time. These are the readings about x, y and z or about the only axis, then with ``truth`` the motion about each axis that has
        one, as numbers of the same kind or, beside pulses, in ″ of each sample, and last the temperature in °C, if it is given.

    Raises
    ------
    StudyError
        The noise or the study is invalid; the message shows the place.
    UsageError
        An argument is missing or not accepted, or the file cannot be read.
    DeviceError
        The device failed.

    Examples
    --------
    >>> noise = {"angle_random_walk": "0.003 deg/sqrt(h)"}
    >>> rates = simulate(noise, rate=1.0, length=3600.0, records=2, seed=3)
    >>> rates.shape, round(float(rates.std()) / 60.0, 3)
    ((2, 3600), 0.003)
    >>> x, y, z, true_z = simulate(noise, rate=1.0, length=3600.0, axes=3, motion={"rate": "15 deg/h"}, truth=True)[0]
    >>> round(float((z - true_z).std()) / 60.0, 3)
    0.003
    """
    if axes not in (1, 3):
        raise UsageError(f"axes={axes!r}\naccepted: 1, 3")
    if (temperature is None) != (temperature_coefficient is None):
        raise UsageError("a dependence on temperature has two numbers\ngive both temperature= and temperature_coefficient=")
    path, text = _source(noise_or_study)
    wanted = Wanted(
        None if rate is None else step_of(rate),
        None if length is None else float(length),
        None if switch_every is None else float(switch_every),
        _by_name(at or {}),
        None if seed is None else _whole("seed", seed, 0, (1 << 63) - 1),
        axes,
        [] if motion is None else _motions(motion, axes),
        _by_name(misalignment or {}),
        [scale_factor] if isinstance(scale_factor, str) else _by_name(scale_factor or {}),
        None if temperature is None else ("..".join(map(str, temperature)), str(temperature_coefficient)),
        truth,
        data,
        _whole("first", first, 0, MAX_TRIALS - MAX_RECORDS),
        _whole("records", records, 1, MAX_RECORDS),
        device,
        _threads(threads),
    )
    return _sagnac.simulate(path, text, wanted)


def _by_name(values: Mapping[str, object]) -> list[str]:
    return [f"{name}={value}" for name, value in values.items()]


def _motions(motion: str | os.PathLike[str] | Mapping[str, Any], axes: int) -> list[tuple[int, str, str]]:
    """The motions with their axes."""
    if isinstance(motion, Mapping) and motion and all(key in ("x", "y", "z") for key in motion):
        return [("xyz".index(axis), *_motion(about)) for axis, about in motion.items()]
    return [(axes - 1, *_motion(motion))]


def _motion(motion: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str]:
    """The path and the text of a motion."""
    path, text = _source(motion)
    if path is None:
        return "motion", text
    try:
        return str(path), path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read the motion {path}: {error}") from None
