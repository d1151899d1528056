"""Monte Carlo studies for laser gyroscopes and related analyses, with NumPy arrays as input and output.

- :func:`run` runs a study: the tables and charts of the program ``sagnac``, bit for bit.
- :func:`allan` computes deviations of a record: Allan, modified Allan, time, Hadamard, with intervals and noise types.
- :func:`fit` fits the noise coefficients Q, N, B, K, R to a record.
- :func:`read_log` reads a log, which these functions take, as they take arrays and paths.
- :func:`psd` computes the spectrum of a record, and :func:`compare` tells whether the noise of two records differs.
- :func:`analyze` is the whole of ``sagnac allan``: temperature, noise over time and position error too; :func:`batch` pools units,
  and :func:`hat` separates three that ran together.
- :func:`model` turns a record or its noise into a model that a navigation filter can use.
- :func:`design` finds the switching interval and the filler with the least drift, and :func:`sensitivity` which uncertain input
  decides an answer.
- :func:`filler` gives the weights that fill the gap at a mode switch, as exact fractions.
- :func:`simulate` makes records of a noise.
- :func:`convert` converts noise coefficients between units and conventions.
- :mod:`sagnac.theory` has the underlying closed forms, over arrays.

Angles are in ″ (arcsec), rates in °/h, which is the same number in ″/s, times in s; any other unit is given
by the name or the ``unit``. Unknown values are NaN in an array and None elsewhere, never 0.

Every result has an ``answer``, a sentence, and ``plot()``, which draws it with matplotlib where that is installed.

Errors are those of :mod:`sagnac.errors`, all of them a :class:`SagnacError`.

>>> import numpy as np, sagnac
>>> rates = np.random.default_rng(1).normal(0.0, 0.03, 36_000)      # deg/h, at 100 Hz
>>> found = sagnac.fit(rates, 100.0, unit="deg/h")
>>> found["N"].status, round(found["N"].value, 7)                  # deg/sqrt(h): 0.03/60/sqrt(100)
('estimated', 4.96e-05)
"""

from _sagnac import version as __version__

from . import errors, theory
from .analyses import Analysis, batch, compare, design, hat, sensitivity
from .errors import (
    DeviceError,
    InternalError,
    RecordError,
    SagnacError,
    StorageError,
    StudyError,
    UsageError,
)
from .fillers import Filler, Fillers, Rule, filler
from .logs import Log, read_log
from .models import model
from .noise import Allan, Coefficient, Conversion, Curve, Fit, Minimum, convert
from .records import allan, fit
from .results import Answer, Results, Table
from .simulation import simulate
from .studies import run
from .whole import analyze, psd

__all__ = [
    "Allan",
    "Analysis",
    "Answer",
    "Coefficient",
    "Conversion",
    "Curve",
    "DeviceError",
    "Filler",
    "Fillers",
    "Fit",
    "InternalError",
    "Log",
    "Minimum",
    "RecordError",
    "Results",
    "Rule",
    "SagnacError",
    "StorageError",
    "StudyError",
    "Table",
    "UsageError",
    "__version__",
    "allan",
    "analyze",
    "batch",
    "compare",
    "convert",
    "design",
    "errors",
    "filler",
    "fit",
    "hat",
    "model",
    "psd",
    "read_log",
    "run",
    "sensitivity",
    "simulate",
    "theory",
]
