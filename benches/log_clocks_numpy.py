"""Logs with the clocks of real loggers: whether `sagnac allan` finds their rate, their gaps and N.

    cargo build --release -p sagnac-cli
    python benches/log_clocks_numpy.py [LOGS]     LOGS of each kind (25)

Each log has white noise with N = 0.3 °/√h in 20,000 samples at about 100 Hz. Its clock is uniform, or stamps jitter by 0.3 steps, come in bursts of
1 to 9 rows, are up to 5 steps late, have the time of the row before, are whole half seconds, drift by 2 %, or 1 % of the samples is lost; or they
jitter by a normal 0.8 steps, bursts of random length share the stamp of their last row, or the unit of the stamps is 0.95 steps. A log that
is refused is read again with the options that the message proposes. A line of the table has the largest relative error of the rate, the
largest number of samples that are too many or too few, and in how many logs the interval of N holds the true value.

Needs NumPy. `SAGNAC` names the program, by default that of target/release.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import documents
import numpy as np

PROGRAM = os.environ.get("SAGNAC", str(pathlib.Path(__file__).resolve().parent.parent / "target/release/sagnac"))
COUNT, N = 20_000, 0.3
PLACE = np.arange(COUNT)


def bursts(rng, t, step):
    t, at = t.copy(), 0
    while at < COUNT:
        end = min(COUNT, at + rng.integers(1, 10))
        t[at:end] = t[end - 1] + 0.1 * step * np.arange(end - at)
        at = end
    return t


def shared(rng, t):
    last = np.append(np.flatnonzero(rng.random(COUNT - 1) < 0.2), COUNT - 1)
    return t[last[np.searchsorted(last, PLACE)]]


# The stamps of samples that were taken at the times t.
CLOCKS = {
    "uniform": lambda rng, t, step: t,
    "jitter": lambda rng, t, step: t + step * rng.uniform(-0.3, 0.3, COUNT),
    "bursts": bursts,
    "late": lambda rng, t, step: np.maximum.accumulate(t + 5 * step * rng.random(COUNT) * (rng.random(COUNT) < 0.1)),
    "doubled": lambda rng, t, step: t - step * ((PLACE % 2 == 1) & (rng.random(COUNT) < 0.2)),
    "coarse": lambda rng, t, step: np.floor(2 * t) / 2,
    "drifting": lambda rng, t, step: t + 0.01 * step * (PLACE * PLACE / COUNT - PLACE),
    "jitter 0.8": lambda rng, t, step: np.maximum.accumulate(t + 0.8 * step * rng.standard_normal(COUNT)),
    "shared": lambda rng, t, step: shared(rng, t),
    "rounded": lambda rng, t, step: np.round(t / (0.95 * step)) * 0.95 * step,
    "lost": lambda rng, t, step: t,
}


def analysed(log, folder):
    """The analysis of a log with the options that messages propose; none if they do not help."""
    options = []
    for _ in range(3):
        words = [PROGRAM, "allan", log, "--data", "rate", "--json", "--bootstrap", "0", "--out", folder / "out", *options]
        ended = subprocess.run(words, capture_output=True, text=True)
        if ended.returncode == 0:
            return json.loads(ended.stdout)
        rate = re.search(r"--rate\s+([\d.]+Hz)", ended.stderr)
        options += ["--duplicates", "keep"] if "keep if each" in ended.stderr else ["--rate", rate[1]] if rate else []
    return None


def main():
    logs = int(sys.argv[1]) if len(sys.argv) > 1 else 25
    print(f"{'clock':10} {'rate':>8} {'samples':>8} {'N held':>7} {'refused':>8}")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for kind, (clock, of) in enumerate(CLOCKS.items()):
            errors, wrong, held, refused = [0.0], [0], 0, 0
            for seed in range(logs):
                rng = np.random.default_rng([kind, seed])
                step = 0.01 * rng.uniform(0.95, 1.05)
                stamps = of(rng, 5 + step * PLACE, step)
                rates = N / 60 / np.sqrt(step) * rng.standard_normal(COUNT)
                kept = (rng.random(COUNT) > 0.01) | (PLACE % (COUNT - 1) == 0) if clock == "lost" else PLACE >= 0
                log = folder / "log.csv"
                rows = np.column_stack([stamps, rates])[kept]
                np.savetxt(log, rows, ["%.7f", "%.9f"], ",", header="time [s],gz [deg/s]", comments="")
                found = analysed(log, folder)
                if found is None:
                    refused += 1
                    continue
                (column,) = documents.columns(found)
                errors.append(abs(column["step_s"] / step - 1))
                wrong.append(max(abs(column["samples"] - COUNT), abs(column["missing"] - np.sum(~kept))))
                coefficient = next(row for row in column["coefficients"] if row["coefficient"] == "N")
                held += coefficient["lower"] <= N <= coefficient["upper"]
            print(f"{clock:10} {max(errors):8.1e} {max(wrong):8d} {held:7d} {refused:8d}", flush=True)


main()
