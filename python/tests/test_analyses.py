"""Designs, comparisons and spectra are those of the program, and every result plots what its chart has."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from program import Program

RATE = 100.0


def record(seed: int, sigma: float) -> Any:
    times = np.arange(20_000) / RATE
    return np.random.default_rng(seed).normal(0.0, sigma, times.size) + 0.3 * np.sin(2 * np.pi * 20.0 * times)


def written(folder: Path, name: str, values: Any) -> Path:
    path = folder / name
    np.savetxt(path, values, fmt="%.17g")
    return path


def without(document: Any, *keys: str) -> Any:
    return {key: value for key, value in document.items() if key not in keys}


def test_a_design_is_that_of_the_program(program: Program, studies: Path) -> None:
    study = studies / "design_point.toml"
    found = sagnac.design(study, trials=64, device="cpu")
    expected = program("design", study, "--trials", 64, "--device", "cpu", "--out", "out")
    assert found.data == expected
    assert found.answer.data == expected["answer"]
    assert found.report == (program.folder / "out/report.html").read_text(encoding="utf-8")
    assert found.tables["design.csv"].rows == len(expected["tables"]["design"])
    searched = sagnac.design(study, trials=64, search=True, latency="20 ms", memory=600, device="cpu")
    options = ["--trials", 64, "--search", "--latency", "20 ms", "--memory", 600, "--device", "cpu"]
    assert searched.data == program("design", study, *options, "--out", "searched")
    assert searched.tables["pareto.csv"].rows == len(searched.data["tables"]["pareto"])
    with pytest.raises(sagnac.UsageError, match="below 0"):
        sagnac.design(study, latency="-1 ms")
    with pytest.raises(sagnac.UsageError, match="search"):
        sagnac.design(study, band="18 Hz,22 Hz")
    with pytest.raises(sagnac.UsageError, match="accepted: drift_p99_73"):
        sagnac.design(study, by="drift")  # type: ignore[arg-type]
    with pytest.raises(sagnac.StudyError, match="switched-run"):
        sagnac.design(studies / "smoke.toml")


def test_a_sensitivity_is_that_of_the_program(program: Program, studies: Path) -> None:
    study = studies / "what_decides.toml"
    found = sagnac.sensitivity(study, by="theory_rms", samples=32, device="cpu")
    expected = program(
        "sensitivity", study, "--by", "theory_rms", "--samples", 32, "--device", "cpu", "--out", "out"
    )  # fmt: skip
    assert found.data == expected
    assert found.report == (program.folder / "out/report.html").read_text(encoding="utf-8")
    assert set(found.tables) == {"sensitivity.csv", "distribution.csv"} and found.answer
    with pytest.raises(sagnac.UsageError, match="none"):
        sagnac.sensitivity(study, by="none")
    with pytest.raises(sagnac.StudyError, match="uncertain inputs"):
        sagnac.sensitivity(studies / "smoke.toml")


def test_a_comparison_is_that_of_the_program(program: Program) -> None:
    a, b = record(1, 1.0), record(2, 1.4)
    files = [written(program.folder, name, values) for name, values in (("A.csv", a), ("B.csv", b))]
    read = ["--data", "rate", "--unit", "deg/h", "--rate", "100Hz"]
    expected = program("compare", *files, *read, "--limit", "N=1.1")
    found = sagnac.compare(a, b, RATE, unit="deg/h", limits={"N": 1.1})
    for table in ("coefficients", "compare", "limits"):
        assert found.data["tables"][table] == expected["tables"][table], table
    assert found.answer.status == expected["answer"]["status"]["is"] == "not_met"
    with pytest.raises(sagnac.UsageError, match="limits: the limit on N"):
        sagnac.compare(a, b, RATE, unit="deg/h", limits={"N": "0.1 deg/sqrt(h)"})  # type: ignore[dict-item]
    assert found.answer and set(found.tables) == {f"{stem}.csv" for stem in expected["tables"]}
    with pytest.raises(sagnac.RecordError, match="at least 16"):
        sagnac.compare(a[:4], b, RATE, unit="deg/h")


def test_a_spectrum_is_that_of_the_program(program: Program) -> None:
    values = record(3, 1.0)
    path = written(program.folder, "record.csv", values)
    read = ["--data", "rate", "--unit", "deg/h", "--rate", "100Hz", "--bootstrap", 0]
    expected = program("allan", path, *read, "--limit", "floor=1 deg/sqrt(h)")
    found = sagnac.psd(values, RATE, unit="deg/h", bootstrap=0, limits={"floor": "1 deg/sqrt(h)"})
    assert found.answer.status == "met"
    for table in ("limits", "psd", "lines", "white_noise"):
        ours, theirs = (
            [{key: cell for key, cell in row.items() if key not in ("record", "column")} for row in rows]
            for rows in (found.data["tables"][table], expected["tables"][table])
        )
        assert ours == theirs, table
    assert found.tables["psd.csv"].rows > 100
    wrong: Any
    for wrong in ({"confidence": 2.0}, {"segment_detrend": "cubic"}, {"terms": "N"}):
        with pytest.raises(sagnac.UsageError, match=next(iter(wrong))):
            sagnac.psd(values, RATE, unit="deg/h", **wrong)


STUDY: dict[str, Any] = {
    "title": 'A "gap"\n',
    "kind": "gap-fill",
    "trials": np.int64(1000),
    "gyro": {"tick": "5 ms", "tick_noise": {"std": "0.5 arcsec"}},
    "motion": {"amplitude": "12000 arcsec/s", "frequency": "20 Hz"},
    "switching": {"gap_ticks": 3, "fillers": ["const", {"kind": "weights", "weights": [["1", "1", "1"]]}]},
    "sweep": [{"key": "motion.frequency", "list": ["5 Hz", "20 Hz"]}, {"key": "switching.gap_ticks", "list": [1, 3]}],
}


def test_a_study_as_a_dictionary_is_the_study_in_its_text() -> None:
    study = {**STUDY, "switching": {"gap_ticks": 3, "fillers": ["const", "quadratic"]}}
    text = """
