"""How long `sagnac.allan` takes beside allantools: the overlapping Allan deviation at the octaves of τ, in one run.

    pip install allantools
    python benchmarks/beside_allantools.py [SAMPLES]

Both are given the same array of rates; the best of three is taken of each. sagnac also identifies the noise at every τ, gives
intervals and looks for gaps and outliers; allantools is asked for its plain errors.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import allantools
import numpy as np

import sagnac


def best(work: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of the fastest of three, and what it returned."""
    seconds, found = [], None
    for _ in range(3):
        started = time.perf_counter()
        found = work()
        seconds.append(time.perf_counter() - started)
    return min(seconds), found


samples = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10_000_000
rates = np.random.default_rng(1).normal(0.0, 1.0, samples)
one, _ = best(lambda: sagnac.allan(rates, 100.0, unit="deg/h", threads=1))
all_threads, ours = best(lambda: sagnac.allan(rates, 100.0, unit="deg/h"))
theirs_s, theirs = best(lambda: allantools.oadev(rates, rate=100.0, data_type="freq", taus="octave"))
curve = ours["oadev"]
shared = min(len(curve.tau), len(theirs[0]))
off = np.max(np.abs(curve.value[:shared] / theirs[1][:shared] - 1.0))
print(f"{samples} samples, {shared} averaging times, values within {off:.1e} of each other")
print(f"sagnac      {all_threads:.2f} s, on one thread {one:.2f} s")
print(f"allantools  {theirs_s:.2f} s, {theirs_s / all_threads:.1f} times as long, {theirs_s / one:.1f} times on one thread")
