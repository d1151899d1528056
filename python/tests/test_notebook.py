"""The notebook runs from the first cell to the last, and its plots where matplotlib is installed."""

from __future__ import annotations

import importlib.util
import json
from typing import Any

import pytest

from program import ROOT

NOTEBOOK = ROOT / "python/notebook/sagnac.ipynb"
HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None


def test_every_cell_runs_in_order() -> None:
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 10
    if HAS_MATPLOTLIB:
        import matplotlib

        matplotlib.use("Agg")
    else:
        cells = [cell for cell in cells if ".plot(" not in cell]
        print("NOT SHOWN HERE: matplotlib is not installed, so the plots of the notebook are left out")
    names: dict[str, Any] = {}
    for place, cell in enumerate(cells):
        exec(compile(cell, f"cell {place + 1} of {NOTEBOOK.name}", "exec"), names)
    assert "Switch every" in names["design"].answer


def test_the_notebook_has_no_outputs() -> None:
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert all(cell.get("outputs", []) == [] for cell in notebook["cells"])


@pytest.mark.skipif(HAS_MATPLOTLIB, reason="matplotlib is installed")
def test_without_matplotlib_a_plot_says_what_to_install() -> None:
    import sagnac

    with pytest.raises(sagnac.UsageError, match="pip install matplotlib"):
        sagnac.filler("quadratic", 3).plot()
