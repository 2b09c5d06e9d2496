"""From Python objects to the texts that model, scenario and problem files are made of."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from numbers import Integral, Real
from typing import Any

import numpy as np

from ._native import BracketryError
from ._sympy import is_function_of_time, is_sympy, sympy_text

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def name_of(value: object, what: str) -> str:
    """The name of a state, input or parameter: a string, a SymPy symbol, or a function of time such as ``x(t)``."""
    if isinstance(value, str):
        return value
    if is_sympy(value):
        if getattr(value, "is_Symbol", False):
            return str(value)
        if is_function_of_time(value):
            return type(value).__name__
    raise BracketryError(f"{what}: `{value}` is not a name; give a string or a symbol")


def expression(value: object, what: str) -> str:
    """An expression as text: strings as they are, numbers exactly, SymPy expressions translated."""
    if isinstance(value, str):
        return value
    if isinstance(value, Fraction):
        return f"{value.numerator}/{value.denominator}"
    if is_sympy(value):
        return sympy_text(value, what)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        raise BracketryError(f"{what}: `{value!r}` is not an expression; give a string, a number, or a SymPy expression")
    return number(value, what)


def number(value: object, what: str) -> str:
    """A number as text that reads back exactly."""
    if is_sympy(value) and getattr(value, "is_number", False):
        value = float(value)  # type: ignore[arg-type]
    if isinstance(value, Fraction):
        value = float(value)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        raise BracketryError(f"{what}: `{value!r}` is not a number")
    if isinstance(value, Integral):
        return str(int(value))
    as_float = float(value)
    if not math.isfinite(as_float):
        raise BracketryError(f"{what} is {as_float}; give a finite number")
    return repr(as_float)


def listed(values: Any, what: str) -> list[Any]:
    """A list; a single text, which would fall apart into its letters, is refused."""
    if isinstance(values, str):
        raise BracketryError(f"{what}: give a list, such as [{values!r}]")
    return list(values)


def whole(value: object, what: str) -> int:
    """A whole number that is not negative."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Integral) or int(value) < 0:
        raise BracketryError(f"{what} is {value!r}; give a whole number, 0 or greater")
    return int(value)


def numbers(values: Mapping[Any, object], what: str) -> dict[str, object]:
    """Numbers by name; fractions and SymPy's become floating-point numbers, strings stay for the reader to refuse."""
    exact = {name_of(k, what): v for k, v in values.items()}
    return {k: float(number(v, f"{what}, {k}")) if is_sympy(v) or isinstance(v, Fraction) else v for k, v in exact.items()}


def key(name: str) -> str:
    """A key of a TOML table."""
    return name if _BARE_KEY.fullmatch(name) else string(name)


def string(text: str) -> str:
    """A string of TOML."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_value(value: object, what: str) -> str:
    """A value of TOML: tables and arrays are written inline."""
    if isinstance(value, Mapping):
        items = (f"{key(str(k))} = {toml_value(v, f'{what}.{k}')}" for k, v in value.items() if v is not None)
        return "{ " + ", ".join(items) + " }"
    if isinstance(value, str):
        return string(value)
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, np.ndarray):
        return toml_value(value.tolist(), what)
    if isinstance(value, Sequence):
        return "[" + ", ".join(toml_value(v, what) for v in value) + "]"
    if is_sympy(value) or isinstance(value, Fraction):
        return string(expression(value, what))
    return number(value, what)


def toml_document(table: Mapping[str, object], what: str) -> str:
    """A document with one line per entry."""
    return "".join(f"{key(str(k))} = {toml_value(v, f'{what}, {k}')}\n" for k, v in table.items() if v is not None)
