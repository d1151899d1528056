"""Models for filters: those of the program, and files that the tools read themselves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gtsam
import numpy as np
import pytest
import yaml

import sagnac
from program import Program

NOISE = {
    "angle_random_walk": "0.003 deg/sqrt(h)",
    "bias_instability": "0.002 deg/h",
    "rate_random_walk": "0.004 deg/h/sqrt(h)",
}
TEXT = "".join(f'{key} = "{value}"\n' for key, value in NOISE.items())
ARCSEC = np.pi / 648_000.0


def without_place(document: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in document.items() if key not in ("title", "question", "files")}


def test_a_model_of_noise_is_that_of_the_program(program: Program) -> None:
    (program.folder / "noise.toml").write_text(TEXT)
    expected = program("model", "noise.toml", "--from", "1s", "--to", "1000s", "--overbound", "--filter-rate", "10Hz")
    for noise in (NOISE, TEXT, program.folder / "noise.toml"):
        found = sagnac.model(noise=noise, from_s=1.0, to_s=1000.0, filter_rate=10.0)
        assert without_place(found.data) == without_place(expected)
    assert found.plot("model") is not None
    assert str(found.answer).startswith("N and K bound the curve to ")


def test_a_model_of_a_record_is_that_of_the_program(program: Program) -> None:
    rng = np.random.default_rng(3)
    rates = rng.standard_normal(5000) + 0.01 * np.cumsum(rng.standard_normal(5000))
    np.save(program.folder / "record.npy", rates)
    read = ["--data", "rate", "--unit", "deg/h", "--rate", "1Hz"]
    for bound, option in (("band", ["--overbound"]), ("repeat", ["--overbound=repeat"]), (None, [])):
        expected = program("model", "record.npy", *read, *option)
        found = sagnac.model(rates, 1.0, unit="deg/h", bound=bound)  # type: ignore[arg-type]
        [ours], [theirs] = (document["model"]["columns"] for document in (found.data, expected))
        for name in ("markov", "largest_excess", "discrete", "white_deg_per_rt_h"):
            assert ours[name] == theirs[name], (bound, name)
        curves = [document["tables"]["model"] for document in (found.data, expected)]
        for one, other in zip(*curves, strict=True):
            assert {**one, "column": None} == {**other, "column": None}, bound


def files() -> tuple[dict[str, Any], dict[str, str]]:
    found = sagnac.model(noise=NOISE, from_s=1.0, to_s=10_000.0, filter_rate=100.0, write=["all"])
    return found.data["model"]["columns"][0], found.data["files"]


def at_1_s(model: dict[str, Any]) -> float:
    """Allan deviation of the whole model at 1 s, rad/s."""
    square = (60 * model["white_deg_per_rt_h"]) ** 2 + (model["random_walk_deg_per_h_per_rt_h"] / 60) ** 2 / 3
    for state in model["markov"]:
        z = 1.0 / state["correlation_time_s"]
        square += 2 * state["sigma_deg_per_h"] ** 2 / z**2 * (z - 1.5 + 2 * np.exp(-z) - 0.5 * np.exp(-2 * z))
    return float(ARCSEC * np.sqrt(square))


@pytest.mark.parametrize("name", ["kalibr.yaml", "allan_variance_ros.yaml", "kalibr_imu_chain.yaml"])
def test_yaml_of_visual_inertial_tools_is_read_by_pyyaml(name: str) -> None:
    model, written = files()
    # OpenCV's directive is none of YAML.
    read = yaml.safe_load(written[name].removeprefix("%YAML:1.0\n"))
    read = read.get("imu0", read)
    found = np.hypot(read["gyroscope_noise_density"], read["gyroscope_random_walk"] / np.sqrt(3))
    assert found == pytest.approx(at_1_s(model), rel=0.01)
    assert read["update_rate"] == 100.0 and read["rostopic"].endswith(("imu", "imu0"))


def test_kf_gins_yaml_is_read_by_pyyaml() -> None:
    model, written = files()
    read = yaml.safe_load(written["kf_gins.yaml"])["imunoise"]
    z = 1.0 / (3600.0 * read["corrtime"])
    square = (60 * read["arw"][0]) ** 2
    square += 2 * read["gbstd"][0] ** 2 / z**2 * (z - 1.5 + 2 * np.exp(-z) - 0.5 * np.exp(-2 * z))
    assert ARCSEC * np.sqrt(square) == pytest.approx(at_1_s(model), rel=0.01)


def test_gtsam_integrates_its_covariances_to_the_deviation_of_the_model() -> None:
    model, written = files()
    place: dict[str, Any] = {}
    exec(written["gtsam_noise.py"], place)
    params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.81)
    params.setAccelerometerCovariance(np.zeros((3, 3)))
    params.setBiasAccCovariance(np.zeros((3, 3)))
    params.setIntegrationCovariance(np.zeros((3, 3)))
    place["set_noise"](params)
    measured = gtsam.PreintegratedCombinedMeasurements(params, gtsam.imuBias.ConstantBias())
    for _ in range(200):
        measured.integrateMeasurement(np.array([0.0, 0.0, 9.81]), np.zeros(3), 0.005)
    # Over 1 s the variance of the angle is N² + K²/3, which is the Allan variance there.
    assert np.sqrt(measured.preintMeasCov()[0, 0]) == pytest.approx(at_1_s(model), rel=0.01)


def test_the_values_of_pyins_are_those_of_the_model() -> None:
    model, written = files()
    place: dict[str, Any] = {}
    exec(written["pyins_model.py"], place)
    gyro = place["gyro"]
    assert np.hypot(gyro["noise"][0], gyro["bias_walk"][0] / np.sqrt(3)) == pytest.approx(at_1_s(model), rel=0.01)
    assert gyro["bias_sd"][0] > 0.0  # without it pyins refuses the walk


def test_what_is_not_accepted_is_said() -> None:
    with pytest.raises(sagnac.UsageError, match="give both"):
        sagnac.model(noise=NOISE)
    with pytest.raises(sagnac.UsageError, match="neither a record nor noise"):
        sagnac.model(from_s=1.0)
    with pytest.raises(sagnac.UsageError, match="not known"):
        sagnac.model(noise=NOISE, from_s=1.0, to_s=10.0, write=["kalibre"])
    with pytest.raises(sagnac.StudyError, match="unknown key"):
        sagnac.model(noise={"n": "1 deg/h"}, from_s=1.0, to_s=10.0)
    assert json.loads(files()[1]["model.json"])["aim"] == "bound"
