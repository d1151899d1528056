"""Closed forms meet the references that other programs computed, and are broadcast as NumPy does."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from sagnac import theory

PAPER: dict[str, Any] = {"magnetic": 14.0, "warm_up_time": 3000.0, "non_magnetic": 0.05}


def columns(path: Path) -> dict[str, np.ndarray]:
    """The columns of a file, numbers where all of a column are."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found = {}
    for name in rows[0]:
        cells = [row[name] for row in rows]
        try:
            found[name] = np.array([float(cell) for cell in cells])
        except ValueError:
            found[name] = np.array(cells)
    return found


def near(found: Any, expected: Any, relative: float = 1e-9) -> None:
    np.testing.assert_allclose(found, expected, rtol=relative, atol=0.0)


def test_errors_of_fillers_meet_the_reference(reference: Path) -> None:
    rows = columns(reference / "gap_sine.csv")
    tick = 0.005
    for kind in ["const", "linear", "quadratic"]:
        for error in ["residual", "extrapolation"]:
            for n in [1, 2, 3]:
                at = (rows["order"] == kind) & (rows["error"] == error) & (rows["gap_ticks"] == n)
                assert at.any()
                found = theory.gap_error(
                    kind, n, rows["nu_T"][at] / tick, amplitude=1.0 / tick, tick=tick, error=error  # type: ignore[arg-type]
                )
                # The reference has twelve digits; of a small error it is a difference of numbers near 1.
                np.testing.assert_allclose(found, rows["max_per_AT"][at], rtol=1e-9, atol=1e-11)


def test_weights_and_noise_gains_meet_the_reference(reference: Path) -> None:
    rows = columns(reference / "gap_weights.csv")
    for place, (n, error, kind) in enumerate(zip(rows["gap_ticks"], rows["error"], rows["order"])):
        filler = sagnac.filler(str(kind), int(n))[str(kind)]
        rule = filler.interpolation if error == "residual" else filler.extrapolation
        assert rule is not None
        expected = [rows[f"w{k}"][place] for k in [1, 2, 3, 4]]
        # What is 0 is the rounding of the other program there.
        np.testing.assert_allclose(rule.weights, expected, rtol=1e-9, atol=1e-15)
        near(rule.noise_gain, rows["noise_gain"][place])


def test_drift_budgets_and_optima_meet_the_reference(reference: Path) -> None:
    rows = columns(reference / "drift_budget.csv")
    bound = theory.drift_bound(rows["interval_s"], rows["run_s"], residual_max=10.0, **PAPER)
    near(bound.total, rows["bound"])
    near(bound.non_magnetic + bound.quasi_non_magnetic + bound.magnetic + bound.residual, rows["bound"])
    best = theory.drift_optimum(rows["run_s"], residual_max=10.0, **PAPER)
    # The reference looks for the least value, which leaves a minimum's place to the root of its rounding.
    near(best.interval, rows["optimum_s"], 1e-7)
    near(best.bound, rows["optimum_bound"])
    near(best.as_published, rows["optimum_as_published_s"])
    near(best.limit_as_published, rows["optimum_limit_s"])


def test_drifts_of_whole_runs_meet_the_reference(reference: Path) -> None:
    rows = columns(reference / "drift_run.csv")
    found = theory.drift_of_runs(rows["interval_s"], rows["run_s"], residual_rms=7.0, **PAPER)
    near(found.mean, rows["mean_drift"])
    near(found.deviation_in_phase, rows["switches"] * 7.0 / rows["run_s"])
    near(found.deviation, np.sqrt(rows["switches"]) * 7.0 / rows["run_s"])


def test_relocks_meet_the_reference(reference: Path) -> None:
    rows = columns(reference / "relock.csv")
    # χ f0 Δλ0² = 1.
    found = theory.relock_ticks(
        rows["tick"], tick=rows["tick_s"], loop_time=rows["loop_s"], bias=4.0, curvature=0.25, miss=1.0
    )
    near(found.apparent_drift, rows["apparent_drift"])
    near(found.bias_error, rows["bias_error"])
    near(found.detuning_plus, rows["detuning_plus"])
    near(found.detuning_minus, rows["detuning_minus"])
    late = rows["tick"] > 1
    first = np.where(rows["tick"] == 1, found.bias_error, np.nan)
    first = np.array([first[: place + 1][~np.isnan(first[: place + 1])][-1] for place in range(len(first))])
    back = theory.drift_from_frequency(first, found.bias_error, rows["tick"])
    near(back[late], found.apparent_drift[late])
    assert np.isnan(back[~late]).all()


def test_allan_deviations_meet_the_reference(reference: Path) -> None:
    rows = columns(reference / "allan_model.csv")
    gyros = {"LGK-400": (0.24, 0.00067, 0.00192), "LGV-1": (0.11, 0.00048, 0.00164)}
    for gyro, (q, n, b) in gyros.items():
        at = rows["gyro"] == gyro
        noise: dict[str, Any] = {"quantization": q, "angle_random_walk": n, "bias_instability": b}
        near(theory.allan_deviation(rows["tau_s"][at], **noise), rows["adev"][at])


