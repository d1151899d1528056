"""Random gap-fill studies with stationary Gaussian motion: every rms of `sagnac run` beside the right value.

    cargo build --release -p sagnac-cli
    python benches/gaussian_numpy.py [COUNT] [SEED]     COUNT studies (200), the same ones for the same SEED (1)
    python benches/gaussian_numpy.py show INDEX [SEED]  one study, as a file that `sagnac run` takes
    python benches/gaussian_numpy.py check [SEED]       the right values beside simulated ticks, without the program

The motion fills a band, has a density, or is a random vibration through a suspension. Ticks last 1 to 10 ms, gaps 1
to 10 ticks, fillers read 1 to 48 ticks on either side, and the noise of a tick is 1e-5 to 1e-1 of the rms angle of the motion in
it, with and without a readout in whole pulses.

Right values form no covariance of the motion, in whose differences small errors would be lost. The weights are those that `sagnac
filler` gives to firmware; the variance of the error is

    ∫ S(ν) (T sinc νT)² |Σ w e^{iωt} − Σ_gap e^{iωt}|² dν + σ² Σ w² + Σ_b Σ_c g_b g_c C(b − c),   g_b = w_{b+1} − w_b,

C being the covariance of the fractions of a pulse at two boundaries of ticks: q²/2π² Σ_m exp(−2π²m²V/q²)/m² for a turned
angle of variance V between them. Phases and sums are in extended precision where NumPy has it. An in-gap error is compared for
n = 1 alone, where it is the extrapolation error.

The least possible rms is that of constrained least squares by QR on samples of √S. Fillers designed for the motion are compared
with it; all minimum-variance fillers also within the model of their design, where fractions of a pulse are independent.
Needs NumPy. `SAGNAC` names the program, by default that of target/release.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import json
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

LONG = np.longdouble
PI = 4 * np.arctan(LONG(1))
POINTS, WEIGHTS = (x.astype(LONG) for x in np.polynomial.legendre.leggauss(20))
MAX_SIDE = 48
TRIALS = 100_000
BEYOND = 5
SHOWN = 40


@dataclass
class Motion:
    """Gaussian motion: a one-sided density with straight lines in log–log between its points, in (″/s)²/Hz, or in g²/Hz
    through modes (Hz, Q, ″/s/g)."""

    kind: str
    points: list
    modes: list = field(default_factory=list)
    scale: float = 1.0
    text: str = ""

    def spectrum(self, longest_s):
        """Frequencies and the power of the rate at each, (″/s)²; a sum over them integrates what turns no faster than
        2πν·longest_s."""
        frequencies, powers = [], []
        for (low, below), (high, above) in zip(self.points, self.points[1:]):
            slope = np.log(LONG(above) / LONG(below)) / np.log(LONG(high) / LONG(low))
            nu, width = nodes(low, high, longest_s, float(slope), self.modes)
            frequencies.append(nu)
            powers.append(width * LONG(below) * (nu / LONG(low)) ** slope)
        nu, power = np.concatenate(frequencies), np.concatenate(powers) * LONG(self.scale)
        if self.modes:
            power = power * abs(response(self.modes, nu)) ** 2
        return nu, power


@dataclass
class Study:
    tick_s: float
    gap_ticks: int
    sigma: float
    pulse: float
    motion: Motion
    # Ticks that the minimum-variance fillers read, and the band that each is designed for, by name.
    fit_ticks: dict
    bands: dict
    text: str


def response(modes, nu):
    """The rate per acceleration at each frequency, ″/s/g."""
    total = np.zeros(nu.shape, np.clongdouble)
    for natural, q, size in modes:
        ratio = nu / LONG(natural)
        total += LONG(size) / LONG(q) / ((1 - ratio) * (1 + ratio) + 1j * ratio / LONG(q))
    return total


def nodes(low, high, longest_s, slope, modes):
    """Gauss–Legendre points and weights: panels of at most one turn, an octave, a factor of e⁴ in density, and near a
    resonance of about the distance from its pole."""
    parts = int(np.log(high / low) / min(np.log(2), 4 / max(abs(slope), 1e-9))) + 1
    edges = [low, high] + [low * (high / low) ** (part / parts) for part in range(1, parts)]
    for natural, q, _ in modes:
        half = natural / (2 * q)
        edges += [natural] + [natural + sign * half * 2.0**k for sign in (-1, 1) for k in range(-1, 14)]
    edges = np.unique([edge for edge in edges if low <= edge <= high])
    panels = []
    for start, end in zip(edges, edges[1:]):
        panels.append(np.linspace(LONG(start), LONG(end), 2 + int((end - start) * longest_s))[:-1])
    panels = np.append(np.concatenate(panels), LONG(high))
    middle, half = (panels[1:] + panels[:-1]) / 2, np.diff(panels) / 2
    return (middle[:, None] + half[:, None] * POINTS).ravel(), (half[:, None] * WEIGHTS).ravel()


def turned(nu, seconds):
    """The most that a sine of rate 1 turns in a time t, = t sinc νt."""
    return np.sin(PI * nu * seconds) / (PI * nu)


class Ticks:
    """What a unit weight on each tick of a window passes of the motion: rows are cosines and sines of each frequency."""

    def __init__(self, study, motion, reach):
        n, tick_s = study.gap_ticks, LONG(study.tick_s)
        self.first, self.gap_ticks, self.tick_s = -reach, n, tick_s
        self.numbers = np.arange(self.first, n + reach + 1)
        self.nu, self.power = motion.spectrum(study.tick_s * (self.numbers.size + 1))
        size = np.sqrt(self.power) * turned(self.nu, tick_s)
        phase = 2 * PI * tick_s * self.nu[:, None] * (self.numbers - LONG(n + 1) / 2)
        self.waves = np.concatenate([size[:, None] * np.cos(phase), size[:, None] * np.sin(phase)])
        self.gap = self.waves[:, 1 - self.first : n + 1 - self.first].sum(1)

    def columns(self, ticks):
        return self.waves[:, np.asarray(ticks) - self.first]

    def variance(self, ticks, weights):
        return np.sum((self.columns(ticks) @ weights - self.gap) ** 2)

    def tick_variance(self):
        return float(np.sum(self.power * turned(self.nu, self.tick_s) ** 2))


def fraction_covariance(pulse, variance):
    """Covariance of the fractions of a pulse at two boundaries between which the angle turned has that variance, > 0."""
    ratio = 2 * PI**2 * variance / LONG(pulse) ** 2
    m = np.arange(1, 2 + min(int(np.sqrt(50 / ratio)), 1_000_000)).astype(LONG)
    return LONG(pulse) ** 2 / (2 * PI**2) * np.sum(np.exp(-ratio * m**2) / m**2)


def by_lag(study, window):
    """Covariance of fractions of a pulse by the number of ticks between two boundaries; blank without a readout."""
    if not study.pulse:
        return None
    covariance = [LONG(study.pulse) ** 2 / 12]
    for lag in range(1, window.numbers.size + 1):
        motion = np.sum(window.power * turned(window.nu, lag * window.tick_s) ** 2)
        covariance.append(fraction_covariance(study.pulse, motion + lag * LONG(study.sigma) ** 2))
    return np.array(covariance)


def noise_covariance(study, ticks, fractions):
    """Covariance of the errors of the readings: tick noise, and the fractions of a pulse at both ends of each tick."""
    apart = abs(np.subtract.outer(ticks, ticks))
    noise = np.eye(len(ticks), dtype=LONG) * LONG(study.sigma) ** 2
    if fractions is not None:
        noise += 2 * fractions[apart] - fractions[apart + 1] - fractions[abs(apart - 1)]
    return noise


def read_variance(study, ticks, weights, fractions):
    """Variance of the error that noise and readout leave."""
    variance = LONG(study.sigma) ** 2 * np.sum(weights**2)
    if fractions is None:
        return variance
    own = dict(zip(ticks, weights))
    ends = np.array(sorted({b for tick in ticks for b in (tick - 1, tick)}))
    g = np.array([own.get(b + 1, LONG(0)) - own.get(b, LONG(0)) for b in ends])
    return variance + g @ fractions[abs(np.subtract.outer(ends, ends))] @ g


def rms(study, window, ticks, weights, fractions):
    return float(np.sqrt(window.variance(ticks, weights) + read_variance(study, ticks, weights, fractions)))


def least(study, window, ticks, fractions):
    """Weights of the least rms whose sum is n."""
    count, n = len(ticks), study.gap_ticks
    mean = np.full(count, n / count)
    if count > 1:
        root = np.linalg.cholesky(noise_covariance(study, ticks, fractions).astype(float)).T
        rows = np.concatenate([window.columns(ticks).astype(float), root])
        target = np.append(window.gap.astype(float), np.zeros(count)) - rows @ mean
        free = np.linalg.qr(np.ones((count, 1)), mode="complete")[0][:, 1:]
        q, r = np.linalg.qr(rows @ free)
        mean = mean + free @ np.linalg.solve(r, q.T @ target)
    return mean.astype(LONG)


def independent(study, lags):
    """Fractions of a pulse without covariance, as fillers are designed for them."""
    return np.append(LONG(study.pulse) ** 2 / 12, np.zeros(lags, LONG)) if study.pulse else None


class Draw:
    """Random values of one study, from uniform numbers alone, which are the same in every version of NumPy."""

    def __init__(self, seed, index):
        self.uniform = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, index]))).random

    def between(self, low, high):
        return low + (high - low) * self.uniform()

    def log(self, low, high):
        return float(np.exp(self.between(np.log(low), np.log(high))))

    def whole(self, low, high):
        return min(int(self.log(low, high + 1)), high)

    def chance(self, part):
        return self.uniform() < part


def number(value):
    return float(f"{value:.6g}")


def density(draw, count, low, high):
    """Points of a density of any scale."""
    while True:
        frequencies = sorted(number(draw.log(low, high)) for _ in range(count))
        if all(b > 1.02 * a for a, b in zip(frequencies, frequencies[1:])):
            return [(nu, draw.log(1e-3, 1)) for nu in frequencies]


def rows(points, unit):
    return "[" + ", ".join(f'["{nu} Hz", "{value} {unit}"]' for nu, value in points) + "]"


def random_motion(draw, tick_s):
    rate, nyquist = number(draw.log(0.1, 5)), 0.49999 / tick_s
    kind = draw.uniform()
    if kind < 0.4:
        low = draw.log(0.1, 0.99 * nyquist)
        high = min(low * (1 + draw.log(1e-3, 300)), nyquist)
        low, high = float(f"{low:.8g}"), float(f"{high:.8g}")
        value = (rate * 3600) ** 2 / (high - low)
        text = f'[motion.gaussian]\nrms = "{rate} deg/s"\nband = ["{low} Hz", "{high} Hz"]\n'
        return Motion("band", [(low, value), (high, value)], text=text)
    if kind < 0.7:
        points = density(draw, int(draw.between(2, 6)), 0.1, nyquist)
        factor = rate**2 / np.sum(Motion("psd", points).spectrum(0)[1])
        points = [(nu, number(value * factor)) for nu, value in points]
        text = f'[motion.gaussian]\npsd = {rows(points, "(deg/s)^2/Hz")}\n'
        return Motion("psd", [(nu, value * 3600**2) for nu, value in points], text=text)
    alias = draw.chance(0.5)
    highest = nyquist * (draw.log(1, 4) if alias else 1)
    points = density(draw, int(draw.between(2, 5)), 0.1, highest)
    within = (points[0][0] * 0.5, min(points[-1][0] * 1.5, highest))
    modes = []
    for _ in range(int(draw.between(1, 4))):
        sign = -1 if modes and draw.chance(0.3) else 1
        modes.append((number(draw.log(*within)), number(draw.log(5, 200)), sign * number(draw.log(3000, 30000))))
    factor = (rate * 3600) ** 2 / np.sum(Motion("suspension", points, modes).spectrum(0)[1])
    points = [(nu, number(value * factor)) for nu, value in points]
    scale, line = 1.0, ""
    if draw.chance(0.3):
        # The density has a given shape alone, and the rms its scale.
        whole = float(np.sum(Motion("suspension", points).spectrum(0)[1]))
        acceleration = number(np.sqrt(whole))
        points = [(nu, number(value * 3)) for nu, value in points]
        scale = float(acceleration**2 / np.sum(Motion("suspension", points).spectrum(0)[1]))
        line = f'rms = "{acceleration} g"\n'
    tables = ", ".join(f'{{ frequency = "{nu} Hz", q = {q}, response = "{size} arcsec/s/g" }}' for nu, q, size in modes)
    text = f"[motion.suspension]\nmodes = [{tables}]\n" + ("alias = true\n" if alias else "")
    text += f'[motion.suspension.random]\n{line}psd = {rows(points, "g^2/Hz")}\n'
    return Motion("suspension", points, modes, scale, text)


def random_study(seed, index):
    draw = Draw(seed, index)
    tick_ms = float(f"{draw.log(1, 10):.4g}")
    tick_s, n = tick_ms / 1000, draw.whole(1, 10)
    motion = random_motion(draw, tick_s)
    fit_ticks, bands = {}, {}
    for name in ("mv", "mv 2"):
        ticks = None
        while ticks is None or ticks in fit_ticks.values():
            before, after = draw.whole(1, MAX_SIDE), draw.whole(1, MAX_SIDE)
            ticks = [*range(1 - before, 1), *range(n + 1, n + after + 1)]
            if draw.chance(0.2):
                ticks = [tick for tick in ticks if tick in (0, n + 1) or draw.chance(0.7)]
        fit_ticks[name] = ticks
    if draw.chance(0.4):
        low, high = motion.points[0][0] * draw.log(0.7, 1), motion.points[-1][0] * draw.log(1, 1.4)
        if low < 0.9 / (2 * tick_s):
            bands["mv 2"] = (number(low), number(min(high, 0.49999 / tick_s)))
    study = Study(tick_s, n, 0.0, 0.0, motion, fit_ticks, bands, "")
    tick_rms = np.sqrt(Ticks(study, motion, 1).tick_variance())
    study.sigma = number(draw.log(1e-5, 1e-1) * tick_rms)
    pulse = number(max(draw.log(0.3, 30) * study.sigma, 2e-6))
    study.pulse = pulse if draw.chance(0.5) else 0.0
    fillers = ['"const"', '"quadratic"']
    for name, ticks in fit_ticks.items():
        band = 'band = ["{} Hz", "{} Hz"], '.format(*bands[name]) if name in bands else ""
        fillers.append(f'{{ kind = "minimum-variance", name = "{name}", {band}fit_ticks = {ticks} }}')
    listed = ",\n  ".join(fillers)
    readout = f'readout_lsb = "{pulse} arcsec"\n' if study.pulse else ""
    study.text = f"""title = "Random study {index} of seed {seed}"
