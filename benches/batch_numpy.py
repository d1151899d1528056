"""Coverage of the intervals of `sagnac compare` for batches, and its outliers, on batches made by NumPy.

    cargo build --release -p sagnac-cli
    python benches/batch_numpy.py units [BATCHES]    # units with white noise and flicker: values, spreads, the next unit, outliers

Needs NumPy and SciPy. Results are tables of docs/dev/numerics.md. `SAGNAC` names the program, by default that of target/release.
"""

import sys

import allan_numpy
import numpy as np

UNITS = 8
SAMPLES = 2**14
B = 0.3
# Flicker is made this much finer and averaged: at its own step it has 1.4 times the Allan variance of flicker, which counts as N.
FINER = 4
# Kind of the spread, spreads of N and B, whether behind a filter, factor of the N of the first unit.
ROWS = [
    ("equal", (0, 0), False, 1),
    ("log-normal", (0.01, 0.2), False, 1),
    ("log-normal", (0.05, 0.2), False, 1),
    ("log-normal", (0.05, 0.2), True, 1),
    ("log-normal", (0.3, 0.5), False, 1),
    ("uniform", (0.05, 0.2), False, 1),
    ("uniform", (0.3, 0.3), False, 1),
    ("log-normal", (0.05, 0.2), False, 2),
    ("log-normal", (0.3, 0.2), False, 2),
]


def factors(rng, kind, spread):
    """Factors of the units and of the next one with median 1, and the standard deviation over the mean."""
    if kind == "uniform":
        return 1 + np.sqrt(3) * spread * rng.uniform(-1, 1, UNITS + 1)
    return np.exp(np.sqrt(np.log1p(spread**2)) * rng.standard_normal(UNITS + 1))


def batch(rng, kind, spreads, filtered, outlier):
    """Rates of all units, and the coefficients of the units and the next one."""
    n, b = (factors(rng, kind, spread) for spread in spreads)
    n[0] *= outlier
    rates = []
    for unit in range(UNITS):
        flicker = allan_numpy.flicker(rng, FINER * (SAMPLES + 1)).reshape(-1, FINER).mean(axis=1)
        one = n[unit] * rng.standard_normal(SAMPLES + 1) + B * b[unit] * flicker
        rates.append(0.5 * (one[1:] + one[:-1]) if filtered else one[1:])
    return np.stack(rates, axis=1), n, B * b


def units(batches):
    print(f"{batches} batches of {UNITS} units of {SAMPLES} samples; coverage in percent: batch, next unit, spread")
    names = ",".join(str(unit + 1) for unit in range(UNITS))
    options = ["--rate", "1Hz", "--unit", "none", "--column", names]
    for kind, spreads, filtered, outlier in ROWS:
        rng = np.random.default_rng(31)
        made = [batch(rng, kind, spreads, filtered, outlier) for _ in range(batches)]
        documents = allan_numpy.POOL.map(lambda one: allan_numpy.program("compare", [one[0]], *options), made)
        covered = {name: [] for name in ("N", "B")}
        false, found, shown = 0, 0, {name: [] for name in covered}
        for (_, n, b), document in zip(made, documents):
            tables = document["tables"]
            labels = list(dict.fromkeys(row["label"] for row in tables["units"]))
            named = {labels.index(row["label"]) for row in tables["units"] if row["outlier"] is not None}
            false += bool(named - ({0} if outlier != 1 else set()))
            first = [row for row in tables["units"] if row["label"] == labels[0]]
            found += any(row["outlier"] == "higher" and row["coefficient"] == "N" for row in first)
            for one in tables["batch"]:
                name = one["coefficient"]
                if name not in covered or one["of"] == "without outliers" or one["value"] is None:
                    continue
                truth, next_one, spread = (1, n[-1], spreads[0]) if name == "N" else (B, b[-1], spreads[1])
                shown[name].append(one["units"])
                covered[name].append(
                    [
                        one[f"{key}lower"] <= value <= one[f"{key}upper"]
                        for key, value in (("", truth), ("prediction_", next_one), ("unit_sd_", spread))
                    ]
                )
        line = f"{kind:10} N {100 * spreads[0]:2.0f} % B {100 * spreads[1]:2.0f} %{' filtered' if filtered else ''}"
        line += f"{f' outlier {outlier}' if outlier != 1 else ''}:"
        for name, inside in covered.items():
            if inside:
                line += f" {name} " + " · ".join(f"{100 * share:.1f}" for share in np.mean(inside, axis=0))
                line += f" ({np.mean(shown[name]):.1f} units)"
        print(line, f"false outlier {100 * false / batches:.1f} %, found {100 * found / batches:.1f} %", flush=True)


if __name__ == "__main__":
    allan_numpy.POOL = allan_numpy.ThreadPoolExecutor(allan_numpy.os.cpu_count())
    globals()[sys.argv[1]](int(sys.argv[2]) if len(sys.argv) > 2 else 300)
