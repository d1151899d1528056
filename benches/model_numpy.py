"""Whether the models of `sagnac model` bound a second record, and what a Kalman filter makes of them, by NumPy.

    cargo build --release -p sagnac-cli
    python benches/model_numpy.py records [RECORDS]    # models of first halves against the bands of second ones, and NEES of filters there
    python benches/model_numpy.py logs FOLDER          # both halves of the logs of public_logs.py

Records are white noise, flicker and a random walk by the generator of allan_numpy.py, which is independent of sagnac: the order-1/2 integral of
Kasdin instead of octave holds. `SAGNAC` names the program. Needs NumPy and SciPy. Results are in docs/dev/numerics.md.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import allan_numpy
import documents
import numpy as np
from scipy import stats

# Samples of a half at 1 Hz, and coefficients in deg/h and s: N, B, K. At 3277 s, a tenth of a half, all three show.
HALF = 2**15
WHITE, FLICKER, WALK = 1.0, 0.1, 3e-4
AIMS = ["--overbound", "--overbound=repeat"]
# Columns of a file, which the program takes in one call.
COLUMNS = 20


def record(rng):
    return (
        WHITE * rng.standard_normal(2 * HALF)
        + FLICKER * allan_numpy.flicker(rng, 2 * HALF)
        + WALK * np.cumsum(rng.standard_normal(2 * HALF))
    )


def program(command, records, *options, rate="1Hz", unit="deg/h"):
    """The documents of records, which are columns of some files."""
    found = []
    for first in range(0, len(records), COLUMNS):
        part = records[first : first + COLUMNS]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "log.npy"
            np.save(path, np.stack(part, axis=1))
            call = [allan_numpy.PROGRAM, command, str(path), "--data", "rate", "--unit", unit, "--rate", rate, "--json"]
            call += ["--column", ",".join(str(i + 1) for i in range(len(part)))]
            call += ["--out", str(Path(folder) / "out"), "--unit-check", "off", *options]
            done = subprocess.run(call, capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"{' '.join(call)}\n{done.stderr}")
            found.append(json.loads(done.stdout))
    return found


def bands(records, to, **reading):
    """Averaging times, deviations and upper ends of the bands of records, up to a time."""
    for document in program("allan", records, "--tau", "decade10", "--bootstrap", "0", **reading):
        for column in documents.columns(document):
            points = [point for point in column["curve"] if point["tau_s"] <= to * 1.0001]
            yield tuple(np.array([point[name] for point in points]) for name in ("tau_s", "value", "upper"))


def deviation(found, tau):
    """Allan deviation of a model in deg/h, by the closed forms."""
    n, k = 60 * found["white_deg_per_rt_h"], found["random_walk_deg_per_h_per_rt_h"] / 60
    square = n**2 / tau + k**2 * tau / 3 + 3 * found["quantization_arcsec"] ** 2 / tau**2
    for state in found["markov"]:
        sigma, time = state["sigma_deg_per_h"], state["correlation_time_s"]
        z = tau / time
        square = square + sigma**2 * 2 / z * (1 - (3 - 4 * np.exp(-z) + np.exp(-2 * z)) / (2 * z))
    return np.sqrt(square)


def halves_of(records):
    return [rates[: len(rates) // 2] for rates in records], [rates[len(rates) // 2 :] for rates in records]


def compared(first, second, *options, **reading):
    """For each aim the least ratios of the models of first halves to the bands, and to the deviations, of second ones; and the models."""
    to = len(first[0]) / float(reading.get("rate", "1Hz")[:-2]) / 10
    seen = list(bands(second, to, **reading))
    found = {}
    for aim in AIMS:
        found_all = program("model", first, aim, "--to", f"{to} s", *options, **reading)
        models = [model for document in found_all for model in document["model"]["columns"]]
        curves = [deviation(model, tau) for model, (tau, _, _) in zip(models, seen)]
        of = [[np.min(curve / upper), np.min(curve / value)] for curve, (_, value, upper) in zip(curves, seen)]
        found[aim] = np.array(of), models
    return found


def records(count):
    rng = np.random.default_rng(26)
    first, second = halves_of([record(rng) for _ in range(count)])
    found = compared(first, second)
    print(f"{count} records of white {WHITE}, flicker {FLICKER}, walk {WALK}, halves of {HALF} s, tau from 1 s to {HALF // 10} s")
    for aim, (ratios, models) in found.items():
        states = np.bincount([len(model["markov"]) for model in models], minlength=4)
        excess = np.median([model["largest_excess"] for model in models])
        above = [f"{100 * np.mean(ratios[:, i] >= 1):.1f} %" for i in (0, 1)]
        print(
            f"{aim:15} nowhere below the band of the second half: {above[0]}, below its deviation: {above[1]}; least ratio to the band"
            f" {ratios[:, 0].min():.2f}, median {np.median(ratios[:, 0]):.2f}; states 0..3: {states}; median of largest excess {excess:.2f}"
        )
    consistency(first, second, found)


def system(model):
    """Transition, added noise and initial variance of the angle in deg and rates in deg/h, from the document."""
    discrete = model["discrete"]
    size = np.degrees(3600.0)  # rad to arcsec
    # The states are rad and rad/s; arcsec and arcsec/s = deg/h keep numbers near 1.
    return np.array(discrete["F"]), np.array(discrete["Q"]) * size**2, np.array(discrete["initial_variance"]) * size**2


def plain(column):
    """N and K of the fit alone, as tools take them: B is left out, and K that is not identified is 0."""
    values = {row["coefficient"]: row["value"] or 0.0 for row in column["coefficients"]}
    n, k = 60 * values["N"], values["K"] / 60
    transition = np.array([[1.0, 1.0], [0.0, 1.0]])
    added = np.array([[n**2 + k**2 / 3, k**2 / 2], [k**2 / 2, k**2]])
    return transition, added, np.array([0.0, k**2 * HALF / 10])


# The filter: the angle is fixed every minute for an hour, to FIX arcsec, and then runs free for as long as COAST.
FIX_EVERY, FIXES, FIX, COAST = 60, 60, 10.0, 3276
TURN_ON = 10.0  # deg/h, of the constant part of the rate, which starts unknown


def nees(records, systems):
    """Normalized squared errors of the angle, of all records at once: the mean over the fixes, and that at the end of the free run."""
    count, size = len(records), 1 + max(len(initial) for _, _, initial in systems)
    f, q, p = (np.zeros((count, size, size)) for _ in range(3))
    for k, (transition, added, initial) in enumerate(systems):
        states = len(initial)
        f[k, :states, :states], q[k, :states, :states] = transition, added
        p[k, :states, :states] = np.diag(initial)
        # The last state is a constant bias beside the model, with which the filter starts.
        f[k, -1, -1] = f[k, 0, -1] = 1.0
        p[k, -1, -1] = TURN_ON**2
    rng = np.random.default_rng(28)
    rates = np.stack(records) + TURN_ON * rng.standard_normal((count, 1))
    x, truth, squares = np.zeros((count, size)), np.zeros(count), []
    for step in range(1, FIX_EVERY * FIXES + COAST + 1):
        truth = truth + rates[:, step - 1]  # arcsec in a second
        x, p = np.einsum("kij,kj->ki", f, x), f @ p @ f.transpose(0, 2, 1) + q
        if step % FIX_EVERY == 0 and step <= FIX_EVERY * FIXES:
            variance = p[:, 0, 0] + FIX**2
            gain = p[:, :, 0] / variance[:, None]
            innovation = truth + FIX * rng.standard_normal(count) - x[:, 0]
            squares.append(innovation**2 / variance)
            x, p = x + gain * innovation[:, None], p - gain[:, :, None] * p[:, None, 0, :]
    return np.mean(squares, axis=0), (truth - x[:, 0]) ** 2 / p[:, 0, 0]


def consistency(first, second, found):
    """NEES of filters with the models of the first halves on the second halves, beside those with N and K of the fit alone."""
    fits = [fit for document in program("allan", first, "--bootstrap", "0", "--fit", "N,B,K") for fit in documents.columns(document)]
    systems = {"N and K of the fit": [plain(column) for column in fits]}
    systems |= {aim: [system(model) for model in models] for aim, (_, models) in found.items()}
    in_mean, at_end = stats.chi2.ppf(0.975, FIXES) / FIXES, stats.chi2.ppf(0.95, 1)
    print(f"within or below the 95 % region: mean of {FIXES} innovations below {in_mean:.2f}, end of a free run of {COAST} s below {at_end:.2f}")
    for name, each in systems.items():
        innovations, end = nees(second, each)
        print(
            f"{name:20} innovations {100 * np.mean(innovations <= in_mean):.1f} % of runs, mean {innovations.mean():.2f};"
            f" end {100 * np.mean(end <= at_end):.1f} % of runs, mean {end.mean():.2f}"
        )


def logs(folder):
    known = [(f"adis16405_{k}.npz", "deg/s", "100Hz") for k in range(1, 7)] + [("mtig.npz", "rad/s", "100Hz")]
    for name, unit, rate in known:
        arrays = np.load(Path(folder) / name)
        axes = [axis for axis in ("gx", "gy", "gz") if axis in arrays]
        first, second = halves_of([arrays[axis].astype(float) for axis in axes])
        found = compared(first, second, unit=unit, rate=rate)
        for k, axis in enumerate(axes):
            said = [f"{aim} {ratios[k, 0]:.2f} of the band, {ratios[k, 1]:.2f} of the deviation" for aim, (ratios, _) in found.items()]
            print(f"{name} {axis}: least ratios {'; '.join(said)}", flush=True)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["records", *count]:
            records(int(count[0]) if count else 200)
        case ["logs", folder]:
            logs(folder)
        case _:
            sys.exit(__doc__)