kind = "gap-fill"
trials = {TRIALS}
seed = {index + 1}
[gyro]
tick = "{tick_ms} ms"
tick_noise = {{ std = "{study.sigma} arcsec" }}
{readout}{motion.text}[switching]
gap_ticks = {n}
fillers = [
  {listed},
]
errors = ["residual", "extrapolation", "in-gap"]
"""
    return study


def call(folder, *arguments):
    """What the program prints as JSON; where it refuses, nothing, its exit code and the first lines of its message."""
    program = Path(os.environ.get("SAGNAC", "target/release/sagnac")).resolve()
    command = ["nice", program, *arguments, "--json", "--out", Path(folder, arguments[0])]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
    if done.returncode:
        message = re.split(r"╭|help:", done.stderr)[0]
        return None, (done.returncode, " ".join(message.replace("×", "").replace("│", "").split())[:300])
    return json.loads(done.stdout), None


@dataclass
class Row:
    index: int
    study: Study
    filler: str
    error: str
    ticks: int
    right: float
    # Columns of the table of `run`, and the rms that `filler` gives.
    found: dict
    filler_rms: float | None

    @property
    def z(self):
        return (self.found["rms_arcsec"] - self.right) / self.found["rms_se_arcsec"]

    @property
    def ratio(self):
        return self.found["rms_arcsec"] / self.right

    @property
    def theory(self):
        closed = self.found.get("theory_rms_arcsec")
        return None if closed is None else closed / self.right - 1

    def line(self):
        study, theory = self.study, self.theory
        readout = f"{study.pulse:.3g}" if study.pulse else "–"
        return (
            f"| {self.index} | {study.motion.kind} | {study.gap_ticks} | {study.sigma:.3g} | {readout} | "
            f"{self.filler} ({self.ticks}) | {self.error} | {self.right:.6g} | {self.found['rms_arcsec']:.6g} | "
            f"{self.z:.2f} | {self.ratio:.4g} | "
            + (f"{theory:.2g} |" if theory is not None else "– |")
        )


COLUMNS = "study", "motion", "n", "σ, ″", "pulse, ″", "filler (ticks)", "error"
COLUMNS += "right, ″", "program, ″", "apart, se", "ratio", "closed form − 1"
HEAD = f"| {' | '.join(COLUMNS)} |\n|" + "---|" * len(COLUMNS)


def compare(index, study, designs):
    """Rows of one study, the excess of its minimum-variance fillers, and what the program said where it refused."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "study.toml").write_text(study.text)
        table, refused = call(folder, "run", "study.toml", "--device", "cpu", "--threads", "1")
        given = None
        if not refused:
            given, refused = call(folder, "filler", "study.toml")
    if refused:
        return [], refused
    window = Ticks(study, study.motion, MAX_SIDE)
    fractions = by_lag(study, window)
    points = {(point["filler"], point["error"]): point for point in table["tables"]["points"]}
    found = []
    for error in given["tables"]["fillers"]:
        name, kind = error["filler"], error["error"]
        rows = [row for row in given["tables"]["weights"] if (row["filler"], row["error"], row["row"]) == (name, kind, "sum")]
        ticks = [row["tick"] for row in rows]
        weights = np.array([LONG(row["numerator"]) for row in rows]) / LONG(rows[0]["denominator"])
        right = rms(study, window, ticks, weights, fractions)
        kinds = [kind] + ["in-gap"] * (kind == "extrapolation" and study.gap_ticks == 1)
        known = error["rms_arcsec"]
        of_table = [Row(index, study, name, kind, len(ticks), right, points[name, kind], known) for kind in kinds]
        found += of_table
        if name in study.fit_ticks:
            designs.append(excess(of_table[0], study, window, ticks, weights, fractions))
    return found, None


