"""Recorded logs, read as the program reads them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import _sagnac

from .errors import UsageError
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
    remove_events: bool
    unit_check: bool
    threads: int


@dataclass(frozen=True)
class _Wanted:
    columns: list[str]
    kind: str | None
    units: list[str]
    step_s: float | None
    time: str | None
    time_unit: str | None
    duplicates: str | None
    decimal: str | None
    binary: str | None
    temperature: str | None
    temperature_unit: str | None
    skip_s: float
    until_s: float | None
    unit_check: bool
    threads: int


@dataclass(frozen=True, eq=False)
class Log:
    """A recorded log, which all functions for records take: its columns of evenly spaced samples, and what was inferred about the file.

    ``log["gz"]`` is the log with that column alone, and so is ``log[0]`` by its place; iteration gives one after the other.
    """

    path: Path
    """The file."""
    native: _sagnac.Log

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns without their units; the number of a column that has no name."""
        return tuple(name for name, _ in self.native.columns)

    @property
    def kind(self) -> str:
        """``rate``, ``increment`` or ``angle``."""
        return self.native.kind

    @property
    def rate(self) -> float:
        """Samples per second."""
        return 1.0 / self.native.step_s

    @property
    def step(self) -> float:
        """Time from sample to sample, s."""
        return self.native.step_s

    @property
    def notes(self) -> tuple[str, ...]:
        """What was inferred about the file, and what looks doubtful in it, each a sentence."""
        return tuple(self.native.notes)

    @property
    def times(self) -> Numbers:
        """Time of each sample from the start of the file, s."""
        return self.native.start_s + self.native.step_s * np.arange(self.native.samples, dtype=np.float64)

    @property
    def is_compensated(self) -> bool:
        """Whether its dependence on temperature was subtracted."""
        return self.native.is_compensated

    @cached_property
    def temperature(self) -> Numbers | None:
        """The temperature at each sample, °C, NaN where it is missing; None if the log was read without one."""
        found = self.native.temperature()
        return None if found is None else found[1]

    @cached_property
    def values(self) -> Numbers:
        """The samples of the only column, as in the file, in its ``unit``; NaN where one is missing."""
        return self.native.values(self._only())

    @property
    def unit(self) -> str:
        """The unit of the only column, as in the file or as given."""
        return self.native.columns[self._only()][1]

    @property
    def gaps(self) -> tuple[range, ...]:
        """The places of missing samples of the only column, a range for each gap."""
        return tuple(range(*ends) for ends in self.native.gaps(self._only()))

    @property
    def missing(self) -> int:
        """The number of missing samples of the only column."""
        return sum(map(len, self.gaps))

    def compensated(
        self,
        *,
        terms: Literal["auto"] | Sequence[str] = "auto",
        detrend: bool = False,
        remove_outliers: bool = False,
        threads: int | None = None,
    ) -> Log:
        """The log without its dependence on temperature, as ``--compensate`` makes it; a column without one stays as it is.

        The log has to be read with its ``temperature``. ``terms`` are ``auto`` or some of T, T2, dT, ``warm-up``, ``aging``.
        """
        reading = Reading(self.kind, "", self.step, detrend, remove_outliers, False, True, _threads(threads))
        return Log(self.path, self.native.compensated(effects_of(terms), reading))

    def _only(self) -> int:
        if len(self) != 1:
            names = ", ".join(self.columns)
            raise UsageError(f'the log has several columns: {names}\nchoose one, as in log["{self.columns[0]}"]')
        return 0

    def __getitem__(self, column: str | int) -> Log:
        if isinstance(column, str):
            if column not in self.columns:
                raise KeyError(f"no column is called {column!r}; the columns are {', '.join(self.columns)}")
            column = self.columns.index(column)
        return Log(self.path, self.native.only(range(len(self))[column]))

    def __iter__(self) -> Iterator[Log]:
        return (self[place] for place in range(len(self)))

    def __len__(self) -> int:
        """The number of columns."""
        return len(self.native.columns)

    def __repr__(self) -> str:
        return f"<Log of {self.native.samples} samples at {self.rate:g} Hz: {', '.join(self.columns)}>"


