"""Deviations and fits of arrays are those of the program for a file of the same data, to the last bit; the ends of intervals of
deviations, which hang on an incomplete gamma function that two builds need not round alike, to a few of these."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sagnac
from program import Program

# A few units in the last place, by which the library lets the ends of intervals differ.
ENDS = 1e-14

ALL: list[Any] = ["adev", "oadev", "mdev", "tdev", "hdev", "ohdev"]


def record(samples: int = 20_000) -> NDArray[np.float64]:
    """White noise and a random walk, a gap of single samples and of a stretch, and two spikes."""
    random = np.random.default_rng(5)
    rates = random.normal(0.01, 0.1, samples) + np.cumsum(random.normal(0.0, 2e-4, samples))
    rates[[70, 71, 4000]] = np.nan
    rates[7000:7100] = np.nan
    rates[[500, 9000]] += 5.0
    return rates


def analysed(program: Program, tmp_path: Path, data: NDArray[Any], *options: object) -> Any:
    """The tables of a file of the data."""
    np.save(tmp_path / "record.npy", data)
    found = program("allan", tmp_path / "record.npy", "--rate", "100Hz", "--out", tmp_path / "out", *options)
    return found["tables"]


def of_events(tables: Any) -> list[dict[str, Any]]:
    """The events without single gaps and outliers, and without the name of the column, which an array does not have."""
    events = [event for event in tables["events"] if event["event"] not in ("gap", "outlier")]
    return [{**event, "column": None} for event in events]


def check_curves(found: sagnac.Allan, tables: Any) -> None:
    assert list(found) == list(dict.fromkeys(point["deviation"] for point in tables["curve"]))
    samples = tables["records"][0]["samples"]
    for deviation, curve in found.items():
        points = [point for point in tables["curve"] if point["deviation"] == deviation]
        assert {curve.unit} == {point["unit"] or "" for point in points}
        pairs = {
            "m": curve.m,
            "tau_s": curve.tau,
            "differences": curve.differences,
            "value": curve.value,
            "alpha": curve.alpha,
            "edf": curve.edf,
        }
        for key, ours in pairs.items():
            theirs = np.array([point[key] for point in points], dtype=ours.dtype)
            assert np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f"), f"{deviation}, {key}"
        for key, ours in [("lower", curve.lower), ("upper", curve.upper)]:
            theirs = np.array([point[key] for point in points], dtype=np.float64)
            np.testing.assert_allclose(ours, theirs, rtol=ENDS, atol=0.0, err_msg=f"{deviation}, {key}")
        for point, carried in zip(points, curve.alpha_carried, strict=True):
            assert (point["alpha_from"] == "carried") == carried
        known = [point for point in points if point["value"] and 8 * point["m"] <= samples]
        if deviation == "tdev" or not known:
            assert curve.minimum is None
        else:
            least = min(known, key=lambda point: float(point["value"]))
            assert curve.minimum is not None
            assert (curve.minimum.tau, curve.minimum.value) == (least["tau_s"], least["value"])
            ends = [curve.minimum.lower, curve.minimum.upper]
            assert ends == pytest.approx([least["lower"], least["upper"]], rel=ENDS, abs=0.0)
            assert curve.minimum.at_end == (least is known[-1])
    # That of the first curve is what the program gives as a coefficient.
    first = next((curve for name, curve in found.items() if name != "tdev"), None)
    stability = {row["coefficient"]: row for row in tables["coefficients"] if row["intervals"] == "of the curve"}
    if first is not None and first.minimum is not None:
        value = None if first.minimum.at_end else first.minimum.value
        assert stability["in_run_bias_stability"]["value"] == value
        assert stability["in_run_bias_stability_tau"]["value"] == first.minimum.tau
        assert (stability["in_run_bias_stability"]["status"] is not None) == first.minimum.at_end
    (record,) = tables["records"]
    assert found.missing == record["missing"]
    assert found.mean_rate == record["mean"]
    assert found.removed_slope_per_s == record["removed_slope"]
    assert len(found.outliers) == record["outliers"]
    assert found.outlier_threshold == record["outlier_threshold"]


@pytest.mark.parametrize("kind, unit", [("rate", "deg/h"), ("rate", "mg"), ("increment", "arcsec"), ("angle", "urad")])
def test_deviations_of_rates_increments_and_angles_are_those_of_the_program(
    kind: Any, unit: str, program: Program, tmp_path: Path
) -> None:
    data = record() if kind != "angle" else np.cumsum(np.nan_to_num(record()))
    expected = analysed(
        program, tmp_path, data, "--data", kind, "--unit", unit, "--deviation", ",".join(ALL), "--bootstrap", 0
    )
    check_curves(sagnac.allan(data, 100.0, kind=kind, unit=unit, deviation=ALL), expected)


def test_trends_outliers_pulses_and_times_are_those_of_the_program(program: Program, tmp_path: Path) -> None:
    counts = np.floor(record() * 1000.0)
    expected = analysed(
        program, tmp_path, counts, "--data", "increment", "--scale", "0.5 arcsec/pulse", "--detrend", "linear",
        "--remove-outliers", "--tau", "0.01,0.5,3", "--confidence", 0.9, "--bootstrap", 0,
    )  # fmt: skip
    found = sagnac.allan(
        counts, 100.0, kind="increment", unit="0.5 arcsec/pulse", detrend=True, remove_outliers=True,
        taus=[0.01, 0.5, 3.0], confidence=0.9,
    )  # fmt: skip
    check_curves(found, expected)
    assert list(found.outliers) == [500, 9000]
    for taus in ["decade10", "decade20"]:
        expected = analysed(
            program, tmp_path, counts, "--data", "rate", "--unit", "none", "--tau", taus, "--fit", "none"
        )
        check_curves(sagnac.allan(counts, 100.0, unit="none", taus=taus), expected)


def test_the_list_of_events_is_that_of_the_program(program: Program, tmp_path: Path) -> None:
    data = record() + 0.3 * np.sin(2 * np.pi * 20.0 * np.arange(20_000) / 100.0)
    expected = of_events(analysed(program, tmp_path, data, "--data", "rate", "--unit", "deg/h", "--bootstrap", 0))
    without_fit = of_events(analysed(program, tmp_path, data, "--data", "rate", "--unit", "deg/h", "--fit", "none"))
    events = sagnac.allan(data, 100.0, unit="deg/h").events
    assert [event["event"] for event in events] == ["spikes", "line"]
    assert events == without_fit
    assert sagnac.fit(data, 100.0, unit="deg/h", bootstrap=0).events == expected
    compared = sagnac.compare(data, data, 100.0, unit="deg/h").data["tables"]["events"]
    assert [event["event"] for event in compared if event["column"] == "B"][0] == "same record"


def check_fit(found: sagnac.Fit, tables: Any) -> None:
    rows = [row for row in tables["coefficients"] if row["intervals"] != "of the curve"]
    assert list(found) == [row["coefficient"] for row in rows]
    for expected in rows:
        row = found[expected["coefficient"]]
        assert (row.value, row.lower, row.upper) == (expected["value"], expected["lower"], expected["upper"])
        assert (row.unit, row.status) == (expected["unit"] or "", expected["status"] or "")
        assert found.intervals == expected["intervals"]
        assert (found.fit_from, found.fit_to) == (expected["fit_from_s"], expected["fit_to_s"])
    assert found.events == of_events(tables)
    (record,) = tables["records"]
    of_fit = (record["chi_squared"], record["degrees_of_freedom"], record["p"])
    assert (found.chi_squared, found.degrees_of_freedom, found.p_value) == of_fit
    assert found.described == all(row["status"] != "model rejected" for row in rows)


def test_coefficients_are_those_of_the_program_with_and_without_bootstrap(program: Program, tmp_path: Path) -> None:
    data = record()
    for bootstrap in [None, 0, 300]:
        options = [] if bootstrap is None else ["--bootstrap", bootstrap]
        expected = analysed(program, tmp_path, data, "--data", "rate", "--unit", "deg/h", *options)
        found = sagnac.fit(data, 100.0, unit="deg/h", bootstrap=bootstrap)
        check_fit(found, expected)
        assert found["N"].is_estimated and found["N"].value is not None
    assert np.allclose(found.fitted, found.deviation, rtol=0.2)
    assert len(found.to_pandas()) == 5


def test_terms_that_are_asked_for_are_fitted_and_a_trend_takes_the_ramp(program: Program, tmp_path: Path) -> None:
    data = record()
    expected = analysed(
        program, tmp_path, data, "--data", "rate", "--unit", "deg/s", "--fit", "N,K,markov", "--bootstrap", 0
    )
    check_fit(sagnac.fit(data, 100.0, unit="deg/s", terms=["N", "K", "markov"], bootstrap=0), expected)
    expected = analysed(
        program, tmp_path, data, "--data", "rate", "--unit", "deg/h", "--detrend", "linear", "--bootstrap", 0
    )
    found = sagnac.fit(data, 100.0, unit="deg/h", detrend=True, bootstrap=0)
    check_fit(found, expected)
    assert "R" not in found


def test_a_range_is_that_of_the_program_and_a_curve_that_no_term_describes_has_no_values(
    program: Program, tmp_path: Path
) -> None:
    data = record()
    options = ["--data", "rate", "--unit", "deg/h", "--bootstrap", 0]
    expected = analysed(program, tmp_path, data, *options, "--fit-from", "0.04 s", "--fit-to", "10 s")
    found = sagnac.fit(data, 100.0, unit="deg/h", fit_from=0.04, fit_to=10.0, bootstrap=0)
    check_fit(found, expected)
    assert np.array_equal(np.isnan(found.fitted), (found.tau < 0.039) | (found.tau > 10.1))
    # No ramp and no random walk is like white noise at any averaging time.
    white = np.random.default_rng(3).normal(0.0, 1.0, 20_000)
    for force in [False, True]:
        asked = [*options, "--fit", "K,R", *(["--force"] if force else [])]
        expected = analysed(program, tmp_path, white, *asked)
        found = sagnac.fit(white, 100.0, unit="deg/h", terms=["K", "R"], force=force, bootstrap=0)
        check_fit(found, expected)
        assert not found.described and np.isnan(found.fitted).all()
        assert {row.status for row in found.values()} == {"model rejected"}
        assert any(row.value is not None for row in found.values()) == force


def test_intervals_of_stable32_are_those_of_the_program(program: Program, tmp_path: Path) -> None:
    data = record()
    expected = analysed(
        program, tmp_path, data, "--data", "rate", "--unit", "deg/h", "--intervals", "stable32", "--fit", "none"
    )
    check_curves(sagnac.allan(data, 100.0, unit="deg/h", intervals="stable32"), expected)


def test_of_long_records_no_bootstrap_is_made_unless_it_is_asked_for() -> None:
    data = np.random.default_rng(1).normal(0.0, 1.0, 2_000_001)
    found = sagnac.fit(data, 100.0, unit="deg/h")
    assert found.intervals == "closed form"
    assert found.without_bootstrap is not None and "bootstrap=1000" in found.without_bootstrap


def test_lists_integers_and_strided_arrays_are_taken_as_arrays_of_float64() -> None:
    data = record()[:1000]
    expected = sagnac.allan(data, 10.0, unit="deg/h")["oadev"].value
    wide = np.zeros((1000, 3))
    wide[:, 1] = data
    others: list[Any] = [list(data), wide[:, 1], data[::-1][::-1], data.astype(">f8")]
    for other in others:
        assert np.array_equal(sagnac.allan(other, 10.0, unit="deg/h")["oadev"].value, expected)
    counts = np.arange(1000) % 7
    assert np.isfinite(sagnac.allan(counts, 10.0, unit="none")["oadev"].value).all()
    data.setflags(write=False)
    assert np.array_equal(sagnac.allan(data, 10.0, unit="deg/h", deviation="oadev")["oadev"].value, expected)


def test_a_fit_and_a_curve_are_held_against_limits(program: Program, tmp_path: Path) -> None:
    data = record()
    options = ["--data", "rate", "--unit", "deg/h", "--bootstrap", 0]
    np.save(tmp_path / "record.npy", data)
    held = ["--limit", "N=1 deg/sqrt(h)", "--limit", "B=1e-9 deg/h"]
    path = tmp_path / "record.npy"
    expected = program("allan", path, "--rate", "100Hz", "--out", tmp_path / "out", *options, *held)
    limits = {"N": "1 deg/sqrt(h)", "B": "1e-9 deg/h"}
    found = sagnac.fit(data, 100.0, unit="deg/h", bootstrap=0, limits=limits)
    theirs = [{**limit, "record": None} for limit in expected["tables"]["limits"]]
    assert [{**limit, "record": None} for limit in found.limits] == theirs
    assert [(limit["coefficient"], limit["status"]) for limit in found.limits] == [("N", "met"), ("B", "inconclusive")]
    assert found.answer.status == "inconclusive" and "may miss" in str(found.answer)
    assert sagnac.fit(data, 100.0, unit="deg/h", bootstrap=0).limits == []
    curve = sagnac.allan(data, 100.0, unit="deg/h", limits={"in_run_bias_stability": "1000 deg/h"})
    assert curve.answer.status == "met" and curve.limits[0]["status"] == "met"
    wrong: dict[str, str]
    for wrong in ({"M": "1 deg/h"}, {"N": "1 deg/h"}, {"N": "1 m/s/sqrt(h)"}, {"N": "1"}):
        with pytest.raises(sagnac.UsageError, match="limits"):
            sagnac.fit(data, 100.0, unit="deg/h", bootstrap=0, limits=wrong)
    with pytest.raises(sagnac.UsageError, match="unknown limit"):
        sagnac.allan(data, 100.0, unit="deg/h", limits={"N": "1 deg/sqrt(h)"})
