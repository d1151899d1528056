"""Errors. Each message says what was found, what is accepted, and what to do.

>>> import sagnac
>>> try:
...     sagnac.run('title = "Mine"\\nkind = "gap-fil"\\n')
... except sagnac.StudyError as error:
...     print(error)
  × unknown value "gap-fil"
   ╭─[study:2:8]
 1 │ title = "Mine"
 2 │ kind = "gap-fil"
   ·        ────┬────
   ·            ╰── not one of the choices
   ╰────
  help: did you mean `gap-fill`? accepted: gap-fill, allan, switched-run, relock, lock-in, drift-
        budget, suspension, navigation
"""


class SagnacError(Exception):
    """Any error of this package."""


class StudyError(SagnacError, ValueError):
    """An invalid study. The message shows the file, the line and a caret below the error."""


class UsageError(SagnacError, ValueError):
    """An argument that is not accepted."""


class RecordError(SagnacError, ValueError):
    """Unusable samples: too few, all equal, or in another unit than stated."""


class StorageError(SagnacError):
    """An unusable results folder: full, read-only, in use, damaged, or of another study."""


class DeviceError(SagnacError, RuntimeError):
    """A device that failed. Completed work is kept if there is a results folder."""


class InternalError(SagnacError, RuntimeError):
    """A fault of sagnac itself."""