def excess(row, study, window, ticks, weights, fractions):
    """By how much a filler is above the least rms: in truth, if it is designed for the motion, and in the model of its design."""
    in_truth, design = None, window
    if row.filler in study.bands:
        low, high = study.bands[row.filler]
        value = float(np.sum(window.power)) / (high - low)
        design = Ticks(study, Motion("band", [(low, value), (high, value)]), MAX_SIDE)
    else:
        in_truth = row.right / rms(study, window, ticks, least(study, window, ticks, fractions), fractions) - 1
    apart = independent(study, window.numbers.size)
    best = rms(study, design, ticks, least(study, design, ticks, apart), apart)
    return row, in_truth, rms(study, design, ticks, weights, apart) / best - 1


def of(row):
    return f"study {row.index}, {row.filler}, {row.error}, {row.ticks} ticks"


def summary(rows, designs, refusals, count, seconds):
    lines = [f"studies: {count}, compared {count - len(refusals)}, refused {len(refusals)}, {seconds:.0f} s"]
    said = {}
    for index, (code, message) in refusals:
        said.setdefault((code, re.sub(r"[0-9.]+(e-?[0-9]+)?", "…", message)), []).append((index, message))
    for (code, _), same in sorted(said.items(), key=lambda item: -len(item[1])):
        where = ", ".join(str(index) for index, _ in same[:12]) + ", …" * (len(same) > 12)
        lines.append(f"    exit {code}, {len(same)} (studies {where}): {same[0][1]}")
    if not rows:
        return lines
    beyond = [row for row in rows if not abs(row.z) <= BEYOND]
    within = [row.z for row in rows if abs(row.z) <= BEYOND]
    far, high = max(rows, key=lambda row: abs(row.z)), max(rows, key=lambda row: max(row.ratio, 1 / row.ratio))
    closed = [row for row in rows if row.theory is not None]
    lines += [
        f"rms compared: {len(rows)}, of {len({row.index for row in rows})} studies",
        f"beyond {BEYOND} standard errors: {len(beyond)} of {len({row.index for row in beyond})} studies; rms of the others' "
        f"{np.sqrt(np.mean(np.square(within))):.3f}",
        f"largest |rms − right|/se: {abs(far.z):.4g} ({of(far)})",
        f"farthest ratio rms/right: {high.ratio:.6g} ({of(high)})",
        f"without a closed form: {len(rows) - len(closed)}",
    ]
    if closed:
        worst = max(closed, key=lambda row: abs(row.theory))
        lines.append(f"largest closed form/right − 1: {worst.theory:.4g} ({of(worst)})")
    stated = [row for row in rows if row.filler_rms is not None]
    if stated:
        worst = max(stated, key=lambda row: abs(row.filler_rms / row.right - 1))
        lines.append(f"largest rms of `filler`/right − 1: {worst.filler_rms / worst.right - 1:.4g} ({of(worst)})")
    lines.append("minimum-variance fillers above the least possible rms, as a part of it:")
    for what, place in (("designed for the motion", 1), ("all, in the model of their design", 2)):
        for readout in (False, True):
            chosen = [design for design in designs if design[place] is not None and bool(design[0].study.pulse) == readout]
            if chosen:
                worst = max(chosen, key=lambda design: design[place])
                excesses = [design[place] for design in chosen]
                lines.append(
                    f"    {what}, {'with' if readout else 'without'} readout: at most {worst[place]:.3g} ({of(worst[0])}), "
                    f"at least {min(excesses):.2g}, median {np.median(excesses):.2g} of {len(chosen)}"
                )
    shown = [row for row in rows if row.found.get("representation") is not None]
    if shown:
        worst = max(shown, key=lambda row: abs(row.found["representation"]))
        lines.append(f"largest representation: {worst.found['representation']:.4g} ({of(worst)})")
    if beyond:
        beyond.sort(key=lambda row: -abs(row.z))
        of_all = f", the farthest {SHOWN} of {len(beyond)}" * (len(beyond) > SHOWN)
        lines += ["", f"beyond {BEYOND} standard errors{of_all}", "", HEAD]
        lines += [row.line() for row in beyond[:SHOWN]]
    return lines


