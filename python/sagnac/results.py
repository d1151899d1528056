"""The results of a study."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _plot
from ._raw import RawAnswer, RawColumn

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

#: A column: float64 with NaN for unknown values, int64 for counts, object (str, or None for a blank) for names.
Column = NDArray[Any]


class Table(Mapping[str, Column]):
    """Columns by name, as in the files of a results folder: ``table["rms_arcsec"]``.

    Numbers have all their bits; the files show nine digits of them.
    """

    def __init__(self, columns: list[RawColumn]) -> None:
        self._columns: dict[str, Column] = {}
        self.labels: dict[str, str] = {}
        """The label of each column, for people."""
        self.units: dict[str, str] = {}
        """The unit of each column as on an axis, such as ``arcsec``; empty for plain numbers."""
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


class Answer(str):
    """An answer: its headline as a text, with what stands behind it. A notebook shows it as the card of the page."""

    text: str
    """Status, headline, table, facts and checks, as a terminal shows them."""
    card: str
    """The same as HTML."""
    data: dict[str, Any]
    """The same for programs, as in ``sagnac run --json``: ``kind``, ``status``, ``value``, ``limit``, ``table``, ``facts`` and ``checks``."""

    @property
    def value(self) -> float | None:
        """The value of the headline; None if it has none."""
        return None if self.data["value"] is None else float(self.data["value"]["value"])

    @property
    def unit(self) -> str:
        """The unit of the value; empty for a pure number."""
        return "" if self.data["value"] is None else str(self.data["value"]["unit"])

    @property
    def interval(self) -> tuple[float, float] | None:
        """The 95 % interval of the value; None for closed forms and too few trials."""
        ends = None if self.data["value"] is None else self.data["value"]["interval"]
        return None if ends is None else (float(ends[0]), float(ends[1]))

    @property
    def status(self) -> str:
        """``met``, ``not_met``, ``partly_met``, ``inconclusive`` or ``no_limit``."""
        return str(self.data["status"]["is"])

    @property
    def table(self) -> list[list[str]]:
        """The headings and the rows of the table, as texts."""
        rows = [[str(cell["text"]) for cell in row] for row in self.data["table"]["rows"]]
        return [list(self.data["table"]["columns"]), *rows]

    @property
    def facts(self) -> dict[str, dict[str, Any]]:
        """The facts by their names: ``worst_case``, ``error_budget``, ``change_to_meet``, ``most_effective_change``, ``caveat``."""
        return {str(fact["fact"]): fact for fact in self.data["facts"]}

    def _repr_html_(self) -> str:
        return self.card


def answer_of(found: RawAnswer) -> Answer:
    headline, text, card, data = found
    answer = Answer(headline)
    answer.text, answer.card, answer.data = text, card, json.loads(data)
    return answer


@dataclass(frozen=True)
class Charted:
    """What has a page with an answer and charts."""

    title: str
    answer: Answer
    """The answer; empty where there is none."""
    notes: tuple[str, ...]
    """Notes on omissions, rounding and assumptions, each a sentence."""
    charts: dict[str, str]
    """The charts as SVG texts, by the names of their files."""
    report: str
    """The page ``report.html`` of the program, as text: one file that needs no network. A notebook shows it as the result of a
    cell."""
    pictures: dict[str, Any] = field(repr=False)
    """The content of the charts, which :meth:`plot` draws."""

    def plot(self, chart: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draws a chart, by default the first, with matplotlib, which has to be installed; returns its axes.

        ``chart`` is one of the names in ``charts``. Without ``ax`` a new figure is made.
        """
        return _plot.draw(_plot.chosen(self.pictures, chart), ax)

    def _repr_html_(self) -> str:
        # A separate frame isolates its style and script.
        return f'<iframe srcdoc="{html.escape(self.report)}" style="width: 100%; height: 900px; border: 0"></iframe>'


@dataclass(frozen=True)
class Results(Charted):
    """The results of a study, as ``sagnac run`` gives them."""

    question: str
    """Question of the study; may be empty."""
    kind: str
    """Kind of the study, such as ``gap-fill``."""
    points: Table
    """A row for each point and estimate: points.csv."""
    coefficients: Table | None
    """The recovered coefficients, if the study fits any: coefficients.csv."""
    trajectories: Table | None
    """The runs that the study keeps as curves, if any: trajectories.csv."""
    seed: int | None
    """Seed; like trials, device and seconds, None if nothing is sampled."""
    trials: int | None
    """Requested trials at each point."""
    device: str | None
    sampled_trials: int | None
    """Trials sampled in this run over all points, without those that the folder contained before."""
    seconds: float | None
    """Duration of the sampling."""
    folder: Path | None
    """The folder in which the results are kept, if any."""

    def __repr__(self) -> str:
        return f"<Results of {self.title!r}: {self.points.rows} rows>"
