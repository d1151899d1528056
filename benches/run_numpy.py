"""Whole runs of gyros that switch modes, stepped from switch to switch in double precision, beside `sagnac run`.

    cargo build --release -p sagnac-cli
    python benches/run_numpy.py [RUNS]

The end of each run is uniform over one cycle of two intervals centred on the run time, drawn by NumPy and not from the 64 steps of the program.
Needs NumPy. `SAGNAC` names the program, by default that of target/release.
"""

import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

TAU = 3000.0
# Name, A and its deviation ″/s, Ω_nm and its deviation ″/s, Ω_m0 ″/s, N ″/√s, δP_max ″, first mode random, interval s, run s.
GYROS = [
    ("the paper's gyro, 1 h", 14, 0, 0.05, 0, 0, 0, 10, False, 40, 3600),
    ("spreads and walk, 10 min", 14, 1, 0.05, 0.01, 0.3, 1.8, 10, True, 47, 600),
    ("quiet gyro, 8 h", 2, 0.2, 0, 0.002, -0.02, 0.1, 1.5, False, 39.3, 28800),
]


def residual(rng, runs, most):
    """Errors of a switch at a random phase."""
    return most * np.sin(rng.uniform(0, 2 * np.pi, runs))


def angles(rng, runs, a, a_spread, nm, nm_spread, initial, walk, most, is_random, interval, duration):
    """Angles at the ends of the runs, ″."""
    end = duration + interval * rng.uniform(-1, 1, runs)
    a = a + a_spread * rng.standard_normal(runs)
    sign = np.where(is_random & (rng.random(runs) < 0.5), -1.0, 1.0)
    angle = (nm + nm_spread * rng.standard_normal(runs)) * duration
    since = 0.0
    while since < end.max():
        # Of the interval, the part before the end.
        to = np.clip(end, since, since + interval)
        warm = (to - since) - TAU * (np.exp(-since / TAU) - np.exp(-to / TAU))
        angle += sign * (a * warm + initial * (to - since)) + walk * np.sqrt(to - since) * rng.standard_normal(runs)
        since += interval
        angle += np.where(end > since, residual(rng, runs, most), 0)
        sign = -sign
    return angle


def of_program(runs, a, a_spread, nm, nm_spread, initial, walk, most, is_random, interval, duration):
    """Rms angle at the end with its standard error, and that in closed form, ″."""
    study = f"""title = "Runs"
kind = "switched-run"
trials = {runs}
[drift]
magnetic = "{a} arcsec/s"
magnetic_spread = "{a_spread} arcsec/s"
warm_up_time = "{TAU} s"
non_magnetic = "{nm} arcsec/s"
non_magnetic_spread = "{nm_spread} arcsec/s"
initial_magnetic = "{initial} arcsec/s"
angle_random_walk = "{walk} arcsec/sqrt(s)"
residual_max = "{most} arcsec"
[switching]
interval = "{interval} s"
first_mode = "{"random" if is_random else "positive"}"
[run]
duration = "{duration} s"
"""
    program = Path(os.environ.get("SAGNAC", "target/release/sagnac")).resolve()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "study.toml").write_text(study)
        command = [program, "run", "study.toml", "--device", "cpu", "--quiet", "--out", "out"]
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        with open(Path(folder, "out", "points.csv")) as table:
            row = next(row for row in csv.DictReader(table) if row["angle"] == "end")
    return [float(row[name]) for name in ("rms_arcsec", "rms_se_arcsec", "theory_rms_arcsec")]


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    rng = np.random.default_rng(1)
    print("| gyro | NumPy, ″ rms | program | closed form | apart, standard errors |\n|---|---|---|---|---|")
    for name, *gyro in GYROS:
        squares = angles(rng, runs, *gyro) ** 2
        rms = np.sqrt(squares.mean())
        se = squares.std() / np.sqrt(runs) / (2 * rms)
        found, found_se, closed = of_program(runs, *gyro)
        z = (found - rms) / np.hypot(se, found_se)
        print(f"| {name} | {rms:.2f} ± {se:.2f} | {found:.2f} ± {found_se:.2f} | {closed:.2f} | {z:.2f} |")


if __name__ == "__main__":
    main()
