"""Coverage of the intervals of `sagnac allan` and `sagnac compare` on records made by NumPy.

    cargo build --release -p sagnac-cli
    python benches/allan_numpy.py deviations [RECORDS]    # intervals of deviations, by kind of noise and averaging time
    python benches/allan_numpy.py coefficients [RECORDS]  # N and B behind the filter of a sensor
    python benches/allan_numpy.py models [RECORDS]        # all coefficients of five noise models, with Q, K and Markov noise
    python benches/allan_numpy.py simulated [RECORDS]     # the same of records of `sagnac simulate`
    python benches/allan_numpy.py tails [RECORDS]         # N of white noise that is not Gaussian, and of Markov noise added to white noise
    python benches/allan_numpy.py compare [PAIRS]         # p of two records of equal noise behind such a filter
    python benches/allan_numpy.py dynamic [RECORDS]       # changes in records without one, and a step of N that is found

Needs NumPy and SciPy. Results are tables of docs/dev/numerics.md. `SAGNAC` names the program, by default that of target/release.
"""

import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import documents
import numpy as np
from scipy import signal, stats

PROGRAM = os.environ.get("SAGNAC", str(Path(__file__).parent.parent / "target/release/sagnac"))
# Columns of a file, which the program analyses in one call.
COLUMNS = 50


def half_integral(taps):
    """Impulse response of flicker noise: white noise integrated to the order 1/2 (Kasdin 1995)."""
    k = np.arange(1, taps)
    return np.concatenate([[1.0], np.cumprod((k - 0.5) / k)])


def flicker(rng, count):
    taps = 2 * count
    return signal.fftconvolve(rng.standard_normal(taps + count), half_integral(taps))[taps : taps + count]


def program(command, files, *options):
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for i, rates in enumerate(files):
            names.append(str(Path(folder) / f"{i}.npy"))
            np.save(names[-1], rates)
        call = [PROGRAM, command, *names, "--data", "rate", "--json", "--out", str(Path(folder) / "out"), *options]
        return json.loads(subprocess.run(call, check=True, capture_output=True, text=True).stdout)


def columns(records, make, *options):
    """The results for records, each a column of some file."""
    for first in range(0, records, COLUMNS):
        rates = np.stack([make() for _ in range(min(COLUMNS, records - first))], axis=1)
        names = ",".join(str(i + 1) for i in range(rates.shape[1]))
        yield from documents.columns(program("allan", [rates], "--column", names, *options))


# Coefficients of white noise, flicker, random walk and ramp. B of half_integral is 1.
KINDS = {
    "white": (1, 0, 0, 0),
    "flicker": (0, 1, 0, 0),
    "walk": (0, 0, 1, 0),
    "white and flicker": (1, 0.3, 0, 0),
    "white and walk": (1, 0, 0.03, 0),
    "white and ramp": (1, 0, 0, 3e-3),
    "weak ramp": (1, 0, 0, 3e-4),
}
DEVIATIONS = ["adev", "oadev", "mdev", "hdev", "ohdev"]
SAMPLES = 4096


def expected(deviation, m, kind):
    """The expected deviation: the mean square of a difference of the rates, from the impulse responses."""
    white, of_flicker, walk, ramp = KINDS[kind]
    order = 3 if deviation.endswith("hdev") else 2
    step = np.repeat([-1.0, 1.0] if order == 2 else [1.0, -2.0, 1.0], m) / m
    if deviation == "mdev":
        step = np.convolve(step, np.ones(m) / m)
    response = half_integral(2 * SAMPLES)
    square = (
        white**2 * np.sum(step**2)
        + of_flicker**2 * np.sum(signal.fftconvolve(step, response) ** 2)
        + walk**2 * np.sum(np.cumsum(step) ** 2)
        + (ramp * m if order == 2 else 0) ** 2
    )
    return np.sqrt(square / (2 if order == 2 else 6))


def deviations(records):
    rng = np.random.default_rng(22)
    print(f"coverage of 95 % intervals in percent, {records} records of {SAMPLES} samples")
    for kind, (white, of_flicker, walk, ramp) in KINDS.items():

        def make():
            return (
                white * rng.standard_normal(SAMPLES)
                + (of_flicker * flicker(rng, SAMPLES) if of_flicker else 0)
                + walk * np.cumsum(rng.standard_normal(SAMPLES))
                + ramp * np.arange(SAMPLES)
            )

        options = ["--rate", "1Hz", "--unit", "none", "--fit", "none", "--deviation", ",".join(DEVIATIONS)]
        covered = {}
        for column in columns(records, make, *options, *EXTRA):
            for point in column["curve"]:
                if 4 * point["m"] <= SAMPLES:
                    at = (point["deviation"], point["m"])
                    truth = covered.setdefault(at, [expected(*at, kind)])[0]
                    covered[at].append(point["lower"] is not None and point["lower"] <= truth <= point["upper"])
        for deviation in DEVIATIONS:
            row = [100 * np.mean(found[1:]) for (name, _), found in covered.items() if name == deviation]
            print(f"{kind:18} {deviation:6}", " ".join(f"{cell:5.1f}" for cell in row), flush=True)


