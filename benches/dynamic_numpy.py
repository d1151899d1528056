"""The test for a change of `sagnac allan --dynamic` in NumPy, and how often it finds one.

    python benches/dynamic_numpy.py rates [RECORDS]    # false alarms by kind of noise, and a step of N that is found
    python benches/dynamic_numpy.py p FILE             # p of the rates of a text file, as in stationarity.csv

Needs NumPy and SciPy. `allan_numpy.py dynamic` counts the same with the program, which takes longer because it draws maps. Results are a
table of docs/dev/numerics.md.
"""

import sys

import allan_numpy
import numpy as np
from scipy import signal, stats

PARTS = 64
MIN_PART = 8
OVERSHOOT = 0.5826


def probabilities(rates):
    """p at each octave, times their number."""
    length = len(rates) // PARTS
    angles = np.concatenate([[0], np.cumsum(rates - np.mean(rates))])
    found = []
    m = 1
    while m * MIN_PART <= length:
        parts = [angles[i * length : (i + 1) * length + 1] for i in range(PARTS)]
        logs = np.log([np.mean((part[2 * m :] - 2 * part[m:-m] + part[: -2 * m]) ** 2) for part in parts])
        sums = np.cumsum(logs - logs.mean())[:-1]
        statistic = (np.abs(sums).max() / logs.std(ddof=1) + OVERSHOOT) / np.sqrt(PARTS)
        found.append(stats.kstwobign.sf(statistic))
        m *= 2
    return np.minimum(1, len(found) * np.array(found))


def rates(records):
    rng = np.random.default_rng(5)
    rng_of_sine = np.random.default_rng(6)
    for samples in (2**13, 2**15):

        def white():
            return rng.standard_normal(samples)

        def flicker():
            return allan_numpy.flicker(rng, samples)

        step = np.where(np.arange(samples) < samples // 2, 1.0, 1.3)
        # Of the power of the white noise, and a period of one sample less than a part.
        sine = np.sqrt(2) * np.sin(2 * np.pi * np.arange(samples) / (samples // PARTS - 1))
        small = np.where(np.arange(samples) < samples // 2, 1.0, 1.1)
        kinds = {
            "white": white,
            "flicker": flicker,
            "white and flicker": lambda: white() + 0.3 * flicker(),
            "white and walk": lambda: white() + 0.03 * np.cumsum(white()),
            "white and ramp": lambda: white() + 3e-3 * np.arange(samples),
            "low-pass": lambda: signal.lfilter([0.2], [1, -0.8], rng.standard_normal(samples + 500))[500:],
            "Student, 3 degrees": lambda: rng.standard_t(3, samples),
            "step of 30 %": lambda: step * white(),
            "step of 30 % and flicker": lambda: step * white() + 0.3 * flicker(),
            "step of 10 %": lambda: small * white(),
            "white and sine": lambda: rng_of_sine.standard_normal(samples) + sine,
        }
        print(f"{records} records of {samples} samples: records in percent with a change")
        for name, make in kinds.items():
            changed = [probabilities(make()).min() < 0.05 for _ in range(records)]
            print(f"{name:25} {100 * np.mean(changed):.1f}", flush=True)


def p(file):
    print(probabilities(np.loadtxt(file)))


if __name__ == "__main__":
    globals()[sys.argv[1]](sys.argv[2] if sys.argv[1] == "p" else int(sys.argv[2]) if len(sys.argv) > 2 else 400)
