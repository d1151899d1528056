"""Intervals of a correlation time by test inversion, from dense matrices, for crates/records/src/fit/times.rs. Needs NumPy and SciPy.

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


def error(variances, found, time):
    """Standard error of ln T if it were `time`, with the squares that fit best then."""
    # The square of Markov noise that a fit keeps is its variance.
    whitener = np.linalg.inv(np.linalg.cholesky(covariance(found, time)))
    columns = np.stack([column(WHITE), column(markov(time))], axis=1)
    squares, _ = nnls(whitener @ columns, whitener @ variances)
    step = 1e-4
    slope = squares[1] * (column(markov(time * np.exp(step))) - column(markov(time * np.exp(-step)))) / (2 * step)
    jacobian = np.column_stack([columns, slope])
    return np.sqrt(np.linalg.inv(jacobian.T @ np.linalg.solve(covariance(squares, time), jacobian))[2, 2])


for sigma, time in ((1.0, 8.0), (1.0, 14.0), (2.0, 10.0)):
    found = [1.0, sigma**2]
    variances = found[0] * column(WHITE) + found[1] * column(markov(time))

    def beyond(distance, sign):
        return norm.ppf(0.975) * error(variances, found, time * np.exp(sign * distance)) - distance

    low, high = (time * np.exp(sign * brentq(beyond, 0, 1.5, args=(sign,))) for sign in (-1, 1))
    plain = np.exp(norm.ppf(0.975) * error(variances, found, time))
    print(f"({sigma}, {time}, [{low:.4f}, {high:.4f}]), beside {time / plain:.4f} and {time * plain:.4f} by the error at {time}")
