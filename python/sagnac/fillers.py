"""Weights that fill the gap at a mode switch."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

import _sagnac

from ._raw import RawFillers, RawRule
from .analyses import Analysis, _found
from .errors import UsageError
from .studies import _whole
from .theory import Values, _broadcast

MINIMUM_VARIANCE = "minimum-variance"


@dataclass(frozen=True)
class Rule:
    """Weights on ticks: the lost ticks, or their sum, are Σ w·P over ``ticks``."""

    error: str
    """Kind of error: ``residual`` for the interpolation I, ``extrapolation`` for E."""
    ticks: tuple[int, ...]
    """The ticks with weights; ticks 1 … n are lost."""
    rows: tuple[tuple[Fraction, ...], ...]
    """The weights of each lost tick, or of their sum alone if the filler gives nothing else."""
    denominator: int
    """Common denominator, as used by firmware."""
    exact: bool
    """Whether the fractions are the exact weights, instead of the nearest ones over a power of two."""
    gap_ticks: int
    tick: float | None
    """Length of a tick, s; None if unknown."""
    noise_gain: float
    """√Σw² of the sum: the standard deviation of the error for unit white noise on the ticks."""
    largest_gain: float
    """Σ|w| of the sum."""
    largest_input: int
    """The largest integer |P| for which 64 bits suffice."""
    amplitude: float | None
    """Largest error of a single tone over its phase, without noise, ″; None unless the motion is a single tone."""
    rms: float | None
    """Rms error including noise, ″; None if unknown."""

    @property
    def fractions(self) -> tuple[Fraction, ...]:
        """The weights of the whole gap."""
        return tuple(sum(column, Fraction(0)) for column in zip(*self.rows))

    @property
    def weights(self) -> NDArray[np.float64]:
        """The weights of the whole gap as floats."""
        return np.array([float(weight) for weight in self.fractions])

    def response(self, frequency: ArrayLike, *, tick: ArrayLike | None = None) -> Values:
        """Amplitude of the error over that of the rate of a vibration, in ″ per ″/s, that is in s.

        ``frequency`` is in Hz; ``tick``, s, is by default that of the filler. The rms over a random phase is 1/√2 of the amplitude.
        """
        length = self.tick if tick is None else tick
        if length is None:
            raise UsageError("the length of a tick is not known\ngive it, as in response(frequency, tick=0.005)")
        arrays, shaped = _broadcast(frequency, length)
        weights = [weight * self.denominator for weight in self.fractions]
        numerators = [weight.numerator for weight in weights]
        return shaped(_sagnac.gap_response(list(self.ticks), numerators, self.denominator, self.gap_ticks, arrays))


@dataclass(frozen=True)
class Filler:
    """A filler: an extrapolation for use while the gap is open, and an interpolation that corrects it afterwards."""

    name: str
    method: str
    """Description, such as ``polynomial of order 2``."""
    interpolation: Rule
    """Rule for the ticks on both sides."""
    extrapolation: Rule | None
    """Rule for the ticks before the gap, if the filler has one."""


@dataclass(frozen=True, repr=False)
class Fillers(Analysis, Mapping[str, Filler]):
    """Fillers by name: ``found["quadratic"].interpolation.fractions``. The charts are the response to vibration and, of a search, the
    error over the ticks."""

    at: dict[str, str]
    """The point of the study: swept keys and their values."""
    gap_ticks: int
    tick: float | None
    fillers: dict[str, Filler]
    no_rms_because: str | None
    """Why there is no rms, if the point cannot be sampled."""

    @property
    def header(self) -> str:
        """The fillers as a C99 header for firmware."""
        return self.files["sagnac_filler.h"]

    def __getitem__(self, name: str) -> Filler:
        return self.fillers[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.fillers)

    def __len__(self) -> int:
        return len(self.fillers)


def filler(
    what: str | Sequence[str] | os.PathLike[str],
    gap_ticks: int | None = None,
    *,
    tick: str | None = None,
    fit_ticks: str | None = None,
    extrapolation_ticks: str | None = None,
    band: str | None = None,
    amplitude: str | None = None,
    noise: str | None = None,
    at: Mapping[str, object] | None = None,
    fillers: Sequence[str] = (),
    limits: Mapping[str, str | float] | None = None,
    latency: str | None = None,
) -> Fillers:
    """The weights of fillers, as computed by ``sagnac filler``.

    Parameters
    ----------
    what
        One or more of ``const``, ``linear``, ``quadratic``, ``minimum-variance``; or the path of a gap-fill study, a
        :class:`~pathlib.Path` or a text ending in ``.toml``.
    gap_ticks
        Number n of lost ticks.
    tick
        Length of a tick, such as ``"5 ms"``; not needed for polynomials.
    fit_ticks, extrapolation_ticks
        Ticks with weights, such as ``"-7..0,n+1,n+2"``; by default −1, 0, n + 1, n + 2 and −3 … 0.
    band, amplitude, noise
        Design conditions of a minimum-variance filler: frequencies of the vibration, ``"18 Hz,22 Hz"`` or a single one, its
        amplitude, ``"12000 arcsec/s"``, and the standard deviation of the noise of a tick, ``"0.5 arcsec"``.
    at
        The point of a study as values of its swept keys, such as ``{"gap_ticks": 3}``.
    fillers
        Names of the fillers of the study to compute; by default all.
    limits
        Searches the ticks of a minimum-variance filler: the first after the gap, and then the fewest, with which 99.73 % of residuals
        are at most this angle, ``{"residual": "8 arcsec"}``, also if the frequencies are 5 % lower or higher. Of a study for its motion,
        and by default its own limit.
    latency
        Searches among the ticks that come at most this time after the gap, such as ``"20 ms"``; by default 16 ticks. All that were
        tried are in ``tables["trade.csv"]``.

    Raises
    ------
    UsageError, StudyError
        An argument is not accepted or is missing, or the study is invalid.

    Examples
    --------
    >>> rule = filler("quadratic", 3)["quadratic"].interpolation
    >>> rule.ticks, [str(weight) for weight in rule.fractions], round(rule.noise_gain, 3)
    ((-1, 0, 4, 5), ['-1', '5/2', '5/2', '-1'], 3.808)
    >>> round(12000 * rule.response(20.0, tick=0.005), 3)               # arcsec, for 12000 arcsec/s at 20 Hz
    26.848
    """
    path = _path(what)
    searched = (_residual(limits), latency)
    made = {"tick": tick, "fit_ticks": fit_ticks, "extrapolation_ticks": extrapolation_ticks}
    made |= {"band": band, "amplitude": amplitude, "noise": noise}
    if path is not None:
        given = [name for name, value in {"gap_ticks": gap_ticks, **made}.items() if value is not None]
        if given:
            raise UsageError(f"{given[0]} describes a filler without a study\na study says it in its file: leave it out")
        asked = [f"{key}={value}" for key, value in (at or {}).items()]
        if searched != (None, None) and fillers:
            raise UsageError("limits and latency search a filler of their own\nleave fillers out")
        return _fillers(_sagnac.of_study(path, asked, list(fillers), searched))
    if at or fillers:
        raise UsageError("at and fillers select from a study, but none is given\nleave them out")
    kinds = [what] if isinstance(what, str) else [str(kind) for kind in what]  # type: ignore[union-attr]
    if gap_ticks is None:
        raise UsageError("gap_ticks is missing: the number of lost ticks\nadd for example gap_ticks=3")
    if MINIMUM_VARIANCE in kinds:
        _check_design(tick, band, amplitude, noise)
    if (band is None) != (amplitude is None):
        raise UsageError('band and amplitude belong together\ngive both, as in band="20 Hz", amplitude="12000 arcsec/s"')
    if searched != (None, None):
        if kinds != [MINIMUM_VARIANCE]:
            raise UsageError(f"limits and latency search the ticks of one filler, {MINIMUM_VARIANCE}\nleave them out")
        if fit_ticks is not None:
            raise UsageError("fit_ticks are what limits and latency search\nleave fit_ticks out, or both of these")
    return _fillers(_sagnac.of_kinds(kinds, _Made(_whole("gap_ticks", gap_ticks, 1, 1 << 31), **made), searched))


def _residual(limits: Mapping[str, str | float] | None) -> str | None:
    """The limit on the residual."""
    unknown = [name for name in limits or {} if name != "residual"]
    if unknown:
        raise UsageError(f"limits: unknown limit `{unknown[0]}`\naccepted: residual")
    return None if not limits else str(limits["residual"])


@dataclass(frozen=True)
class _Made:
    gap_ticks: int
    tick: str | None
    fit_ticks: str | None
    extrapolation_ticks: str | None
    band: str | None
    amplitude: str | None
    noise: str | None


def _path(what: str | Sequence[str] | os.PathLike[str]) -> Path | None:
    if isinstance(what, os.PathLike) or (isinstance(what, str) and what.endswith(".toml")):
        return Path(what)
    return None


def _check_design(tick: str | None, band: str | None, amplitude: str | None, noise: str | None) -> None:
    needed = {
        "tick": (tick, "5 ms"),
        "band": (band, "18 Hz,22 Hz"),
        "amplitude": (amplitude, "12000 arcsec/s"),
        "noise": (noise, "0.5 arcsec"),
    }
    for name, (value, example) in needed.items():
        if value is None:
            raise UsageError(
                f"{name} is missing: a minimum-variance filler is designed for a given vibration and noise\n"
                f'add for example {name}="{example}"'
            )


def _fillers(found: RawFillers) -> Fillers:
    def rule(raw: RawRule) -> Rule:
        denominator = raw["denominator"]
        return Rule(
            error=raw["error"],
            ticks=tuple(raw["ticks"]),
            rows=tuple(tuple(Fraction(weight, denominator) for weight in row) for row in raw["rows"]),
            denominator=denominator,
            exact=raw["exact"],
            gap_ticks=found["gap_ticks"],
            tick=found["tick_s"],
            noise_gain=raw["noise_gain"],
            largest_gain=raw["largest_gain"],
            largest_input=raw["largest_input"],
            amplitude=raw["amplitude"],
            rms=raw["rms"],
        )

    fillers = {}
    for name, method, rules in found["fillers"]:
        interpolation, *rest = [rule(raw) for raw in rules]
        fillers[name] = Filler(name, method, interpolation, rest[0] if rest else None)
    return Fillers(
        **_found(found),
        at=dict(found["at"]),
        gap_ticks=found["gap_ticks"],
        tick=found["tick_s"],
        fillers=fillers,
        no_rms_because=found["no_rms_because"],
    )
