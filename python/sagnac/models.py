"""Noise models for navigation filters, as the program gives them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import _sagnac

from ._reading import Record, curve_of, reading_of, refuse_for_curve, refuse_interval
from .analyses import Analysis, _analysis, _terms
from .errors import UsageError
from .logs import Kind
from .studies import _source, _whole

MAX_STATES = 3

#: What a curve takes of the arguments of :func:`model`.
CURVE_ARGUMENTS = (
    "data", "rate", "unit", "name", "terms", "curve_interval", "from_s", "to_s", "bound", "margin", "states", "quantization", "filter_rate", "write",
)  # fmt: skip


@dataclass(frozen=True)
class _Wanted:
    from_s: float | None
    to_s: float | None
    bound: str | None
    margin: float
    states: int | None
    is_white: bool
    filter_hz: float | None
    confidence: float
    write: list[str]


def model(
    data: Record | None = None,
    rate: float | None = None,
    *,
    noise: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    unit: str | None = None,
    kind: Kind | None = None,
    name: str | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    bound: Literal["band", "repeat"] | None = "band",
    margin: float = 0.2,
    states: int | None = None,
    quantization: Literal["measurement", "white"] = "measurement",
    filter_rate: float | None = None,
    confidence: float = 0.95,
    write: Sequence[str] = (),
    terms: Literal["auto"] | Sequence[str] = "auto",
    curve_interval: str | None = None,
    detrend: bool = False,
    remove_outliers: bool = False,
    unit_check: bool = True,
    threads: int | None = None,
) -> Analysis:
    """White noise, a random walk and the fewest Markov states for a filter, as ``sagnac model`` finds them.

    Parameters
    ----------
    data, rate, unit, kind, terms, detrend, remove_outliers, unit_check, threads
        A record, as for :func:`fit`; a log may have several columns. Or a curve, as for :func:`analyze`, which takes ``unit``, ``name``,
        ``terms``, ``curve_interval`` and the arguments of the model except ``confidence``.
    noise
        Instead of a record, the noise of a study: a path of a noise.toml, its text, or a dictionary such as
        ``{"angle_random_walk": "0.003 deg/sqrt(h)"}``.
    name
        What the record is called; by default the name of its file, or ``record`` for an array.
    from_s, to_s
        Shortest and longest averaging time that the model covers, s; by default that of the record and a tenth of its length. Noise
        needs both.
    bound
        ``"band"`` for a model whose Allan deviation is nowhere below the upper end of the band of the record, ``"repeat"`` for one that
        is nowhere below that of most further records like it, None for one within the band.
    margin
        How far a bound may lie above, as a part, before a state is added.
    states
        Number of Markov states, 0 to 3, instead of the fewest.
    quantization
        Whether quantization is measurement noise of the angle, or covered by white noise of the rate.
    filter_rate
        Rate of the filter, Hz, for the matrices; by default that of the record.
    confidence
        Probability of the band.
    write
        Tools for which ``data["files"]`` has files, such as ``["kalibr", "gtsam_python"]``, or ``["all"]``.

    Raises
    ------
    RecordError, StudyError, UsageError
        The record or the noise is unusable, no model fits, or an argument is not accepted.

    Examples
    --------
    >>> gyro = {"angle_random_walk": "0.003 deg/sqrt(h)", "bias_instability": "0.01 deg/h"}
    >>> found = model(noise=gyro, from_s=1.0, to_s=1000.0)
    >>> gyro = found.data["model"]["columns"][0]
    >>> len(gyro["markov"]), gyro["largest_excess"] < 0.2
    (1, True)
    """
    given = dict(locals())
    if bound not in ("band", "repeat", None):
        raise UsageError(f'bound={bound!r}\naccepted: "band", "repeat", None')
    if quantization not in ("measurement", "white"):
        raise UsageError(f'quantization="{quantization}"\naccepted: "measurement", "white"')
    if not 0.0 < confidence < 1.0:
        raise UsageError(f"confidence={confidence}\naccepted: between 0 and 1, as in 0.95")
    if not 0.0 < margin <= 10.0:
        raise UsageError(f"margin={margin}\naccepted: above 0 and at most 10, as in 0.2")
    if filter_rate is not None and not 0.0 < filter_rate < 1e9:
        raise UsageError(f"filter_rate={filter_rate}\naccepted: Hz above 0")
    if isinstance(write, str):
        raise UsageError(f'write="{write}"\naccepted: a list such as ["kalibr"], or ["all"]')
    states = None if states is None else _whole("states", states, 0, MAX_STATES)
    wanted = _Wanted(
        from_s,
        to_s,
        bound,
        margin,
        states,
        quantization == "white",
        filter_rate,
        confidence,
        list(write),
    )
    if noise is not None:
        if data is not None:
            raise UsageError("data and noise are both given\ngive the record, or its noise")
        path, text = _source(noise)
        return _analysis(_sagnac.model_of_noise(path, text, wanted))
    if data is None:
        raise UsageError("neither a record nor noise is given\ngive data, or noise=")
    if (curve := curve_of(data, rate, unit, name, curve_interval)) is not None:
        refuse_for_curve(model, given, CURVE_ARGUMENTS)
        return _analysis(_sagnac.model_of_curve(*curve, _terms(terms), wanted))
    refuse_interval(curve_interval)
    record = reading_of(data, rate, kind, unit, detrend, remove_outliers, unit_check, threads, name=name)
    return _analysis(_sagnac.model_of_record(*record, _terms(terms), wanted))
