"""Angle random walk of a dithered gyro from lock-in in Numba, for the speed and as an independent check.

    python benches/lock_in_numba.py speed [SECONDS]    # steps per second and core, and the N that they give
    python benches/lock_in_numba.py walk               # N at three input rates beside the closed form
    python benches/lock_in_numba.py beat               # mean rate without dither beside the closed form
    python benches/lock_in_numba.py zones              # edges of dynamic zones beside Bessel functions

Needs NumPy, SciPy and Numba. Everything is f64: the dither turns the beat phase by the exact increments of its angle, and the lock-in term
acts in the middle of each step (symmetric splitting, second order). The dither's amplitude is drawn for each
half-cycle between zero crossings of its angle, as `kind = "lock-in"` does. Trials run on all
cores; `speed` counts the time of all threads, so that other load on the machine matters little.
"""

import os
import sys
import time

import numpy as np
from numba import njit, prange
from scipy import optimize, special

TAU = 2 * np.pi
# ″/s, ″ per pulse, Hz, ″/s and σ_A/A: the gyro of docs/dev/equations.md.
THRESHOLD, SCALE, FREQUENCY, DITHER, NOISE = 180.0, 2.0, 400.0, 360_000.0, 0.02


@njit(parallel=True, fastmath=True)
def angles(seed, trials, half_cycles, every, turned, theta, noise, drift, kick):
    """The beat phases in rad that lock-in adds, read after each `every` half-cycles; those of the input and the dither are left out.

    `turned` has the dither's angle, as parts of its amplitude, from the middle of each step to that of the next, with half steps at the ends.
    """
    steps = len(turned) - 1
    read = np.zeros((trials, half_cycles // every))
    for trial in prange(trials):
        np.random.seed(seed + trial)
        psi = TAU * np.random.random()
        added = 0.0
        sign = 1.0
        for half in range(half_cycles):
            amplitude = sign * theta * (1 + noise * np.random.standard_normal())
            psi += 0.5 * drift + amplitude * turned[0]
            for step in range(steps):
                jump = kick * np.sin(psi)
                added += jump
                psi += jump + drift + amplitude * turned[step + 1]
            # The last step is a half one. A small phase keeps the sine quick.
            psi = (psi - 0.5 * drift) % TAU
            sign = -sign
            if (half + 1) % every == 0:
                read[trial, (half + 1) // every - 1] = added
    return read


def simulate(rate, periods, trials=64, every=50, steps=500, threshold=THRESHOLD, dither=DITHER, noise=NOISE, seed=1):
    """Angles in ″, read every `every` dither periods, with `steps` steps in half a period, and the time between them in s."""
    factor = TAU / SCALE
    h = 0.5 / FREQUENCY / steps
    edges = np.concatenate([[0], np.arange(steps) + 0.5, [steps]])
    turned = np.diff(np.sin(np.pi * edges / steps))
    theta = dither / (FREQUENCY * SCALE)
    read = angles(seed, trials, 2 * periods, 2 * every, turned, theta, noise, factor * rate * h, factor * threshold * h)
    return read / factor, every / FREQUENCY


def walk(read, time_s):
    """N in ″/√s from the variance of increments, with its standard error."""
    increments = np.diff(read, axis=1, prepend=0.0)
    found = increments.std(ddof=1) / np.sqrt(time_s)
    return found, found / np.sqrt(2 * increments.size)


def closed(threshold=THRESHOLD, dither=DITHER):
    return threshold * np.sqrt(SCALE / (TAU * dither))


def speed(seconds=4.0):
    simulate(37.0, 50)
    periods, steps, cores = int(50 * max(1, round(seconds * 8))), 500, len(os.sched_getaffinity(0))
    wall, used = time.perf_counter(), time.process_time()
    read, time_s = simulate(37.0, periods, steps=steps)
    wall, used = time.perf_counter() - wall, time.process_time() - used
    done = len(read) * periods * 2 * steps
    found, error = walk(read, time_s)
    print(f"{done / used / 1e6:.1f} M steps/s per core, {done / wall / 1e6:.1f} M steps/s on {cores} cores")
    print(f"N = {found:.4f} ± {error:.4f} arcsec/sqrt(s), closed form {closed():.4f}")


def walks():
    print("rate ″/s     N ″/√s   closed form")
    for rate in (0.0, 37.0, 523.0):
        found, error = walk(*simulate(rate, 4000, every=400, seed=17))
        print(f"{rate:8.0f}  {found:.4f} ± {error:.4f}  {closed():.4f}")


def beat():
    """The mean rate over whole beats, by integration of dt = dψ/ψ̇ over a turn."""
    print("rate ″/s   mean rate ″/s   √(Ω² − Ω_L²)")
    for rate in (181.0, 200.0, 300.0, 1000.0):
        psi = TAU * (np.arange(4096) + 0.5) / 4096
        mean = 1 / np.mean(1 / (rate + THRESHOLD * np.sin(psi)))
        print(f"{rate:8.0f}  {mean:14.6f}  {np.sqrt(rate**2 - THRESHOLD**2):14.6f}")


@njit
def period(psi, steps, theta, drift, kick):
    """The beat phase one dither period later, without noise."""
    before = 0.0
    for step in range(steps):
        middle = np.sin(TAU * (step + 0.5) / steps)
        psi += 0.5 * drift + theta * (middle - before)
        psi += kick * np.sin(psi)
        before = np.sin(TAU * (step + 1) / steps)
        psi += 0.5 * drift + theta * (before - middle)
    return psi


@njit
def turns(rate, periods, steps, theta, threshold, frequency, scale):
    """Mean turns of the beat in a dither period, from the start and end of whole periods after a while."""
    factor = TAU / scale
    h = 1 / frequency / steps
    psi = 0.3
    for _ in range(periods):
        psi = period(psi, steps, theta, factor * rate * h, factor * threshold * h)
    start = psi
    for _ in range(periods):
        psi = period(psi, steps, theta, factor * rate * h, factor * threshold * h)
    return (psi - start) / TAU / periods


def zones(threshold=4.0, periods=4000, steps=200):
    """Edges of zone k by bisection over the input rate, for which the beat gains k turns in each dither period."""
    print("  k     Θ   lower edge  upper edge   Ω_k ∓ Ω_L |J_k(Θ)|")
    for k, theta in ((0, 1.0), (0, 5.0), (1, 1.0), (1, 3.0), (2, 4.0), (3, 5.0), (4, 8.0), (0, 12.0), (5, 20.0), (2, 30.0)):
        centre, half = k * FREQUENCY * SCALE, threshold * abs(special.jv(k, theta))
        side = lambda offset: turns(centre + offset, periods, steps, theta, threshold, FREQUENCY, SCALE) - k
        edges = []
        for sign in (-1, 1):
            inside, outside = 0.0, sign * 2 * half
            while abs(outside - inside) > 1e-3 * half:
                middle = 0.5 * (inside + outside)
                if abs(side(middle)) < 0.5 / periods:
                    inside = middle
                else:
                    outside = middle
            edges.append(centre + inside)
        print(f"{k:3} {theta:5.1f}  {edges[0]:11.4f} {edges[1]:11.4f}   {centre - half:11.4f} {centre + half:11.4f}", flush=True)


if __name__ == "__main__":
    commands = {"speed": speed, "walk": walks, "beat": beat, "zones": zones}
    commands[sys.argv[1]](*[float(text) for text in sys.argv[2:]])