RATE = 100
LENGTH = 2**17
# White noise of 1 per √Hz, and a flicker that meets it at 30 s.
B = 1 / np.sqrt(2 * np.log(2) / np.pi * 30)


def filters():
    yield "none", [1.0], [1.0]
    yield "two samples", [0.5, 0.5], [1.0]
    for corner in (10, 40, 100):
        a = np.exp(-2 * np.pi * corner / RATE)
        yield f"low-pass {corner} Hz", [1 - a], [1.0, -a]


def filtered(rng, b, forward, back):
    past = 1000
    white = np.sqrt(RATE) * rng.standard_normal(LENGTH + past)
    rates = white + (b * flicker(rng, LENGTH + past) if b else 0)
    return signal.lfilter(forward, back, rates)[past:]


OF_RECORD = ["--rate", f"{RATE}Hz", "--unit", "none"]


def coefficients(records):
    print(f"{records} records of {LENGTH} samples at {RATE} Hz")
    rng = np.random.default_rng(22)
    for name, forward, back in filters():
        for b in (0, B):
            options = [*OF_RECORD, *(EXTRA or ["--bootstrap", "0"])]
            found = list(columns(records, lambda: filtered(rng, b, forward, back), *options))
            line = f"{name:16} B {b:.3f}:"
            starts = [RATE * column["coefficients"][0]["fit_from_s"] for column in found]
            line += f" from {np.median(starts):3.0f} ({min(starts):.0f} … {max(starts):.0f}) samples;"
            described = [column for column in found if column["coefficients"][0]["status"] != "model rejected"]
            line += f" not described {100 * (1 - len(described) / records):.1f} %;"
            for coefficient, truth in (("N", 1.0), ("B", b)):
                rows = [row for column in found for row in column["coefficients"] if row["coefficient"] == coefficient]
                identified = [row for row in rows if row["status"] == "estimated"]
                bounded = [row for row in rows if row["upper"] is not None]
                line += f" {coefficient} identified {100 * len(identified) / records:.1f} %"
                for which in (identified, bounded):
                    inside = [row["lower"] <= truth <= row["upper"] for row in which]
                    line += f", covered {100 * np.mean(inside):.1f}" if inside else ""
                if identified:
                    sides = [row["lower"] > truth for row in identified]
                    line += f" (above {100 * np.mean(sides):.1f})"
                    line += f" median {np.median([row['value'] for row in identified]):.4f}"
            others = {}
            for column in found:
                for row in column["coefficients"]:
                    if row["status"] == "estimated" and row["coefficient"] not in "NB":
                        others[row["coefficient"]] = others.get(row["coefficient"], 0) + 1
            print(line, others, flush=True)


COVERED = "coverage of 95 % intervals in percent (truth below · above) and its 99.9 % interval"
COEFFICIENTS = ("Q", "N", "B", "K", "markov", "markov_time")
# Q, N, B, K, then σ and time of Markov noise in samples, and the terms of the fit.
MODELS = {
    "white": ((0, 1, 0, 0, 0, 0), "auto"),
    "white and flicker": ((0, 1, 0.3, 0, 0, 0), "auto"),
    "white and walk": ((0, 1, 0, 0.03, 0, 0), "auto"),
    "quantization, white and flicker": ((3, 1, 0.3, 0, 0, 0), "auto"),
    "white and Markov": ((0, 1, 0, 0, 0.3, 50), "N,markov"),
}


def models(records):
    samples = 2**12
    print(f"{records} records of {samples} samples: {COVERED}")
    for name, (truth, terms) in MODELS.items():
        q, n, b, k, sigma, time = truth
        rng = np.random.default_rng(31)

        def make():
            rates = n * rng.standard_normal(samples) + np.diff(q * rng.standard_normal(samples + 1))
            rates += (b * flicker(rng, samples) if b else 0) + k * np.cumsum(rng.standard_normal(samples))
            if sigma:
                a, past = np.exp(-1 / time), 10 * time
                rates += sigma * signal.lfilter([np.sqrt(1 - a * a)], [1, -a], rng.standard_normal(samples + past))[past:]
            return rates

        covered(name, truth, columns(records, make, "--rate", "1Hz", "--unit", "none", "--fit", terms, *EXTRA))