def test_sampled_deviations_are_those_of_records_and_near_continuous_ones_at_long_times() -> None:
    noise: dict[str, Any] = {"angle_random_walk": 0.01, "rate_random_walk": 0.05}
    m = np.array([1.0, 4.0, 16.0])
    rates = np.random.default_rng(2).normal(size=(400, 4096)) * 0.6
    rates += np.cumsum(np.random.default_rng(3).normal(size=(400, 4096)) * 0.05 / 60.0, axis=1)
    variances = [sagnac.allan(row, 1.0, unit="deg/h", taus=m)["oadev"].value ** 2 for row in rates]
    expected = theory.sampled_allan_deviation(m, sample=1.0, samples=4096, **noise) ** 2
    error = np.std(variances, axis=0) / np.sqrt(len(variances))
    assert (np.abs(np.mean(variances, axis=0) - expected) < 5.0 * error).all()
    near(expected[-1], theory.allan_deviation(16.0, **noise) ** 2, 1e-3)
    assert np.isnan(theory.sampled_allan_deviation([0, 0.5, 4097], sample=1.0, samples=4096, **noise)).all()


def test_markov_noise_is_a_random_walk_at_short_times_and_a_sine_shows_at_its_half_period() -> None:
    found = theory.allan_deviation([0.1, 0.2], markov=(0.1, 300.0))
    near(found, np.sqrt(2.0 / 300.0) * 0.1 * np.sqrt(np.array([0.1, 0.2]) / 3.0), 1e-3)
    near(theory.allan_deviation([50.0, 100.0], sine=(0.1, 0.01)) + 1.0, [1.0 + 0.2 / np.pi, 1.0], 1e-12)


def test_suspensions_respond_as_driven_oscillators() -> None:
    one = [(380.0, 100.0, 1000.0)]
    peak = theory.suspension_response(380.0, one)
    assert abs(peak.real) < 1e-9 and abs(peak.imag + 1000.0) < 1e-9
    both = theory.suspension_response([[0.0, 380.0]], one)
    assert both.shape == (1, 2) and both.dtype == np.complex128 and both[0, 0] == 10.0
    assert abs(theory.suspension_response(300.0, "LGV-1")) > 19_000.0


def test_laws_as_published_are_those_of_the_print() -> None:
    arcsec = 12000.0 * 0.005
    near(arcsec * theory.taylor_term_as_published(1, [0.1, 0.15], at="zero crossing"), [2.4805, 8.3717], 1e-4)
    near(arcsec * theory.taylor_term_as_published(2, 0.2, at="extremum"), 6.2342, 1e-4)
    assert np.isnan(theory.taylor_term_as_published(0, 0.1, at="zero crossing"))
    near(theory.noise_of_const(1.6, [1, 3]), [0.8, 2.4])
    near(theory.noise_of_const(1.6, [1, 3], as_published=True), [0.8, 1.3856406], 1e-7)


def test_arguments_are_broadcast_and_numbers_give_a_number() -> None:
    found = theory.gap_error("quadratic", 3, [[10.0], [20.0]], amplitude=[1.0, 2.0, 3.0], tick=0.005)
    assert found.shape == (2, 3)
    near(found[1, 1], 2.0 * theory.gap_error("quadratic", 3, 20.0, amplitude=1.0, tick=0.005))
    assert type(theory.drift_bound(40.0, 600.0, residual_max=10.0, **PAPER).total) is float
    assert theory.drift_bound([], 600.0, residual_max=10.0, **PAPER).total.shape == (0,)
    with pytest.raises(ValueError, match="broadcast"):
        theory.drift_bound([1.0, 2.0], [1.0, 2.0, 3.0], residual_max=10.0, **PAPER)


def test_what_is_no_number_gives_none_and_ends() -> None:
    for strange in [np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-300, 1e300]:
        for name in ["magnetic", "warm_up_time", "non_magnetic"]:
            theory.drift_optimum(600.0, residual_max=10.0, **{**PAPER, name: strange})
        theory.drift_optimum(strange, residual_max=10.0, **PAPER)
        theory.drift_optimum(600.0, residual_max=strange, **PAPER)
        theory.drift_of_runs(strange, strange, residual_rms=strange, **PAPER)
        theory.relock_ticks(strange, tick=strange, loop_time=strange, bias=1.0, curvature=1.0, miss=1.0)
        theory.allan_deviation(strange, bias_instability=strange, markov=(strange, strange))
        theory.gap_error("linear", 2, strange, amplitude=strange, tick=strange)
        theory.suspension_response(strange, [(strange, strange, strange)])
    assert np.isnan(theory.drift_optimum(np.nan, residual_max=10.0, **PAPER).interval)


@pytest.mark.parametrize(
    "call, piece",
    [
        (lambda: theory.gap_error("cubic", 3, 1.0, amplitude=1.0, tick=1.0), "const, linear, quadratic"),  # type: ignore[arg-type]
        (lambda: theory.gap_error("const", 65, 1.0, amplitude=1.0, tick=1.0), "1 to 64"),
        (lambda: theory.gap_error("const", 3, 1.0, amplitude=1.0, tick=1.0, ticks=[2]), "not the lost ones"),
        (lambda: theory.gap_error("quadratic", 3, 1.0, amplitude=1.0, tick=1.0, ticks=[0, 4]), "do not determine"),
        (lambda: theory.suspension_response(1.0, "LGK"), "LGK-400, LGV-1"),
        (lambda: theory.suspension_response(1.0, []), "no modes"),
        (lambda: theory.sampled_allan_deviation(1, sample=0.0, samples=9), "sample=0.0"),
        (lambda: theory.sampled_allan_deviation(1, sample=1.0, samples=1 << 28), "too long"),
    ],
)
def test_arguments_that_are_none_are_refused_with_those_that_are(call: object, piece: str) -> None:
    with pytest.raises(sagnac.UsageError, match=piece):
        call()  # type: ignore[operator]