def read_log(
    path: str | os.PathLike[str],
    *,
    column: str | int | Sequence[str | int] = (),
    rate: float | None = None,
    unit: str | Sequence[str] = (),
    kind: Kind | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    duplicates: Literal["first", "last", "keep"] | None = None,
    decimal: Literal["point", "comma"] | None = None,
    binary: str | None = None,
    temperature: str | int | None = None,
    temperature_unit: str | None = None,
    skip: float = 0.0,
    until: float | None = None,
    unit_check: bool = True,
    threads: int | None = None,
) -> Log:
    """Reads a recorded log as ``sagnac allan`` reads it.

    Parameters
    ----------
    path
        CSV and other text, Stable32, NumPy, MATLAB, HDF5, MCAP, ROS bags, PX4, ArduPilot, or raw binary with ``binary``.
    column
        Columns by name or number from 1, a range such as ``"2-4"``, or ``"all"``; by default the only one, or all whose units fit.
    rate
        Samples per second; time stamps then only show where samples are missing. By default it follows from them.
    unit
        One unit for all columns, or one for each, as for :func:`allan`; by default those of the header.
    kind
        As for :func:`allan`; by default what names and units say, else ``rate``.
    time, time_unit
        Column of the time stamps, ``"none"`` to ignore them, and their unit, ``s``, ``ms``, ``us`` or ``ns``.
    duplicates
        Rows with the time of the row before, but other numbers: the first or the last of them, or each as a sample.
    decimal
        Sign before decimals in a text, ``point`` or ``comma``.
    binary
        Layout of a raw binary file, such as ``"f64 x7, little, time 1, rate 3"``.
    temperature, temperature_unit
        Column of a temperature on which the samples depend, and its unit, ``°C``, ``K`` or ``°F``.
    skip, until
        Times from the start of the file, s, before and after which samples are omitted.
    unit_check
        Notes samples that seem to be in another unit.
    threads
        As for :func:`allan`.

    Raises
    ------
    RecordError
        The file is refused; the message has the file, the line and what settles it.
    UsageError
        An argument is not accepted.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "gyro.csv"
    ...     lines = [f"{10 * i},{8 + i % 3}" for i in range(20) if i != 3]
    ...     _ = path.write_text("time [ms],gz [deg/h]\\n" + "\\n".join(lines))
    ...     log = read_log(path)
    >>> log.rate, log.columns, log.unit, log.gaps
    (100.0, ('gz',), 'deg/h', (range(3, 4),))
    """
    path = Path(path)
    if path.suffix.lower() == ".toml":
        raise UsageError(f"{path} is a study, not a log\nrun it with sagnac.run")
    wanted = _Wanted(
        columns=_texts(column),
        kind=kind,
        units=_texts(unit),
        step_s=None if rate is None else step_of(rate),
        time=None if time is None else str(time),
        time_unit=time_unit,
        duplicates=duplicates,
        decimal=decimal,
        binary=binary,
        temperature=None if temperature is None else str(temperature),
        temperature_unit=temperature_unit,
        skip_s=_seconds("skip", skip),
        until_s=None if until is None else _seconds("until", until),
        unit_check=unit_check,
        threads=_threads(threads),
    )
    return Log(path, _sagnac.read_log(path, wanted))


def step_of(rate: float) -> float:
    """The time between samples, s."""
    step = 1.0 / rate if rate > 0.0 else 0.0
    if not 1e-9 <= step <= 1e9:
        raise UsageError(f"rate={rate}\naccepted: samples per second from 1e-9 to 1e9")
    return step


def effects_of(terms: str | Sequence[str]) -> str:
    """Terms of a dependence on temperature, as the native part takes them."""
    return terms if isinstance(terms, str) else ",".join(terms)


def _texts(values: str | int | Sequence[str | int]) -> list[str]:
    """One value, or several, of which a text may separate them by commas."""
    if isinstance(values, str):
        return [value.strip() for value in values.split(",")]
    return [str(values)] if isinstance(values, int) else [str(value) for value in values]


def _seconds(name: str, value: float) -> float:
    if not value >= 0.0:
        raise UsageError(f"{name}={value}\naccepted: seconds from 0")
    return float(value)