# The same coefficients as keys of a noise file, with the units in which they are found.
KEYS = {
    "Q": 'quantization = "{} arcsec"',
    "N": 'angle_random_walk = "{} deg/sqrt(h)"',
    "B": 'bias_instability = "{} deg/h"',
    "K": 'rate_random_walk = "{} deg/h/sqrt(h)"',
    "markov": 'markov = {{ amplitude = "{} deg/h", time = "200 s" }}',
}
SIMULATED = {
    "white": ((0, 0.003, 0, 0, 0, 0), "auto"),
    "white and walk": ((0, 0.003, 0, 0.03, 0, 0), "auto"),
    "white and flicker": ((0, 0.003, 0.01, 0, 0, 0), "auto"),
    "quantization, white, flicker and walk": ((0.05, 0.003, 0.01, 0.02, 0, 0), "auto"),
    "white and Markov": ((0, 0.003, 0, 0, 0.03, 200), "N,markov"),
}


def simulated(records):
    print(f"{records} records of 9 h at 1 Hz of sagnac simulate: {COVERED}")
    for name, (truth, terms) in SIMULATED.items():
        with tempfile.TemporaryDirectory() as folder:
            noise, out = Path(folder) / "noise.toml", Path(folder) / "records"
            noise.write_text("\n".join(KEYS[key].format(value) for key, value in zip(COEFFICIENTS, truth) if value and key in KEYS))
            call = [PROGRAM, "simulate", noise, "--rate", "1Hz", "--length", "9h", "--records", str(records), "--seed", "47"]
            subprocess.run([*call, "--form", "npy", "--out", out, "--quiet"], check=True)
            files = iter(sorted(out.glob("*.npy")))

            def read():
                return np.load(next(files)).ravel()

            covered(name, truth, columns(records, read, "--rate", "1Hz", "--unit", "deg/h", "--fit", terms, *EXTRA))


def covered(name, truth, found):
    """Prints how many intervals of each coefficient contain the truth."""
    found = list(found)
    for coefficient, true in zip(COEFFICIENTS, truth):
        rows = [row for column in found for row in column["coefficients"] if row["coefficient"] == coefficient]
        bounded = [row for row in rows if row["upper"] is not None]
        if not true or not bounded:
            continue
        estimated = sum(row["status"] == "estimated" for row in rows)
        below, above = (sum(side) for side in zip(*((row["lower"] > true, row["upper"] < true) for row in bounded)))
        inside = len(bounded) - below - above
        low, high = stats.binomtest(inside, len(bounded)).proportion_ci(0.999)
        line = f"{name:37} {coefficient:12} estimated in {estimated}, covered {100 * inside / len(bounded):.1f} of {len(bounded)}"
        print(f"{line} ({below} · {above}), {100 * low:.1f} … {100 * high:.1f}", flush=True)


def tails(records):
    rng = np.random.default_rng(3)

    def white():
        return rng.standard_normal(LENGTH)

    def smooth(time):
        a = np.exp(-1 / time)
        return signal.lfilter([np.sqrt(1 - a * a)], [1, -a], rng.standard_normal(LENGTH + 10 * time))[10 * time :]

    def bursts():
        rates = white()
        for start in rng.integers(0, LENGTH - 500, rng.poisson(10)):
            rates[start : start + 500] *= 3
        return rates

    # Each with its N² over that of the unit white noise.
    kinds = {
        "Gaussian": (white, 1),
        "1 % ten times as large": (lambda: white() * np.where(rng.random(LENGTH) < 0.01, 10, 1), 1.99),
        "Student, 3 degrees": (lambda: rng.standard_t(3, LENGTH), 3),
        "size drawn every 20 s": (lambda: np.exp(0.3 * smooth(2000)) * white(), np.exp(0.18)),
        "10 bursts of 5 s": (bursts, 1 + 10 * 500 * 8 / LENGTH),
        "Markov noise of 3 s": (lambda: white() + 0.15 * smooth(300), 1),
        "Markov noise of 0.1 s": (lambda: white() + 0.5 * smooth(10), 1),
    }
    print(f"{records} records of {LENGTH} samples at {RATE} Hz: coverage of 95 % intervals in percent")
    for name, (make, square) in kinds.items():
        n = np.sqrt(square / RATE)
        options = [*OF_RECORD, *(EXTRA or ["--bootstrap", "0"])]
        found = list(columns(records, make, *options))
        rows = [{row["coefficient"]: row for row in column["coefficients"]} for column in found]
        identified = [row["N"] for row in rows if row["N"]["value"] is not None]
        inside = [row["lower"] <= n <= row["upper"] for row in identified]
        width = np.median([row["upper"] / row["lower"] - 1 for row in identified]) / 2
        line = f"{name:24} N identified {100 * len(inside) / records:.0f} %, covered {100 * np.mean(inside):.1f}, ±{100 * width:.2f} %;"
        for other in ("Q", "B", "K", "L", "markov"):
            share = np.mean([other in row and row[other]["value"] is not None for row in rows])
            line += f" {other} {100 * share:.0f}" if share else ""
        if "Markov" not in name:
            for m in (1, 64, 4096):
                points = [point for column in found for point in column["curve"] if point["m"] == m]
                sigma = n * np.sqrt(RATE / m)
                line += f"; m = {m}: {100 * np.mean([point['lower'] <= sigma <= point['upper'] for point in points]):.1f}"
        print(line, flush=True)