title = 'A "gap"'
kind = "gap-fill"
trials = 1000
gyro = { tick = "5 ms", tick_noise = { std = "0.5 arcsec" } }
motion = { amplitude = "12000 arcsec/s", frequency = "20 Hz" }
switching = { gap_ticks = 3, fillers = ["const", "quadratic"] }
sweep = [{ key = "motion.frequency", list = ["5 Hz", "20 Hz"] }, { key = "switching.gap_ticks", list = [1, 3] }]
"""
    found, expected = sagnac.run({**study, "title": 'A "gap"'}), sagnac.run(text)
    for name, column in expected.points.items():
        np.testing.assert_array_equal(found.points[name], column)
    assert found.answer == expected.answer != ""


@pytest.mark.parametrize(
    ("study", "place"),
    [
        ({**STUDY, "trials": None}, "trials = None"),
        ({**STUDY, "gyro": {"tick": 5j}}, r"gyro.tick = 5j"),
        ({**STUDY, "gyro": {"tick_noise": {"std": float("nan")}}}, r"gyro.tick_noise.std = nan"),
        ({**STUDY, "sweep": [{"key": "motion.frequency", "list": ["5 Hz", set()]}]}, r"sweep\[0\].list\[1\] = set"),
        ({"": "x"}, "the key '' is not a text"),
    ],
)
def test_what_has_no_place_in_a_study_is_named(study: Any, place: str) -> None:
    with pytest.raises(sagnac.UsageError, match=place):
        sagnac.run(study)


def test_an_unknown_key_of_a_dictionary_is_shown_in_its_line() -> None:
    with pytest.raises(sagnac.StudyError, match=r"(?s)tock.*did you mean"):
        sagnac.run({**STUDY, "gyro": {"tock": "5 ms"}})


def test_every_result_plots_what_its_chart_has(studies: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib", reason="NOT SHOWN HERE: matplotlib is not installed")
    matplotlib.use("Agg")
    values = record(4, 1.0)
    results = [
        sagnac.run(studies / "error_vs_dtnu.toml", trials=200),
        sagnac.run(studies / "filler_map.toml", trials=64),
        sagnac.design(studies / "design_point.toml", trials=64, device="cpu"),
        sagnac.compare(values, record(5, 1.0), RATE, unit="deg/h"),
        sagnac.psd(values, RATE, unit="deg/h", bootstrap=0),
    ]
    for result in results:
        assert result.answer
        for name, svg in result.charts.items():
            axes = result.plot(name)
            assert axes.get_xlabel() in svg or "&" in svg, name
            picture = result.pictures[name]
            if picture["kind"] == "curves":
                lines = [line.get_xydata() for line in axes.get_lines()]
                for series in picture["series"]:
                    points = [[np.nan if p[k] is None else p[k] for k in "xy"] for p in series["points"]]
                    assert any(np.array_equal(line, points, equal_nan=True) for line in lines), name
            matplotlib.pyplot.close(axes.figure)
    for found in (sagnac.allan(values, RATE, unit="deg/h"), sagnac.fit(values, RATE, unit="deg/h", bootstrap=0)):
        assert found.answer and found.plot().get_xscale() == "log"
    labelled = sagnac.allan(values, RATE, unit="deg/h").plot(label="unit 7", color="green")
    fitted = sagnac.fit(values, RATE, unit="deg/h", bootstrap=0)
    fitted.plot(ax=labelled, label="its fit", color="red")
    legend = labelled.get_legend()
    assert legend is not None and [text.get_text() for text in legend.get_texts()] == ["unit 7", "its fit"]
    # N at 1 s: the deviation there is N in °/√h times 60.
    tau, deviation = fitted.marks["N"]
    assert tau == 1.0 and abs(deviation / (60.0 * (fitted["N"].value or np.nan)) - 1.0) < 1e-12
    assert any(np.array_equal(line.get_xydata(), [[tau, deviation]]) for line in labelled.get_lines())
    matplotlib.pyplot.close(labelled.figure)
    # The crossings of the answer are marked.
    axes = results[0].plot()
    marks = results[0].pictures[next(iter(results[0].charts))]["marks"]
    assert marks and all(any(np.array_equal(line.get_xydata(), [mark["place"]]) for line in axes.get_lines()) for mark in marks)
    matplotlib.pyplot.close(axes.figure)
    with pytest.raises(sagnac.UsageError, match="accepted: chart-1"):
        results[0].plot("none")


def test_conversions_are_those_that_the_program_prints(program: Program) -> None:
    for value in ("0.0135 deg/s/sqrt(Hz)", "0.05 deg/h", "120 ug/sqrt(Hz)"):
        printed = subprocess.run([program.path, "convert", value], capture_output=True, encoding="utf-8", check=True)
        first, *lines = printed.stdout.splitlines()
        found = sagnac.convert(value)
        assert first == f"{found.quantity} = {value}"
        of_file = [f"  {line}" for line in found.lines]
        assert lines[len(found.rows) :] == (["in a noise file, one of", *of_file] if of_file else [])
        for row, line in zip(found.rows, lines):
            *_, number, unit = line.split()
            assert (float(number), unit) == (float(f"{row.value:.6g}"), row.unit.replace("^2", "²"))
