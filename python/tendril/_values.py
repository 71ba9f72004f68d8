"""Python values as values of a scene: SI numbers, text with units, lists, tables."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from typing import Any

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+\Z")
_SHORT = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}
_DEEPEST = 64


def plain(value: Any, name: str) -> float | str:
    """A number (SI) or a quantity as a float or as text with a unit. Raises TypeError, ValueError naming `name`."""
    if isinstance(value, str):
        return unicode(value, name)
    if hasattr(value, "to_base_units"):  # a quantity of pint
        return _quantity(value, name)
    if isinstance(value, bool) or not hasattr(value, "__float__") or getattr(value, "ndim", 0) > 0:
        raise TypeError(f"{name}: found {value!r}, expected a number or text with a unit")
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name}: found {value!r}, expected one number") from error
    if not math.isfinite(number):
        raise ValueError(f"{name}: found {number}, expected a finite number")
    return number


def unicode(text: str, name: str) -> str:
    """The text, which has to be one that a file can hold."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{name}: found {text!r}, which is not Unicode, expected text that is") from None
    return text


def number(value: Any, name: str, least: float = -math.inf, most: float = math.inf) -> float:
    """A plain number within bounds; infinity only where a bound is infinite."""
    if isinstance(value, (bool, str)) or not hasattr(value, "__float__"):
        raise TypeError(f"{name}: found {value!r}, expected a number")
    found = float(value)
    if not least <= found <= most:
        raise ValueError(f"{name}: found {found}, expected a number from {least:g} to {most:g}")
    return found


def whole_number(value: Any, name: str, least: int = 1, most: int | None = None) -> int:
    """`value`, which has to be a whole number within bounds; 6.0 is one."""
    number_like = hasattr(value, "__float__") and not isinstance(value, bool)
    if not number_like or not float(value).is_integer() or value < least or (most is not None and value > most):
        until = "on" if most is None else f"to {most}"
        raise ValueError(f"{name}: found {value!r}, expected a whole number from {least} {until}")
    return int(value)


def file_path(value: Any, name: str) -> str:
    """The name of a file or directory, as text."""
    path = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if not isinstance(path, str):
        raise TypeError(f"{name}: found {value!r}, expected the name of a file")
    return unicode(path, name)


def each(values: Any, name: str) -> list[Any]:
    """The entries of what has to be a list or the like, and no text."""
    if isinstance(values, (str, bytes, Mapping)) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name}: found {values!r}, expected a list")
    return list(values)


def _quantity(value: Any, name: str) -> float | str:
    base = value.to_base_units()
    number = plain(base.magnitude, name)
    units = " ".join(f"{unit}^{exponent:g}" for unit, exponent in base.units._units.items())
    return f"{number!r} {units}" if units else number


def is_list(value: Any) -> bool:
    """A list, a tuple, or an array, of numpy or of pint."""
    if hasattr(value, "to_base_units"):
        value = value.magnitude
    return isinstance(value, (list, tuple)) or (hasattr(value, "tolist") and getattr(value, "ndim", 0) > 0)


def entries(values: Any, name: str) -> list[Any]:
    """What stands between the commas of a text, or in a list or the like; a lone value stands for a list of one."""
    if isinstance(values, str):
        return values.split(",")
    if isinstance(values, (bytes, set, frozenset, Mapping)):
        raise TypeError(f"{name}: found {values!r}, expected a list")
    lone = hasattr(values, "to_base_units") or hasattr(values, "ndim") or not hasattr(values, "__iter__")
    return [values] if lone and not is_list(values) else list(values)


def inline(value: Any, name: str, depth: int = 0) -> str:
    """`value` as TOML on one line. Raises TypeError or ValueError naming `name`, the key that it is for."""
    if depth > _DEEPEST:
        raise ValueError(f"{name}: found values nested deeper than {_DEEPEST} levels")
    if isinstance(value, bool) or type(value).__name__ in ("bool_", "bool8"):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(unicode(value, name))
    if isinstance(value, Mapping):
        items = (f"{key_text(key, name)} = {inline(item, f'{name}.{key}', depth + 1)}" for key, item in value.items())
        return "{" + ", ".join(items) + "}"
    if is_list(value):
        return "[" + ", ".join(inline(item, f"{name}[{i}]", depth + 1) for i, item in enumerate(value)) + "]"
    if hasattr(value, "__index__") and not hasattr(value, "to_base_units"):
        return str(value.__index__())
    number = plain(value, name)
    return _text(number) if isinstance(number, str) else repr(number)


def _text(value: str) -> str:
    return '"' + "".join(_SHORT.get(c) or (f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c) for c in value) + '"'


def key_text(key: Any, name: str) -> str:
    """A key as TOML writes it."""
    if not isinstance(key, str):
        raise TypeError(f"{name}: found the key {key!r}, expected text")
    return key if _BARE_KEY.match(key) else _text(unicode(key, name))
