"""Studies given as dictionaries, as the text of a study file."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

import numpy as np

from .errors import UsageError

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def text_of(study: Mapping[str, Any]) -> str:
    """The text of a study: values first, then a table for each dictionary, and one for each dictionary of a list."""
    values = [f"{_key(key, key)} = {_value(value, key)}" for key, value in study.items() if not _is_table(value)]
    tables: list[str] = []
    for key, value in study.items():
        if isinstance(value, Mapping):
            tables += ["", f"[{_key(key, key)}]", *_lines(value, key)]
        elif _is_table(value):
            for place, each in enumerate(value):
                tables += ["", f"[[{_key(key, key)}]]", *_lines(each, f"{key}[{place}]")]
    return "\n".join([*values, *tables]) + "\n"


def _is_table(value: Any) -> bool:
    """Whether a value has tables of its own: a dictionary, or a list of them."""
    is_list = isinstance(value, list | tuple) and len(value) > 0
    return isinstance(value, Mapping) or (is_list and all(isinstance(each, Mapping) for each in value))


def _lines(table: Mapping[str, Any], place: str) -> list[str]:
    return [f"{_key(key, place)} = {_value(value, f'{place}.{key}')}" for key, value in table.items()]


def _key(key: Any, place: str) -> str:
    if not isinstance(key, str) or key == "":
        raise UsageError(f"{place}: the key {key!r} is not a text\nkeys are those of a study file, such as 'gap_ticks'")
    return key if _BARE.fullmatch(key) else _quoted(key)


def _quoted(text: str) -> str:
    # The escapes of JSON are those of TOML, which has one more character to escape.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _value(value: Any, place: str) -> str:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real) and math.isfinite(value):
        return repr(float(value))
    if isinstance(value, Mapping):
        pairs = (f"{_key(key, place)} = {_value(each, f'{place}.{key}')}" for key, each in value.items())
        return "{ " + ", ".join(pairs) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(each, f"{place}[{at}]") for at, each in enumerate(value)) + "]"
    raise UsageError(
        f"{place} = {value!r} has no place in a study\n"
        'accepted: texts with units such as "5 ms", finite numbers, True and False, lists and dictionaries of these'
    )
