"""Coverage of the coefficients of `sagnac allan --temperature` on records made by NumPy.

    cargo build --release -p sagnac-cli
    python benches/temperature_numpy.py terms [RECORDS]   # T, T2 and dT, by kind of noise and course of the temperature
    python benches/temperature_numpy.py method [RECORDS]  # the same from an implementation in NumPy, without the sensor's resolution
    python benches/temperature_numpy.py chosen [RECORDS]  # records without dependence, terms chosen by the program

Needs NumPy and SciPy. Results are tables of docs/dev/numerics.md. `SAGNAC` names the program, by default that of target/release.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import documents
import numpy as np
from scipy import linalg, signal, stats

from allan_numpy import PROGRAM, flicker

SAMPLES = 20_000
COLUMNS = 50
# White noise of 1 °/h/√Hz. Flicker meets it at some 70 s, the random walks at 350, 1200 and 3500 s.
NOISES = {
    "white": lambda rng: rng.standard_normal(SAMPLES),
    "white, low-pass 5 s": lambda rng: signal.lfilter(
        [1 - np.exp(-0.2)], [1, -np.exp(-0.2)], rng.standard_normal(SAMPLES + 200)
    )[200:],
    "white and flicker": lambda rng: rng.standard_normal(SAMPLES) + 0.15 * flicker(rng, SAMPLES),
    "white and walk": lambda rng: walk(rng, 0.005),
    "white and weak walk": lambda rng: walk(rng, 0.0015),
    "white and hidden walk": lambda rng: walk(rng, 0.0005),
}
TIME = np.arange(SAMPLES)
RESOLUTION = 0.0625


def walk(rng, k):
    return rng.standard_normal(SAMPLES) + k * np.cumsum(rng.standard_normal(SAMPLES))


def chamber():
    """Six steps of a chamber, to which the sensor settles in 300 s each."""
    settled = signal.lfilter([1 - np.exp(-1 / 300)], [1, -np.exp(-1 / 300)], np.repeat([0, -20, 20, -10, 30, 5], 1 + SAMPLES // 6))
    return 20 + settled[:SAMPLES]


# Each with the terms that it tells from each other.
COURSES = {
    "ramp": (20 + 10 * TIME / SAMPLES, ["T", "T2"]),
    "chamber": (chamber(), ["T", "T2", "dT"]),
    "day": (20 + 5 * np.sin(2 * np.pi * TIME / SAMPLES + 0.7), ["T", "T2", "dT"]),
}
# °/h/K, °/h/K², °/h/(K/min)
TRUTH = {"T": 0.1, "T2": 0.01, "dT": 0.5}


def program(records, course, *options):
    """The columns of the document, for records with the same quantized temperature."""
    measured = np.round(course / RESOLUTION) * RESOLUTION
    for first in range(0, len(records), COLUMNS):
        part = records[first : first + COLUMNS]
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log.npy"
            np.save(log, np.stack([*part, measured], axis=1))
            columns = ",".join(str(i + 1) for i in range(len(part)))
            call = [PROGRAM, "allan", str(log), "--data", "rate", "--rate", "1Hz", "--unit", "deg/h", "--column", columns]
            call += ["--temperature", str(len(part) + 1), "--json", "--out", str(Path(folder) / "out")]
            call += ["--bootstrap", "0", "--fit", "none", "--intervals", "stable32", *options]
            yield from documents.columns(json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout))


def part(name, course):
    """The rate of a term with its true coefficient. The reference temperature of a square is the mean, to 0.1 K."""
    match name:
        case "T":
            return TRUTH["T"] * course
        case "T2":
            return TRUTH["T2"] * (course - np.round(course.mean(), 1)) ** 2
        case "dT":
            return TRUTH["dT"] * 60 * np.gradient(course)


def row(column, name):
    return next(row for row in column["temperature"] if row["coefficient"] == name)


def covered(columns, name, truth):
    rows = [row(column, name) for column in columns]
    inside = [found["lower"] is not None and found["lower"] <= truth <= found["upper"] for found in rows]
    values = [found["value"] for found in rows if found["value"] is not None]
    widths = [found["upper"] - found["lower"] for found in rows if found["lower"] is not None]
    ratio = np.median(widths) / (2 * 1.96 * np.std(values)) if len(values) > 1 else np.nan
    return f"{100 * np.mean(inside):5.1f} ({ratio:.2f})"


def terms(records):
    print(f"coverage of 95 % intervals in percent (median width over that of the scatter), {records} records of {SAMPLES} samples")
    rng = np.random.default_rng(29)
    for noise, make in NOISES.items():
        made = [make(rng) for _ in range(records)]
        for name, (course, wanted) in COURSES.items():
            rates = sum(part(term, course) for term in wanted)
            found = list(program([x + rates for x in made], course, "--temperature-terms", ",".join(wanted)))
            cells = [f"{term} {covered(found, term, TRUTH[term])}" for term in wanted]
            robust = np.mean([row(column, wanted[0])["intervals"] == "robust" for column in found])
            print(f"{noise:22} {name:8} {', '.join(cells)}; robust {100 * robust:.1f} %", flush=True)


def covariances(blocks, m):
    """Covariances of blocks of m samples of white noise, flicker and a random walk, each of unit variance about its mean."""
    lags = np.arange(blocks + 1) * m
    holds = np.loadtxt(Path(__file__).parent.parent / "tests/data/flicker_weights.csv", delimiter=",", skiprows=1)
    samples = np.arange(lags[-1] + 1)
    rates = sum(variance * np.maximum(0, 1 - samples / length) for _, length, variance in holds)
    # Variance of the angle after so many samples, that of a random walk up to a multiple of their square.
    of_flicker = lags * rates[0] + 2 * np.array([np.sum((lag - samples[1:lag]) * rates[1:lag]) for lag in lags])
    for angle in (lags, of_flicker, (lags - lags.astype(float) ** 3) / 6):
        covariance = 0.5 * (angle[1:] - 2 * angle[:-1] + np.concatenate([angle[1:2], angle[:-2]]))
        matrix = linalg.toeplitz(covariance)
        centred = np.eye(blocks) - 1 / blocks
        yield matrix * blocks / np.trace(centred @ matrix @ centred)


def method(records):
    print(f"coverage of 95 % intervals in percent by the method in NumPy, {records} records of {SAMPLES} samples")
    rng = np.random.default_rng(37)
    m = -(-SAMPLES // 128)
    blocks = SAMPLES // m
    white, of_flicker, of_walk = covariances(blocks, m)
    means = lambda x: x[: blocks * m].reshape(blocks, m, *x.shape[1:]).mean(1)
    inverses, constants = [], []
    for f in (0, *4.0 ** np.arange(-2, 6)):
        for k in (0, *4.0 ** np.arange(-4, 9)):
            matrix = white + f * of_flicker + k * of_walk
            factor = np.linalg.cholesky(matrix + 2 * np.abs(matrix).max())
            inverses.append(np.linalg.inv(factor))
            prior = np.log(20) * (f == 0) + 0.2 * np.log(max(k, 4.0**-4))
            constants.append(prior - np.log(np.diag(factor)).sum())
    inverses, constants = np.array(inverses), np.array(constants)
    for noise, make in NOISES.items():
        values = inverses @ means(np.stack([make(rng) for _ in range(records)], axis=1))
        for name, (course, wanted) in COURSES.items():
            columns = np.stack([np.ones(SAMPLES), *[part(term, course - course.mean()) for term in wanted]], axis=1)
            whitened = inverses @ means(columns)
            products = np.einsum("gia,gib->gab", whitened, whitened)
            towards = np.einsum("gia,gir->gar", whitened, values)
            inverse = np.linalg.inv(products)
            found = np.einsum("gab,gbr->gar", inverse, towards)
            squares = (values**2).sum(1) - (found * towards).sum(1)
            degrees = blocks - columns.shape[1]
            determinants = np.linalg.slogdet(products)[1]
            likelihood = (constants - 0.5 * determinants)[:, None] - 0.5 * degrees * np.log(squares)
            weights = np.exp(likelihood - likelihood.max(0))
            weights /= weights.sum(0)
            cells = []
            for i, term in enumerate(wanted, 1):
                errors = np.sqrt(inverse[:, i, i][:, None] * squares / degrees)
                below = (weights * stats.t.cdf(-found[:, i] / errors, degrees)).sum(0)
                cells.append(f"{term} {100 * np.mean((below > 0.025) & (below < 0.975)):5.1f}")
            print(f"{noise:22} {name:8} {', '.join(cells)}", flush=True)


def chosen(records):
    print(f"{records} records of {SAMPLES} samples without any dependence, terms chosen by the program: percent with an interval without 0")
    rng = np.random.default_rng(31)
    for noise, make in NOISES.items():
        made = [make(rng) for _ in range(records)]
        for name, (course, _) in COURSES.items():
            found = list(program(made, course))
            line = f"{noise:22} {name:8} {covered(found, 'T', 0)} of T covered;"
            for term in ("T", "T2", "dT", "aging", "warm-up"):
                rows = [row(column, term) for column in found]
                used = [cell["value"] is not None and (cell["lower"] > 0 or cell["upper"] < 0) for cell in rows]
                line += f" {term} {100 * np.mean(used):.1f}"
            print(line, flush=True)


if __name__ == "__main__":
    globals()[sys.argv[1]](int(sys.argv[2]) if len(sys.argv) > 2 else 200)
