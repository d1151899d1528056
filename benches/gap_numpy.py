"""The gap fill with NumPy: what a user who knows it well would write instead, for figures side by side.

    python3 benches/gap_numpy.py [mv] [tones] [profile]

Million trials a second on one thread, float32, the best of several runs, with the rms errors in arcseconds: as drawn, and
in brackets as they must be. Each trial is one gap of n = 3 ticks of 5 ms with noise of 1.6/3 arcsec on every tick.

mv       minimum-variance filler for a tone of 20 Hz, 12000 arcsec/s, uniform phase: residual from the ticks
         -7 ... 0, 4, 5 and extrapolation from -7 ... 0
tones    eight tones of independent uniform phases; constant, linear and quadratic, residual from -1, 0, 4, 5 and
         extrapolation from -3 ... 0
profile  studies/data/base_vibration.csv from random ticks on; the same six estimates

An error is linear in sines, cosines and noises: all that does not change from trial to trial is folded into one matrix, and
a trial is a column of it. Sums, squares and the largest error of each estimate are kept; there is no histogram. Chunks stay
in the cache; of several lengths the fastest counts.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import sys
import time
from pathlib import Path

import numpy as np

TICK, GAP_TICKS, SIGMA = 5e-3, 3, 1.6 / 3
GAP = np.arange(1, GAP_TICKS + 1)
TONE = [(20.0, 12000.0)]
TONES = [(hz, 12000.0 / np.sqrt(8)) for hz in (7.0, 11.0, 19.3, 23.0, 31.0, 37.0, 41.0, 53.0)]
RECORD = Path(__file__).parent.parent / "studies" / "data" / "base_vibration.csv"
SEED, TRIALS, REPEATS = 1, 1 << 20, 7
CHUNKS = (1024, 2048, 4096, 8192, 16384)


def tick_amplitude(hz, rate):
    return rate * TICK * np.sinc(hz * TICK)


def polynomial(ticks, order):
    """Weights on `ticks` that give the sum over the gap of the polynomial fitted to them."""
    powers = np.vander(np.array(ticks, float), order + 1, increasing=True)
    return np.vander(GAP.astype(float), order + 1, increasing=True).sum(0) @ np.linalg.pinv(powers)


def minimum_variance(ticks, tones):
    """Weights on `ticks` of the least error for `tones` of random phase and the noise, with a sum of n."""
    def covariance(a, b):
        lag = np.subtract.outer(a, b)
        waves = (tick_amplitude(hz, rate) ** 2 / 2 * np.cos(2 * np.pi * hz * TICK * lag) for hz, rate in tones)
        return sum(waves)

    ticks = np.array(ticks)
    count = ticks.size
    system = np.ones((count + 1, count + 1))
    system[:count, :count] = covariance(ticks, ticks) + SIGMA**2 * np.eye(count)
    system[count, count] = 0
    return np.linalg.solve(system, np.append(covariance(ticks, GAP).sum(1), GAP_TICKS))[:count]


def on_window(window, estimates):
    """One row an estimate: its weight on each tick of the window, and -1 on those of the gap."""
    rows = np.zeros((len(estimates), window.size))
    for row, (ticks, weights) in zip(rows, estimates):
        row[np.searchsorted(window, ticks)] = weights
        row[np.searchsorted(window, GAP)] = -1
    return rows


def polynomial_estimates():
    residual, before = [-1, 0, GAP_TICKS + 1, GAP_TICKS + 2], [-3, -2, -1, 0]
    return [(ticks, polynomial(ticks, order)) for order in range(3) for ticks in (residual, before)]


def noise_rows(window, weights):
    """The columns that noise falls on: every tick that is read."""
    return SIGMA * weights[:, ~np.isin(window, GAP)]


def tone_rows(window, weights, tones):
    """For each tone the factors of the sine and of the cosine of its phase at the middle of tick 0."""
    columns = []
    for hz, rate in tones:
        phase = 2 * np.pi * hz * TICK * window
        columns += [tick_amplitude(hz, rate) * (weights @ wave) for wave in (np.cos(phase), np.sin(phase))]
    return np.stack(columns, 1)


def record_ticks():
    """The angle of each tick of the record, its rate taken as straight lines between samples."""
    with open(RECORD) as file:
        rows = [line.split(",") for line in file if line[0] not in "#t"]
    times, rates = np.array(rows, float).T
    step, rates = (times[-1] - times[0]) / (times.size - 1), rates * 3600
    turned = np.append(0, np.cumsum(0.5 * step * (rates[1:] + rates[:-1])))
    at = np.arange(int((times.size - 1) * step / TICK) + 1) * TICK / step
    i = np.minimum(at.astype(int), times.size - 2)
    part = at - i
    return np.diff(turned[i] + step * part * (rates[i] + 0.5 * part * (rates[i + 1] - rates[i])))


class Tally:
    def __init__(self, estimates):
        self.count, self.sum, self.square, self.largest = 0, *np.zeros((3, estimates))

    def add(self, errors):
        self.count += errors.shape[1]
        self.sum += errors.sum(1)
        self.square += [np.dot(row, row) for row in errors]
        np.maximum(self.largest, np.maximum(errors.max(1), -errors.min(1)), out=self.largest)


def tone_trials(window, estimates, tones):
    """Draws chunks of trials with tones; the rms that they must have."""
    weights = on_window(window, estimates)
    matrix = np.hstack([tone_rows(window, weights, tones), noise_rows(window, weights)])
    waves = 2 * len(tones)
    exact = np.sqrt((matrix[:, :waves] ** 2).sum(1) / 2 + (matrix[:, waves:] ** 2).sum(1))
    matrix = np.ascontiguousarray(matrix, np.float32)

    def prepare(generator, size):
        phases = np.empty((len(tones), size), np.float32)
        draws = np.empty((matrix.shape[1], size), np.float32)
        errors = np.empty((len(estimates), size), np.float32)

        def chunk():
            generator.random(out=phases, dtype=np.float32)
            np.multiply(phases, np.float32(2 * np.pi), out=phases)
            np.sin(phases, out=draws[0:waves:2])
            np.cos(phases, out=draws[1:waves:2])
            generator.standard_normal(out=draws[waves:], dtype=np.float32)
            return np.matmul(matrix, draws, out=errors)

        return chunk

    return prepare, exact


def profile_trials(window, estimates):
    """The same for the record: what its motion does to each estimate is one table over all places to start."""
    weights = on_window(window, estimates)
    ticks = record_ticks()
    motion = weights @ np.lib.stride_tricks.sliding_window_view(ticks, window.size).T
    matrix = noise_rows(window, weights)
    exact = np.sqrt((motion**2).mean(1) + (matrix**2).sum(1))
    motion, matrix = (np.ascontiguousarray(x, np.float32) for x in (motion, matrix))

    def prepare(generator, size):
        draws = np.empty((matrix.shape[1], size), np.float32)
        errors = np.empty((len(estimates), size), np.float32)
        moved = np.empty_like(errors)

        def chunk():
            places = generator.integers(motion.shape[1], size=size, dtype=np.uint32).astype(np.intp)
            # Without a mode the result would go through a buffer.
            np.take(motion, places, axis=1, out=moved, mode="clip")
            generator.standard_normal(out=draws, dtype=np.float32)
            np.matmul(matrix, draws, out=errors)
            return np.add(errors, moved, out=errors)

        return chunk

    return prepare, exact


def measure(prepare, estimates):
    """Trials a second of the fastest chunk length, that length, and the rms of all its trials."""
    best = (0.0, 0, None)
    for size in CHUNKS:
        chunk = prepare(np.random.Generator(np.random.SFC64(SEED)), size)
        tally = Tally(estimates)
        for _ in range(REPEATS):
            started = time.perf_counter()
            for _ in range(TRIALS // size):
                tally.add(chunk())
            rate = TRIALS / (time.perf_counter() - started)
            if rate > best[0]:
                best = (rate, size, tally)
    rate, size, tally = best
    return rate, size, np.sqrt(tally.square / tally.count)


def main(modes):
    wide = np.arange(-7, GAP_TICKS + 3)
    near = np.arange(-3, GAP_TICKS + 3)
    sides = [*range(-7, 1), GAP_TICKS + 1, GAP_TICKS + 2]
    best_linear = [(ticks, minimum_variance(ticks, TONE)) for ticks in (sides, sides[:8])]
    trials = {
        "mv": lambda: tone_trials(wide, best_linear, TONE),
        "tones": lambda: tone_trials(near, polynomial_estimates(), TONES),
        "profile": lambda: profile_trials(near, polynomial_estimates()),
    }
    unknown = [mode for mode in modes if mode not in trials]
    if unknown:
        sys.exit(f"no mode is called {', '.join(unknown)}; there are {', '.join(trials)}")
    for mode in modes or trials:
        prepare, exact = trials[mode]()
        rate, size, rms = measure(prepare, exact.size)
        shown = "  ".join(f"{found:.3f} ({expected:.3f})" for found, expected in zip(rms, exact))
        print(f"{mode}: {rate / 1e6:.3g} million trials/s, chunks of {size}\n    rms {shown}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
