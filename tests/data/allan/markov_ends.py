"""Intervals of Markov noise by test inversion, from dense matrices, for crates/records/src/fit/times.rs. Needs NumPy and SciPy.

The record has 512 samples of 2 s of white noise with N = 1 and Markov noise. The covariance of two overlapping Allan variances is
2 tr(A C B C), where A and B are their quadratic forms in the rates and C is the covariance of the rates.
"""

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import brentq, nnls
from scipy.stats import norm

SAMPLES, STEP_S = 512, 2.0
FACTORS = [2**octave for octave in range(7)]


def form(m):
    """The matrix whose quadratic form in the rates is the Allan variance."""
    rows = SAMPLES - 2 * m + 1
    differences = np.zeros((rows, SAMPLES))
    for k in range(rows):
        differences[k, k : k + m] = -1 / m
        differences[k, k + m : k + 2 * m] = 1 / m
    return differences.T @ differences / (2 * rows)


FORMS = [form(m) for m in FACTORS]
WHITE = np.eye(SAMPLES) / STEP_S


def markov(time):
    return toeplitz(np.exp(-STEP_S * np.arange(SAMPLES) / time))


def column(covariance):
    return np.array([np.sum(a * covariance) for a in FORMS])


def covariance(squares, time):
    c = squares[0] * WHITE + squares[1] * markov(time)
    products = [a @ c for a in FORMS]
    return np.array([[2 * np.sum(a * b.T) for b in products] for a in products])


def beside(variances, found, time):
    """Squares that fit best if T is `time`, and the covariance of the squares and ln T there."""
    # The square of Markov noise that a fit keeps is its variance.
    whitener = np.linalg.inv(np.linalg.cholesky(covariance(found, time)))
    columns = np.stack([column(WHITE), column(markov(time))], axis=1)
    squares, _ = nnls(whitener @ columns, whitener @ variances)
    step = 1e-4
    slope = squares[1] * (column(markov(time * np.exp(step))) - column(markov(time * np.exp(-step)))) / (2 * step)
    jacobian = np.column_stack([columns, slope])
    weighted = jacobian.T @ np.linalg.inv(covariance(squares, time))
    inverse = np.linalg.inv(weighted @ jacobian)
    return squares, inverse, inverse @ weighted


def interval(found, time):
    """Interval of the variance of Markov noise from the fit at this T, which it takes as the outcome at both quantiles."""
    row = beside(found[0] * column(WHITE) + found[1] * column(markov(time)), found, time)[2][1]
    # The scatter of Markov noise alone is that of a χ² of 2/v₂ degrees of freedom.
    v2 = row @ covariance([0, 1], time) @ row

    def beyond(square, sigmas):
        deviation = np.sqrt(row @ covariance([found[0], square], time) @ row)
        skewness = min(2 * v2**2 * (square / deviation) ** 3, np.sqrt(2))
        return square + deviation * (sigmas + (sigmas**2 - 1) / 6 * skewness) - found[1]

    z = norm.ppf(0.975)
    return brentq(beyond, 1e-6, found[1], args=(z,)), brentq(beyond, found[1], 10 * found[1], args=(-z,))


for sigma, time in ((1.0, 8.0), (1.0, 14.0), (2.0, 10.0)):
    found = [1.0, sigma**2]
    variances = found[0] * column(WHITE) + found[1] * column(markov(time))

    def error(at):
        return np.sqrt(beside(variances, found, at)[1][2, 2])

    def beyond(distance, sign):
        return norm.ppf(0.975) * error(time * np.exp(sign * distance)) - distance

    low, high = (time * np.exp(sign * brentq(beyond, 0, 1.5, args=(sign,), xtol=1e-6)) for sign in (-1, 1))
    plain = np.exp(norm.ppf(0.975) * error(time))
    ends = []
    for own, at, sign in zip(interval(found, time), (low, high), (-1, 1)):
        squares, inverse, _ = beside(variances, found, at)
        known = np.sqrt(inverse[1, 1] - inverse[1, 2] ** 2 / inverse[2, 2]) / squares[1]
        free = np.sqrt(beside(variances, found, time)[1][1, 1]) / found[1]
        distance = np.hypot(np.log(own / found[1]) * known / free, np.log(squares[1] / found[1]))
        ends.append(sigma * np.exp(sign * distance / 2))
    print(f"({sigma}, {time}, [{ends[0]:.4f}, {ends[1]:.4f}], [{low:.4f}, {high:.4f}]), beside {time / plain:.4f} and {time * plain:.4f} by the error at {time}")
