"""What goes wrong is an exception of its class that says what to do."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac

RATES = np.random.default_rng(1).normal(0.0, 1.0, 1000)


def test_a_study_is_refused_with_file_line_and_caret(studies: Path, tmp_path: Path) -> None:
    study = tmp_path / "mine.toml"
    text = (studies / "smoke.toml").read_text(encoding="utf-8")
    study.write_text(text.replace('tick = "5 ms"', 'tick = "5 mm"'), encoding="utf-8")
    with pytest.raises(sagnac.StudyError) as refused:
        sagnac.run(study)
    said = str(refused.value)
    assert "mine.toml:7" in said and "5 mm" in said and "─" in said and "ms" in said, said
    assert "\x1b" not in said
    with pytest.raises(sagnac.StudyError, match="cannot read the study"):
        sagnac.run(tmp_path / "other.toml")
    with pytest.raises(sagnac.StudyError, match="study:1"):
        sagnac.run("title = 5 ms\n")
    # As others would catch them.
    assert isinstance(refused.value, ValueError) and isinstance(refused.value, sagnac.SagnacError)


def test_what_shows_in_charts_only_is_found_before_anything_is_sampled(studies: Path, tmp_path: Path) -> None:
    text = (studies / "smoke.toml").read_text(encoding="utf-8").replace('y = "p99_73"', 'y = "q9937"')
    with pytest.raises(sagnac.StudyError, match="no column is called `q9937`"):
        sagnac.run(text, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments, piece",
    [
        ({"trials": 0}, "trials=0"),
        ({"trials": 1 << 41}, "accepted: 1 to"),
        ({"trials": 10.5}, "not a whole number"),
        ({"seed": -1}, "seed=-1"),
        ({"seed": 1 << 63}, "accepted: 0 to"),
        ({"threads": 0}, "threads=0"),
        ({"device": "abacus"}, "no device is called `abacus`"),
    ],
)
def test_arguments_of_runs_are_refused_with_what_is_accepted(arguments: Any, piece: str, studies: Path) -> None:
    with pytest.raises(sagnac.UsageError, match=piece):
        sagnac.run(studies / "smoke.toml", **arguments)


def test_a_folder_that_cannot_be_used_is_an_error_of_storage(studies: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(sagnac.StorageError, match="results folder"):
        sagnac.run(studies / "smoke.toml", trials=100, device="cpu", out=tmp_path / "file")
    sagnac.run(studies / "smoke.toml", trials=100, seed=1, device="cpu", out=tmp_path / "out")
    with pytest.raises(sagnac.StorageError, match="another study") as refused:
        sagnac.run(studies / "smoke.toml", trials=100, seed=2, device="cpu", out=tmp_path / "out")
    assert "out=DIR" in str(refused.value) and "--out" not in str(refused.value)


@pytest.mark.parametrize(
    "data, arguments, error, piece",
    [
        (RATES[:15], {}, sagnac.RecordError, "15 samples, at least 16"),
        (np.ones(100), {}, sagnac.RecordError, "constant"),
        (np.full(100, np.nan), {}, sagnac.RecordError, "0 samples"),
        (np.append(RATES, np.inf), {}, sagnac.RecordError, "sample 1000 of the array is infinite"),
        (RATES.reshape(10, 100), {}, sagnac.RecordError, "2 dimensions"),
        (np.float64(3.0), {}, sagnac.RecordError, "0 dimensions"),
        (["a", "b"], {}, sagnac.RecordError, "not an array of numbers"),
        (RATES, {"unit": "deg"}, sagnac.UsageError, "an angle"),
        (RATES, {"unit": "volts"}, sagnac.UsageError, "unit=deg/h"),
        (RATES, {"unit": "0 arcsec/pulse", "kind": "angle"}, sagnac.UsageError, "unit"),
        (RATES, {"kind": "phase"}, sagnac.UsageError, "kind=\"phase\""),
        (RATES, {"rate": 0.0}, sagnac.UsageError, "rate=0.0"),
        (RATES, {"rate": float("nan")}, sagnac.UsageError, "rate=nan"),
        (RATES, {"threads": -1}, sagnac.UsageError, "threads=-1"),
    ],
)
def test_records_are_refused_by_deviations_and_fits_alike(
    data: Any, arguments: Any, error: type[Exception], piece: str
) -> None:
    given = {"rate": 100.0, "unit": "deg/h"} | arguments
    functions: list[Any] = [sagnac.allan, sagnac.fit]
    for function in functions:
        with pytest.raises(error) as refused:
            function(data, **given)
        assert piece in str(refused.value) and "--" not in str(refused.value), str(refused.value)


@pytest.mark.parametrize(
    "arguments, piece",
    [
        ({"deviation": "avar"}, "`avar` is not a deviation"),
        ({"taus": "octaves"}, "accepted: \"octave\""),
        ({"taus": [1e-9]}, "shorter than the sampling step"),
        ({"taus": [-1.0]}, "is not a time"),
        ({"taus": [1e9]}, "too long for a record of 10 s"),
        ({"confidence": 1.0}, "confidence=1.0"),
    ],
)
def test_arguments_of_deviations_are_refused_with_what_is_accepted(arguments: Any, piece: str) -> None:
    with pytest.raises(sagnac.UsageError) as refused:
        sagnac.allan(RATES, 100.0, unit="deg/h", **arguments)
    assert piece in str(refused.value) and "--" not in str(refused.value), str(refused.value)
    with pytest.raises(sagnac.UsageError, match="decade20"):
        sagnac.allan(np.arange(200_001.0) % 3, 1.0, unit="none", taus="all")


@pytest.mark.parametrize(
    "arguments, piece",
    [
        ({"terms": "QNB"}, "accepted: \"auto\""),
        ({"terms": ["Z"]}, "`Z` is not a term"),
        ({"terms": []}, "no coefficients"),
        ({"bootstrap": 10}, "accepted: 200 to"),
    ],
)
def test_arguments_of_fits_are_refused_with_what_is_accepted(arguments: Any, piece: str) -> None:
    with pytest.raises(sagnac.SagnacError) as refused:
        sagnac.fit(RATES, 100.0, unit="deg/h", **arguments)
    assert piece in str(refused.value), str(refused.value)


@pytest.mark.parametrize(
    "data, unit, piece",
    [(RATES * 1e-6 + 0.0042, "rad/s", "degrees taken for radians"), (RATES + 30.0, "deg/s", "no gyro at rest")],
)
def test_a_doubtful_unit_is_a_warning_that_can_be_silenced(data: Any, unit: str, piece: str) -> None:
    with pytest.warns(UserWarning, match=piece):
        sagnac.allan(data, 100.0, unit=unit)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sagnac.allan(data, 100.0, unit=unit, unit_check=False)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root writes everywhere")
def test_a_folder_that_is_read_only_is_an_error_of_storage(studies: Path, tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    with pytest.raises(sagnac.StorageError, match="writable"):
        sagnac.run(studies / "smoke.toml", trials=100, device="cpu", out=tmp_path / "out")


def test_values_that_cannot_be_converted_are_refused() -> None:
    with pytest.raises(sagnac.UsageError, match="unit is missing"):
        sagnac.convert("5")
    with pytest.raises(sagnac.UsageError, match="deg/h is a unit of rate.*not of angle random walk N"):
        sagnac.convert("5 deg/sqrt(h)").to("deg/h")
