"""Curves of averaging times and deviations give what the program gives for their files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from program import Program

TAU = 2.0 ** np.arange(12)
READ = ["--unit", "deg/h"]


def deviations(n: float) -> Any:
    """White noise of n °/√h and flicker noise of 0.2 °/h."""
    return np.sqrt(3600.0 * n * n / TAU + 0.04)


def written(folder: Path, name: str, *columns: Any) -> Path:
    path = folder / name
    header = ",".join(["tau", "adev", "low", "high"][: len(columns)])
    np.savetxt(path, np.column_stack(columns), fmt="%.17g", delimiter=",", header=header, comments="")
    return path


def test_the_noise_of_a_curve_is_that_of_the_program(program: Program) -> None:
    sigma = deviations(0.05)
    for columns in ((TAU, sigma), (TAU, sigma, 0.95 * sigma, 1.05 * sigma)):
        path = written(program.folder, "curve.csv", *columns)
        expected = program("allan", "curve.csv", *READ, "--limit", "N=0.06 deg/sqrt(h)")
        found = sagnac.analyze(path, unit="deg/h", name="curve.csv", limits={"N": "0.06 deg/sqrt(h)"})
        # Notes name settings, which are options of the program.
        assert {**found.data, "notes": []} == {**expected, "notes": []}
        given = sagnac.analyze(columns, unit="deg/h", limits={"N": "0.06 deg/sqrt(h)"})
        assert given.data["tables"] == expected["tables"]
        [n] = [row["value"] for row in given.data["tables"]["coefficients"] if row["coefficient"] == "N"]
        assert n == pytest.approx(0.05)
    expected = program("allan", "curve.csv", *READ, "--curve-interval", "9h", "--rate", "2Hz")
    for data in (path, columns):
        found = sagnac.analyze(data, 2.0, unit="deg/h", curve_interval="9 h")
        assert found.data["tables"] == expected["tables"]
    with pytest.raises(sagnac.UsageError, match="rate=0"):
        sagnac.analyze(columns, 0.0, unit="deg/h", curve_interval="9 h")


def test_a_model_and_a_comparison_take_curves(program: Program) -> None:
    first, second = deviations(0.05), deviations(0.06)
    paths = [written(program.folder, f"{name}.csv", TAU, sigma) for name, sigma in (("a", first), ("b", second))]
    model = sagnac.model((TAU, first), unit="deg/h", name="a.csv")
    expected = program("model", "a.csv", *READ, "--overbound")
    assert model.data["tables"] == expected["tables"]
    compared = sagnac.compare((TAU, first), (TAU, second), unit="deg/h", names=("a.csv", "b.csv"))
    expected = program("compare", "a.csv", "b.csv", *READ)
    assert compared.data["tables"] == expected["tables"]
    assert sagnac.compare(paths[0], paths[1], unit="deg/h").answer[:25] == str(compared.answer)[:25]
    (program.folder / "sheet.toml").write_text('angle_random_walk = "0.04 deg/sqrt(h)"\n')
    expected = program("compare", "sheet.toml", "a.csv", *READ)
    for sheet in ({"angle_random_walk": "0.04 deg/sqrt(h)"}, program.folder / "sheet.toml"):
        found = sagnac.compare(sheet, (TAU, first), unit="deg/h", names=("sheet.toml", "a.csv"))
        assert found.data["tables"] == expected["tables"]
    expected = program("compare", "a.csv", "b.csv", *READ, "--curve-interval", "5%")
    compared = sagnac.compare(paths[0], paths[1], unit="deg/h", names=("a.csv", "b.csv"), curve_interval="5%")
    assert compared.data["tables"] == expected["tables"]
    record = np.random.default_rng(1).normal(0.0, 3.0, 20_000)
    mixed = sagnac.compare(record, (TAU, first), 1.0, unit="deg/h")
    assert mixed.data["tables"]["coefficients"][0]["status"] == "consistent"


def test_what_a_curve_cannot_give_is_said(program: Program) -> None:
    curve = (TAU, deviations(0.05))
    calls: dict[str, Callable[[], object]] = {
        "dynamic=True needs a record": lambda: sagnac.analyze(curve, unit="deg/h", dynamic=True),
        "confidence=0.9 needs a record": lambda: sagnac.model(curve, unit="deg/h", confidence=0.9),
        "remove_outliers=True needs a record": lambda: sagnac.compare(curve, curve, unit="deg/h", remove_outliers=True),
        'curve_interval="0%"': lambda: sagnac.analyze(curve, unit="deg/h", curve_interval="0%"),
        "is that of a curve": lambda: sagnac.analyze(TAU, 1.0, unit="deg/h", curve_interval="5%"),
        "unit is missing": lambda: sagnac.analyze(curve),
    }
    for wrong, call in calls.items():
        with pytest.raises(sagnac.UsageError, match=wrong):
            call()
    with pytest.raises(sagnac.RecordError, match="one end"):
        sagnac.analyze((TAU, TAU, TAU), unit="deg/h")


def test_a_hat_is_that_of_the_program(program: Program) -> None:
    rng = np.random.default_rng(5)
    table = 30.0 * np.sin(0.01 * np.arange(4096))
    records = [table + rng.normal(0.0, sigma, table.size) for sigma in (1.0, 2.0, 0.5)]
    path = program.folder / "table.csv"
    np.savetxt(path, np.column_stack(records), fmt="%.17g", delimiter=",", header="g1,g2,g3", comments="")
    expected = program("compare", "table.csv", *READ, "--rate", "1Hz", "--column", "g1,g2,g3", "--hat")
    names = ("g1", "g2", "g3")
    found = sagnac.hat(records, 1.0, unit="deg/h", names=names)
    assert found.data["tables"] == expected["tables"]
    of_log = sagnac.hat(sagnac.read_log(path, column=list(names), rate=1.0, unit="deg/h"))
    assert of_log.data["tables"] == expected["tables"]
    with pytest.raises(sagnac.UsageError, match="found 2"):
        sagnac.hat(records[:2], 1.0, unit="deg/h")
