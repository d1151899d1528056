"""What can go wrong. Each message says what was found, what is accepted, and what to do.

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
   help: did you mean `gap-fill`? accepted: gap-fill, allan, switched-run, relock, drift-budget,
         suspension
"""


class SagnacError(Exception):
    """Any error of this package."""


class StudyError(SagnacError, ValueError):
    """A study that makes no sense. The message shows the file, the line and a caret below what is wrong."""


class UsageError(SagnacError, ValueError):
    """An argument that is none of those accepted."""


class RecordError(SagnacError, ValueError):
    """Samples of which nothing can be said: too few, all equal, or of another unit than said."""


class StorageError(SagnacError):
    """A results folder that cannot be used: full, read-only, in use, damaged, or of another study."""


class DeviceError(SagnacError, RuntimeError):
    """A device that failed. What was sampled before is kept where there is a results folder."""


class InternalError(SagnacError, RuntimeError):
    """A fault of sagnac itself."""
