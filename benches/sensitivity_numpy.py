"""Sobol' indices of studies/what_decides.toml by SALib, from closed forms in NumPy, beside those of `sagnac sensitivity`.

    sagnac sensitivity studies/what_decides.toml --by theory_rms --out out
    pip install numpy scipy SALib
    python benches/sensitivity_numpy.py out/sensitivity.json

Distributions, weights of the filler and the rms error are written here anew; nothing of sagnac is used but its result. Prints both
indices of each input with their 95 % intervals, and ends with 1 where two intervals do not overlap.
"""

import json
import sys

import numpy as np
from SALib.analyze import sobol as analyze
from SALib.sample import sobol as sample
from scipy.special import j0
from scipy.stats import norm

TICK, GAP = 0.005, 3
TICKS = np.array([-1, 0, GAP + 1, GAP + 2])
LOST = np.arange(1, GAP + 1)


def normal(u, middle, below, above):
    z = norm.ppf(u)
    return middle + z * np.where(z < 0, below, above)


INPUTS = {
    "gyro.tick_noise.std": lambda u: normal(u, 0.5, 0.05, 0.05),
    "gyro.readout_lsb": lambda u: 0.05 * (1.2 / 0.05) ** u,
    "motion.amplitude": lambda u: normal(u, 6000.0, 1000.0 / norm.ppf(0.975), 2000.0 / norm.ppf(0.975)),
    "motion.frequency": lambda u: 6.0 + 4.0 * u,
    "motion.gaussian.rms": lambda u: 2.0 + 58.0 * u,
    "motion.acceleration": lambda u: 7200.0 * u,
}


def weights():
    """Weights of the quadratic: the integral over the gap of the parabola through the ticks, by least squares."""
    powers = np.arange(3)
    fit = np.linalg.pinv(TICKS[:, None].astype(float) ** powers)
    return (LOST[:, None].astype(float) ** powers).sum(0) @ fit


W = weights()
ALL = np.concatenate([TICKS, LOST])
SIGNED = np.concatenate([W, -np.ones(GAP)])
MIDDLE = (GAP + 1) / 2


def swing(nu, ticks, factors):
    """Amplitude, per rate, of the sum of ticks with these factors, for a sine of the rate."""
    phase = 2j * np.pi * np.multiply.outer(nu * TICK, np.asarray(ticks, float) - MIDDLE)
    return TICK * np.sinc(nu * TICK) * np.abs(np.exp(phase) @ factors)


def in_band(ticks, factors):
    """Variance of the same sum, for Gaussian motion of unit rms with equal power from 1 to 60 Hz."""
    nu = np.linspace(1.0, 60.0, 20_001)
    return np.trapezoid(swing(nu, ticks, factors) ** 2, nu) / 59.0


def fractions(sigma, q, amplitude, nu, rms, acceleration):
    """Variance that whole pulses add: the fractions of a pulse at the boundaries that the filler does not cancel."""
    weight = dict(zip(TICKS.tolist(), W))
    boundaries = []
    for b in [-2, -1, 0, GAP, GAP + 1, GAP + 2]:
        own = weight.get(b, 0.0) if b != GAP else 0.0
        after = weight.get(b + 1, 0.0) if b != 0 else 0.0
        boundaries.append((b, after - own))
    total = 0.0
    for i, (start, g) in enumerate(boundaries):
        total = total + g * g * q * q / 12
        for end, h in boundaries[i + 1 :]:
            spanned = np.arange(start + 1, end + 1)
            ones = np.ones(len(spanned))
            constant = acceleration * TICK**2 * (spanned - MIDDLE).sum()
            spread = len(spanned) * sigma**2 + rms**2 * in_band(spanned, ones)
            size = amplitude * swing(nu, spanned, ones)
            covariance = 0.0
            for m in range(1, 400):
                k = 2 * np.pi * m / q
                covariance = covariance + np.exp(-0.5 * k * k * spread) * j0(k * size) * np.cos(k * constant) / m**2
            total = total + 2 * g * h * covariance * q * q / (2 * np.pi**2)
    return total


def rms_error(values):
    sigma, q, amplitude, nu, rms, acceleration = values.T
    mean = acceleration * TICK**2 * (SIGNED * (ALL - MIDDLE)).sum()
    motion = mean**2 + 0.5 * (amplitude * swing(nu, ALL, SIGNED)) ** 2 + rms**2 * in_band(ALL, SIGNED)
    return np.sqrt(motion + sigma**2 * (W @ W) + fractions(sigma, q, amplitude, nu, rms, acceleration))


def main():
    problem = {"num_vars": len(INPUTS), "names": list(INPUTS), "bounds": [[0.0, 1.0]] * len(INPUTS)}
    cube = sample.sample(problem, 8192, calc_second_order=False, seed=7)
    values = np.stack([f(np.clip(u, 1e-9, 1 - 1e-9)) for f, u in zip(INPUTS.values(), cube.T)], axis=1)
    answers = rms_error(values)
    found = analyze.analyze(problem, answers, calc_second_order=False, num_resamples=400, seed=7)
    ours = json.load(open(sys.argv[1]))
    by_name = {row["input"]: row for row in ours["inputs"]}
    apart = 0
    print(f"mean {answers.mean():.5f} and {ours['mean']['value']:.5f}, sd {answers.std():.5f} and {ours['sd']['value']:.5f}")
    for place, name in enumerate(INPUTS):
        for order, key in [("S1", "first"), ("ST", "total")]:
            value, half = found[order][place], found[order + "_conf"][place]
            own = by_name[name][key]
            overlap = own["lo"] <= value + half and value - half <= own["hi"]
            apart += not overlap
            print(
                f"{name:22} {key:5} SALib {value:8.4f} ± {half:.4f}   sagnac {own['value']:8.4f}"
                f" ({own['lo']:.4f} to {own['hi']:.4f}) {'' if overlap else ' APART'}"
            )
    sys.exit(apart > 0)


if __name__ == "__main__":
    main()
