"""Writes log.csv, a log of six axes at rest with white noise, and deviations.csv, their overlapping Allan deviations.

Run it in its folder: python make.py
"""

import numpy as np

SAMPLES, STEP_S = 1200, 0.01
NAMES = ["gx [deg/s]", "gy [deg/s]", "gz [deg/s]", "ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]"]
MEANS = [0.001, -0.002, 0.003, 0.1, -0.2, 9.80665]
SIGMAS = [0.05, 0.06, 0.07, 0.01, 0.011, 0.012]
G = 9.80665

rng = np.random.default_rng(6)
columns = [np.round(rng.normal(mean, sigma, SAMPLES), 6) for mean, sigma in zip(MEANS, SIGMAS)]
rows = (",".join(f"{x:.6f}" for x in row) for row in zip(STEP_S * np.arange(SAMPLES), *columns))
with open("log.csv", "w") as file:
    file.write("\n".join(["time [s]," + ",".join(NAMES), *rows]) + "\n")


def deviation(samples, m):
    """From sums over m neighbours: half the mean square of the differences of neighbouring means."""
    means = np.convolve(samples, np.ones(m) / m, mode="valid")
    return np.sqrt(0.5 * np.mean((means[m:] - means[:-m]) ** 2))


with open("deviations.csv", "w") as file:
    file.write("column,m,value,unit\n")
    for name, samples in zip(NAMES, columns):
        unit, size = ("deg/h", 3600.0) if name.startswith("g") else ("ug", 1e6 / G)
        for m in [1, 2, 4, 8, 16, 32, 64]:
            file.write(f"{name.split()[0]},{m},{float(deviation(size * samples, m))!r},{unit}\n")
