"""Files of a results folder load without options: numbers are numbers, blanks NaN, names as written."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sagnac
from program import Program

# What R's read.csv and MATLAB's readtable take as names: these change other signs, or cut what is longer.
NAME = re.compile(r"[A-Za-z][A-Za-z0-9._]{0,62}")

TEXTS = {
    "filler", "error", "angle", "compensation", "tick", "coefficient", "unit", "column", "deviation", "status",
    "intervals", "alpha_from", "edf_from", "row", "treatment", "noise.file", "relock.compensation",
    "motion.suspension.gyro", "suspension.gyro", "gyro",
}  # fmt: skip


def check(path: Path) -> pd.DataFrame:
    header = path.read_text(encoding="utf-8").splitlines()[0]
    table = pd.read_csv(path)
    names = list(table.columns)
    assert header.split(",") == names, path
    assert len({name.lower() for name in names}) == len(names), names
    for name in names:
        assert NAME.fullmatch(name), f"{path}: {name}"
        is_number = table[name].dtype.kind in "if"
        # A column of blanks alone is numbers that are not known.
        assert is_number or name in TEXTS, f"{path}: {name} is read as {table[name].dtype}"
    return table


def written(folder: Path, *names: str) -> list[pd.DataFrame]:
    return [check(folder / name) for name in names]


@pytest.mark.parametrize(
    "name, trials", [("error_vs_dtnu", 100), ("my_gyro", 20), ("design_point", 50), ("relock_noise", 100),
                     ("relock_in_runs", 50), ("lgk400_vs_lgv1", 10), ("suspension", None), ("optimal_interval", None)]
)  # fmt: skip
def test_tables_of_studies_load_as_they_are(name: str, trials: int | None, studies: Path, tmp_path: Path) -> None:
    found = sagnac.run(studies / f"{name}.toml", trials=trials, device="cpu", out=tmp_path)
    tables = {"points.csv": found.points, "coefficients.csv": found.coefficients}
    for file, table in tables.items():
        if table is None:
            continue
        frame = check(tmp_path / file)
        assert len(frame) == table.rows
        for column, values in table.items():
            if values.dtype.kind == "f":
                # Nine digits.
                np.testing.assert_allclose(frame[column].to_numpy(float), values, rtol=5e-9, atol=0.0)
            elif values.dtype.kind == "i":
                assert (frame[column] == values).all()
            else:
                assert list(frame[column].astype(str)) == [str(value) for value in values]


def test_tables_of_logs_and_designs_load_as_they_are(program: Program, studies: Path, tmp_path: Path) -> None:
    log = studies / "data/gyro_at_rest.csv"
    program("allan", log, "--data", "rate", "--rate", "1Hz", "--deviation", "oadev,hdev", "--out", tmp_path / "log")
    curve, coefficients = written(tmp_path / "log", "curve.csv", "coefficients.csv")
    assert curve["value"].dtype == np.float64 and set(curve["deviation"]) == {"oadev", "hdev"}
    # Not "NA", not the Boolean F, and N is no missing value.
    assert list(coefficients["coefficient"][:5]) == ["Q", "N", "B", "K", "R"]
    assert coefficients["value"].isna().any() and coefficients["value"].dtype == np.float64
    study = tmp_path / "design.toml"
    text = (studies / "design_point.toml").read_text(encoding="utf-8")
    study.write_text(re.sub(r"(?m)^trials = .*", "trials = 200", text), encoding="utf-8")
    program("design", study, "--device", "cpu", "--out", tmp_path / "design")
    check(tmp_path / "design/design.csv")
    program("filler", "quadratic", "--gap-ticks", 3, "--out", tmp_path / "filler")
    check(tmp_path / "filler/weights.csv")
