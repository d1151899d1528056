"""Writes the logs of the how-tos in docs/howto into a folder.

    python benches/guide_logs.py [FOLDER]    # results/guide

Needs NumPy and SciPy. The commands of the how-tos can be run there.
"""

import sys
from pathlib import Path

import batch_numpy
import numpy as np

FOLDER = Path(sys.argv[1] if len(sys.argv) > 1 else "results/guide")
FOLDER.mkdir(parents=True, exist_ok=True)
rng = np.random.default_rng(1)


def write(name, *columns, header=""):
    np.savetxt(FOLDER / name, np.stack(columns, axis=1), "%.6f", ",", header=header, comments="")


def white(n, samples):
    """Rates in °/h each second of an angle random walk n in °/√h."""
    return 60 * n * rng.standard_normal(samples)


# How does the rate depend on temperature?
time = np.arange(36_000)
temperature = 20 + 5 * np.sin(2 * np.pi * time / 9000)
rate = white(0.06, len(time)) + 0.5 * temperature + 2.1 * np.exp(-time / 1600)
write("log.csv", rate, temperature, header="gz,temp")

# How even is a batch of gyros? The first has twice the N.
rates, _, _ = batch_numpy.batch(np.random.default_rng(8), "log-normal", (0.05, 0.2), False, 2)
for unit, rate in enumerate(10 * rates.T, start=1):
    write(f"g{unit}.csv", rate)

# Does the noise change? N is larger by 30 % from 20,000 s on.
write("gyro.csv", white(1 / 6, len(time)) * np.where(time < 20_000, 1.0, 1.3))
