"""Simulated records: those of the program."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sagnac
from program import Program

NOISE = {"angle_random_walk": "0.01 deg/sqrt(h)", "bias_instability": "0.02 deg/h"}
TEXT = "".join(f'{key} = "{value}"\n' for key, value in NOISE.items())


def write(program: Program, *arguments: object) -> None:
    subprocess.run([program.path, "simulate", *map(str, arguments), "--quiet"], cwd=program.folder, check=True)


@pytest.mark.parametrize("data", ["rate", "increment", "angle"])
def test_records_have_the_bits_of_the_program(program: Program, data: Any) -> None:
    (program.folder / "noise.toml").write_text(TEXT)
    asked = ["--rate", "10Hz", "--length", "500s", "--seed", 3, "--first", 6, "--records", 2, "--data", data]
    write(program, "noise.toml", *asked, "--form", "npy", "--out", "records")
    expected = np.stack([np.load(program.folder / f"records/record_0000{number}.npy") for number in (6, 7)])
    for noise in (NOISE, TEXT, program.folder / "noise.toml"):
        found = sagnac.simulate(noise, rate=10.0, length=500.0, seed=3, first=6, records=2, data=data)
        assert found.shape == (2, 5000) and found.tobytes() == expected.tobytes()
    [alone] = sagnac.simulate(NOISE, rate=10.0, length=500.0, seed=3, first=7, data=data, threads=1)
    assert alone.tobytes() == expected[1].tobytes()


def test_a_gpu_makes_the_same_bits(program: Program) -> None:
    devices = subprocess.run([program.path, "device", "list"], check=True, capture_output=True, text=True).stdout
    if "gpu:0" not in devices:
        pytest.skip("there is no adapter")
    on_processor, on_gpu = (
        sagnac.simulate(NOISE, rate=10.0, length=500.0, seed=3, first=6, records=3, device=device) for device in ("cpu", "gpu:0")
    )
    assert on_gpu.tobytes() == on_processor.tobytes()


def test_motion_has_the_bits_of_the_program(program: Program) -> None:
    (program.folder / "noise.toml").write_text(TEXT)
    motion = {"amplitude": "90 arcsec", "frequency": "1.3 Hz"}
    (program.folder / "motion.toml").write_text("".join(f'{key} = "{value}"\n' for key, value in motion.items()))
    asked = ["--rate", "10Hz", "--length", "500s", "--motion", "motion.toml", "--form", "npy", "--out", "moving"]
    write(program, "noise.toml", *asked)
    expected = np.load(program.folder / "moving/record_00000.npy")
    for given in (motion, program.folder / "motion.toml"):
        [found] = sagnac.simulate(NOISE, rate=10.0, length=500.0, motion=given)
        assert found.tobytes() == expected.tobytes()


AXES = ["--axes", 3, "--motion", "x=sway.toml", "--motion", "spin.toml"]
PARTS = ["--misalignment", "xz=10arcsec,yx=-1deg", "--scale-factor", "z=50ppm,x=-0.1%"]
WARM = ["--temperature", "20..60.5", "--temperature-coefficient", "0.02 deg/h/K"]


@pytest.mark.parametrize(
    "asked, given, columns",
    [
        (["--axes", 3], {"axes": 3}, 3),
        ([*AXES, *PARTS, "--truth", *WARM], {
            "axes": 3,
            "motion": {"x": {"amplitude": "3 deg/s", "frequency": "1 Hz"}, "z": "rate = \"100 deg/s\"\n"},
            "misalignment": {"xz": "10 arcsec", "yx": "-1 deg"},
            "scale_factor": {"z": "50 ppm", "x": "-0.1 %"},
            "truth": True,
            "temperature": (20, 60.5),
            "temperature_coefficient": "0.02 deg/h/K",
        }, 6),
        (["--motion", "spin.toml", "--scale-factor", "50ppm", "--truth"], {"motion": {"rate": "100 deg/s"}, "scale_factor": "50 ppm", "truth": True}, 2),
        (["--data", "pulses", *WARM], {"data": "pulses", "temperature": (20.0, 60.5), "temperature_coefficient": "0.02 deg/h/K"}, 2),
    ],
)
def test_columns_have_the_bits_of_the_program(program: Program, asked: list[object], given: dict[str, Any], columns: int) -> None:
    noise = TEXT + 'readout_lsb = "0.5 arcsec"\n'
    (program.folder / "noise.toml").write_text(noise)
    (program.folder / "sway.toml").write_text('amplitude = "3 deg/s"\nfrequency = "1 Hz"\n')
    (program.folder / "spin.toml").write_text('rate = "100 deg/s"\n')
    write(program, "noise.toml", "--rate", "10Hz", "--length", "60s", "--records", 2, *asked, "--form", "npy", "--out", "records")
    expected = np.stack([np.load(program.folder / f"records/record_0000{number}.npy").T for number in range(2)])
    found = sagnac.simulate(noise, rate=10.0, length=60.0, records=2, **given)
    assert found.shape == (2, columns, 600) and found.tobytes() == expected.tobytes()


def test_gaps_are_those_of_the_program(program: Program, studies: Path) -> None:
    study = studies / "smoke.toml"
    write(program, study, "--at", "gap_ticks=3", "--length", "3s", "--switch-every", "1s", "--truth", "--form", "npy", "--out", "gaps")
    expected = np.load(program.folder / "gaps/record_00000.npy").T
    [found] = sagnac.simulate(study, at={"gap_ticks": 3}, length=3.0, switch_every=1.0, truth=True)
    assert found.tobytes() == expected.tobytes()
    assert np.flatnonzero(np.isnan(found[0])).tolist() == [200, 201, 202, 400, 401, 402] and not np.isnan(found[1]).any()


def test_arrays_of_numpy_are_read_by_numpy(program: Program) -> None:
    (program.folder / "noise.toml").write_text(TEXT)
    write(program, "noise.toml", "--rate", "10Hz", "--length", "500s", "--form", "npz", "--out", "records")
    [rates] = sagnac.simulate(NOISE, rate=10.0, length=500.0)
    with np.load(program.folder / "records/record_00000.npz") as arrays:
        assert arrays["rate_deg_per_h"].tobytes() == rates.tobytes()
        assert np.allclose(arrays["time_s"], np.arange(1, 5001) / 10.0, rtol=1e-15)


def test_a_point_of_a_study_is_chosen_by_its_swept_keys(studies: Path) -> None:
    short, longer = (sagnac.simulate(studies / "record_length.toml", at={"length": length}) for length in ("15 min", "1 h"))
    assert longer.shape[1] == 4 * short.shape[1]


@pytest.mark.parametrize(
    "noise, arguments, error, piece",
    [
        (NOISE, {}, sagnac.UsageError, "give rate=HZ and length=TIME"),
        (NOISE, {"rate": 1.0, "length": 3.0}, sagnac.UsageError, "accepted: 16 to"),
        (NOISE, {"rate": 0.0, "length": 3.0}, sagnac.UsageError, "rate=0.0"),
        (NOISE, {"rate": 1.0, "length": 60.0, "records": 0}, sagnac.UsageError, "records=0"),
        (NOISE, {"rate": 1.0, "length": 60.0, "data": "phase"}, sagnac.UsageError, 'data="phase"'),
        (NOISE, {"rate": 1.0, "length": 60.0, "at": {"length": "1 h"}}, sagnac.UsageError, "selects from a study"),
        ({"angle_random_walk": "1 m"}, {"rate": 1.0, "length": 60.0}, sagnac.StudyError, "angle_random_walk"),
        (NOISE, {"rate": 1.0, "length": 60.0, "motion": "nowhere.toml"}, sagnac.UsageError, "cannot read the motion nowhere.toml"),
        (NOISE, {"rate": 1.0, "length": 60.0, "motion": {"amplitud": "3 arcsec"}}, sagnac.StudyError, "amplitud"),
        (NOISE, {"rate": 1.0, "length": 60.0, "data": "pulses"}, sagnac.UsageError, "readout_lsb"),
        (NOISE, {"rate": 1.0, "length": 60.0, "axes": 2}, sagnac.UsageError, "accepted: 1, 3"),
        (NOISE, {"rate": 1.0, "length": 60.0, "truth": True}, sagnac.UsageError, "give motion=FILE"),
        (NOISE, {"rate": 1.0, "length": 60.0, "motion": {"y": {"rate": "1 deg/s"}}}, sagnac.UsageError, "give axes=3"),
        (NOISE, {"rate": 1.0, "length": 60.0, "misalignment": {"xx": "1 deg"}}, sagnac.UsageError, 'misalignment="xx=1 deg"'),
        (NOISE, {"rate": 1.0, "length": 60.0, "scale_factor": "2"}, sagnac.UsageError, "ppm"),
        (NOISE, {"rate": 1.0, "length": 60.0, "temperature": (20, 60)}, sagnac.UsageError, "temperature_coefficient="),
        (NOISE, {"rate": 1.0, "length": 60.0, "temperature": (20, -300), "temperature_coefficient": "1 deg/h/K"}, sagnac.UsageError, "°C"),
        (NOISE, {"rate": 1.0, "length": 60.0, "device": "no such"}, sagnac.UsageError, "no such"),
        ("nowhere.toml", {}, sagnac.UsageError, "cannot read nowhere.toml"),
    ],
)
def test_what_cannot_be_simulated_is_refused(noise: Any, arguments: Any, error: type[Exception], piece: str) -> None:
    with pytest.raises(error) as refused:
        sagnac.simulate(noise, **arguments)
    assert piece in str(refused.value) and "--" not in str(refused.value), str(refused.value)