def compare(pairs):
    print(f"{pairs} pairs of records of {LENGTH} samples at {RATE} Hz: p of the test of Kolmogorov and Smirnov")
    rng = np.random.default_rng(7)
    for name, forward, back in filters():
        for b in (0, B):
            p = {"noise": [], "N": [], "B": []}

            def of_pair(files):
                return program("compare", files, *OF_RECORD, *EXTRA)

            made = ([filtered(rng, b, forward, back) for _ in range(2)] for _ in range(pairs))
            for found in POOL.map(of_pair, made):
                p["noise"].append(next(fact["p"] for fact in found["answer"]["facts"] if fact["fact"] == "test"))
                for row in found["tables"]["coefficients"]:
                    if row["coefficient"] in p and row["p"] is not None:
                        p[row["coefficient"]].append(row["p"])
            line = f"{name:16} B {b:.3f}:"
            for key, values in p.items():
                if values:
                    test = stats.kstest(values, "uniform").pvalue
                    share = 100 * np.mean(np.array(values) < 0.05)
                    line += f" {key} {test:.3f} ({len(values)}, p < 5 %: {share:.1f} %)"
            print(line, flush=True)


def dynamic(records):
    samples = 2**14
    rng = np.random.default_rng(5)

    def white():
        return rng.standard_normal(samples)

    a = np.exp(-2 * np.pi * 10 / RATE)
    step = np.where(np.arange(samples) < samples // 2, 1.0, 1.3)
    gap = np.zeros(samples)
    gap[3000:5000] = np.nan
    kinds = {
        "white": white,
        "flicker": lambda: flicker(rng, samples),
        "white and flicker": lambda: white() + 0.3 * flicker(rng, samples),
        "white and walk": lambda: white() + 0.03 * np.cumsum(white()),
        "low-pass 10 Hz": lambda: filtered(rng, 0, [1 - a], [1.0, -a])[:samples],
        "low-pass 10 Hz and B": lambda: filtered(rng, B, [1 - a], [1.0, -a])[:samples],
        "white with a gap": lambda: white() + gap,
        "Student, 3 degrees": lambda: rng.standard_t(3, samples),
        "step of 30 %": lambda: step * white(),
        "step of 30 % and B": lambda: step * white() + 0.3 * flicker(rng, samples),
    }
    print(f"{records} records of {samples} samples: records in percent with a change")
    for name, make in kinds.items():
        found = list(columns(records, make, *OF_RECORD, "--fit", "none", "--dynamic", *EXTRA))
        clearest = [min(one["stationarity"], key=lambda octave: octave["p"]) for one in found]
        changed = [octave for octave in clearest if octave["p"] < 0.05]
        line = f"{name:20} {100 * len(changed) / records:.1f}"
        if changed and "step" in name:
            at = np.array([octave["at_s"] for octave in changed]) * RATE / samples
            ratio = [octave["after"] / octave["before"] for octave in changed]
            line += f", at {np.quantile(at, 0.05):.3f} … {np.quantile(at, 0.95):.3f} of the record, by {np.median(ratio):.3f}"
        print(line, flush=True)


if __name__ == "__main__":
    EXTRA = sys.argv[3:]
    POOL = ThreadPoolExecutor(os.cpu_count())
    globals()[sys.argv[1]](int(sys.argv[2]) if len(sys.argv) > 2 else 200)
