"""Fillers for a specification with NumPy: the design and the residual by brute force, to check the program against.

    python3 benches/filler_numpy.py > tests/data/gap_specification.csv

The specification: Gaussian motion in bands, each end within a tolerance, and lines, each frequency within another. A filler
reads ticks on either side of a gap of n ticks. Its weights are those of the least variance, with a sum of n, for each part
spread evenly over all its frequencies within the tolerance, and for white noise. Its residual is integrated over the spectrum
by the midpoint rule, for every frequency of a line and every pair of ends of a band on a fine grid; the largest counts. The
99.73 % level is that of the line with the largest residual as a sine and all else as normally distributed, from the mean over
phases and bisection.

Nothing is shared with the program: it forms no covariance but factors rows of lines, and tries few deviations.
"""

import math

import numpy as np

TICK = 2e-3
STEPS = 40_000
DEVIATIONS = 201
ENDS = 11
PHASES = 20_001

# Name, lost ticks, ticks before and after, noise in arcsec, bands (low, high, rms in arcsec/s, tolerance) and lines
# (frequency, amplitude, tolerance, whether the amplitude is that of the angle in arcsec and not of the rate in arcsec/s).
PROBLEM = ([(30.0, 80.0, 1000.0, 0.05)], [(345.0, 90.0, 1e-3, True)])
CASES = [
    ("problem", 3, 20, 2, 0.2, *PROBLEM),
    ("problem", 3, 12, 6, 0.2, *PROBLEM),
    ("problem", 3, 16, 8, 0.2, *PROBLEM),
    ("problem", 3, 24, 8, 0.2, *PROBLEM),
    ("several", 2, 16, 8, 0.2, [(5.0, 20.0, 3000.0, 0.1), (60.0, 90.0, 500.0, 0.02)],
     [(345.0, 2e5, 1e-3, False), (140.0, 5e3, 0.01, False)]),
    ("exact", 3, 8, 4, 0.2, [(30.0, 40.0, 1000.0, 0.0)], [(120.0, 4e3, 0.0, False)]),
]


def spread(low, high, steps=STEPS):
    """Midpoints of a band, as one frequency where it has no width."""
    if low == high:
        return np.array([low])
    return low + (high - low) * (np.arange(steps) + 0.5) / steps


def tick_angle(hz):
    """Angle of a tick at the peak of the rate, per rate."""
    return TICK * np.sinc(hz * TICK)


def rate(hz, of_angle):
    """Amplitude of the rate per amplitude of a line."""
    return 2 * np.pi * hz if of_angle else np.ones_like(hz)


def transfer(hz, ticks, weights, n):
    """The residual per rate at frequencies: the filled angle less that of the gap, as complex amplitudes."""
    def waves(k):
        return np.exp(2j * np.pi * TICK * np.outer(hz, k))
    return tick_angle(hz) * (waves(ticks) @ weights - waves(np.arange(1, n + 1)).sum(1))


def covariance(low, high, of_angle, lags):
    """Covariance of ticks of a motion of rms 1 over a band, by lag."""
    hz = spread(low, high)
    squares = (rate(hz, of_angle) * tick_angle(hz)) ** 2
    return np.array([np.mean(squares * np.cos(2 * np.pi * hz * TICK * lag)) for lag in range(lags)])


def design(ticks, n, noise, parts):
    """The weights of least variance with a sum of n, in long doubles from the covariance."""
    both = np.concatenate([ticks, np.arange(1, n + 1)])
    lags = np.abs(np.subtract.outer(both, both))
    by_lag = sum(rms**2 * covariance(low, high, of_angle, lags.max() + 1) for low, high, rms, of_angle in parts)
    count = len(ticks)
    matrix = by_lag[lags]
    system = np.ones((count + 1, count + 1))
    system[:count, :count] = matrix[:count, :count] + noise**2 * np.eye(count)
    system[count, count] = 0
    right = np.append(matrix[:count, count:].sum(1), n)
    weights = np.linalg.solve(system, right)
    # A step of refinement, as motion is far above the noise.
    weights += np.linalg.solve(system, (right.astype(np.longdouble) - system.astype(np.longdouble) @ weights).astype(float))
    return weights[:count]


def level(sine, sigma):
    """The 99.73 % level of |a sin θ + σ z|, where `sine` is a²/2."""
    amplitude = math.sqrt(2 * sine)
    sines = amplitude * np.sin(np.pi / 2 * (np.arange(PHASES) + 0.5) / PHASES)
    erf = np.vectorize(math.erf)
    low, high = 0.0, amplitude + 10 * sigma
    for _ in range(40):
        middle = 0.5 * (low + high)
        scale = math.sqrt(2) * sigma
        inside = np.mean(0.5 * (erf((middle - sines) / scale) + erf((middle + sines) / scale)))
        low, high = (middle, high) if inside < 0.9973 else (low, middle)
    return high


def size(noise, of_bands, of_lines):
    total = noise + sum(of_bands) + sum(of_lines)
    sine = max(of_lines, default=0.0)
    return math.sqrt(total), level(sine, math.sqrt(total - sine))


def judge(n, before, after, noise, bands, lines):
    ticks = np.concatenate([np.arange(1 - before, 1), np.arange(n + 1, n + after + 1)])
    parts = [(low * (1 - off), high * (1 + off), rms, False) for low, high, rms, off in bands]
    parts += [(hz * (1 - off), hz * (1 + off), peak / math.sqrt(2), of_angle) for hz, peak, off, of_angle in lines]
    weights = design(ticks, n, noise, parts)

    def of_band(low, high, rms):
        return rms**2 * np.mean(np.abs(transfer(spread(low, high, 2000), ticks, weights, n)) ** 2)

    def of_line(hz, peak, of_angle):
        hz = np.atleast_1d(hz)
        return peak**2 / 2 * np.abs(rate(hz, of_angle) * transfer(hz, ticks, weights, n)) ** 2

    grid = np.linspace(-1, 1, ENDS)
    worst_bands = [max(of_band(low * (1 + a * off), high * (1 + b * off), rms) for a in grid for b in grid)
                   for low, high, rms, off in bands]
    deviations = np.linspace(-1, 1, DEVIATIONS)
    worst_lines = [of_line(hz * (1 + off * deviations), peak, of_angle).max() for hz, peak, off, of_angle in lines]
    of_noise = noise**2 * np.sum(weights**2)
    own = size(of_noise, [of_band(low, high, rms) for low, high, rms, _ in bands],
               [of_line(hz, peak, of_angle)[0] for hz, peak, _, of_angle in lines])
    return own, size(of_noise, worst_bands, worst_lines)


if __name__ == "__main__":
    print("case,gap_ticks,before,after,own_rms,own_level,rms,level")
    for name, n, before, after, noise, bands, lines in CASES:
        own, worst = judge(n, before, after, noise, bands, lines)
        numbers = ",".join(f"{value:.9g}" for value in own + worst)
        print(f"{name},{n},{before},{after},{numbers}", flush=True)