def simulate(study, estimates, seed, trials, waves=3000, chunk=4000):
    """Rms errors of estimates over simulated ticks, with standard errors; the motion is a sum of sines of normal amplitudes
    at the middles of steps that are equal in frequency, in its logarithm, and finer near resonances."""
    rng = np.random.default_rng(seed)
    motion, n = study.motion, study.gap_ticks
    edges = np.concatenate([np.linspace(low, high, waves) for (low, _), (high, _) in zip(motion.points, motion.points[1:])])
    edges = [edges] + [np.geomspace(motion.points[0][0], motion.points[-1][0], waves)]
    for natural, q, _ in motion.modes:
        edges.append(natural + natural / (2 * q) * np.sinh(np.linspace(-6, 6, 1200)))
    edges = np.unique(np.concatenate(edges))
    edges = edges[(edges >= motion.points[0][0]) & (edges <= motion.points[-1][0])]
    nu, width = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    place = np.log([point for point in motion.points])
    power = np.exp(np.interp(np.log(nu), *place.T)) * motion.scale * width
    for_g = sum(size / q / (1 - (nu / natural) ** 2 + 1j * nu / natural / q) for natural, q, size in motion.modes)
    if motion.modes:
        power = power * abs(for_g) ** 2
    used = [tick for ticks, _ in estimates for tick in ticks]
    first, last = min(min(used), 1), max(max(used), n)
    numbers = np.arange(first, last + 1)
    phase = 2 * np.pi * nu[:, None] * study.tick_s * (numbers - (n + 1) / 2)
    size = np.sqrt(power) * study.tick_s * np.sinc(nu * study.tick_s)
    matrix = np.concatenate([size[:, None] * np.cos(phase), size[:, None] * np.sin(phase)])
    squares = np.zeros((2, len(estimates)))
    for _ in range(trials // chunk):
        true = rng.standard_normal((chunk, matrix.shape[0])) @ matrix
        gap = (numbers >= 1) & (numbers <= n)
        noise = study.sigma * rng.standard_normal(true.shape)
        angle = np.cumsum(true + noise, axis=1)
        read = true + noise
        if study.pulse:
            angle = np.concatenate([np.zeros((chunk, 1)), angle], axis=1) + study.pulse * rng.random((chunk, 1))
            read = study.pulse * np.diff(np.floor(angle / study.pulse), axis=1)
        for place, (ticks, weights) in enumerate(estimates):
            errors = read[:, np.array(ticks) - first] @ np.array(weights, float) - true[:, gap].sum(1)
            squares[:, place] += np.sum(errors**2), np.sum(errors**4)
    mean, fourth = squares / (trials // chunk * chunk)
    return np.sqrt(mean), np.sqrt((fourth - mean**2) / (trials // chunk * chunk)) / (2 * np.sqrt(mean))


def check(seed, trials=40_000):
    """Right values of some studies of each kind, with and without readout, beside simulated ticks."""
    print("| study | motion | pulse | n | ticks | right, ″ | simulated | apart, se | doubled panels − 1 |\n" + "|---" * 9 + "|")
    missing = {(kind, pulse) for kind in ("band", "psd", "suspension") for pulse in (False, True)}
    index = -1
    while missing:
        index += 1
        study = random_study(seed, index)
        if (study.motion.kind, bool(study.pulse)) not in missing:
            continue
        missing.remove((study.motion.kind, bool(study.pulse)))
        window, wider = Ticks(study, study.motion, MAX_SIDE), Ticks(study, study.motion, 3 * MAX_SIDE)
        fractions = by_lag(study, window)
        n = study.gap_ticks
        estimates = [([-1, 0, n + 1, n + 2], np.full(4, LONG(n) / 4))]
        for ticks in study.fit_ticks.values():
            estimates.append((ticks, least(study, window, ticks, fractions)))
        found, errors = simulate(study, estimates, index, trials)
        for (ticks, weights), simulated, se in zip(estimates, found, errors):
            right = rms(study, window, ticks, weights, fractions)
            doubled = rms(study, wider, ticks, weights, by_lag(study, wider))
            pulse = f"{study.pulse:.3g}" if study.pulse else "–"
            print(
                f"| {index} | {study.motion.kind} | {pulse} | {n} | {len(ticks)} | {right:.6g} | {simulated:.6g} ± {se:.2g} | "
                f"{(simulated - right) / se:.2f} | {doubled / right - 1:.1g} |",
                flush=True,
            )


def main(arguments):
    if arguments[:1] == ["check"]:
        return check(int(arguments[1]) if len(arguments) > 1 else 1)
    if arguments[:1] == ["show"]:
        return print(random_study(int(arguments[2]) if len(arguments) > 2 else 1, int(arguments[1])).text, end="")
    count, seed = (int(given) for given in (arguments + ["200", "1"][len(arguments) :])[:2])
    started = time.perf_counter()
    rows, designs, refusals = [], [], []
    for index in range(count):
        found, refused = compare(index, random_study(seed, index), designs)
        rows += found
        if refused:
            refusals.append((index, refused))
    print("\n".join(summary(rows, designs, refusals, count, time.perf_counter() - started)))


if __name__ == "__main__":
    main(sys.argv[1:])
