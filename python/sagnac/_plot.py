"""Plots with matplotlib, which is imported when the first one is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

import _sagnac

from .errors import UsageError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DASHES = ["-", "--", ":", "-.", (0, (8, 2)), (0, (8, 2, 2, 2, 2, 2))]
_MARKERS = ["o", "s", "^", "D", "v", "p"]
#: Most points of a line that all have markers.
_MAX_MARKED = 200


def axes_of(ax: Axes | None) -> Axes:
    """The given axes, or new ones."""
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        message = "plots need matplotlib, which is not installed\ninstall it with pip install matplotlib, or use the SVG texts in charts"
        raise UsageError(message) from error
    return plt.subplots(layout="constrained")[1]


def chosen(pictures: Mapping[str, Any], name: str | None) -> Any:
    """The picture of this name, by default the first."""
    if not pictures:
        raise UsageError("there is no chart to plot\na study has charts where it has [chart] or [[chart]], or a sweep")
    if name is None:
        return next(iter(pictures.values()))
    if name not in pictures:
        raise UsageError(f"chart={name!r} is not known\naccepted: {', '.join(pictures)}")
    return pictures[name]


def draw(picture: Mapping[str, Any], ax: Axes | None) -> Axes:
    """Draws a chart, whose content is that of the page."""
    ax = axes_of(ax)
    if picture["kind"] == "curves":
        _curves(picture, ax)
    else:
        _map(picture, ax)
    for axis, name in ((picture["x"], "x"), (picture["y"], "y")):
        getattr(ax, f"set_{name}label")(title_of(axis))
        if not axis["names"]:
            getattr(ax, f"set_{name}scale")(axis["scale"])
    if picture["x"]["names"]:
        ax.set_xticks(range(1, len(picture["x"]["names"]) + 1), picture["x"]["names"], rotation=20, ha="right")
    ax.set_title(picture["title"], fontsize="medium")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="small")
    return ax


def title_of(axis: Mapping[str, Any]) -> str:
    """The title of an axis."""
    title = f"{axis['label']}, {axis['unit']}" if axis["unit"] else str(axis["label"])
    return f"{title} with {axis['defined']}" if axis["defined"] else title


def colour(style: int) -> str:
    """The colour of a style, as on pages."""
    return _sagnac.colours[style % len(_sagnac.colours)]


def _numbers(values: Any) -> Any:
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _curves(figure: Mapping[str, Any], ax: Axes) -> None:
    names = [{entry["style"]: entry["name"] for entry in figure[by]["entries"]} for by in ("colours", "dashes")]
    has_laws = any(series["law"] for series in figure["series"])
    is_named = bool(figure["x"]["names"])
    for law in figure["laws"]:
        for at, line in enumerate(law["lines"]):
            look = "0.75" if line["colour"] is None else colour(line["colour"])
            label = law["label"] if at == 0 else None
            ax.plot(*_pairs(line["points"]), color=look, alpha=0.5, linewidth=4, label=label, zorder=1)
    for part in figure["parts"]["lines"]:
        look = colour(part["colour"])
        ax.plot(*_pairs(part["points"]), color=look, linewidth=1, linestyle="--", label=part["label"])
    for series in figure["series"]:
        points = series["points"]
        x, y = _numbers(p["x"] for p in points), _numbers(p["y"] for p in points)
        look = colour(series["colour"])
        dash = series["dash"] if names[1] else series["colour"]
        line = "none" if has_laws or is_named else _DASHES[dash % len(_DASHES)]
        marker = _MARKERS[dash % len(_MARKERS)] if len(x) <= _MAX_MARKED or has_laws else "none"
        texts = [text for text in (names[0].get(series["colour"]), names[1].get(series["dash"])) if text is not None]
        label = ", ".join(texts) or None
        ax.plot(x, y, color=look, linestyle=line, marker=marker, markersize=4, label=label, zorder=3)
        if series["law"] and not is_named:
            style = _DASHES[dash % len(_DASHES)]
            ax.plot(*_pairs(series["law"]), color=look, linewidth=1, linestyle=style, zorder=2)
        banded = [(p["x"], *p["band"]) for p in points if p["band"] is not None]
        if banded:
            at, low, high = (_numbers(column) for column in zip(*banded))
            if is_named:
                ax.vlines(at, low, high, color=look)
            else:
                ax.fill_between(at, low, high, color=look, alpha=0.2, linewidth=0)
    for mark in figure["marks"]:
        if mark["range"] is not None:
            ax.axvspan(*mark["range"], color="0.5", alpha=0.15, linewidth=0)
        ax.plot(*mark["place"], "D", color="black", markersize=6, markerfacecolor="white", zorder=4)
        if mark["label"]:
            ax.annotate(mark["label"], mark["place"], textcoords="offset points", xytext=(6, 6), fontsize="small")
    limit = figure["limit"]
    if limit is not None:
        ax.axhline(limit["value"], color="#b3001b", linestyle="--", linewidth=1.2, label=limit["label"])


def _pairs(points: Any) -> tuple[Any, Any]:
    return _numbers(x for x, _ in points), _numbers(y for _, y in points)


def _ends(values: Any, limit: Any, is_log: bool) -> tuple[tuple[float | None, float | None], str]:
    """The ends of the colours and their name: about a limit they reach equally far on both sides."""
    if limit is None or values.size == 0 or (is_log and limit["value"] <= 0):
        return (None, None), "viridis"
    at = np.log10 if is_log else np.asarray
    middle = float(at(limit["value"]))
    reach = float(np.max(np.abs(at(values) - middle))) or 1.0
    low, high = middle - reach, middle + reach
    return ((10.0**low, 10.0**high) if is_log else (low, high)), "RdBu_r"


def _map(chart: Mapping[str, Any], ax: Axes) -> None:
    from matplotlib.colors import ListedColormap, LogNorm, Normalize
    from matplotlib.patches import Patch

    columns, rows = _numbers(chart["columns"]), _numbers(chart["rows"])
    grid = (len(rows), len(columns))
    cells = chart["cells"]
    limit = chart["limit"]
    if "values" in cells:
        values = np.ma.masked_invalid(_numbers(cells["values"]).reshape(grid))
        is_log = chart["z"]["scale"] == "log"
        ends, cmap = _ends(values.compressed(), limit, is_log)
        norm = LogNorm(*ends) if is_log else Normalize(*ends)
        mesh = ax.pcolormesh(columns, rows, values, shading="nearest", norm=norm, cmap=cmap)
        ax.figure.colorbar(mesh, ax=ax, label=title_of(chart["z"]))
    else:
        entries = cells["winners"]["of"]["entries"]
        styles = [entry["style"] for entry in entries]
        place = [None if won is None else styles.index(won["style"]) for won in cells["winners"]["won"]]
        colours = [colour(style) for style in styles]
        shown = np.ma.masked_invalid(_numbers(place).reshape(grid))
        most = max(len(styles) - 1, 1)
        ax.pcolormesh(columns, rows, shown, shading="nearest", cmap=ListedColormap(colours), vmin=-0.5, vmax=most + 0.5)
        patches = [Patch(color=look, label=entry["name"]) for look, entry in zip(colours, entries)]
        ax.legend(handles=patches, fontsize="small", title=cells["winners"]["of"]["title"])
        values = np.ma.masked_invalid(_numbers(None if won is None else won["value"] for won in cells["winners"]["won"]).reshape(grid))
    if limit is not None and min(grid) > 1:
        ax.contour(columns, rows, values, levels=[limit["value"]], colors="#b3001b")
