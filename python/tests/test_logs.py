"""Logs are read as the program reads them, and what is found in them is what the program finds, number by number."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from program import Program


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Two gyros, of which one depends on the temperature beside it and lacks samples, and both an unused number."""
    random = np.random.default_rng(7)
    samples = 8000
    celsius = 20.0 + 5.0 * np.sin(np.arange(samples) / 400.0)
    gx = random.normal(0.0, 0.1, samples) + 0.5 * celsius
    gy = random.normal(0.0, 0.1, samples)
    gy[samples // 2 :] *= 1.5
    cells = [[f"{0.01 * i:.2f}", f"{gx[i]:.9f}", f"{gy[i]:.9f}", f"{celsius[i]:.4f}"] for i in range(samples)]
    for i in (50, 51, 700):
        cells[i][1] = ""
    path = tmp_path / "log.csv"
    path.write_text("time_s,gx [deg/h],gy [deg/h],temp [degC]\n" + "\n".join(map(",".join, cells)))
    return path


def check(found: sagnac.Analysis, expected: Any, folder: Path) -> None:
    """The same document, and the same page."""
    assert found.data == expected
    assert found.answer.data == expected["answer"]
    assert {f"{stem}.csv" for stem in expected["tables"]} == set(found.tables)
    assert found.report == (folder / "report.html").read_text(encoding="utf-8")
    for name, text in found.files.items():
        assert text == (folder / name).read_text(encoding="utf-8"), name
    for name, table in found.tables.items():
        rows = expected["tables"][name.removesuffix(".csv")]
        assert table.rows == len(rows)
        for column, values in table.items():
            theirs = [row[column] for row in rows]
            if values.dtype == object:
                assert list(values) == theirs, (name, column)
            else:
                np.testing.assert_array_equal(values, np.array(theirs, dtype=float), err_msg=f"{name}, {column}")


def test_a_log_has_what_its_file_has(program: Program, log: Path) -> None:
    found = sagnac.read_log(log, column=["gx", "gy"])
    assert (found.columns, found.kind, found.rate, len(found)) == (("gx", "gy"), "rate", 100.0, 2)
    gx, gy = found
    assert gx.gaps == (range(50, 52), range(700, 701)) and gx.missing == 3 and gy.gaps == ()
    assert gx.unit == "deg/h" and np.isnan(gx.values[[50, 51, 700]]).all()
    assert np.array_equal(found["gy"].values, np.loadtxt(log, delimiter=",", skiprows=1, usecols=2, converters=float))
    assert np.allclose(found.times[:3], [0.0, 0.01, 0.02]) and found.temperature is None
    cut = sagnac.read_log(log, column=2, skip=10.0, until=20.0, temperature="temp")
    assert cut.times[0] == 10.0 and cut.values.size == 1000
    assert cut.temperature is not None and cut.temperature[0] == pytest.approx(20.0 + 5.0 * np.sin(1000 / 400.0), abs=1e-4)
    expected = program("allan", log, "--column", "gx,gy", "--fit", "none", "--no-psd")["tables"]["records"]
    assert [[axis.missing, axis.values.size, axis.step] for axis in found] == [
        [row["missing"], row["samples"], row["step_s"]] for row in expected
    ]
    with pytest.raises(sagnac.UsageError, match='several columns: gx, gy\nchoose one, as in log\\["gx"\\]'):
        found.values
    with pytest.raises(KeyError, match="the columns are gx, gy"):
        found["gz"]


@pytest.mark.parametrize(
    "arguments, error, piece",
    [
        ({"column": "gz"}, sagnac.RecordError, "no column is called `gz`"),
        ({"column": "gx", "unit": "deg"}, sagnac.UsageError, "unit=deg/h"),
        ({"column": "gx", "kind": "phase"}, sagnac.UsageError, 'accepted: "rate"'),
        ({"column": "gx", "rate": 0.0}, sagnac.UsageError, "rate=0.0"),
        ({"column": "gx", "time": "none"}, sagnac.UsageError, "rate=HZ"),
        ({"column": "gx", "duplicates": "both"}, sagnac.UsageError, 'duplicates="both"'),
        ({"column": "gx", "skip": -1.0}, sagnac.UsageError, "skip=-1.0"),
        ({"column": "gx", "skip": 100.0}, sagnac.RecordError, "nothing of"),
        ({"column": "gx", "temperature": "gy", "temperature_unit": "V"}, sagnac.RecordError, "temperature_unit=K"),
        ({"binary": "f65"}, sagnac.UsageError, "f65"),
    ],
)
def test_logs_are_refused_in_terms_of_the_arguments(arguments: Any, error: Any, piece: str, log: Path) -> None:
    with pytest.raises(error) as refused:
        sagnac.read_log(log, **arguments)
    assert piece in str(refused.value) and "--" not in str(refused.value), str(refused.value)


def test_a_study_and_a_missing_file_are_no_logs(studies: Path, tmp_path: Path) -> None:
    with pytest.raises(sagnac.UsageError, match="is a study, not a log"):
        sagnac.read_log(studies / "smoke.toml")
    with pytest.raises(sagnac.RecordError, match="cannot read"):
        sagnac.allan(tmp_path / "none.csv")


def test_deviations_and_coefficients_of_a_file_and_of_its_log_are_those_of_the_program(
    program: Program, log: Path, tmp_path: Path
) -> None:
    expected = program("allan", log, "--column", "gx", "--bootstrap", 0)["tables"]
    log_of_gx = sagnac.read_log(log)["gx"]
    alone = tmp_path / "alone.csv"
    alone.write_text("\n".join(",".join(line.split(",")[:2]) for line in log.read_text().splitlines()))
    for given in (log_of_gx, sagnac.read_log(log, column="gx")):
        curve = sagnac.allan(given)["oadev"]
        assert list(curve.value) == [row["value"] for row in expected["curve"]]
        fit = sagnac.fit(given, bootstrap=0)
        rows = [row for row in expected["coefficients"] if row["intervals"] != "of the curve"]
        assert [(row.name, row.value, row.lower, row.upper) for row in fit.values()] == [
            (row["coefficient"], row["value"], row["lower"], row["upper"]) for row in rows
        ]
        # The temperature beside the samples explains what an array alone would take for a slow sine.
        events = [event for event in expected["events"] if event["event"] not in ("gap", "outlier")]
        assert fit.events == [{**event, "column": None} for event in events] != []
        assert fit.missing == expected["records"][0]["missing"]
    of_file = sagnac.fit(str(alone), bootstrap=0)
    values = sagnac.read_log(alone).values
    of_array = sagnac.fit(values, 100.0, unit="deg/h", bootstrap=0)
    assert [row.value for row in of_file.values()] == [row.value for row in of_array.values()]
    assert of_array.notes == () and of_file.notes == sagnac.read_log(alone).notes != ()
    with pytest.raises(sagnac.UsageError, match="choose one"):
        sagnac.fit(log)
    with pytest.raises(sagnac.UsageError, match="a log has its own"):
        sagnac.fit(log_of_gx, 100.0)
    with pytest.raises(sagnac.UsageError, match="unit is missing"):
        sagnac.fit(values, 100.0)


def test_the_whole_analysis_is_that_of_the_program(program: Program, log: Path) -> None:
    expected = program("allan", log, "--column", "gx,gy", "--bootstrap", 0, "--remove-events", "--out", "out")
    given = sagnac.read_log(log, column="gx,gy")
    check(sagnac.analyze(given, bootstrap=0, remove_events=True), expected, program.folder / "out")
    expected = program(
        "allan", log, "--column", "gx", "--fit", "none", "--no-psd", "--tau", "0.1,1", "--deviation", "hdev,adev",
        "--intervals", "stable32", "--confidence", 0.9, "--detrend", "linear", "--remove-outliers", "--out", "short",
    )  # fmt: skip
    found = sagnac.analyze(
        given["gx"], terms=None, spectrum=False, taus=[0.1, 1.0], deviation=["hdev", "adev"], intervals="stable32",
        confidence=0.9, detrend=True, remove_outliers=True,
    )  # fmt: skip
    assert found.data == expected
    psd = sagnac.psd(given["gy"], bootstrap=0, segment=5.0)
    expected = program("allan", log, "--column", "gy", "--bootstrap", 0, "--segment", "5 s", "--out", "psd")
    check(psd, expected, program.folder / "psd")


def test_the_dependence_on_temperature_is_that_of_the_program(program: Program, log: Path) -> None:
    given = sagnac.read_log(log, column=["gx", "gy"], temperature="temp")
    options = ["allan", log, "--column", "gx,gy", "--temperature", "temp", "--bootstrap", 0]
    found = sagnac.analyze(given, bootstrap=0)
    check(found, program(*options, "--out", "seen"), program.folder / "seen")
    coefficients = found.tables["temperature.csv"]
    of_gx = (coefficients["column"] == "gx") & (coefficients["coefficient"] == "T")
    assert coefficients["lower"][of_gx][0] < 0.5 < coefficients["upper"][of_gx][0]
    taken = ["--temperature-terms", "T", "--compensate", "--out", "taken"]
    found = sagnac.analyze(given, bootstrap=0, temperature_terms=["T"], compensate=True)
    check(found, program(*options, *taken), program.folder / "taken")
    # The log without it is what the program writes and other functions take.
    compensated = given["gx"].compensated(terms=["T"])
    record = program.folder / "record.csv"
    program("allan", log, "--column", "gx", "--temperature", "temp", *taken[:3], "--record", record, "--out", "one")
    np.testing.assert_array_equal(compensated.values, sagnac.read_log(record).values)
    assert compensated.is_compensated and np.nanstd(compensated.values) < 0.2 < np.nanstd(given["gx"].values)
    for wrong, piece in (({"temperature_terms": ["T2"]}, "T2 needs T"), ({"temperature_terms": "x"}, "`x` is not a term")):
        with pytest.raises(sagnac.UsageError, match=piece):
            sagnac.analyze(given, bootstrap=0, **wrong)
    with pytest.raises(sagnac.UsageError, match="no temperature"):
        sagnac.analyze(sagnac.read_log(log, column="gx"), bootstrap=0, compensate=True)


def test_the_change_of_noise_is_that_of_the_program(program: Program, log: Path) -> None:
    gy = sagnac.read_log(log, column="gy")
    for option, window in (([], True), (["4 s"], 4.0)):
        expected = program("allan", log, "--column", "gy", "--bootstrap", 0, "--dynamic", *option, "--out", "out")
        found = sagnac.analyze(gy, bootstrap=0, dynamic=window)
        check(found, expected, program.folder / "out")
    assert found.tables["stationarity.csv"]["p"][0] < 1e-6 and "chart-dynamic" in found.charts
    with pytest.raises(sagnac.UsageError, match="(?s)the window of 0.1 s is too short.*dynamic="):
        sagnac.analyze(gy, bootstrap=0, dynamic=0.1)


def test_the_position_error_is_that_of_the_program(program: Program, studies: Path) -> None:
    path = studies / "data/gyro_at_rest.csv"
    options = ["--rate", "1Hz", "--navigate", "1h", "--position-limit", "0.3nmi", "--bootstrap", 0, "--out", "out"]
    expected = program("allan", path, *options)
    found = sagnac.analyze(path, 1.0, navigate=3600.0, position_limit="0.3 nmi", bootstrap=0)
    check(found, expected, program.folder / "out")
    assert found.answer.unit == "nmi" and "navigation.toml" in found.files
    for wrong, piece in (
        ({"position_limit": "1 nmi"}, "navigate=3600.0"),
        ({"navigate": 3600.0, "position_limit": "5 deg"}, "position_limit="),
        ({"navigate": 3600.0, "terms": None}, "navigate needs coefficients"),
        ({"navigate": -1.0}, "navigate=-1.0"),
    ):
        with pytest.raises(sagnac.UsageError, match=piece):
            sagnac.analyze(path, 1.0, bootstrap=0, **wrong)


def test_a_batch_and_a_comparison_of_logs_are_those_of_the_program(program: Program, tmp_path: Path) -> None:
    random = np.random.default_rng(9)
    paths = []
    for place, sigma in enumerate((1.0, 1.02, 0.98, 1.01, 3.0)):
        path = tmp_path / f"unit{place}.csv"
        path.write_text("gz [deg/h]\n" + "\n".join(f"{rate:.9f}" for rate in random.normal(0.0, sigma, 5000)))
        paths.append(path)
    options = ["--rate", "100Hz", "--out", "out"]
    expected = program("compare", *paths, *options, "--limit", "N=0.004 deg/sqrt(h)")
    found = sagnac.batch(paths, 100.0, limits={"N": "0.004 deg/sqrt(h)"})
    check(found, expected, tmp_path / "out")
    assert found.answer.status == "partly_met" and len(found.charts) == 2
    logs = [sagnac.read_log(path, rate=100.0) for path in paths]
    check(sagnac.batch(logs), program("compare", *paths, *options), tmp_path / "out")
    arrays = sagnac.batch([log.values for log in logs], 100.0, unit="deg/h", names=[str(path) for path in paths])
    ours, theirs = (one.tables["batch.csv"]["value"] for one in (arrays, sagnac.batch(logs)))
    np.testing.assert_array_equal(ours, theirs)
    expected = program("compare", *paths[:2], *options, "--max-ratio", "N=1.1")
    check(sagnac.compare(logs[0], logs[1], limits={"N": 1.1}), expected, tmp_path / "out")
    with pytest.raises(sagnac.RecordError, match="at least two units"):
        sagnac.batch(logs[:1])
    with pytest.raises(sagnac.RecordError, match="the same record"):
        sagnac.batch([*logs, logs[0]])
    with pytest.raises(sagnac.UsageError, match="5 records and 1 names"):
        sagnac.batch(logs, names=["one"])


def test_a_model_of_a_log_is_that_of_the_program(program: Program, log: Path) -> None:
    expected = program("model", log, "--column", "gx,gy", "--overbound")
    found = sagnac.model(sagnac.read_log(log, column="gx,gy"))
    assert found.data["model"] == expected["model"] and found.data["tables"] == expected["tables"]
