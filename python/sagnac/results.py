"""What a study gives."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._raw import RawColumn

if TYPE_CHECKING:
    import pandas

#: A column: float64 with NaN for what is not known, int64 for counts, object (str, or None for a blank) for names.
Column = NDArray[Any]


class Table(Mapping[str, Column]):
    """Columns by name, as in the files of a results folder: ``table["rms_arcsec"]``.

    Numbers have all their bits; the files show nine digits of them.
    """

    def __init__(self, columns: list[RawColumn]) -> None:
        self._columns: dict[str, Column] = {}
        self.labels: dict[str, str] = {}
        """What each column is, for people."""
        self.units: dict[str, str] = {}
        """The unit of each column as an axis has it, such as ``″``; empty for plain numbers."""
        for name, label, unit, values in columns:
            if isinstance(values, list):
                texts = np.empty(len(values), dtype=object)
                texts[:] = values
                values = texts
            self._columns[name] = values
            self.labels[name] = label
            self.units[name] = unit

    @property
    def rows(self) -> int:
        """The number of rows."""
        return next((len(column) for column in self._columns.values()), 0)

    def __getitem__(self, name: str) -> Column:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"no column is called {name!r}; the columns are {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """The number of columns."""
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<Table of {self.rows} rows: {', '.join(self._columns)}>"

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a pandas DataFrame; pandas has to be installed."""
        import pandas

        return pandas.DataFrame(self._columns)


@dataclass(frozen=True)
class Verdict:
    """What the curves of a chart are against its limit."""

    text: str
    """A heading, and a sentence for each curve."""
    data: dict[str, Any]
    """The same for programs: ``charts``, ``of``, ``where``, the limit, and in ``series`` for each curve its ``outcome`` and
    the places ``at`` and ``until``."""

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True)
class Results:
    """The results of a study, as ``sagnac run`` gives them."""

    title: str
    question: str
    """Empty where the study asks none."""
    kind: str
    """Such as ``gap-fill``."""
    points: Table
    """A row for each point and estimate: points.csv."""
    coefficients: Table | None
    """How well coefficients are found again, where a study fits them: coefficients.csv."""
    trajectories: Table | None
    """The runs that a study keeps as curves: trajectories.csv."""
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...]
    """What is left out, rounded or assumed, each in a sentence."""
    charts: dict[str, str]
    """The charts of the study as SVG texts, by the names of their files."""
    report: str
    """The page ``report.html`` of ``sagnac run``, as text: one file that needs no network. A notebook shows it as the result of a cell."""
    seed: int | None
    """None where nothing is sampled; so are trials, device and seconds."""
    trials: int | None
    """At each point, as asked for."""
    device: str | None
    sampled_trials: int | None
    """Over all points, in this run: what the folder held before is not among them."""
    seconds: float | None
    """Of sampling."""
    folder: Path | None
    """Where the results are kept, if they are."""

    def __repr__(self) -> str:
        return f"<Results of {self.title!r}: {self.points.rows} rows>"

    def _repr_html_(self) -> str:
        # In a frame of its own, so that its style and script stay with it.
        return f'<iframe srcdoc="{html.escape(self.report)}" style="width: 100%; height: 900px; border: 0"></iframe>'
