"""Studies give what the program gives, to the last bit."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from program import Program

# Of every kind, and with everything that a study may have: a stop rule, closed forms, coefficients, trajectories, maps.
STUDIES = {
    "error_vs_dtnu": 2000,
    "which_filler": 2000,
    "filler_map": 200,
    "recorded_profile": 100,
    "readout_quantization": 500,
    "my_gyro": 40,
    "lgk400_vs_lgv1": 40,
    "design_point": 200,
    "relock_in_runs": 200,
    "relock_noise": 500,
    "drift_vs_interval_bound": None,
    "optimal_interval": None,
    "suspension": None,
}


def same(column: Any, place: int, expected: Any) -> bool:
    """Whether a cell is that of the program's JSON."""
    value = column[place]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and math.isnan(value):
        return expected is None
    return bool(value == expected)


def check(table: sagnac.Table, rows: list[dict[str, Any]]) -> None:
    assert table.rows == len(rows) > 0
    assert set(table) == set(rows[0])
    for place, row in enumerate(rows):
        for name, expected in row.items():
            assert same(table[name], place, expected), f"row {place}, {name}: {table[name][place]}, not {expected}"


@pytest.mark.parametrize("name", STUDIES)
def test_tables_and_files_are_those_of_the_program(
    name: str, program: Program, studies: Path, tmp_path: Path
) -> None:
    study, trials = studies / f"{name}.toml", STUDIES[name]
    asked = [] if trials is None else ["--trials", trials]
    expected = program("run", study, *asked, "--device", "cpu", "--out", tmp_path / "program")
    found = sagnac.run(study, trials=trials, device="cpu", out=tmp_path / "python")
    check(found.points, expected["tables"]["points"])
    if "coefficients" in expected["tables"]:
        assert found.coefficients is not None
        check(found.coefficients, expected["tables"]["coefficients"])
    else:
        assert found.coefficients is None
    assert (found.title, found.question) == (expected["title"], expected["question"])
    provenance = expected.get("provenance", {})
    for key in ["seed", "trials", "device", "sampled_trials"]:
        assert getattr(found, key) == provenance.get(key), key
    assert found.answer.data == expected["answer"]
    assert found.answer == expected["answer"]["headline"] and found.answer in found.answer.text
    assert list(found.notes) == expected["notes"]
    written = sorted(path.name for path in (tmp_path / "python").glob("*.csv"))
    for file in [*written, "resolved_study.toml"]:
        ours, theirs = (tmp_path / folder / file for folder in ["python", "program"])
        assert ours.read_bytes() == theirs.read_bytes(), file
    assert set(found.charts) == {path.stem for path in (tmp_path / "program").glob("*.svg")}
    for stem, svg in found.charts.items():
        assert svg == (tmp_path / f"program/{stem}.svg").read_text(encoding="utf-8")
    # The pages differ in how long the sampling took.
    digest = hashlib.sha256((tmp_path / "program/points.csv").read_bytes()).hexdigest()
    assert digest in found.report and digest in (tmp_path / "program/report.html").read_text(encoding="utf-8")
    assert found.report == (tmp_path / "python/report.html").read_text(encoding="utf-8")


def test_trajectories_are_those_of_the_file(studies: Path, tmp_path: Path) -> None:
    text = (studies / "design_point.toml").read_text(encoding="utf-8")
    assert "[run]" in text and "trajectories" not in text
    study = tmp_path / "study.toml"
    study.write_text(text.replace("[run]", "[run]\ntrajectories = 3"), encoding="utf-8")
    found = sagnac.run(study, trials=100, device="cpu", out=tmp_path / "out")
    assert found.trajectories is not None and found.trajectories.rows > 10
    lines = (tmp_path / "out/trajectories.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].split(",") == list(found.trajectories) and len(lines) == found.trajectories.rows + 1


def test_a_text_is_run_as_its_file_and_threads_seed_and_trials_are_followed(studies: Path) -> None:
    path = studies / "smoke.toml"
    text = path.read_text(encoding="utf-8")
    of_file = sagnac.run(str(path), trials=3000, seed=7, device="cpu", threads=1)
    of_text = sagnac.run(text, trials=3000, seed=7, device="cpu", threads=2)
    other = sagnac.run(text, trials=3000, seed=8, device="cpu")
    assert (of_file.seed, of_file.trials, of_file.folder) == (7, 3000, None)
    assert of_file.device is not None and "1 threads" in of_file.device
    assert np.array_equal(of_file.points["rms_arcsec"], of_text.points["rms_arcsec"])
    assert not np.array_equal(of_file.points["rms_arcsec"], other.points["rms_arcsec"])


def test_a_run_goes_on_from_what_the_folder_holds(studies: Path, tmp_path: Path, program: Program) -> None:
    study = studies / "smoke.toml"
    first = sagnac.run(study, trials=1000, device="cpu", out=tmp_path / "out")
    assert first.sampled_trials
    again = sagnac.run(study, trials=1000, device="cpu", out=tmp_path / "out")
    assert again.sampled_trials == 0 and again.folder == tmp_path / "out"
    # The program takes the folder over.
    more = program("run", study, "--trials", 2000, "--device", "cpu", "--out", tmp_path / "out")
    assert more["provenance"]["sampled_trials"] == first.sampled_trials


def test_columns_have_types_labels_and_units(studies: Path) -> None:
    points = sagnac.run(studies / "error_vs_dtnu.toml", trials=500, device="cpu").points
    assert points["switching.gap_ticks"].dtype == np.int64
    assert points["rms_arcsec"].dtype == np.float64
    assert points["filler"].dtype == object and points["filler"][0] == "const"
    # 500 trials bound no 99.73 % level: blank, and not 0.
    assert np.isnan(points["p99_73_hi_arcsec"]).all()
    assert (points.units["rms_arcsec"], points.labels["rms_arcsec"]) == ("″", "rms error")
    frame = points.to_pandas()
    assert list(frame.columns) == list(points) and len(frame) == points.rows
    with pytest.raises(KeyError, match="no column is called 'rms'; the columns are"):
        points["rms"]
